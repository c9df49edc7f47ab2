"""What a call from Python costs over the same work done in a loop in C++: processor time, least of many rounds in turn.

    PYTHONPATH=build/python python3 tests/benchmarks/python_overhead.py
"""

import time

import gelenk
import numpy as np

panda, figure = gelenk.model("panda"), gelenk.model("figure")


def least(rounds, *calls):
    """us a pose of each of the calls, which take turns so that a busy machine is busy for all of them."""
    best = [np.inf] * len(calls)
    for _ in range(rounds):
        for i, (call, count) in enumerate(calls):
            begin = time.thread_time()
            call()
            best[i] = min(best[i], 1e6 * (time.thread_time() - begin) / count)
    return best


def compared(name, one, many, rows, rounds=60):
    """`one` of every row in Python against `many` of all of them."""
    def loop():
        for row in rows:
            one(row)

    single, batch = least(rounds, (loop, len(rows)), (lambda: many(rows), len(rows)))
    print(f"{name:<44} {single:8.2f} us a call, {batch:8.2f} us each in a batch: {single - batch:+.2f}", flush=True)


compared("nothing but the loop", lambda q: None, lambda Q: None, panda.random(1, 2000))
compared("fk, panda", panda.fk, panda.fk, panda.random(1, 2000))
compared("fk, figure", figure.fk, figure.fk, figure.random(1, 500))
compared("jacobian, panda", panda.jacobian, panda.jacobian, panda.random(1, 2000))
tool = panda.index("tool")
poses = np.ascontiguousarray(panda.fk(panda.random(2, 500))[:, tool])
# dls solves rows of a batch one after the other; one step each, so that the answer costs little
ask = dict(solver="dls", restarts=0, max_iterations=1)
compared("solve, panda, one step of dls and the judge", lambda T: gelenk.solve(panda, T, **ask), lambda A: gelenk.solve_batch(panda, A, **ask), poses)

many = np.ascontiguousarray(panda.fk(panda.random(3, 100_000))[:, tool])
shares = []
for _ in range(6):
    begin = time.perf_counter()
    answers = gelenk.solve_batch(panda, many)
    shares.append((time.perf_counter() - begin) / answers.seconds - 1)
print(f"solve_batch, 100,000 poses: {100 * min(shares):.2f} to {100 * max(shares):.2f} % over the seconds that the C++ call took")
