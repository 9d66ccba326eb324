// Presses the buttons itself, to try a mission without a person: goes straight at the agent's speed, and does what it is told to.
import { distance_m } from "../places.mjs";

export function beAuto(phone) {
  let id = 0;
  const press = (type, order) => phone.sync({ sent_ms: 0, items: [{ id: `auto-${String(++id).padStart(8, "0")}`, session: phone.session, at_ms: 0, type, order }] });
  phone.beforeTick = () => {
    const { order, track, mission_s } = phone;
    if (order?.stage === "going") {
      const left_s = mission_s - track.last.mission_s, way_s = distance_m(track.last.at, order.to) / track.speed_m_s;
      if (left_s >= way_s - 1e-6) press("here", order.goto.id);
      else track.see(along(track.last.at, order.to, left_s / way_s), mission_s);
    } else {
      if (order?.stage === "working" && mission_s >= order.work.mission_s + order.work.for_s) press("done", order.work.id);
      track.see(track.last.at, mission_s);
    }
  };
}

function along(from, to, part) {
  return { x_m: from.x_m + part * (to.x_m - from.x_m), y_m: from.y_m + part * (to.y_m - from.y_m) };
}
