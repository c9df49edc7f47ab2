#!/usr/bin/env python3
"""The core's own tests (kinematics, solvers, skinning) in WebAssembly, under Node:

    tests/web/core_test.py build-web/apps/web [--filter=PATTERN]

The arguments after the folder are GoogleTest's, without their "gtest_"."""
import os
import re
import subprocess
import sys

folder, *more = sys.argv[1:]
# Solvers that join the catalogue stay in it: their tests run in a process of their own, as every test does natively.
runs = [('kinematics', []), ('solvers', ['--gtest_filter=-OwnSolver.*']), ('solvers', ['--gtest_filter=OwnSolver.*']), ('skinning', [])]
failed = False
for module, chosen in runs:
    done = subprocess.run(['node', '--no-experimental-fetch', os.path.join(folder, f'{module}_tests.js'), '--gtest_brief=1', *chosen,
                           *(f'--gtest_{m.lstrip("-")}' for m in more)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    count = lambda word: int((re.search(rf'^\[ +{word} +\] (\d+) test', done.stdout, re.M) or [0, 0])[1])
    if done.returncode != 0 or (count('PASSED') == 0 and not more):
        failed = True
        print(done.stdout)
    print(f'{module}: {count("PASSED")} tests hold, {count("SKIPPED")} were skipped, {"none" if done.returncode == 0 else "some"} failed', flush=True)
sys.exit(failed)
