"""The window's process driven from a script (offscreen), and pictures."""

import json
import shutil
import struct
import subprocess
import time
import zlib

import numpy as np
import pytest

import gelenk
from gelenk import _show


@pytest.fixture(autouse=True)
def needs_graphics(program, monkeypatch):
    import subprocess
    if "sandbox" not in subprocess.run([program.path, "--help"], capture_output=True, text=True).stdout:
        pytest.skip("built without graphics")
    monkeypatch.setenv("GELENK_PROGRAM", program.path)


def until(condition, seconds=200):  # machines that test may be busy
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
        assert '"theme": "light"' in view.scene()
    assert view.closed
    with pytest.raises(ValueError, match="theme"):
        gelenk.show(panda, theme="green", offscreen=True)
    with gelenk.show(panda, theme="dark", offscreen=True) as view:
        assert '"theme": "dark"' in view.scene()
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

        @gelenk.solver("window-newton")
        def window_newton(problem):
            asked.append("whole")
            q = problem.project(problem.start)
            for _ in range(problem.max_iterations):
                r, J = problem.evaluate(q)
                if problem.solved(q):
                    break
                q = problem.integrate(q, J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(len(r)), r))
            return q

        view.solver = "window-newton"
        view.set_goal("tool", target - [0, 0.05, 0])
        assert until(lambda: np.linalg.norm(panda.fk(view.q)[tool][:3, 3] - target + [0, 0.05, 0]) < 1e-3)
        assert "whole" in asked


def test_a_picture_that_cannot_be_made_is_refused_with_the_reason(panda):
    nan, inf = float("nan"), float("inf")
    for name in ("scale", "zoom", "azimuth", "elevation"):
        for value, found in ((nan, "'nan' (not a number)"), (-inf, "'-inf' (infinity)")):
            with pytest.raises(ValueError) as error:
                gelenk.render(panda, size=(64, 64), **{name: value})
            assert str(error.value) == f"--{name}: expected a number, found {found}"
    for name, value, range_ in (("scale", 9, "0.1 to 8"), ("zoom", 0, "0.001 to 1000"), ("elevation", 91, "-90 to 90")):
        with pytest.raises(ValueError) as error:
            gelenk.render(panda, size=(64, 64), **{name: value})
        assert str(error.value) == f"--{name}: expected a number from {range_}, found {value}"
    with pytest.raises(ValueError, match=r"^q: expected shape \(7,\), found \(2, 7\)$"):
        gelenk.render(panda, np.zeros((2, 7)))


def test_notes_are_not_in_front_of_an_errors_reason():
    told = "note: the file has no up axis\nnote: another\ngelenk: a picture of 0 x 0\nRun with --help for more information.\n"
    assert _show._reason(told) == "a picture of 0 x 0"


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
    told = tmp_path / "told.ppm"
    program("render", "panda", "-o", told, "--size", "320x200", "--q", *(repr(float(v)) for v in q))
    assert np.array_equal(picture, gelenk._show._read_ppm(told.read_bytes()))
    picture.save(tmp_path / "panda.png")
    assert np.array_equal(pixels_of((tmp_path / "panda.png").read_bytes()), picture)
    assert picture[0]._repr_png_() is None
    for path, part in (("panda.jpg", picture), ("panda.png", picture[0]), ("panda.png", picture.astype(float))):
        with pytest.raises(ValueError):
            part.save(tmp_path / path)
    chain = gelenk.PlanarChain([1, 0.7]).model()
    assert gelenk.render(chain, [0.3, 0.4], size=(200, 200)).std() > 1


def pixels_of(png):
    """Of a PNG of 8 bits a colour whose rows are unfiltered."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    at, data = 8, b""
    while at < len(png):
        size, name = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + size]
        assert zlib.crc32(name + body) == struct.unpack(">I", png[at + 8 + size:at + 12 + size])[0]
        if name == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        if name == b"IDAT":
            data += body
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


def arm_of_the_script():
    ball = dict(name="shoulder", ball=True, ball_limit=dict(swing_radii=(0.9, 0.9), twist=(-0.3, 0.4)))
    elbow = dict(name="elbow", parent="shoulder", offset=(0, 0, 1), axes=[dict(axis=(1, 0, 0), lower=0, upper=2)])
    finger = dict(name="finger", parent="elbow", offset=(0, 0, 0.8), axes=[dict(kind="translation", axis=(1, 0, 0), lower=0, upper=0.2)])
    twin = dict(name="twin", parent="elbow", offset=(0, 0, 0.8), axes=[dict(kind="translation", axis=(-1, 0, 0), lower=0, upper=0.2)],
                mimic=dict(joint="finger"))
    return gelenk.Model.from_joints([ball, elbow, finger, twin], name="arm of the script")


def made_models(inputs):
    figure = gelenk.model("figure")
    tube = gelenk.load(inputs / "tube.obj", skeleton=inputs / "tube.skel", unit="cm")
    return [arm_of_the_script(), tube, gelenk.bind(figure, figure.skin.vertices, figure.skin.triangles, None)]


def test_models_of_a_script_are_shown_as_they_are(inputs, tmp_path):
    for model in made_models(inputs):
        gelenk.save(tmp_path / "made.json", model)  # what the window opens
        again = gelenk.load(tmp_path / "made.json")
        wild = model.integrate(model.random(1), np.random.default_rng(2).normal(size=model.nv))
        for q in (model.rest, model.random(3), wild):
            assert np.array_equal(again.fk(q), model.fk(q))
            assert again.violation(q) == model.violation(q)
            assert np.array_equal(again.project(q), model.project(q))
            if model.skin:
                assert np.array_equal(again.skin(again.fk(q)), model.skin(model.fk(q)))
        assert again.nv == model.nv and again.name == model.name


def test_a_model_of_the_script_moves_in_the_window():
    arm = arm_of_the_script()
    with gelenk.show(arm, offscreen=True) as view:
        q = arm.random(3)
        view.q = q
        assert np.array_equal(view.q, q)
        target = arm.fk(arm.random(4))[arm.index("finger")][:3, 3]
        view.set_goal("finger", target)
        assert until(lambda: np.linalg.norm(arm.fk(view.q)[arm.index("finger")][:3, 3] - target) < 2e-3)
        q = view.q
        assert arm.violation(q) < 1e-6 and np.array_equal(arm.coupled(q), q)
    pictures = [gelenk.render(arm, q, size=(200, 200)).astype(int) for q in (arm.rest, q)]
    assert (np.abs(pictures[0] - pictures[1]).max(-1) > 20).sum() > 100


def test_a_damaged_description_is_told(tmp_path, inputs):
    arm = arm_of_the_script()
    gelenk.save(tmp_path / "arm.json", arm)
    scene = json.loads((tmp_path / "arm.json").read_text())
    tree = json.loads(scene["model"]["name"].removeprefix("joints:"))

    def opened(change):
        copy = json.loads(json.dumps(tree))
        change(copy)
        scene["model"]["name"] = "joints:" + json.dumps(copy)
        (tmp_path / "bad.json").write_text(json.dumps(scene))
        return gelenk.load(tmp_path / "bad.json")

    assert opened(lambda t: None).nv == arm.nv
    for change, word in ((lambda t: t.pop("joints"), "joints"), (lambda t: t["joints"].clear(), "at least one joint"), (lambda t: t["joints"][1].update(parent=7), "parent"),
                         (lambda t: t["joints"][1].update(offset=[1, 2]), r"joints\[1\].offset"), (lambda t: t["joints"][1]["axes"][0].update(kind="screw"), "rotation"),
                         (lambda t: t["rest"].pop(), "rest"), (lambda t: t.update(handles=["nobody"]), "nobody"), (lambda t: t.update(up=[0, 0, 2]), "up"),
                         (lambda t: t.update(skin={}), "skin"), (lambda t: t["joints"][3]["mimic"].update(joint=9), "twin")):
        with pytest.raises(ValueError, match=word):
            opened(change)


# ---- a person's hand: a real window on a display of its own, and a mouse


@pytest.fixture
def display(monkeypatch):
    for needed in ("Xvfb", "xdotool"):
        if not shutil.which(needed):
            pytest.skip(f"{needed} is not installed")
    server = subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", "1280x800x24", "-noreset", "-nolisten", "tcp"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    monkeypatch.setenv("DISPLAY", ":" + server.stdout.readline().strip())
    monkeypatch.setenv("LIBGL_ALWAYS_SOFTWARE", "1")
    yield lambda *words: subprocess.run(["xdotool", *map(str, words)], check=True)
    server.terminate()
    server.wait()


@pytest.mark.parametrize("model, joint", [(gelenk.model("figure"), "hand_r"), (arm_of_the_script(), "finger")], ids=["figure", "script"])
def test_what_a_person_drags_comes_back(model, joint, display, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    q = model.rest
    if joint == "finger":
        q[model.q_slice("elbow")] = 0.7
    with gelenk.show(model, q, size=(900, 640)) as view:
        def goal():
            return next(g for g in view.goals if g["name"] == joint)

        assert until(lambda: view._ask("status")["frame"] >= 2)
        before, at, area = view.q, goal()["pixel"], view._ask("status")["view"]
        for g in view.goals:  # the window opens with the whole in view
            assert area["x"] < g["pixel"][0] < area["x"] + area["width"] and area["y"] < g["pixel"][1] < area["y"] + area["height"]
        seen = []
        view.on_change = lambda v: seen.append(v)
        display("mousemove", round(at[0]), round(at[1]))
        assert until(lambda: np.abs(np.subtract(view._ask("status")["mouse"], at)).max() < 2)
        display("mousedown", 1)
        assert until(lambda: view._ask("status")["dragging"] == joint)
        for k in range(1, 11):
            display("mousemove", round(at[0]) - 2 * k, round(at[1]) - 5 * k)
        change = view.wait_for_change(timeout=200)
        assert change["dragging"] == joint and change["q"]
        assert until(lambda: goal()["error"] < 2e-3 and abs(goal()["pixel"][1] - at[1] + 50) < 2, 40), (at, goal(), view._ask("status")["mouse"], view._ask("status")["frame"])
        display("mouseup", 1)
        assert until(lambda: not view._ask("status")["dragging"])
        now = view._now()  # one frame's pose and goals
        after, held = np.array(now["q"]), next(g for g in now["goals"] if g["name"] == joint)
        there = model.fk(after)[model.index(joint)][:3, 3]
        assert np.abs(model.difference(before, after)).max() > 0.02 and seen
        assert np.allclose(there, held["reached"], atol=1e-9)
        assert np.linalg.norm(there - held["target"]) < 5e-3
        assert model.violation(after) < 1e-6
