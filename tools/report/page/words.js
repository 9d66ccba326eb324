/** Numbers of the wire by the names that a run's first chunk has for them: there are none before one was read. */
export let UAV, WORKER, VEHICLE;
/** Statuses of agents. */
export let OFFLINE, IDLE, MOVING, WAITING, SENSING, CHARGING, FAILED, NOT_READY;
/** Statuses of tasks. */
export let OPEN, RESERVED, BEING_SENSED, DONE, UNREPORTED, EXPIRED, CANCELLED, HELD;
/** Kinds of actions: the last one that sends nobody, and those of pairs. */
export let LAST_STAY, SENSE, CHARGE;
/** The kind of an activity that charges; the other one senses. */
export let CHARGES;
/** The state of a process whose decision takes it long. */
export let DECIDING;

const numbers = (names) => Object.fromEntries(names.map((name, number) => [name, number]));

/** Names are the same in all runs; the scene's script, which is unpacked later, reads them for itself. */
export function readWords({ agents, statuses, tasks, actions, activities, processes }) {
  ({ uav: UAV, worker: WORKER, vehicle: VEHICLE } = numbers(agents));
  ({ offline: OFFLINE, idle: IDLE, moving: MOVING, waiting: WAITING, sensing: SENSING, charging: CHARGING, failed: FAILED,
    "not ready": NOT_READY } = numbers(statuses));
  ({ open: OPEN, reserved: RESERVED, sensing: BEING_SENSED, done: DONE, unreported: UNREPORTED, expired: EXPIRED, cancelled: CANCELLED,
    held: HELD } = numbers(tasks));
  ({ Vk: LAST_STAY, UiTxWj: SENSE, UiCyVk: CHARGE } = numbers(actions));
  ({ charging: CHARGES } = numbers(activities));
  ({ deciding: DECIDING } = numbers(processes));
}
