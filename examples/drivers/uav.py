#!/usr/bin/env python3
"""A driver in Python: a UAV that flies straight to where it is sent, as it is told to (docs/guide/drivers.md).

Try it: muster drive --check examples/drivers/uav.py
--late P: it flies P % longer. --silent FROM:UNTIL: it says nothing between these minutes. --dies MINUTE: it ends then. --ready MINUTE: it cannot
set out before. --calls MINUTE: it calls for help then, and is all right ten minutes later.
"""

import argparse
import json
import sys

options = argparse.ArgumentParser()
options.add_argument("--late", type=float, default=0)
options.add_argument("--silent", default="0:0")
options.add_argument("--dies", type=float, default=1e9)
options.add_argument("--ready", type=float, default=0)
options.add_argument("--calls", type=float, default=1e9)
options = options.parse_args()
calls = [(options.calls, {"text": "a rotor is loose", "help": True}), (options.calls + 10, {"text": "all right again"})]
silent_from_s, silent_until_s = (60 * float(minute) for minute in options.silent.split(":"))


def say(**line):
    print(json.dumps(line), flush=True)


me, leg, work, now = None, None, None, 0.0  # leg: what it flies to; work: what it senses or charges
for told in map(json.loads, sys.stdin):
    kind, now = told["type"], told.get("mission_s", now)
    if kind == "bye" or now >= 60 * options.dies:
        sys.exit(0 if kind == "bye" else 1)
    if kind == "hello":
        me = {"x_m": told["at"]["x_m"], "y_m": told["at"]["y_m"]}
        say(type="hello", version=1, name="uav.py", **({"not_ready": f"minute {options.ready:g}"} if options.ready else {}))
    elif kind == "goto":
        took_s = (told["expected_s"] - now) * (1 + options.late / 100)
        leg, work = {**told, "from": me, "left_s": now, "there_s": now + took_s}, None
    elif kind in ("sense", "charge"):
        leg, work = None, told
    elif kind == "cancel":
        leg = work = None
    elif kind == "time" and options.ready and now >= 60 * options.ready:
        say(type="ready")
        options.ready = 0
    if kind == "time" and calls and now >= 60 * calls[0][0]:
        say(type="message", **calls.pop(0)[1])
    if kind == "time" and not silent_from_s <= now < silent_until_s:
        if leg:
            part = min(1, (now - leg["left_s"]) / max(1e-9, leg["there_s"] - leg["left_s"]))
            me = {axis: leg["from"][axis] + part * (leg["to"][axis] - leg["from"][axis]) for axis in me}
            if part == 1:
                say(type="arrived", id=leg["id"])
        if work and now >= work["mission_s"] + work["for_s"]:
            say(type="done", id=work["id"])
            work = None
        if leg and part < 1:
            say(type="state", at=me, mission_s=now, expected_s=leg["there_s"])
        else:
            say(type="state", at=me, mission_s=now)
            leg = None
