/** What `muster explain` says of a task, by decision: { head, tail, decisions: [{ index, lines }] }. */
export function readStory(text) {
  const story = { head: [], tail: [], decisions: [] };
  for (const line of text.split("\n")) {
    const [, index, rest] = /^decision +(\d+) +\d+:\d\d:\d\d +(.*)$/.exec(line) ?? [];
    if (index !== undefined) story.decisions.push({ index: Number(index), lines: [rest] });
    else if (/^ {4}/.test(line) && story.decisions.length) story.decisions.at(-1).lines.push(line.trim());
    else if (line.trim()) (story.decisions.length ? story.tail : story.head).push(line.trim());
  }
  return story;
}

/** Why a task was not done, as the page holds it; null: it does not say. */
export function storyOf(run, task) {
  const text = run.reasons?.get(task);
  return text === undefined ? null : run.once(`reasons ${task}`, () => readStory(text));
}

/** The decision of a story that was in force at `decision`; null: none was. */
export function reasonAt(story, decision) {
  return (decision && story.decisions.findLast((d) => d.index <= decision.index)) ?? null;
}

/** "outbid", "impossible, range (constraint 6)": a reason in a few words. */
export function shortReason(reason) {
  const [words] = reason.lines[0].split(": ");
  return words.length <= 48 ? words : `${words.slice(0, 46).replace(/ \S*$/, "")} …`;
}
