import { say } from "./language.js";
import { itemOf, nameOf } from "./link.js";

export const taskName = (id) => say("task {id}", { id });
export const pointName = (id) => say("charging point {id}", { id });

const LETTERS = ["U", "W", "V"]; // UAV, worker, vehicle

/** "U8", "W46", "V2": an agent on the map, where the full name has no room. */
export const shortName = ({ kind, id }) => `${LETTERS[kind]}${id}`;

/** What stands beside something on the map. */
export function labelOf(run, item) {
  if (item.type === "agent") return nameOf(run, item);
  return item.type === "task" ? taskName(item.id) : say("charge {id}", { id: item.id });
}

/** What matches a name that stands before its number, or around it. */
const pattern = (name) => name.replace(/[.*+?^${}()|[\]\\]/g, "\\$&").replace("@", "\\d+");

/** A text in parts, { text, item }: item is what the part names, in the page's language or, as explanations do, in English; or null. */
export function mentions(run, text) {
  const [tasks, points] = [["task @", taskName("@")], ["charging point @", pointName("@")]].map((names) => names.map(pattern).join("|"));
  const kinds = [[/^(?:uav|worker|vehicle):\d+$/, ""], [new RegExp(`^(?:${tasks})$`), "task:"], [new RegExp(`^(?:${points})$`), "charge:"]];
  return text.split(new RegExp(`((?:uav|worker|vehicle):\\d+|${tasks}|${points})`)).filter(Boolean).map((part) => {
    const [, prefix] = kinds.find(([kind]) => kind.test(part)) ?? [];
    const name = prefix ? `${prefix}${/\d+/.exec(part)[0]}` : part;
    return { text: part, item: prefix === undefined ? null : itemOf(run, name) };
  });
}
