#!/usr/bin/env python3
"""Plays a language model: reads the prompt of appendix D and names pairs of near agents and places, among nonsense.

scripted_model.py: once, stdin to stdout. scripted_model.py --serve FILE: as an OpenAI-compatible server on a free port of
the loopback, whose URL it writes to FILE; it refuses who has no key, and every fourth prompt.
"""

import http.server
import json
import math
import os
import sys


def table(prompt, title):
    lines = prompt[prompt.rindex(title + ":"):].splitlines()[1:]
    rows = []
    for line in lines:
        try:
            rows.append([float(word) for word in line.split(",")])
        except ValueError:
            break
    return rows


def answer(prompt):
    uavs, workers, tasks = table(prompt, "UAV Data"), table(prompt, "Worker Data"), table(prompt, "Task Data")
    said = ["fly to the moon"]
    for uav in uavs[:10]:
        if not (workers and tasks):
            break
        task = min(tasks, key=lambda t: math.dist(t[1:3], uav[1:3]))
        worker = min(workers, key=lambda w: math.dist(w[1:3], task[1:3]))
        tasks.remove(task)
        workers.remove(worker)
        said.append(f"UAV {uav[0]:g} + Worker {worker[0]:g} + Task point {task[0]:g}")
        said.append(f"U{uav[0]:g} stays put")
    return "Step 1: there are UAVs; some tasks.\n\n**Final answer:** <" + "> ; <".join(said) + ">"


class Server(http.server.BaseHTTPRequestHandler):
    prompts = 0

    def do_POST(self):
        asked = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        Server.prompts += 1
        good = self.headers["Authorization"] == "Bearer sesame" and Server.prompts % 4 != 0
        text = answer(asked["messages"][0]["content"]) if good else ""
        body = json.dumps({"choices": [{"message": {"role": "assistant", "content": text}}]}).encode()
        self.send_response(200 if good else 503)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *words):
        pass


if sys.argv[1:2] == ["--serve"]:
    server = http.server.HTTPServer(("127.0.0.1", 0), Server)
    with open(sys.argv[2] + ".part", "w") as file:
        file.write(f"http://127.0.0.1:{server.server_port}/v1/chat/completions")
    os.rename(sys.argv[2] + ".part", sys.argv[2])
    server.serve_forever()
else:
    print(answer(sys.stdin.read()))
