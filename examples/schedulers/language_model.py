#!/usr/bin/env python3
"""The language-model baseline of HoCs-MPQ's appendix D, with a model of yours.

  language_model.py --command 'PROGRAM ARGUMENT...'   reads a prompt on stdin, prints an answer
  language_model.py --url URL --model NAME            OpenAI-compatible, e.g. http://localhost:8080/v1/chat/completions

An API key is taken from the environment (MUSTER_MODEL_KEY). Combinations that are not understood, not offered, or in
conflict with an earlier one are left out and counted; the counts go to stderr, at the end and where there are some.
"""

import argparse
import collections
import json
import os
import re
import shlex
import subprocess
import sys
import urllib.request

PROMPT = """\
Prompt Template: Multi-Agent Scheduling for Post-Disaster Perception

Problem Overview:
A post-disaster environment requires coordination of three agent types (UAVs, vehicles, and workers) to complete \
perception tasks at task points and being charged at charge points.

Agents & Locations:
Agent Types
- UAVs: Primary task executors requiring periodic charging
- Workers: Task assistants (must collaborate with UAVs)
- Vehicles: Charge assistants (for UAVs)
Location Types
- Task Points: Require UAV and Worker collaboration
- Charge Points: Provide UAV charging via Vehicles

Valid Combinations:
- UAV Stays Put
- Worker Stays Put
- Vehicle Stays Put
- UAV Moves to Task Point
- Worker Moves to Task Point
- UAV Moves to Charge Point
- Vehicle Moves to Charge Point
- Task Execution: UAV + Worker move to Task Point
- Charging Operation: UAV + Vehicle move to Charge Point

Critical Constraints:
- Availability Window: Must operate within agent-specific [up, down] time ranges
- State Dependency: Only idle agents can be scheduled

State Transition Rules:
Task Completion:
- Position Update: UAV & Worker move to task point
- Time Cost: max(movement time) + (T_costPow/UAV_speed)
- Power Update: UAV_power -= (movement time + T_costPow)
Charging Completion:
- Position Update: UAV & Vehicle move to charge point
- Time Cost: max(movement time) + (Fullpower - current_power)/V_chargePow
- Power Update: UAV_power = Fullpower

Input Data Structure:
- UAV Data: id, x, y, uRge, Fullpower, uPow, U_uptime, U_downtime
- Worker Data: id, x, y, wRge, W_uptime, W_downtime
- Vehicle Data: id, x, y, vRge, V_uptime, V_downtime, V_chargePow
- Task Data: id, x, y, T_costPow
- Charging Data: id, x, y

Optimization Objective:
- Time Horizon: 0-{limit:g} units ({decisions} decision points @ {interval:g}-unit intervals)
- Primary Goal: Maximize completed tasks while preventing UAV power depletion
- Required Output:
  a) Scheduling decisions at each interval
  b) Total completed tasks count

Current System State:
Time: {now:g} units (a unit is a minute, positions are km, uRge, wRge, vRge km per unit, power km)
{tables}

Please answer:
Which agent-target pairing combination should be prioritized at the current decision interval to maximize task \
completion while maintaining UAV survivability?

Requirements:
- Choose only ONE combination (Task or Charging)
- Follow analysis steps:
  Step 1: Determine whether the UAV is performing a task or going to charge.
  Step 2: Evaluate the assistant (worker, vehicle) situation of the UAVs.
  Step 3: Select optimal combination based on above priorities
- Final answer must use: <combination> ; <combination> ; ...
  A combination names its agents and its place, e.g. UAV 3 + Worker 5 + Task 17 or UAV 2 + Vehicle 0 + Charge 4
"""

KINDS = {("uav",): "Ui", ("worker",): "Wj", ("vehicle",): "Vk", ("task", "uav"): "UiTx",
         ("task", "worker"): "WjTx", ("charge", "uav"): "UiCy", ("charge", "vehicle"): "VkCy",
         ("task", "uav", "worker"): "UiTxWj", ("charge", "uav", "vehicle"): "UiCyVk"}
LETTERS = {"u": "uav", "w": "worker", "v": "vehicle", "t": "task", "c": "charge"}
PART = re.compile(r"\b(uav|u|worker|w|vehicle|v|task|t|charg(?:e|ing)|c)(?:[\s_]*point)?[\s_#:]*(\d+)\b", re.I)
STRANGE = re.compile(r"stays?|put|moves?|to|at|and|with|execution|operation|task|charg(?:e|ing)|point|[^a-z]", re.I)


def table(title, columns, rows):
    lines = [", ".join(f"{value:g}" for value in row) for row in rows]
    return "\n".join([f"{title}: {columns}", *(lines or ["none"])])


def prompt_for(s):
    """The appendix's template with the tables of a situation: idle agents, open tasks, free places."""
    def agents(kind, full):
        for a in s[kind]:
            if a["idle"]:
                times = (a["online_from_s"] / 60, a["online_until_s"] / 60)
                yield (a["id"], a["x_m"] / 1e3, a["y_m"] / 1e3, a["speed_m_s"] * 0.06, *full(a), *times)

    workers = agents("workers", lambda a: ())
    uavs = agents("uavs", lambda a: (a["range_full_m"] / 1e3, a["range_m"] / 1e3))
    vehicles = ((*row, rate) for row, rate in zip(
        agents("vehicles", lambda a: ()),
        [a["charge_rate_m_s"] * 0.06 for a in s["vehicles"] if a["idle"]]))
    tasks = ((t["id"], t["x_m"] / 1e3, t["y_m"] / 1e3, t["cost_m"] / 1e3)
             for t in s["tasks"] if t["status"] == "open")
    points = ((c["id"], c["x_m"] / 1e3, c["y_m"] / 1e3)
              for c in s["charging_points"] if c["free"] is None or c["free"] > 0)
    tables = [table("UAV Data", "id, x, y, uRge, Fullpower, uPow, U_uptime, U_downtime", uavs),
              table("Worker Data", "id, x, y, wRge, W_uptime, W_downtime", workers),
              table("Vehicle Data", "id, x, y, vRge, V_uptime, V_downtime, V_chargePow", vehicles),
              table("Task Data", "id, x, y, T_costPow", tasks),
              table("Charging Data", "id, x, y", points)]
    limit, interval = s["rules"]["limit_s"] / 60, s["rules"]["interval_s"] / 60
    return PROMPT.format(limit=limit, interval=interval, decisions=-int(-limit // interval),
                         now=s["now_s"] / 60, tables="\n".join(tables))


def combinations_in(answer):
    """The texts between the semicolons behind the last "final answer", else of the last line."""
    behind = re.split(r"final answer\W*", answer, flags=re.I)
    lines = [line for line in behind[-1].splitlines() if line.strip()]
    if not lines:
        return []
    text = " ".join(lines) if len(behind) > 1 else lines[-1]
    return [part.strip(" .*`<>()[]\t") for part in text.split(";") if part.strip(" .*`<>()[]\t")]


def node_of(combination, by_name):
    """Index of the node that it names, or why there is none."""
    parts = [(LETTERS[word[0].lower()], int(number)) for word, number in PART.findall(combination)]
    kind = KINDS.get(tuple(sorted(name for name, _ in parts)))
    if kind is None or STRANGE.sub("", PART.sub("", combination)):
        return "not understood"
    return by_name.get((kind, frozenset(parts)), "not offered")


def usable(answer, situation, counts):
    """Nodes that may be done together, the first named first."""
    by_name = {(node["kind"], frozenset((name, node[name]) for name in LETTERS.values() if name in node)): i
               for i, node in enumerate(situation["nodes"] or [])}
    free = [float("inf") if e["admits"] is None else e["admits"] for e in situation["elements"] or []]
    nodes = []
    for combination in combinations_in(answer):
        counts["combinations"] += 1
        node = node_of(combination, by_name)
        if isinstance(node, int) and any(free[e] < 1 for e in situation["nodes"][node]["elements"]):
            node = "in conflict"
        if isinstance(node, int):
            nodes.append(node)
            for e in situation["nodes"][node]["elements"]:
                free[e] -= 1
        else:
            counts[node] += 1
            print(f"decision {situation['decision']}: {node}: {combination[:100]!r}", file=sys.stderr)
    return nodes


def ask(options, prompt):
    """What the model says. Any OSError, ValueError or subprocess error: it says nothing."""
    if options.command:
        return subprocess.run(shlex.split(options.command), input=prompt, capture_output=True, text=True, check=True,
                              timeout=options.seconds, errors="replace").stdout
    body = {"model": options.model, "messages": [{"role": "user", "content": prompt}], "temperature": 0}
    headers = {"Content-Type": "application/json"}
    if os.environ.get("MUSTER_MODEL_KEY"):
        headers["Authorization"] = "Bearer " + os.environ["MUSTER_MODEL_KEY"]
    request = urllib.request.Request(options.url, json.dumps(body).encode(), headers)
    with urllib.request.urlopen(request, timeout=options.seconds) as reply:
        text = json.loads(reply.read(1 << 24))["choices"][0]["message"]["content"]
    if not isinstance(text, str):
        raise ValueError("the reply's content is no text")
    return text


def say_counts(counts):
    unusable = counts["not understood"] + counts["not offered"] + counts["in conflict"]
    print(f"language model: {counts['prompts']} prompts, {counts['no answer']} without an answer; "
          f"{counts['combinations']} combinations, {unusable} unusable: {counts['not understood']} not understood, "
          f"{counts['not offered']} not offered, {counts['in conflict']} in conflict", file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command")
    parser.add_argument("--url")
    parser.add_argument("--model", default="default")
    parser.add_argument("--seconds", type=float, default=60, help="for an answer of the model (default: 60)")
    options = parser.parse_args()
    if bool(options.command) == bool(options.url):
        parser.error("one of --command and --url")
    counts = collections.Counter()
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "hello":
            reply = {"type": "hello", "version": 1, "name": "language model", "want": ["nodes"],
                     "deadline_s": min(600, options.seconds + 10)}
        else:
            counts["prompts"] += 1
            try:
                answer = ask(options, prompt_for(message))
            except (OSError, ValueError, LookupError, TypeError, subprocess.SubprocessError) as error:
                counts["no answer"] += 1
                print(f"decision {message['decision']}: no answer: {error}", file=sys.stderr)
                answer = ""
            reply = {"type": "decision", "id": message["id"], "nodes": usable(answer, message, counts)}
        print(json.dumps(reply), flush=True)
    say_counts(counts)


if __name__ == "__main__":
    main()
