// How things are, in words.
import { ahead, apart, lengthOf } from "./way.mjs";

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

export function direction(from, to) {
  const turn = Math.atan2(to.x_m - from.x_m, to.y_m - from.y_m) / (Math.PI / 4);
  return COURSES[((Math.round(turn) % 8) + 8) % 8];
}

/** "by 0:42:10, in 12 min"; the wall's time as well where the mission keeps step with it. */
function when(at_s, now_s, rate, wall_ms) {
  const left_s = at_s - now_s;
  const wall = rate === 1 ? ` (${new Date(wall_ms + 1000 * left_s).toTimeString().slice(0, 5)})` : "";
  return `${clock(at_s)}${wall}, ${left_s >= 0 ? "in" : "late by"} ${duration(left_s)}`;
}

function goal({ task, task_name: name, charging_point }) {
  if (task !== null) return name ? `task ${task}, ${name}` : `task ${task}`;
  return charging_point !== null ? `charging point ${charging_point}` : "the place";
}

export function title(view) {
  const { order } = view;
  if (view.failed) return "You are out of the mission";
  if (view.over !== null) return "The mission is over for you";
  if (!view.agent) return "Waiting for the mission";
  if (!order) return view.stopped ? "Stop where you are" : "Nothing to do yet";
  if (order.stage === "working") return order.work === "sense" ? `At ${goal(order)}: the UAV is at work` : `At ${goal(order)}: change the battery`;
  if (order.stage === "finished") return "Done; wait here";
  if (order.stage === "there") return order.partner ? `Wait here for ${order.partner}` : "Wait here";
  return `Go to ${goal(order)}`;
}

/** Lines under the title; `now_s`: the mission's time. */
export function lines(view, now_s, wall_ms) {
  const { order } = view;
  if (view.failed) return [view.failed];
  if (view.over !== null) return [view.over, "You may close this page."];
  if (!view.agent) return [];
  if (!order) {
    if (view.stopped) return [view.stopped, "Stay where you are until you are sent somewhere."];
    return now_s < view.online_from_s ? [`You take part from ${when(view.online_from_s, now_s, view.rate, wall_ms)}.`] : ["Stay where you are."];
  }
  if (order.stage === "working") {
    const word = order.work === "sense" ? "Done" : "Battery changed";
    return [`With ${order.partner}. Planned until ${when(order.ends_s, now_s, view.rate, wall_ms)}.`, `Press "${word}" when it is.`];
  }
  if (order.stage === "finished") return ["You will be told where to go next."];
  if (order.stage === "there") return order.partner ? [`It comes for ${goal(order)}.`] : ["You will be told where to go next."];
  const from = view.place ?? view.told;
  const left_m = order.way ? lengthOf(ahead(order.way, from)) : apart(from, order.to);
  const found = [
    `${length(left_m)}${order.way ? " by road" : ""} to the ${direction(from, order.to)}`,
    `By ${when(order.expected_s, now_s, view.rate, wall_ms)}`,
    order.partner ? `With ${order.partner}` : "Alone",
  ];
  if (order.held_until_s !== null) found.push(`You said that you are there. The mission takes it at ${clock(order.held_until_s)}: sooner is more than its ${view.speed_m_s} m/s.`);
  return found;
}

/** What the button says: {text, type, order}; null: nothing to press. */
export function action(view) {
  const { order } = view;
  if (!order || view.failed || view.over !== null) return null;
  if (order.stage === "going") return { text: "I am here", type: "here", order: order.goto };
  if (order.stage !== "working") return null;
  return { text: order.work === "sense" ? "Done" : "Battery changed", type: "done", order: order.id };
}

/** Of the phone's place. `gps`: why the phone itself tells none, or "". */
export function whereabouts(view, gps, now_s) {
  if (!view.agent) return "";
  if (!view.has_origin) return "This mission is nowhere on the earth: your place is not used, the buttons are.";
  if (!view.place) return `Your place is not known${gps ? `: ${gps}` : ""}. The buttons work without it.`;
  const { accuracy_m, trouble, mission_s } = view.place;
  const age_s = now_s - mission_s;
  const parts = [`Your place is good to ${Math.round(accuracy_m)} m${age_s > 60 * Math.max(1, view.rate) ? `, ${duration(age_s)} old` : ""}.`];
  if (trouble === "inexact") parts.push(`Worse than ${view.accuracy_m} m is not told to the mission.`);
  if (trouble === "outside") parts.push("You are outside the mission's area: that is not told to the mission.");
  if (!trouble && view.told.is_limited) parts.push(`You are ahead of the ${view.speed_m_s} m/s that the mission takes for possible: it sees you at the ring.`);
  return parts.join(" ");
}
