#!/usr/bin/env python3
"""Prints how many tasks were done when, as CSV: tasks_over_time.py RUN/mission.lcm"""

import sys

from muster import event_t
from muster.transport import EventLog

SENSING_DONE = 5  # event_t.kind

done = 0
seen = set()
print("minute,tasks_done")
for event in EventLog(sys.argv[1]):
    if event.channel != "MUSTER_EVENT":
        continue
    message = event_t.decode(event.data)
    key = message.header.sender, message.header.boot_id, message.header.seq
    if key in seen:  # repeated until it was logged
        continue
    seen.add(key)
    if message.kind == SENSING_DONE:
        done += 1
        print(f"{message.at_us / 60e6:.2f},{done}")
