"""A thousand wrong calls: each is an exception with a sentence, and what was right before stays right."""

import gc
import random

import numpy as np
import pytest

import gelenk

nan, inf = float("nan"), float("inf")


def wrong_vectors(n):
    """What is no (n,) array of finite numbers."""
    good = [0.1] * n
    yield from ([], good + [0.0], good[:-1], [good, good[:-1] + [nan]], [nan] * n, [inf] + good[1:], [-inf] + good[1:])
    yield from (["a"] * n, ["1.0"] * n, "abc", b"abc", 3, 3.5, None if n else 1, True, {}, {"a": 1}, object(), [None] * n, [[0.0]] * n)
    yield from (np.zeros(n, complex), np.zeros(n, bool), np.zeros((n, n, 2)), np.zeros((2, n + 1)), np.array("x"), np.array([object()] * n))
    yield from (np.zeros(n, "datetime64[s]"), np.zeros(n, [("a", float)]), np.zeros((0, 0)), lambda: 0, range(n + 1), slice(3))


def wrong_numbers():
    yield from (nan, inf, -inf, -1, "1", None, [], {}, object(), 1j)


def wrong_joints():
    yield from ("", "nothing", "hand", -1, 10**9, 10**30, 1.0, True, [], {}, object(), b"tool", ("tool",), nan)


def calls():
    panda, figure = gelenk.model("panda"), gelenk.model("figure")
    q, target = panda.rest, [0.4, 0.1, 0.5]
    frames = figure.fk(figure.rest)
    skin, chain, table = figure.skin, gelenk.PlanarChain([1, 2, 3]), gelenk.DhTable.robot("ur5")
    clip = gelenk.Clip(figure, figure.rest[None], 30)
    drag = gelenk.DragSolver(panda)

    for v in wrong_vectors(7):
        for f in (panda.fk, panda.jacobian, panda.violation, panda.project, panda.coupled, panda.centre_of_mass, panda.mirror,
                  lambda v: panda.integrate(v, q), lambda v: panda.integrate(q, v), lambda v: panda.difference(v, q),
                  lambda v: panda.difference(q, v), lambda v: panda.interpolate(v, q, 0.5), lambda v: gelenk.judge(panda, target, v),
                  lambda v: gelenk.evaluate(panda, target, v), lambda v: gelenk.Clip(panda, v, 30),
                  lambda v: v is None or gelenk.solve(panda, target, start=v), lambda v: v is None or drag.reset(v)):
            yield f, v
    for v in wrong_vectors(3):
        for f in (chain.points, chain.jacobian, chain.end_effector, chain.frames, lambda v: gelenk.Goal("position", joint=0, target=v),
                  lambda v: gelenk.Goal("aim", joint=0, target=(1, 0, 0), axis=v), gelenk.pose, gelenk.exp,
                  lambda v: gelenk.rotation_from_euler("xyz", v), lambda v: gelenk.solve(panda, {"tool": v}),
                  lambda v: gelenk.solutions(gelenk.model("ur5"), v)):
            if not (v is None and f.__name__ == "<lambda>"):
                yield f, v
    for v in wrong_vectors(2):
        for f in (lambda v: gelenk.two_link(1, 1, v), lambda v: v is None or gelenk.PlanarChain([1], v)):
            yield f, v
    for v in wrong_vectors(6):
        yield table.frames, v
    for v in wrong_vectors(5):
        for f in (skin, skin.with_normals, gelenk.Muscles(figure), lambda v: gelenk.solve_batch(panda, v),
                  lambda v: gelenk.path(panda, v), lambda v: gelenk.bind(panda, v, [[0, 1, 2]])):
            yield f, v
    for j in wrong_joints():
        for f in (panda.index, panda.joint, panda.q_slice, panda.v_slice, lambda j: panda.jacobian(q, j),
                  lambda j: gelenk.solve(panda, target, joint=j), lambda j: gelenk.Goal("position", joint=j, target=target).text(panda),
                  lambda j: gelenk.solve(panda, gelenk.Goal("distance", joint=0, other=j, length=1)),
                  lambda j: clip.layered(clip, 0.5, [j]), lambda j: gelenk.DhTable.of(panda, j),
                  lambda j: gelenk.solve_batch(panda, [[0.4, 0, 0.4]], joint=j)):
            yield f, j
    for v in wrong_numbers():
        for f in (lambda v: gelenk.solve(panda, target, tolerance=v), lambda v: gelenk.solve(panda, target, solver="dls", lambda_=v),
                  lambda v: gelenk.solve(panda, target, max_iterations=v), lambda v: gelenk.solve(panda, target, restarts=v),
                  lambda v: v in (None, inf) or gelenk.solve(panda, target, max_seconds=v), lambda v: gelenk.solve(panda, target, seed=v),
                  lambda v: v is None or panda.random(v), lambda v: v is None or panda.random(1, v), lambda v: clip.resampled(v), lambda v: clip.low_passed(v),
                  lambda v: gelenk.Clip(figure, figure.rest[None], v), lambda v: gelenk.Goal("position", joint=0, target=target, weight=v),
                  lambda v: v in (-1, []) or panda.interpolate(q, q, v), lambda v: panda.interpolate([q, q], [q, q, q], v),
                  lambda v: gelenk.compare(panda, ["dls"], problems=v), lambda v: gelenk.two_link(v, 1, (1, 1)),
                  lambda v: gelenk.Muscles(figure, activation=v), lambda v: table.transform(v, 0.0),
                  lambda v: v == inf or gelenk.step_rule("wrong", largest_step=v)(lambda J, r, q: q), lambda v: gelenk.check("dls", problems=v)):
            yield f, v
    for word in ("", "nothing", "PANDA", "planar:", "planar:1:2", "balls:", "balls:x", "dh:", "../x", "\0", None, 3, []):
        for f in (gelenk.model, gelenk.load, lambda w: gelenk.solve(panda, target, solver=w), gelenk.Goal, gelenk.DhTable.robot,
                  gelenk.DhTable.parse, gelenk.check, lambda w: gelenk.compare(panda, [w], problems=1),
                  lambda w: gelenk.compare(panda, ["dls"], problems=1, sets=[w]), lambda w: gelenk.rotation_from_euler(w, [0, 0, 0]),
                  lambda w: gelenk.save(w, panda), lambda w: gelenk.command(w), lambda w: w == "" or gelenk.lecture(w),
                  lambda w: gelenk.solve(panda, gelenk.Goal("position", joint=0, target=target, role=w)),
                  lambda w: w == "nothing" or gelenk.step_rule(w)(lambda J, r, q: q), lambda w: gelenk.rig(skin.vertices, skin.triangles, skeleton=w),
                  lambda w: w is None or gelenk.rig(skin.vertices, skin.triangles, up=w)):
            yield f, word
    yield from ((lambda f: skin(f), frames[:-1]), (lambda f: skin(f), frames * nan), (lambda f: skin(f), frames[..., :3]))
    for rows in ([], [dict()], [dict(name="")], [dict(name="a"), dict(name="a", parent="a")], [dict(name="a"), dict(name="b")],
                 [dict(name="a", axes=[dict(axis=(0, 0, 0))])], [dict(name="a", axes=[dict(lower=1, upper=0)])], [dict(name="a", axes=[3])],
                 [dict(name="a", offset=np.zeros((4, 4)))], [dict(name="a", nothing=1)], [dict(name="a", axes=[dict(kind="screw")])],
                 [3], None, "abc", [dict(name="a", parent="z")], [dict(name="a", ball="maybe")], [dict(name="a", mimic=3)],
                 [dict(name="a", mimic=dict(joint="a"))], [dict(name="a", ball_limit={})], [dict(name="a", ball=True, ball_limit=3)],
                 [dict(name="a", ball=True, ball_limit=dict(swing_radii=(nan, 1)))], [dict(name="a", ball=True, ball_limit=dict(twist=(1,)))],
                 [dict(name="a", axes=[dict(lower=nan)])], [dict(name="a", axes=[dict(upper="x")])], [dict(name="a", axes=3)], [dict(name=1, parent=1)]):
        yield gelenk.Model.from_joints, rows
    for rows in ([], [(1, 2, 3)], [(nan, 0, 0, 0)], [dict(kind="screw")], [dict(a="x")], [dict(b=1)], None, 3, [None], "abcd"):
        yield gelenk.DhTable, rows
    for t in ([], [[0, 1]], [[0, 1, 10**9]], [[-1, 0, 1]], [[0.0, 1.0, 2.0]], "abc", [["a", "b", "c"]], [[0, 1, 2**70]]):
        yield (lambda t: gelenk.rig(skin.vertices, t)), t
        yield (lambda t: gelenk.bind(figure, skin.vertices, t)), t
    for a, b in ((gelenk.Model, None), (gelenk.Result, None), (gelenk.Problem, None), (gelenk.Skin, None), (gelenk.DragSolver, None),
                 (gelenk.DragSolver, 3), (gelenk.Muscles, panda), (gelenk.Clip, None), (gelenk.show, None), (gelenk.render, "panda"),
                 (gelenk.solve, None), (gelenk.solve, panda), (gelenk.with_body, 3), (clip.retarget, panda), (clip.retarget, None)):
        yield a, b
    for kind in gelenk.goal_types():
        yield (lambda k: gelenk.Goal(k)), kind["kind"]
        yield (lambda k: gelenk.Goal(k, nothing=1)), kind["kind"]


# what a call may raise; anything else (SystemError, MemoryError, a crash) is a fault
allowed = (ValueError, TypeError, OSError, RuntimeError, OverflowError)


def test_a_thousand_wrong_calls_are_exceptions():
    panda = gelenk.model("panda")
    before = gelenk.solve(panda, [0.4, 0.1, 0.5]).q
    count, quiet = 0, []
    for i, (call, value) in enumerate(calls()):
        try:
            out = call(value)
        except allowed as error:
            assert str(error), (i, call, value)
            count += 1
            continue
        if out is not True:  # a call that does not apply to this value says True
            quiet.append((i, getattr(call, "__name__", call), value, out))
    assert not quiet, quiet[:5]
    assert count >= 1000, count
    assert np.array_equal(gelenk.solve(panda, [0.4, 0.1, 0.5]).q, before)


def test_objects_may_go_in_any_order():
    rng = random.Random(1)
    for _ in range(50):
        figure = gelenk.model("panda")
        parts = [figure, figure.fk(figure.rest), figure.skin, figure.skin.vertices if figure.skin else 0, gelenk.DragSolver(figure),
                 gelenk.solve_batch(figure, [[0.4, 0.1, 0.5]]).q, gelenk.Clip(figure, figure.rest[None]).q]
        del figure
        rng.shuffle(parts)
        while parts:
            parts.pop()
            gc.collect(0)
            for part in parts:
                if isinstance(part, np.ndarray):
                    assert np.isfinite(part).all()
