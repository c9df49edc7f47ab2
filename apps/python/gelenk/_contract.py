"""The rules that every solver of the catalogue is held to, for one's own."""

import numpy as np

from . import _gelenk


class Contract:
    """What check() found. True where nothing was broken; faults: a list of (rule, where, what)."""

    def __init__(self, solver):
        self.solver, self.problems, self.solved, self.unsupported, self.faults = solver, 0, 0, 0, []

    def __bool__(self):
        return not self.faults

    def __repr__(self):
        head = (f"<gelenk.Contract '{self.solver}': {self.problems} problems, {self.solved} solved, "
                f"{self.unsupported} unsupported, {len(self.faults)} faults>")
        return "\n".join([head] + [f"  {rule} ({where}): {what}" for rule, where, what in self.faults[:10]])


def _models():
    yield from (_gelenk.model(name) for name in ("panda", "ur5", "scara", "planar"))
    yield _gelenk.model("balls:0.5,0.4,0.3")
    yield _gelenk.model("planar:0,0:1,1,1")
    fork = [dict(name="trunk", axes=[dict(axis=(0, 1, 0), lower=-1, upper=1)])]
    for side, x in (("l", -0.3), ("r", 0.3)):
        for i in range(4):
            fork.append(dict(name=f"{side}{i}", parent="trunk" if i == 0 else f"{side}{i - 1}",
                             offset=(x, 0.5 if i == 0 else 0.1, 0.0),
                             axes=[dict(axis=(0, 1, 0) if i % 2 else (0, 0, 1), lower=-2, upper=2)] if i < 3 else []))
    yield _gelenk.Model.from_joints(fork, name="fork")


def _problems(model, rng, count):
    """(where, joint, goal, start): reachable, out of reach, at the base, there already, from the neutral pose."""
    joint = model.index("l3") if model.name == "fork" else model.joint_count - 1
    for i in range(count):
        there, start = model.random(rng), model.random(rng)
        frame = model.fk(there)[joint]
        kind = ("position", "pose", "orientation")[i % 3]
        where = ("reachable", "out of reach", "target at the base", "already there", "from the neutral pose")[i % 5]
        place = frame[:3, 3]
        if where == "out of reach":
            place = place * (1 + 10 * rng.random())
        elif where == "target at the base":
            place = model.fk(there)[0][:3, 3]
        elif where == "already there":
            start = there
        elif where == "from the neutral pose":
            start = model.project(model.neutral)
        fields = dict(joint=int(joint))
        if kind != "orientation":
            fields["target"] = place
        if kind != "position":
            fields["orientation"] = frame[:3, :3]
        yield f"{model.name}, {kind}, {where}", joint, _gelenk.Goal(kind, **fields), start


def check(solver, problems=30, seed=1, **parameters):
    """Holds a solver of the catalogue to the rules of all of them, on that many problems of each of seven models: a Contract.

    Answers and a step rule's steps are finite, quaternions of length 1, all within limits; the residual reported is the one recomputed; 'converged' is said where the judge
    says so, and only there; the same seed gives the same bits; tracing changes nothing; joints off the goal's path keep
    every bit; no goals are met at once; every parameter changes something.
    """
    entry = next((e for e in _gelenk.solvers() if e["name"] == solver), None)
    if entry is None and solver != "default":
        names = ", ".join(e["name"] for e in _gelenk.solvers())
        raise ValueError(f"no solver is called '{solver}'; there are: {names}")
    if problems < 1:
        raise ValueError(f"problems: at least 1, not {problems}")
    found, rng = Contract(solver), np.random.default_rng(seed)
    ask = dict(solver=solver, max_iterations=60, restarts=1, seed=7)
    changed = {p["name"]: False for p in (entry or {"parameters": []})["parameters"]}
    tried = 0

    def fault(rule, where, what):
        found.faults.append((rule, where, what))

    for model in _models():
        for where, joint, goal, start in _problems(model, rng, problems):
            not_finite = _gelenk._steps_not_finite(solver)
            result = _gelenk.solve(model, goal, start=start, **ask, **parameters)
            not_finite = _gelenk._steps_not_finite(solver) - not_finite
            if not_finite:
                fault("steps of a step rule are finite", where, f"{not_finite} of them not")
            found.problems += 1
            if result.status == "unsupported":
                found.unsupported += 1
                if not np.array_equal(result.q, start):
                    fault("what is unsupported stays at the start", where, "it moved")
                continue
            found.solved += result.solved
            q = result.q
            if not np.isfinite(q).all():
                fault("answers are finite, quaternions of length 1", where, q)
                continue
            if not _gelenk.judge(model, goal, q)["finite"]:
                fault("answers are finite, quaternions of length 1", where, q)
            if result.limit_violation > 1e-9:
                fault("answers are within limits", where, f"{result.limit_violation:.3g} outside")
            r, _ = _gelenk.evaluate(model, goal, q)
            if abs(np.linalg.norm(r) - result.residual) > 1e-12 * (1 + result.residual):
                fault("the residual reported is the true one", where, f"{result.residual} for {np.linalg.norm(r)}")
            if (result.status == "converged") != result.solved:
                fault("converged means solved", where, f"{result.status}, solved: {result.solved}")
            again = _gelenk.solve(model, goal, start=start, trace=True, **ask, **parameters)
            if not np.array_equal(again.q, q) or again.iterations != result.iterations:
                fault("the same seed gives the same bits, traced or not", where, f"{np.abs(again.q - q).max():.3g} apart")
            on_path, j = set(), joint
            while j >= 0:
                on_path.add(j)
                j = model.parents[j]
            for j in range(model.joint_count):
                entries = model.q_slice(j)
                if j not in on_path and not np.array_equal(q[entries], start[entries]):
                    fault("joints off the goal's path stay", where, model.joint_names[j])
            for p in entry["parameters"] if entry and tried < 60 else ():
                value = p["upper"] if p["value"] != p["upper"] else p["lower"]
                word = p["name"].replace("-", "_") + "_"
                if changed[p["name"]] or p["name"].replace("-", "_") in parameters or word in parameters:
                    changed[p["name"]] = True
                    continue
                for value in (p["upper"], p["lower"]):
                    other = _gelenk.solve(model, goal, start=start, **ask, **{word: value})
                    changed[p["name"]] |= not np.array_equal(other.q, q) or other.iterations != result.iterations
            tried += 1
        nothing = _gelenk.solve(model, [], **ask, **parameters)
        if nothing.status != "unsupported" and not (nothing.status == "converged" and nothing.residual == 0):
            fault("no goals are met at once", model.name, nothing.status)
    for name, did in changed.items():
        if not did:
            fault("every parameter changes something", name, "it did not")
    return found
