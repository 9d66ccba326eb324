// A run of two tasks and an agent of each class, as its first chunk tells it.
import { Run } from "../../../../tools/report/page/run.js";

export const SCENARIO = {
  name: "two", seed: 1, width_m: 1000, height_m: 1000, interval_ms: 600000, limit_ms: 3600000, tick_ms: 30000,
  uavs: 1, workers: 1, vehicles: 1, tasks: [100, 100, 50, 900, 900, 60], charging_points: [500, 500, null], range_full_m: [30000],
};

export const WORDS = {
  agents: ["uav", "worker", "vehicle"], statuses: ["offline", "idle", "moving", "waiting", "sensing", "charging", "failed", "not ready"],
  tasks: ["open", "reserved", "sensing", "done", "unreported", "expired", "cancelled", "held"],
  actions: ["Ui", "Wj", "Vk", "UiTx", "WjTx", "UiCy", "VkCy", "UiTxWj", "UiCyVk", "go"],
  activities: ["sensing", "charging"], processes: ["starting", "ready", "running", "degraded", "ended", "deciding"],
};

/** The run, with what `more` has of its first chunk. */
export function begun(more = {}) {
  const run = new Run();
  run.apply({ version: 1, name: "r", scenario: SCENARIO, words: WORDS, now_ms: 0, epoch_ms: 0, ended: false, ...more });
  return run;
}
