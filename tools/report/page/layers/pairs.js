import { shortName } from "../names.js";
import { CHARGING, SENSING, UAV } from "../words.js";

const TOGETHER_PX = 3;

/**
 * Those in view that work together at one place: { pairs: [{ uav, partner }] (items), partners (agents, all but UAVs), names: "U8 W46" by
 * the pair's UAV }. Only where a UAV and one partner are there: of more nobody can tell who works with whom.
 */
export function pairsOf(near) {
  const places = new Map();
  for (const item of near) {
    if (item.status !== SENSING && item.status !== CHARGING) continue;
    const key = `${Math.round(item.place.x)} ${Math.round(item.place.y)}`;
    if (!places.has(key)) places.set(key, []);
    places.get(key).push(item);
  }
  const pairs = [...places.values()].filter((items) => items.length === 2).map((items) => ({
    uav: items.find(({ agent }) => agent.kind === UAV), partner: items.find(({ agent }) => agent.kind !== UAV) }))
    .filter(({ uav, partner }) => uav && partner && Math.hypot(uav.px - partner.px, uav.py - partner.py) < TOGETHER_PX);
  return { pairs, partners: new Set(pairs.map(({ partner }) => partner.agent)),
    names: new Map(pairs.map(({ uav, partner }) => [uav.agent, `${shortName(uav.agent)} ${shortName(partner.agent)}`])) };
}
