// How things are, in words.
import { say } from "./language.mjs";
import { ahead, apart, lengthOf } from "./way.mjs";

/** A partner who comes so much later is worth a line. */
const LATER_S = 60;
const two = (n) => String(n).padStart(2, "0");

export function clock(seconds) {
  const s = Math.max(0, Math.round(seconds));
  return `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}:${two(s % 60)}`;
}

export function duration(seconds) {
  const s = Math.abs(Math.round(seconds));
  if (s < 60) return `${s} s`;
  return s < 3600 ? `${Math.round(s / 60)} min` : `${Math.floor(s / 3600)} h ${Math.round(s / 60) % 60} min`;
}

export function length(m) {
  return m < 1000 ? `${Math.round(m / 10) * 10} m` : `${(m / 1000).toFixed(1)} km`;
}

const COURSES = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];
/** From where one looks. */
const TURNS = ["ahead of you", "ahead on the right", "on the right", "behind on the right", "behind you", "behind on the left", "on the left", "ahead on the left"];

const eighth = (radians) => ((Math.round(radians / (Math.PI / 4)) % 8) + 8) % 8;
const bearing = (from, to) => Math.atan2(to.x_m - from.x_m, to.y_m - from.y_m);

export const direction = (from, to) => COURSES[eighth(bearing(from, to))];

/** `heading_deg`: where one looks, from north to east. */
export const turn = (from, to, heading_deg) => TURNS[eighth(bearing(from, to) - (heading_deg * Math.PI) / 180)];

/** "0:42:10, in 12 min"; the wall's time as well where the mission keeps step with it. */
function when(at_s, now_s, rate, wall_ms) {
  const left_s = at_s - now_s;
  const wall = rate === 1 ? ` (${new Date(wall_ms + 1000 * left_s).toTimeString().slice(0, 5)})` : "";
  return say(left_s >= 0 ? "{time}, in {left}" : "{time}, late by {left}", { time: clock(at_s) + wall, left: duration(left_s) });
}

function goal({ task, task_name: name, charging_point: n }) {
  if (task !== null) return name ? say("task {n}, {name}", { n: task, name }) : say("task {n}", { n: task });
  return n !== null ? say("charging point {n}", { n }) : say("the place");
}

export function title(view) {
  const { order } = view;
  if (view.failed) return say("You are out of the mission");
  if (view.over !== null) return say("The mission is over for you");
  if (!view.agent) return say("Waiting for the mission");
  if (!order && view.isPaused) return say("You have a break");
  if (!order) return view.stopped ? say("Stop where you are") : say("Nothing to do yet");
  const { partner } = order;
  if (order.stage === "working") return say(order.work === "sense" ? "At {goal}: the UAV is at work" : "At {goal}: change the battery", { goal: goal(order) });
  if (order.stage === "finished") return say("Done; wait here");
  if (order.stage === "there") return partner ? say("Wait here for {partner}", { partner }) : say("Wait here");
  return say("Go to {goal}", { goal: goal(order) });
}

function withoutOrder(view, now_s, wall_ms) {
  if (view.isPaused) return [say("You are sent nowhere until your break is over.")];
  if (view.stopped) return [say(view.stopped), say("Stay where you are until you are sent somewhere.")];
  if (now_s < view.online_from_s) return [say("You take part from {when}.", { when: when(view.online_from_s, now_s, view.rate, wall_ms) })];
  return [say("Stay where you are.")];
}

/** How important the task is, and until when it is to be done. */
function urgency({ priority, due_s }, now_s, rate, wall_ms) {
  const found = [];
  if (priority === 3) found.push(say("An emergency"));
  if (priority === 2) found.push(say("Of high priority"));
  if (due_s !== null) found.push(say("To be done by {when}", { when: when(due_s, now_s, rate, wall_ms) }));
  return found;
}

/** Lines under the title; `now_s`: the mission's time; `heading_deg`: where the phone points, or null. */
export function lines(view, now_s, wall_ms, heading_deg = null) {
  const { order, rate } = view;
  if (view.failed) return [say(view.failed)];
  if (view.over !== null) return [say(view.over), say("You may close this page.")];
  if (!view.agent) return [];
  if (!order) return withoutOrder(view, now_s, wall_ms);
  const { partner } = order;
  const note = order.task_note ? [order.task_note] : [];
  const onBreak = view.isPaused ? [say("Your break begins when this is done.")] : [];
  if (order.stage === "working") {
    return [say("With {partner}. Planned until {when}.", { partner, when: when(order.ends_s, now_s, rate, wall_ms) }),
      say("Press \"{word}\" when it is.", { word: say(order.work === "sense" ? "Done" : "Battery changed") }), ...note, ...onBreak];
  }
  if (order.stage === "finished") return [say("You will be told where to go next."), ...onBreak];
  const meeting = partner && order.meeting_s !== null && order.meeting_s > now_s
    ? [say("{partner} is expected at {when}", { partner, when: when(order.meeting_s, now_s, rate, wall_ms) })] : [];
  if (order.stage === "there") return [partner ? say("It comes for {goal}.", { goal: goal(order) }) : say("You will be told where to go next."), ...meeting, ...note, ...onBreak];
  const from = view.place ?? view.told;
  const rest = order.way ? ahead(order.way, from) : [from, order.to];
  const next = order.way ? rest[1] ?? order.to : order.to;
  const course = { length: length(order.way ? lengthOf(rest) : apart(from, order.to)), direction: say(`to the ${direction(from, order.to)}`) };
  const found = [
    say(order.way ? "{length} by road {direction}" : "{length} {direction}", course),
    ...(heading_deg === null ? [] : [say(turn(from, next, heading_deg))]),
    say("By {when}", { when: when(order.expected_s, now_s, rate, wall_ms) }),
    partner ? say("With {partner}", { partner }) : say("Alone"),
    ...(order.meeting_s > order.expected_s + LATER_S ? meeting : []),
    ...urgency(order, now_s, rate, wall_ms),
    ...note,
    ...onBreak,
  ];
  if (order.held_until_s !== null) {
    found.push(say("You said that you are there. The mission takes it at {time}: sooner is more than its {speed} m/s.", { time: clock(order.held_until_s), speed: Number(view.speed_m_s.toFixed(1)) }));
  }
  return found;
}

/** What the button says: {text, type, order}; null: nothing to press. */
export function action(view) {
  const { order } = view;
  if (!order || view.failed || view.over !== null) return null;
  if (order.stage === "going") return { text: say("I am here"), type: "here", order: order.goto };
  if (order.stage !== "working") return null;
  return { text: say(order.work === "sense" ? "Done" : "Battery changed"), type: "done", order: order.id };
}

/** Of the phone's place. `gps`: why the phone itself tells none, or "". */
export function whereabouts(view, gps, now_s) {
  if (!view.agent) return "";
  if (!view.has_origin) return say("This mission is nowhere on the earth: your place is not used, the buttons are.");
  if (!view.place) return gps ? say("Your place is not known: {why}. The buttons work without it.", { why: gps }) : say("Your place is not known. The buttons work without it.");
  const { accuracy_m, trouble, mission_s } = view.place;
  const age_s = now_s - mission_s;
  const known = { m: Math.round(accuracy_m), age: duration(age_s) };
  const parts = [say(age_s > 60 * Math.max(1, view.rate) ? "Your place is good to {m} m, {age} old." : "Your place is good to {m} m.", known)];
  if (trouble === "inexact") parts.push(say("Worse than {m} m is not told to the mission.", { m: view.accuracy_m }));
  if (trouble === "outside") parts.push(say("You are outside the mission's area: that is not told to the mission."));
  if (!trouble && view.told.is_limited) parts.push(say("You are ahead of the {speed} m/s that the mission takes for possible: it sees you at the ring.", { speed: Number(view.speed_m_s.toFixed(1)) }));
  return parts.join(" ");
}
