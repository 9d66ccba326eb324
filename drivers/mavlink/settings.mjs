// An autopilot's settings and its fence: what a flight relies on is set, what was there before is put back. Until then it is
// kept in a file, so that a driver that is killed loses nothing: the next one, or --restore, finds it.
import { readFence, writeFence as writeItems } from "./fence.mjs";
import { isClose, Trouble } from "./talk.mjs";

export class Settings {
  /** `kept`: {load() -> object or null, save(object), drop()}; `note`: takes words for people. */
  constructor(talk, kept, note) {
    Object.assign(this, { talk, kept, note });
  }

  /** Sets what a flight needs; returns it, by name. `wanted`: of autopilots.mjs; `writeFence()`: does that. */
  *apply(wanted, writeFence) {
    const before = this.kept.load() ?? { settings: {}, fence: yield* readFence(this.talk) };
    const plans = [];
    for (const setting of wanted) {
      const plan = yield* this.#plan(setting);
      if (plan) plans.push(plan);
      else if (setting.needed) throw new Trouble(`it has no setting ${setting.name}`);
    }
    for (const { name, now, type } of plans) before.settings[name] ??= { value: now, type };
    this.kept.save(before);
    yield* this.#write(plans.filter((plan) => !plan.afterFence));
    yield* writeFence();
    yield* this.#write(plans.filter((plan) => plan.afterFence));
    return Object.fromEntries(plans.map(({ name, to }) => [name, to]));
  }

  /** Puts back what was there, the fence's switch first. Returns whether all of it is. */
  *restore() {
    const before = this.kept.load();
    if (!before) return true;
    const missing = [];
    for (const [name, { value, type }] of Object.entries(before.settings).reverse()) {
      if (!(yield* this.talk.write(name, value, type))) missing.push(name);
    }
    try {
      yield* writeItems(this.talk, before.fence);
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      missing.push("its fence");
    }
    if (missing.length) this.note(`not put back: ${missing.join(", ")}; --restore tries again`);
    else this.kept.drop();
    return !missing.length;
  }

  *#plan(setting) {
    const called = [setting, setting.otherwise].filter(Boolean);
    const found = yield* this.talk.read(...called.map(({ name }) => name));
    if (!found) return null;
    const { value } = called.find(({ name }) => name === found.name);
    const others = setting.from ? { [setting.from]: (yield* this.talk.read(setting.from))?.value } : {};
    const to = typeof value === "function" ? value(found.value, others) : value;
    if (!Number.isFinite(to)) return null;
    return { name: found.name, to, now: found.value, type: found.type, afterFence: setting.afterFence };
  }

  *#write(plans) {
    for (const { name, to, now, type } of plans) {
      if (isClose(now, to)) continue;
      if (!(yield* this.talk.write(name, to, type))) throw new Trouble(`its setting ${name} cannot be set to ${to}`);
    }
  }
}
