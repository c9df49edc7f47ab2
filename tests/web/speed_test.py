#!/usr/bin/env python3
"""Solves in WebAssembly, under Node, beside the native program's, in turns:

    tests/web/speed_test.py build-web/apps/web/speed.js build/tests/web_speed"""
import subprocess
import sys

script, native = sys.argv[1:]


def times(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {name: float(value) for name, value in map(str.split, done.stdout.splitlines())}


here, there = {}, {}
for _ in range(3):
    for least, command in (here, ('node', '--no-experimental-fetch', script)), (there, (native,)):
        for name, value in times(*command).items():
            least[name] = min(least.get(name, value), value)
wrong = []
for name in there:
    if name.endswith('-solved'):
        assert here[name] == there[name] == 2000, (name, here[name], there[name])
        continue
    ratio, mark = here[name] / there[name], 10.0 if name.startswith('panda') else 2.5
    print(f'{name}: {here[name]:.2f} us here, {there[name]:.2f} us natively, {ratio:.2f} times (mark {mark})')
    # A busy machine moves ratios by a fifth; twice the mark is another algorithm.
    if ratio > 2 * mark:
        wrong.append(name)
sys.exit(f'too slow: {wrong}' if wrong else 0)
