#!/usr/bin/env python3
"""A scheduler in Python: each UAV senses the nearest task with the worker who is there first, or charges.

Try it: muster policies check examples/schedulers/nearest.py
"""

import json
import math
import sys


def way(a, b):
    return math.hypot(a["x_m"] - b["x_m"], a["y_m"] - b["y_m"])


def arrives(agent, place, now):
    return now + way(agent, place) / agent["speed_m_s"]


def decide(s):
    """The nearest task or charging point of each UAV that has the range, the time and a partner."""
    now, actions = s["now_s"], []
    idle = {kind: [a for a in s[kind] if a["idle"]] for kind in ("uavs", "workers", "vehicles")}
    tasks = [t for t in s["tasks"] if t["status"] == "open"]
    points = [c for c in s["charging_points"] if c["free"] is None or c["free"] > 0]

    def pair(uav, kind, partners, site, site_name, duration):
        """Takes the partner who is there first, if both have the time."""
        for partner in sorted(partners, key=lambda p: arrives(p, site, now)):
            end = max(arrives(uav, site, now), arrives(partner, site, now)) + duration(partner) + 1
            if end <= min(uav["online_until_s"], partner["online_until_s"], s["rules"]["limit_s"]):
                partners.remove(partner)
                actions.append({"kind": kind, "uav": uav["id"], site_name: site["id"],
                                "worker" if site_name == "task" else "vehicle": partner["id"]})
                return True
        return False

    for uav in idle["uavs"]:
        low = uav["range_m"] < 0.3 * uav["range_full_m"]
        for site in sorted(points if low else tasks, key=lambda p: way(uav, p)):
            need = way(uav, site) + (0 if low else site["cost_m"] + (site["to_charge_m"] or 0))
            if need + 1 > uav["range_m"]:
                continue
            missing = uav["range_full_m"] - uav["range_m"] + way(uav, site)
            if pair(uav, "UiCyVk" if low else "UiTxWj", idle["vehicles" if low else "workers"], site,
                    "charge" if low else "task", lambda p: missing / p["charge_rate_m_s"] if low
                    else site["cost_m"] / uav["speed_m_s"]):
                (points if low else tasks).remove(site)
                break
    return actions


for line in sys.stdin:
    message = json.loads(line)
    answer = {"type": "hello", "version": 1, "name": "nearest"}
    if message["type"] == "situation":
        answer = {"type": "decision", "id": message["id"], "actions": decide(message)}
    print(json.dumps(answer), flush=True)
