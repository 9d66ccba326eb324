#!/usr/bin/env python3
"""The workers of a mission, in Python: muster run SCENARIO --program worker=./worker.py

The other processes notice no difference: same states, same digest as with muster-worker. What it
leaves out: going on where an earlier start of it was killed, answering a world that was, and
failed matches (a disturbance of some scenarios). docs/reference/mission.md and docs/reference/wire.md say the rest.
"""

import argparse
import fractions
import json
import math
import os
import random
import signal
import sys
import time

import muster
from muster.seal import Seal
from muster.transport import LCM

OFFLINE, IDLE, MOVING, WAITING, SENSING, FAILED = 0, 1, 2, 3, 4, 6  # agent_t.status
NONE, WORKER_TO_TASK, SENSE, GO_TO = -1, 4, 7, 9  # action_t.kind
STARTING, READY, RUNNING, ENDED = 0, 1, 2, 4  # process_status_t.state
WORKER = 1  # agent_states_t.kind, ruling_t.agent_kind
NEVER = 2**63 - 1
TYPES = {
    "MUSTER_SCENARIO": muster.scenario_t,
    "MUSTER_CLOCK": muster.clock_t,
    "MUSTER_WORLD": muster.world_state_t,
    "MUSTER_RULINGS": muster.rulings_t,
    "MUSTER_SCHEDULE": muster.schedule_t,
    "MUSTER_LOG": muster.log_status_t,
}


def rounded(x):
    """To the nearest integer, halves up, for numbers from 0."""
    whole = math.floor(x)
    return whole + (x - whole >= 0.5)


class Sender:
    """Numbers messages and keeps each until the recorder has it in the log: `window` of them are
    out at a time, and the oldest is sent again and again. With window 0 nobody records."""

    def __init__(self, lcm, options):
        self.lcm, self.options = lcm, options
        self.seq = self.resent = 0
        self.kept = []  # (seq, channel, bytes), oldest first
        self.out = 0  # of them, sent before
        self.repair_s, self.wait_s = math.inf, 0

    def send(self, channel, message, sim_us):
        header = message.header = muster.header_t()
        header.run_id, header.boot_id = self.options.run_id, self.options.boot_id
        header.sender, header.seq = self.options.name, self.seq
        header.sim_us, header.wall_us = sim_us, time.time_ns() // 1000
        self.kept.append((self.seq, channel, message.encode()))
        self.seq += 1
        return self.kept[-1]

    def again(self, packet):
        if packet not in self.kept[self.out :]:
            self.lcm.publish(*packet[1:])
            self.resent += 1

    def acknowledge(self, status):
        for mark in status.marks:
            if (mark.sender, mark.boot_id) == (self.options.name, self.options.boot_id):
                while self.out > 0 and self.kept[0][0] < mark.next_seq:
                    self.kept.pop(0)
                    self.out -= 1
                    self.repair_s = math.inf

    def flush(self):
        now_s = time.monotonic()
        if now_s >= self.repair_s:
            for packet in self.kept[: min(self.out, 4)]:
                self.again(packet)
            self.wait_s = min(2 * self.wait_s, 0.5)
            self.repair_s = now_s + self.wait_s
        window = self.options.window or len(self.kept)
        while self.out < min(window, len(self.kept)):
            self.lcm.publish(*self.kept[self.out][1:])
            self.out += 1
        if not self.options.window:
            self.kept.clear()
            self.out = 0
        elif self.out > 0 and self.repair_s == math.inf:
            self.wait_s = 0.02
            self.repair_s = now_s + self.wait_s


class Worker:
    """A worker as a function of time: a straight leg, then perhaps sensing with a UAV. The same as
    model/agent.cc, line by line, so that it is the same to the last bit."""

    def __init__(self, spec):
        self.id = int(spec["id"])
        self.speed_m_s = float(spec["speed_km_per_min"] * 1000 / 60)
        self.online_from_us = rounded(spec["online_from_min"] * 60_000_000)
        self.online_until_us = rounded(spec["online_until_min"] * 60_000_000)
        self.start = self.end = (float(spec["x_km"] * 1000), float(spec["y_km"] * 1000))
        self.depart_us = self.arrive_us = self.busy_until_us = 0
        self.action, self.target, self.partner, self.decision = NONE, -1, -1, -1
        self.sensing_us = None  # start of it, once known
        self.failed = False

    def online(self, t):
        return self.online_from_us <= t < self.online_until_us

    def idle(self, t):
        return self.online(t) and not self.failed and self.busy_until_us <= t

    def position(self, t):
        if t >= self.arrive_us:
            return self.end
        if t <= self.depart_us:
            return self.start
        fraction = (t - self.depart_us) / (self.arrive_us - self.depart_us)
        return tuple(a + (b - a) * fraction for a, b in zip(self.start, self.end))

    def status(self, t):
        if self.failed:
            return FAILED
        if self.busy_until_us <= t:
            return IDLE if self.online(t) else OFFLINE
        if t < self.arrive_us:
            return MOVING
        return WAITING if self.sensing_us is None or t < self.sensing_us else SENSING

    def stop(self, t):
        self.start = self.end = self.position(t)
        self.depart_us = self.arrive_us = self.busy_until_us = t
        self.action, self.target, self.partner, self.sensing_us = NONE, -1, -1, None

    def settle(self, activities, rulings, t):
        """Brings the worker to the truth of the world's verdict on the tick at t."""
        activities = [a for a in activities if (a.kind, a.partner_id) == (0, self.id)]
        rulings = [r for r in rulings if (r.agent_kind, r.agent_id) == (WORKER, self.id)]
        fails = [ruling for ruling in rulings if ruling.kind == 0]
        if self.failed and fails:
            return
        for activity in sorted(activities, key=lambda a: (a.start_us, a.uav_id)):
            over = self.action != NONE and self.busy_until_us <= activity.start_us
            if over and self.busy_until_us < activity.end_us and activity.start_us <= t:
                self.stop(self.busy_until_us)
            if activity.start_us < self.depart_us:
                continue
            if self.action == NONE:
                takes = activity.end_us > self.busy_until_us  # they met
            else:
                commanded = self.action, self.partner, self.target
                takes = commanded == (SENSE, activity.uav_id, activity.site_id)
            if takes:
                self.action, self.target, self.partner = SENSE, activity.site_id, activity.uav_id
                self.sensing_us, self.busy_until_us = activity.start_us, activity.end_us
        for ruling in sorted(rulings, key=lambda r: r.kind):
            if ruling.kind == 0 and not self.failed:
                self.stop(ruling.at_us)
            if ruling.kind == 1 and self.action != NONE and ruling.at_us >= self.depart_us:
                self.stop(ruling.at_us)
        self.failed = bool(fails)
        if self.action != NONE and self.busy_until_us <= t:
            self.stop(self.busy_until_us)

    def begin(self, action, decision, now_us):
        self.decision = decision
        if action.kind not in (WORKER_TO_TASK, SENSE, GO_TO):
            return  # it stays
        self.start, self.end = self.end, (action.x_m, action.y_m)
        dx, dy = (a - b for a, b in zip(self.start, self.end))
        way_m = math.sqrt(dx * dx + dy * dy)
        self.depart_us = now_us
        self.arrive_us = now_us + rounded(way_m / self.speed_m_s * 1e6)
        self.action, self.sensing_us = action.kind, None
        self.busy_until_us = NEVER if action.kind == SENSE else self.arrive_us
        self.target = action.task_id if action.task_id >= 0 else action.charge_id
        if action.kind == SENSE:
            self.partner = action.uav_id

    def wire(self, t):
        agent = muster.agent_t()
        agent.id, agent.speed_m_s = self.id, self.speed_m_s
        agent.x_m, agent.y_m = self.position(t)
        agent.from_x_m, agent.from_y_m = self.start
        agent.depart_us, agent.arrive_us = self.depart_us, self.arrive_us
        agent.online_from_us, agent.online_until_us = self.online_from_us, self.online_until_us
        agent.busy_until_us, agent.status = self.busy_until_us, self.status(t)
        agent.action, agent.decision = self.action, self.decision
        agent.target_id, agent.partner_id = self.target, self.partner
        return agent


class Workers:
    """The process. It goes to the next tick when it has the world's clock, the verdict on the
    present tick and the decision that must be in force; asked again, it repeats what it said."""

    def __init__(self, lcm, options):
        self.options, self.sender = options, Sender(lcm, options)
        self.workers = None  # until the scenario has come
        self.state, self.reported, self.heartbeat_s, self.ask_s = STARTING, None, 0, 0
        self.tick, self.tick_us, self.decision = -1, 0, -1
        self.clock = self.repeat = None
        self.world = self.rulings = self.schedule = None  # on the present tick
        self.published = {}  # packets of this tick and the one before
        self.received = self.rejected = 0
        self.luck = random.Random(options.drop_seed)
        for channel in TYPES:
            lcm.subscribe(channel, self.on_packet)

    def on_packet(self, channel, data):
        if self.luck.random() < self.options.drop:
            return
        try:
            message = TYPES[channel].decode(data)
        except Exception:  # the decoder of a damaged message may fail in any way
            self.rejected += 1
            return
        if message.header.run_id != self.options.run_id:
            self.rejected += 1
            return
        self.received += 1
        if channel == "MUSTER_LOG":
            self.sender.acknowledge(message)
        elif channel == "MUSTER_SCENARIO":
            if self.workers is None:
                self.on_scenario(message)
        elif self.workers is None:
            return
        elif channel == "MUSTER_CLOCK":
            self.on_clock(message)
        elif message.tick == self.tick and channel == "MUSTER_WORLD":
            self.world = self.world or message
        elif message.tick == self.tick and channel == "MUSTER_RULINGS":
            self.rulings = self.rulings or message
        elif message.tick == self.tick and message.decision > self.decision:
            self.schedule = self.schedule or message

    def on_scenario(self, message):
        # Exact numbers, rounded once: as the others read them.
        exact = fractions.Fraction
        scenario = json.loads(message.json, parse_float=exact, parse_int=exact)
        if scenario.get("disturbances", {}).get("match_failure", [0, 0])[1] > 0:
            sys.exit("worker.py: scenarios with match_failure are beyond this example")
        first, last = self.options.ids or (0, len(scenario["workers"]) - 1)
        self.workers = [Worker(spec) for spec in scenario["workers"][first : last + 1]]
        self.state = READY

    def on_clock(self, clock):
        if clock.phase == 2:
            self.state = ENDED
        elif clock.phase == 1 and self.state == READY:
            self.state = RUNNING
        if clock.phase < 2 and clock.tick in self.published:
            self.repeat = clock.tick
        if clock.tick == self.tick + 1:
            self.clock = clock

    def ready(self):
        if self.clock is None or self.tick < 0:
            return self.clock is not None
        required = self.clock.required_decision
        decided = self.schedule is not None and self.schedule.decision == required
        return self.world and self.rulings and (required <= self.decision or decided)

    def advance(self):
        if self.tick >= 0:
            for worker in self.workers:
                worker.settle(self.world.activities, self.rulings.rulings, self.tick_us)
            if self.clock.required_decision > self.decision:
                self.decision = self.schedule.decision
                workers = {worker.id: worker for worker in self.workers}
                for action in self.schedule.actions:
                    worker = workers.get(action.worker_id)
                    if worker and worker.idle(self.tick_us):
                        worker.begin(action, self.decision, self.tick_us)
        self.published.pop(self.tick - 1, None)
        self.tick, self.tick_us = self.clock.tick, self.clock.tick_us
        self.clock = self.world = self.rulings = self.schedule = None
        self.published[self.tick] = []
        for at in range(0, len(self.workers), 256):  # near one datagram each
            states = muster.agent_states_t()
            states.kind, states.tick, states.applied_decision = WORKER, self.tick, self.decision
            states.agents = [worker.wire(self.tick_us) for worker in self.workers[at : at + 256]]
            states.n = len(states.agents)
            self.published[self.tick].append(
                self.sender.send("MUSTER_WORKERS", states, self.tick_us)
            )

    def report(self):
        status = muster.process_status_t()
        status.name, status.host, status.pid = self.options.name, os.uname().nodename, os.getpid()
        status.state, status.tick = self.state, self.tick
        status.received = self.received
        status.rejected = self.rejected + self.sender.lcm.refused
        status.resent, status.cpu_s = self.sender.resent, time.process_time()
        self.sender.send("MUSTER_PROCESS", status, self.tick_us)
        self.reported = self.state
        self.heartbeat_s = math.inf if self.state == ENDED else time.monotonic() + 1

    def step(self):
        now_s = time.monotonic()
        if self.workers is None and now_s >= self.ask_s:
            request = muster.request_t()
            request.channel = "MUSTER_SCENARIO"
            self.sender.send("MUSTER_REQUEST", request, 0)
            self.ask_s = now_s + 0.2
        if self.workers is not None and self.ready():
            self.advance()
        elif self.repeat is not None:
            for packet in self.published[self.repeat]:
                self.sender.again(packet)
        self.repeat = None
        if self.state != self.reported or now_s >= self.heartbeat_s:
            self.report()
        self.sender.flush()


def id_range(text):
    first, _, last = text.partition("-")
    return int(first), int(last or first)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lcm-url", default=os.environ.get("LCM_DEFAULT_URL"))
    parser.add_argument("--name", default="worker")
    parser.add_argument("--run-id", type=int, default=1)
    parser.add_argument("--boot-id", type=int, default=0)
    parser.add_argument("--window", type=int, default=0, help="messages that may be out before they are in the log")
    parser.add_argument("--ids", type=id_range, help="of the workers to move, 0-9; default: all")
    parser.add_argument("--key", help="of a sealed mission: a file, or - for a line of stdin")
    parser.add_argument("--drop", type=float, default=0, help="share of packets to lose, 0 to 1")
    parser.add_argument("--drop-seed", type=int, default=1)
    options = parser.parse_args()
    if options.lcm_url is None:
        parser.error("--lcm-url or LCM_DEFAULT_URL must say where the mission is")
    if options.boot_id > 0:
        parser.error("--boot-id: this example cannot go on where an earlier start of it ended")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    seal = Seal.load(options.key, options.run_id) if options.key else None
    lcm = LCM(options.lcm_url, seal)
    process = Workers(lcm, options)
    while True:
        process.step()
        wait_s = min(process.sender.repair_s, process.heartbeat_s) - time.monotonic()
        lcm.handle_timeout(1000 * min(max(wait_s, 0), 0.2))


if __name__ == "__main__":
    main()
