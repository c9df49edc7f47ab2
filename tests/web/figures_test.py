#!/usr/bin/env python3
"""The lecture's figures computed by the core in WebAssembly, under Node, against the native program's:

    tests/web/figures_test.py build-web/apps/web/figures.js build/gelenk"""
import json
import subprocess
import sys

script, native = sys.argv[1:]


def output(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, (command, done.returncode, done.stderr)
    return done.stdout


here = dict(line.split(' ', 1) for line in output('node', '--no-experimental-fetch', script).splitlines())
there = {row['id']: ' '.join(format(v, '.11g') for v in row['computed'])
         for row in json.loads(output(native, 'lecture', '--json'))}
assert here.keys() == there.keys() and len(here) >= 55, here.keys() ^ there.keys()
same, wrong = 0, []
for name in there:
    if here[name] == there[name]:
        same += 1
        continue
    for x, y in zip(map(float, here[name].split()), map(float, there[name].split()), strict=True):
        # What is nought but for rounding is rounded in another order here. Where |q| - 1 is penalised, Ceres and the method
        # that stands in for it stop within 1e-8 of a flat minimum.
        if max(abs(x), abs(y)) < 1e-9 or (name == 'rotations-penalty-unreachable' and abs(x - y) < 1e-8):
            print(f'{name}: {x} here, {y} natively')
        else:
            wrong.append((name, x, y))
print(f'{same} of {len(there)} figures have the same 11 digits, {len(wrong)} values are wrong')
for name, x, y in wrong:
    print(f'{name}: {x} here, {y} natively')
sys.exit(bool(wrong))
