#!/usr/bin/env python3
"""Runs the fuzz targets of a build folder: run.py BUILD [--seconds 620] [--jobs 2] [--logs FOLDER] [TARGET ...]

A line a target: when it ended, what it found, executions, processor time. Exit status 1 where something was found; the input lies
in the folder of the logs.
"""
import argparse
import concurrent.futures
import datetime
import os
import re
import subprocess
import sys

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("build")
parser.add_argument("targets", nargs="*", metavar="TARGET")
parser.add_argument("--seconds", type=int, default=620)
parser.add_argument("--jobs", type=int, default=2)
parser.add_argument("--logs")
given = parser.parse_intermixed_args()
here = os.path.dirname(os.path.abspath(__file__))
logs = os.path.abspath(given.logs or os.path.join(given.build, "fuzz-logs"))
seeds = os.path.join(logs, "seeds")
subprocess.run([sys.executable, os.path.join(here, "make_seeds.py"), seeds], check=True)
targets = given.targets or sorted(f[: -len("_fuzz.cpp")] for f in os.listdir(here) if f.endswith("_fuzz.cpp"))


def run(target):
    program = os.path.abspath(os.path.join(given.build, "tests", target + "_fuzz"))
    path = os.path.join(logs, target + ".log")
    with open(path, "w") as log:
        words = [program, f"-max_total_time={given.seconds}", "-print_final_stats=1", f"-artifact_prefix={logs}/{target}-",
                 os.path.join(seeds, target)]
        process = subprocess.Popen(words, stdout=log, stderr=log)
        _, status, usage = os.wait4(process.pid, 0)
    with open(path, errors="replace") as log:
        runs = re.findall(r"stat::number_of_executed_units: *(\d+)", log.read())
    end = datetime.datetime.now().isoformat(" ", "seconds")
    print(f"{end}  {target:20} {'finding' if status else 'nothing':8} {int(runs[-1]) if runs else 0:12,} executions "
          f"{usage.ru_utime + usage.ru_stime:8.1f} s of processor time", flush=True)
    return status == 0


with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
    sys.exit(0 if all(list(pool.map(run, targets))) else 1)
