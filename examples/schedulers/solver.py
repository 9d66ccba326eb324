#!/usr/bin/env python3
"""Lets a general solver decide on the exported graph: COIN-OR CBC (Debian: coinor-cbc) or GLPK (glpk-utils).

solver.py [cbc|glpsol] [SECONDS]: which one (default: the first that is there) and how long a decision may take it.
A decision is the heaviest choice of nodes in which every element admits what it admits.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile


def write_problem(situation, file):
    """As an integer program in CPLEX's LP format. Lines stay short, as the format wants."""
    nodes, elements = situation["nodes"], situation["elements"]
    of_element = [[] for _ in elements]
    for i, node in enumerate(nodes):
        for e in node["elements"]:
            of_element[e].append(i)
    print("Maximize\n weight:", file=file)
    for i, node in enumerate(nodes):
        print(f" + {node['weight']!r} n{i}", file=file)
    print("Subject To", file=file)
    for e, users in enumerate(of_element):
        if not users or elements[e]["admits"] is None:
            continue
        print(f" e{e}:", file=file)
        for i in users:
            print(f" + n{i}", file=file)
        print(f" <= {elements[e]['admits']}", file=file)
    print("Binary", file=file)
    for i in range(len(nodes)):
        print(f" n{i}", file=file)
    print("End", file=file)


def chosen_by_cbc(program, problem, solution, seconds):
    run([program, problem, "-sec", str(seconds), "-solve", "-solution", solution])
    with open(solution) as file:
        next(file)  # how it ended
        rows = [line.replace("**", "").split() for line in file]  # number, name, value, cost
    return [int(row[1][1:]) for row in rows if float(row[2]) > 0.5]


def chosen_by_glpsol(program, problem, solution, seconds):
    run([program, "--lp", problem, "--tmlim", str(seconds), "-w", solution])
    with open(solution) as file:
        rows = [line.split() for line in file]  # j COLUMN VALUE, in the order of the objective
    return [int(row[1]) - 1 for row in rows if row[0] == "j" and float(row[2]) > 0.5]


def run(command):
    """Its words go to stderr: stdout is for decisions."""
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL, stdout=sys.stderr)


def decide(situation, solver, program, seconds):
    if situation["nodes"] is None:
        print("the graph is too large to be told: everybody stays", file=sys.stderr)
        return []
    if not situation["nodes"]:
        return []
    with tempfile.TemporaryDirectory() as folder:
        problem, solution = os.path.join(folder, "problem.lp"), os.path.join(folder, "solution")
        with open(problem, "w") as file:
            write_problem(situation, file)
        return SOLVERS[solver](program, problem, solution, seconds)


SOLVERS = {"cbc": chosen_by_cbc, "glpsol": chosen_by_glpsol}


def main():
    wanted = [word for word in sys.argv[1:] if word in SOLVERS] or list(SOLVERS)
    seconds = next((int(word) for word in sys.argv[1:] if word.isdigit()), 20)
    solver = next((name for name in wanted if shutil.which(name)), None)
    if solver is None:
        sys.exit(f"solver.py: found none of {', '.join(wanted)} (Debian: coinor-cbc, glpk-utils)")
    for line in sys.stdin:
        message = json.loads(line)
        answer = {"type": "hello", "version": 1, "name": solver, "want": ["nodes"],
                  "deadline_s": 3 * seconds}
        if message["type"] == "situation":
            nodes = decide(message, solver, shutil.which(solver), seconds)
            answer = {"type": "decision", "id": message["id"], "nodes": nodes}
        print(json.dumps(answer), flush=True)


main()
