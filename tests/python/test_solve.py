"""Solving: true answers, the same bits as the command line, every goal, batches, threads."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gelenk

seven = [0.4, 0.1, 0.5, 0.0, 1.0, 0.0, 0.0]


def pose7(frame):
    q = gelenk.exp(gelenk.log(frame[:3, :3]))
    return np.r_[frame[:3, 3], q]


def targets(model, count, seed=1):
    return np.array([pose7(model.fk(q)[-1]) for q in model.random(seed, count)])


def test_an_answer_is_where_it_says(panda):
    result = gelenk.solve(panda, seven, solver="dls", lambda_=0.1, restarts=50)
    assert result and result.solved and result.status == "converged"
    assert result.solver == "dls[lambda=0.1]"
    frame = panda.fk(result.q)[-1]
    assert np.linalg.norm(frame[:3, 3] - seven[:3]) == pytest.approx(result.position_error, abs=1e-15)
    assert result.position_error < 1e-6 and result.orientation_error < 1e-6
    assert panda.violation(result.q) < 1e-9
    assert result.counters["iterations"] == result.iterations > 0


solverNames = [s["name"] for s in gelenk.solvers() if s["reference"] != "own"] + ["default"]


@pytest.mark.parametrize("solver", solverNames)
def test_solve_is_the_command_line_to_the_bit(panda, program, solver):
    told = program.json("solve", "--model", "panda", "--solver", solver, "--seed", 7, "--restarts", 5,
                        "--max-iterations", 60, "--target", *seven)
    result = gelenk.solve(panda, seven, solver=solver, seed=7, restarts=5, max_iterations=60)
    assert result.q.tolist() == told["solution"]
    assert result.status == told["status"] and result.solved == told["solved"]
    assert result.counters == told["counters"]
    if told["status"] != "unsupported":
        assert result.position_error == told["position_error"]
    else:
        assert result.unsupported_because == told["unsupported_because"]


def test_a_trace_is_arrays(panda, program):
    result = gelenk.solve(panda, seven, solver="sdls", trace=True)
    told = program.json("solve", "--model", "panda", "--solver", "sdls", "--target", *seven, "--trace")["trace"]
    assert result.trace["residual"].tolist() == [r["residual"] for r in told]
    assert result.trace["q"].tolist() == [r["q"] for r in told]
    assert gelenk.solve(panda, seven).trace is None


figureGoals = [
    gelenk.Goal("position", joint="hand_l", target=(0.3, 1.2, 0.3)),
    gelenk.Goal("orientation", joint="head", orientation=(1, 0, 0, 0), weight=0.1),
    gelenk.Goal("pose", joint="foot_l", target=(0.1, 0.1, 0.1), orientation=np.eye(3), role="pin"),
    gelenk.Goal("aim", joint="head", axis=(0, 0, 1), target=(0, 1.6, 2)),
    gelenk.Goal("direction", joint="head", axis=(0, 0, 1), direction=(1, 0, 0)),
    gelenk.Goal("distance", joint="hand_l", other="hand_r", length=0.25),
    gelenk.Goal("keep-out", joint="hand_r", target=(0.2, 1.0, 0.3), radius=0.1),
]


@pytest.mark.parametrize("goal", figureGoals, ids=lambda g: g.kind)
def test_goals_are_those_of_the_command_line(figure, program, goal):
    result = gelenk.solve(figure, goal, restarts=0)
    told = program.json("solve", "--model", "figure", "--restarts", 0, "--goal", goal.text(figure))
    assert result.q.tolist() == told["solution"]
    assert result.solved == told["solved"]


def test_every_kind_of_goal_can_be_made(figure):
    examples = dict(joint="hand_l", other="hand_r", point=(0, 0, 0.01), target=(0.2, 1.2, 0.3), orientation=(1, 0, 0, 0),
                    axis=(0, 0, 1), posture=figure.rest, length=0.2, direction=(0, 1, 0), up=(0, 1, 0),
                    polygon=[(-0.1, 0, -0.1), (-0.1, 0, 0.2), (0.1, 0, 0.2), (0.1, 0, -0.1)],
                    support=[(-0.1, 0, -0.1), (-0.1, 0, 0.2), (0.1, 0, 0.2), (0.1, 0, -0.1)], margin=0.01,
                    normal=(0, 1, 0), radius=0.2, end=(0.3, 1.2, 0.3), other_point=(0, 0, 0))
    kinds = gelenk.goal_types()
    assert len(kinds) >= 13
    for kind in kinds:
        fields = {}
        for name, explain, optional in kind["fields"]:
            if not optional:
                fields[name] = examples[name]
        if kind["kind"] == "pole":
            fields["joint"] = "lowerarm_l"
        goal = gelenk.Goal(kind["kind"], **fields)
        result = gelenk.solve(figure, goal, restarts=0)
        assert np.isfinite(result.q).all(), kind["kind"]
        assert result.goal_errors.shape == (1, 2)
        text = goal.text(figure)
        again = gelenk.solve(figure, text, restarts=0)
        assert np.array_equal(again.q, result.q), kind["kind"]


def test_targets_of_several_joints(figure):
    result = gelenk.solve(figure, {"hand_l": (0.4, 1.3, 0.3), "hand_r": (-0.4, 1.3, 0.3)})
    assert result and result.goal_errors.shape == (2, 2)
    with pytest.raises(ValueError, match="several ends"):
        gelenk.solve(figure, (0.4, 1.3, 0.3))


def test_a_scene_is_solved_with_its_own_goals(root):
    scene = gelenk.load(root / "assets/scenes/reach.json")
    assert gelenk.solve(scene, restarts=0).goal_errors.size > 0
    with pytest.raises(ValueError, match="nothing is asked for"):
        gelenk.solve(gelenk.model("panda"))


def test_a_batch_is_the_command_line_to_the_bit(panda, program, tmp_path):
    T = targets(panda, 300)
    T[17, :3] *= 40  # out of reach
    table = tmp_path / "targets.csv"
    table.write_text("x,y,z,qw,qx,qy,qz\n" + "\n".join(",".join(repr(float(v)) for v in t) for t in T) + "\n")
    lines = program("solve", "--model", "panda", "--targets", table).splitlines()[1:]
    batch = gelenk.solve_batch(panda, T)
    assert len(batch) == 300 and batch.solved.sum() == 299 and not batch.solved[17]
    for line, q, status in zip(lines, batch.q, batch.status):
        words = line.split(",")
        assert [float(w) for w in words[5:]] == q.tolist()
        assert words[1] == status
    assert gelenk.solve(panda, T).q.shape == (300, 7)
    for t, q in zip(T[:17], batch.q):
        assert np.linalg.norm(panda.fk(q)[-1][:3, 3] - t[:3]) < 1e-6


def test_a_kept_table_changes_no_bit(program, tmp_path):
    """Of 2000 targets on a table of starts is made; a model keeps it for the next batch on that joint."""
    model = gelenk.model("panda")
    T = targets(model, 5000)  # more than one block
    first, again = gelenk.solve_batch(model, T), gelenk.solve_batch(model, T)
    elsewhere = gelenk.solve_batch(model, T[:2500, :7], joint="joint6")
    back = gelenk.solve_batch(model, T)
    assert np.array_equal(first.q, again.q) and np.array_equal(first.q, back.q)
    assert np.array_equal(elsewhere.q, gelenk.solve_batch(gelenk.model("panda"), T[:2500], joint="joint6").q)
    table = tmp_path / "targets.csv"
    table.write_text("x,y,z,qw,qx,qy,qz\n" + "\n".join(",".join(repr(float(v)) for v in t) for t in T) + "\n")
    lines = program("solve", "--model", "panda", "--targets", table).splitlines()[1:]
    assert [[float(w) for w in line.split(",")[5:]] for line in lines] == first.q.tolist()
    with ThreadPoolExecutor(4) as pool:
        for q in pool.map(lambda _: gelenk.solve_batch(model, T).q, range(4)):
            assert np.array_equal(q, first.q)


def test_matrices_are_the_same_targets(panda):
    F = panda.fk(panda.random(2, 20))[:, -1]
    assert gelenk.solve_batch(panda, F).solved.all()
    starts = panda.random(3, 20)
    assert gelenk.solve_batch(panda, F, start=starts).solved.all()


def test_eight_threads_give_the_same_bits(panda, figure):
    T = targets(panda, 200)

    def work(_):
        a = gelenk.solve_batch(panda, T).q
        b = np.array([gelenk.solve(panda, t, solver="evolution", restarts=2, seed=3).q for t in T[:5]])
        c = gelenk.solve(figure, {"hand_l": (0.4, 1.3, 0.3)}).q
        return a.tobytes() + b.tobytes() + c.tobytes()

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(work, range(8)))) == 1


def test_solving_lets_other_threads_run(panda):
    import threading
    T = targets(panda, 3000)
    done = threading.Event()

    def work():
        gelenk.solve_batch(panda, T)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns = 0
    while not done.is_set():
        turns += 1
    thread.join()
    assert turns > 1000


def test_every_solution_of_an_arm(program):
    ur5 = gelenk.model("ur5")
    target = [0.4, 0.1, 0.5, 1, 0, 0, 0]
    found = gelenk.solutions(ur5, target)
    told = program.json("solutions", "--model", "ur5", "--target", *target, "--json")
    assert len(found["q"]) == told["count"] == 8 and found["complete"]
    assert found["q"].tolist() == [s["q"] for s in told["solutions"]]
    for q in found["q"]:
        assert np.allclose(ur5.fk(q)[-1][:3, 3], target[:3], atol=1e-9)
    with pytest.raises(ValueError):
        gelenk.solutions(gelenk.model("panda"), target)


def test_a_path_has_no_needless_jumps():
    ur5 = gelenk.model("ur5")
    n = 30
    line = np.c_[np.full(n, 0.4), np.linspace(-0.2, 0.2, n), np.full(n, 0.4), np.tile([0, 1, 0, 0], (n, 1))]
    plan = gelenk.path(ur5, line)
    assert not plan["jumps"]
    assert np.allclose(ur5.fk(plan["q"])[:, -1, :3, 3], line[:, :3], atol=1e-8)


def test_a_path_counts_the_way_from_its_start():
    ur5 = gelenk.model("ur5")
    line = np.c_[np.full(9, 0.4), np.linspace(-0.2, 0.2, 9), np.full(9, 0.4), np.tile([0, 1, 0, 0], (9, 1))]
    first = gelenk.path(ur5, line)["q"][0]
    near, far = first + 0.01, first + np.array([0.9, 0, 0, 0, 0, 0])
    for start, jumps in ((near, []), (far, [-1])):
        plan = gelenk.path(ur5, line, start=start)
        ways = np.diff(np.vstack([start, plan["q"]]), axis=0)
        assert np.isclose(plan["length"], np.linalg.norm(ways, axis=1).sum())
        assert [pose for pose, _, _ in plan["jumps"]] == jumps
        small = np.abs(ways[len(jumps):])  # the jump is the first way
        assert np.isclose(plan["largest_step"], small.max())
    with pytest.raises(ValueError, match="start: joint 1 of the arm is at 7, outside its limits"):
        gelenk.path(ur5, line, start=[7, 0, 0, 0, 0, 0])


def test_a_path_that_cannot_be_followed_is_refused_in_the_programs_words(program, tmp_path):
    ur5 = gelenk.model("ur5")
    line = [[0.4, 0, 0.4, 0, 1, 0, 0], [9, 0, 0.4, 0, 1, 0, 0]]
    np.savetxt(tmp_path / "path.csv", line)
    told = program("path", "--model", "ur5", "--path", tmp_path / "path.csv").strip()
    assert told.startswith("pose 2 of 2 at (9.0000")
    with pytest.raises(ValueError) as error:
        gelenk.path(ur5, line)
    assert str(error.value) == told
    with pytest.raises(ValueError, match="two poses at least, found 1"):
        gelenk.path(ur5, line[:1])


def test_a_drag_follows_frame_by_frame(figure):
    drag = gelenk.DragSolver(figure)
    foot = figure.fk(figure.rest)[figure.index("foot_l")][:3, 3]
    hand = figure.fk(figure.rest)[figure.index("hand_r")][:3, 3]
    pin = gelenk.Goal("position", joint="foot_l", target=foot, role="pin")
    for t in np.linspace(0, 1, 60):
        result = drag.frame([gelenk.Goal("position", joint="hand_r", target=hand + t * np.array([0, 0.3, 0.2])), pin])
    assert result.position_error < 5e-3
    assert np.array_equal(drag.q, result.q)
    assert np.linalg.norm(figure.fk(drag.q)[figure.index("foot_l")][:3, 3] - foot) < 2e-3
    drag.reset()
    assert np.allclose(drag.q, figure.rest)


def test_the_judge_does_not_ask_who_proposed(panda):
    q = panda.random(5)
    target = panda.fk(q)[-1]
    assert gelenk.judge(panda, target, q)["solved"]
    assert not gelenk.judge(panda, target, panda.rest)["solved"]


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "1", True, None])
def test_a_seed_is_a_whole_number(panda, seed):
    calls = [lambda: gelenk.solve(panda, [0.4, 0.1, 0.5], seed=seed), lambda: gelenk.compare(panda, ["dls"], problems=1, seed=seed),
             lambda: gelenk.solve_batch(panda, [[0.4, 0.1, 0.5]], seed=seed)]
    for call in calls:
        with pytest.raises(ValueError, match=r"^seed: a seed is a whole number from 0 to 2\^64 - 1, found "):
            call()
    assert gelenk.solve(panda, [0.4, 0.1, 0.5], seed=np.uint64(2**64 - 1)).solved
