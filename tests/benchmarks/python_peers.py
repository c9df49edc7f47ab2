"""Pose inverse kinematics from Python, beside other libraries: reachable poses of the Panda, every answer judged by gelenk.

    PYTHONPATH=build/python:FOLDER python3 tests/benchmarks/python_peers.py [POSES]

PyKDL is Debian's python3-pykdl; FOLDER holds fknm, the compiled part of the Robotics Toolbox (its ik_LM is this call). Both
get gelenk's own Panda, so that all solve the same problems; those that are not there are left out. Times: processor time.
"""

import sys
import time

import gelenk
import numpy as np

panda = gelenk.model("panda")
tool, limits = panda.index("tool"), panda.limits
poses = np.ascontiguousarray(panda.fk(panda.random(1, int(sys.argv[1]) if len(sys.argv) > 1 else 2000))[:, tool])
attempts = 101


def reached(T, q):
    """To 1e-6 m and rad, and within limits."""
    found = panda.fk(q)[tool]
    turn = gelenk.log(found[:3, :3].T @ T[:3, :3])
    return np.linalg.norm(found[:3, 3] - T[:3, 3]) < 1e-6 and np.linalg.norm(turn) < 1e-6 and panda.violation(q) < 1e-9


def race(name, solve, share=1.0):
    mine = poses[: max(1, int(share * len(poses)))]
    begin = time.thread_time()
    answers = [solve(T) for T in mine]
    seconds = time.thread_time() - begin
    solved = np.mean([reached(T, q) for T, q in zip(mine, answers)])
    print(f"{name:<40} {1e6 * seconds / len(mine):10.1f} us a pose {100 * solved:7.2f} % solved", flush=True)


def starts(rng):
    yield panda.rest
    for _ in range(attempts - 1):
        yield panda.random(rng)


def clik(T):
    """The closed loop as tutorials write it, damped, over fk and jacobian in Python."""
    for q in starts(np.random.default_rng(0)):
        for _ in range(200):
            now = panda.fk(q)[tool]
            e = np.r_[T[:3, 3] - now[:3, 3], gelenk.log(T[:3, :3] @ now[:3, :3].T)]
            if np.linalg.norm(e) < 1e-6:
                break
            J = panda.jacobian(q, tool)
            q = q + 0.5 * J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(6), e)
        if reached(T, q):
            return q
    return panda.rest


def toolbox(method, damping):
    import fknm

    kept, parts, joints = [], [], 0

    def matrix(M):  # the toolbox points at it
        kept.append(np.array(M, float, order="F"))
        return kept[-1]

    for i in range(panda.joint_count):
        joint = panda.joint(i)
        parts.append(fknm.ET_init(0, 0, 0, 0, 0, matrix(joint["offset"]), np.array([-np.pi, np.pi])))
        for axis in joint["axes"]:  # all about z
            range_ = np.array([axis["lower"], axis["upper"]])
            parts.append(fknm.ET_init(0, 1, 0, joints, 2, matrix(np.eye(4)), range_))
            joints += 1
    chain = fknm.ETS_init(parts, joints, len(parts))
    ones = np.ones(6)
    kept.append(chain)
    # its tolerance is on half the squared error: 4e-13 is 0.9e-6
    return lambda T, keep=kept: fknm.IK_LM_c(chain, T, None, 30, attempts - 1, 4e-13, 1, ones, damping, method)[0]


def kdl():
    import PyKDL

    chain = PyKDL.Chain()
    for i in range(panda.joint_count):
        joint = panda.joint(i)
        M = joint["offset"]
        frame = PyKDL.Frame(PyKDL.Rotation(*M[:3, :3].ravel()), PyKDL.Vector(*M[:3, 3]))
        chain.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.Fixed), frame))
        for _ in joint["axes"]:
            chain.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), PyKDL.Frame()))
    lower, upper = PyKDL.JntArray(7), PyKDL.JntArray(7)
    for k in range(7):
        lower[k], upper[k] = limits[k]
    positions, velocities = PyKDL.ChainFkSolverPos_recursive(chain), PyKDL.ChainIkSolverVel_pinv(chain)
    solver = PyKDL.ChainIkSolverPos_NR_JL(chain, lower, upper, positions, velocities, 200, 1e-7)

    def solve(T, keep=(chain, positions, velocities, lower, upper)):
        frame = PyKDL.Frame(PyKDL.Rotation(*T[:3, :3].ravel()), PyKDL.Vector(*T[:3, 3]))
        start, found = PyKDL.JntArray(7), PyKDL.JntArray(7)
        for q in starts(np.random.default_rng(0)):
            for k in range(7):
                start[k] = q[k]
            if solver.CartToJnt(start, frame, found) >= 0:
                break
        return np.array([found[k] for k in range(7)])

    return solve


race("gelenk.solve", lambda T: gelenk.solve(panda, T, restarts=attempts - 1).q)
for name, make, share in (("Robotics Toolbox ik_LM, Chan 1.0", lambda: toolbox("c", 1.0), 1),
                          ("Robotics Toolbox ik_LM, Chan 0.1", lambda: toolbox("c", 0.1), 1),
                          ("Robotics Toolbox ik_LM, Sugihara 0.001", lambda: toolbox("s", 0.001), 1),
                          ("PyKDL ChainIkSolverPos_NR_JL", kdl, 0.2), ("closed loop in numpy over gelenk.fk", lambda: clik, 0.1)):
    try:
        solve = make()
    except ImportError as missing:
        print(f"{name:<40} not here: {missing}")
        continue
    race(name, solve, share)
many = np.ascontiguousarray(panda.fk(panda.random(2, 100_000))[:, tool])
for what in ("first, with the table of starts", "again"):
    begin = time.thread_time()
    answers = gelenk.solve_batch(panda, many)
    print(f"gelenk.solve_batch, 100,000, {what:<31}: {1e6 * (time.thread_time() - begin) / len(many):.2f} us a pose, "
          f"{100 * answers.solved.mean():.3f} % solved")
