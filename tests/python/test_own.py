"""One's own methods: in the catalogue, held to its rules, compared, and equal to the program's comparison."""

import csv
import sys
import types

import numpy as np
import pytest

import gelenk


@gelenk.step_rule("mine", parameters={"lambda": (0.05, 0.0, 10.0)})
def mine(J, r, q, lambda_):
    return J.T @ np.linalg.solve(J @ J.T + lambda_**2 * np.eye(len(r)), r)


@gelenk.solver("mine-whole", parameters={"damping": (1e-3, 1e-9, 1.0)})
def mine_whole(problem, damping):
    best, least = problem.project(problem.start), np.inf
    rng = np.random.default_rng(problem.seed)
    for attempt in range(problem.restarts + 1):
        q = problem.project(problem.start)
        if attempt:  # joints off the goals' paths have no column in J and stay
            _, J = problem.evaluate(q)
            q = problem.integrate(q, np.where(np.abs(J).sum(0) > 0, rng.uniform(-1, 1, problem.nv), 0.0))
        for _ in range(problem.max_iterations):
            r, J = problem.evaluate(q)
            if np.linalg.norm(r) < least:
                best, least = q, np.linalg.norm(r)
            if problem.solved(q):
                return q
            dq = np.linalg.lstsq(np.vstack([J, np.sqrt(damping) * np.eye(problem.nv)]),
                                 np.r_[r, np.zeros(problem.nv)], rcond=None)[0]
            problem.count(np.linalg.norm(dq))
            q = problem.integrate(q, dq)
    return best


def test_a_rule_of_ones_own_gives_the_answers_of_its_twin():
    model = gelenk.model("ur5")
    rng = np.random.default_rng(2)
    for _ in range(30):
        start, target = model.random(rng), model.fk(model.random(rng))[-1]
        a = gelenk.solve(model, target, start=start, solver="dls", restarts=0)
        b = gelenk.solve(model, target, start=start, solver="mine", restarts=0)
        # the linear systems are solved by other routines: rounding, carried through tens of steps
        if a.solved or b.solved:
            assert a.solved == b.solved and a.iterations == b.iterations
            assert np.allclose(a.q, b.q, atol=1e-6)


def test_it_is_in_the_catalogue(panda):
    entry = {e["name"]: e for e in gelenk.solvers()}["mine"]
    assert entry["reference"] == "own" and entry["parameters"][0]["name"] == "lambda"
    result = gelenk.solve(panda, panda.fk(panda.random(1))[-1], solver="mine", lambda_=0.2)
    assert result.solver == "mine[lambda=0.2]"
    with pytest.raises(ValueError, match="lambda"):
        gelenk.solve(panda, [0.4, 0, 0.4], solver="mine", lambda_=11)
    with pytest.raises(ValueError, match="there are"):
        gelenk.solve(panda, [0.4, 0, 0.4], solver="min")


@pytest.mark.parametrize("solver", ["mine", "mine-whole", "dls", "default", "lm-gain-ratio", "qp"])
def test_the_rules_hold(solver):
    found = gelenk.check(solver, problems=10)
    assert found, repr(found)
    assert found.problems == 70 and found.solved > 20


def test_the_rules_are_seen_to_be_broken():
    @gelenk.solver("careless", parameters={"nothing": 0.5})
    def careless(problem, nothing):
        return problem.start + 3.0  # out of limits, off the paths, and no unit quaternions

    rules = {rule for rule, _, _ in gelenk.check("careless", problems=10).faults}
    assert {"answers are finite, quaternions of length 1", "answers are within limits", "joints off the goal's path stay", "every parameter changes something"} <= rules

    @gelenk.solver("restless")
    def restless(problem):
        return problem.random(None)

    rules = {rule for rule, _, _ in gelenk.check("restless", problems=5).faults}
    assert "the same seed gives the same bits, traced or not" in rules


def test_steps_that_are_not_finite_are_seen():
    @gelenk.step_rule("divides")
    def divides(J, r, q):
        return np.full(J.shape[1], np.nan) if np.linalg.norm(r) < 0.5 else J.T @ r

    found = gelenk.check("divides", problems=5)
    assert "steps of a step rule are finite" in {rule for rule, _, _ in found.faults}, found


def test_what_a_rule_raises_arrives(panda):
    @gelenk.step_rule("raising")
    def raising(J, r, q):
        raise KeyError("from the rule")

    with pytest.raises(KeyError, match="from the rule"):
        gelenk.solve(panda, [0.4, 0, 0.4], solver="raising")

    @gelenk.step_rule("misshapen")
    def misshapen(J, r, q):
        return r

    with pytest.raises(ValueError, match="misshapen"):
        gelenk.solve(panda, [0.4, 0, 0.4], solver="misshapen")

    @gelenk.step_rule("not-a-number")
    def not_a_number(J, r, q):
        return np.full(J.shape[1], np.nan)

    assert gelenk.solve(panda, [0.4, 0, 0.4], solver="not-a-number", restarts=0).status == "failure"


def test_a_name_takes_a_new_method_and_never_a_builtin_one(panda):
    for step in (0.0, 0.1):
        @gelenk.step_rule("changing")
        def changing(J, r, q):
            return np.full(J.shape[1], step)

        trace = gelenk.solve(panda, [0.4, 0, 0.4], solver="changing", restarts=0, max_iterations=3, trace=True).trace
        assert (trace["step"].max() > 0) == (step > 0)
    with pytest.raises(ValueError, match="another name"):
        gelenk.step_rule("dls")(lambda J, r, q: r)
    with pytest.raises(ValueError, match="a to z"):
        gelenk.step_rule("No Name")(lambda J, r, q: r)


def test_a_problem_ends_with_its_solve(panda):
    kept = []

    @gelenk.solver("keeping")
    def keeping(problem):
        kept.append(problem)
        return problem.start

    gelenk.solve(panda, [0.4, 0, 0.4], solver="keeping")
    with pytest.raises(ValueError, match="over"):
        kept[0].evaluate(panda.rest)
    with pytest.raises(ValueError, match="over"):
        kept[0].start


def test_comparing_is_the_command_line_to_the_bit(program, tmp_path):
    ur5 = gelenk.model("ur5")
    found = gelenk.compare(ur5, ["dls", "sdls", "default"], problems=20, seed=3)
    program("compare", "--model", "ur5", "--solver", "dls", "--solver", "sdls", "--solver", "default", "--set", "D1",
            "--problems", 20, "--seed", 3, "--out", tmp_path / "out")
    with open(tmp_path / "out/results.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found) == 2 * 3 * 20
    for i, row in enumerate(rows):
        assert row["set"] == found["set"][i] and row["solver"] == found["solver"][i]
        assert int(row["iterations"]) == found["iterations"][i]
        assert float(row["position_error"]) == found["position_error"][i]
        assert row["status"] == found["status"][i]
    mixed = gelenk.compare(ur5, ["dls", "mine"], problems=10, restarts=0)
    share = {row.solver: row.solved for row in mixed.summary()}
    assert abs(share["dls"] - share["mine"]) <= 0.1
    assert len(mixed.table) == 20 and "dls" in repr(mixed)


def test_the_table_is_a_data_frame_where_pandas_is_there(monkeypatch):
    class DataFrame(dict):
        pass

    race = gelenk.compare(gelenk.model("planar"), ["dls"], problems=5, restarts=0)
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=DataFrame))
    assert isinstance(race.table, DataFrame) and len({len(column) for column in race.table.values()}) == 1
    monkeypatch.setitem(sys.modules, "pandas", None)  # importing it then fails
    assert isinstance(race.table, np.recarray) and len(race.table) == 5


def test_progress_and_a_folder(tmp_path):
    seen = []
    gelenk.compare(gelenk.model("planar"), ["dls"], problems=5, restarts=0, out=tmp_path / "here",
                   progress=lambda done, total, what: seen.append((done, total)))
    assert seen[-1][0] == seen[-1][1] and (tmp_path / "here/report.html").exists()

    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="is a file, not a folder for results"):
        gelenk.compare(gelenk.model("planar"), ["dls"], problems=5, out=tmp_path / "file")

    def stop(done, total, what):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        gelenk.compare(gelenk.model("planar"), ["dls"], problems=5, progress=stop)
