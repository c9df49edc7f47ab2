"""The window's process driven from a script (offscreen), and pictures."""

import time

import numpy as np
import pytest

import gelenk


@pytest.fixture(autouse=True)
def needs_graphics(program, monkeypatch):
    import subprocess
    if "sandbox" not in subprocess.run([program.path, "--help"], capture_output=True, text=True).stdout:
        pytest.skip("built without graphics")
    monkeypatch.setenv("GELENK_PROGRAM", program.path)


def until(condition, seconds=30):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def test_a_pose_goes_there_and_back(panda):
    with gelenk.show(panda, offscreen=True) as view:
        q = panda.random(1)
        view.q = q
        assert np.array_equal(view.q, q)
        assert view.solver == "drag"
        view.solver = "dls[lambda=0.1]"
        assert view.solver == "dls"
        for wrong in (lambda: setattr(view, "q", q[:3]), lambda: setattr(view, "solver", "nothing"),
                      lambda: view.set_goal("elbow", (0, 0, 0)), lambda: view.set_goal("tool", (0, 0), "held"),
                      lambda: view.set_goal("tool", (0.4, 0, 0.4), "loose"), lambda: view._ask("dance")):
            with pytest.raises(ValueError):
                wrong()
        assert not view.closed
    assert view.closed
    with pytest.raises(RuntimeError, match="closed"):
        view.q


def test_goals_are_followed_and_told(figure):
    with gelenk.show(figure, offscreen=True) as view:
        hand = figure.fk(figure.rest)[figure.index("hand_r")][:3, 3]
        seen = []
        view.on_change = lambda v: seen.append(1)
        view.set_goal("hand_r", hand + [0, 0.2, 0.1])
        there = figure.index("hand_r")
        assert until(lambda: np.linalg.norm(figure.fk(view.q)[there][:3, 3] - hand - [0, 0.2, 0.1]) < 2e-3)
        assert seen and view.wait_for_change(0.0) is None
        goal = next(g for g in view.goals if g["name"] == "hand_r")
        assert np.allclose(goal["target"], hand + [0, 0.2, 0.1])
        before = len(view.goals)
        view.add_goal(gelenk.Goal("distance", joint="hand_l", other="head", length=0.3))
        assert len(view.goals) == before + 1
        assert '"goals"' in view.scene()
        picture = view._repr_png_()
        assert picture.startswith(b"\x89PNG")
        view.q = figure.random(3)
        assert view._repr_png_() != picture
    assert view._repr_png_() is None


def test_a_solver_of_ones_own_runs_in_the_window(panda):
    asked = []

    @gelenk.step_rule("window-dls", parameters={"lambda": (0.05, 0.0, 1.0)})
    def window_dls(J, r, q, lambda_):
        asked.append(1)
        return J.T @ np.linalg.solve(J @ J.T + lambda_**2 * np.eye(len(r)), r)

    with gelenk.show(panda, offscreen=True) as view:
        view.solver = "window-dls"
        tool = panda.index("tool")
        target = panda.fk(panda.rest)[tool][:3, 3] + [0.05, 0.1, 0.05]
        view.set_goal("tool", target)
        assert until(lambda: np.linalg.norm(panda.fk(view.q)[tool][:3, 3] - target) < 1e-3)
        assert asked


def test_a_picture_is_that_of_the_program(panda, program, tmp_path):
    q = panda.random(2)
    picture = gelenk.render(panda, q, size=(320, 200))
    assert picture.shape == (200, 320, 3) and picture.dtype == np.uint8 and picture.std() > 5
    assert not np.array_equal(picture, gelenk.render(panda, panda.rest, size=(320, 200)))
    with_handles = gelenk.render(panda, q, size=(320, 200), handles=True)
    assert (with_handles != picture).any(-1).sum() < 2000  # one mark
    assert (with_handles != picture).any()
    dark = gelenk.render(panda, q, size=(320, 200), theme="dark")
    assert dark.mean() < picture.mean()
    with pytest.raises(ValueError, match="made in this script"):
        gelenk.show(gelenk.Model.from_joints([dict(name="alone")]), offscreen=True)
    # a model made here is drawn as well, in the same places
    figure = gelenk.model("figure")
    made = gelenk.bind(figure, figure.skin.vertices, figure.skin.triangles)
    q = figure.rest
    q[figure.q_slice("lowerarm_l")][0] = 1.5
    def moved(model):  # pixels that the arm leaves or enters, whatever the colour of the skin
        straight, bent = (gelenk.render(model, pose, size=(200, 200), shadow=False).astype(int) for pose in (None, q))
        return np.abs(straight - bent).max(-1) > 20

    ours, theirs = moved(made), moved(figure)
    assert ours.sum() > 100 and (ours & theirs).sum() > 0.7 * (ours | theirs).sum()
    chain = gelenk.PlanarChain([1, 0.7]).model()
    assert gelenk.render(chain, [0.3, 0.4], size=(200, 200)).std() > 1
