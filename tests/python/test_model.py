"""Models and their mathematics: against the definitions, differences, and the command line to the bit."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

import gelenk

everyModel = [name for name in gelenk.models()]


@pytest.fixture(params=everyModel)
def model(request):
    return gelenk.model(request.param)


def test_frames_are_rigid_and_batches_are_the_same_bits(model):
    Q = model.random(3, 20)
    assert Q.shape == (20, model.nq)
    F = model.fk(Q)
    assert F.shape == (20, model.joint_count, 4, 4)
    for q, frames in zip(Q, F):
        assert np.array_equal(model.fk(q), frames)
    R = F[..., :3, :3]
    # rounding of products of some ten rotations
    assert np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max() < 1e-13
    assert np.array_equal(F[..., 3, :], np.broadcast_to([0, 0, 0, 1], F[..., 3, :].shape))


def test_jacobian_matches_central_differences(model):
    rng = np.random.default_rng(5)
    q, joint, point = model.random(7), model.joint_count - 1, rng.normal(size=3)
    J = model.jacobian(q, joint, point)
    assert J.shape == (6, model.nv)
    h = 1e-6
    for k in range(model.nv):
        d = h * np.eye(model.nv)[k]
        a, b = (model.fk(model.integrate(q, s * d))[joint] for s in (1, -1))
        place = ((a - b) @ np.append(point, 1))[:3] / (2 * h)
        turn = gelenk.log(a[:3, :3] @ b[:3, :3].T) / (2 * h)
        # rounding 1e-16 / h of places up to a thousand units, and h^2
        assert np.allclose(J[:, k], np.r_[place, turn], atol=2e-7 * (1 + np.abs(a).max()))
    both = model.jacobian(np.stack([q, q]), joint, point)
    assert np.array_equal(both[1], J)


def test_integrate_undoes_difference(model):
    a, b = model.random(1), model.random(2)
    there = model.integrate(a, model.difference(a, b))
    assert np.allclose(model.fk(there), model.fk(b), atol=1e-12 * (1 + np.abs(model.fk(b)).max()))
    A, B = model.random(1, 5), model.random(2, 5)
    D = model.difference(A, B)
    assert D.shape == (5, model.nv)
    assert np.array_equal(model.integrate(A, D)[3], model.integrate(A[3], D[3]))


def test_random_poses_keep_limits_and_follow_the_seed(model):
    Q = model.random(11, 50)
    assert max(model.violation(q) for q in Q) <= 1e-12
    low, high = model.limits.T
    assert np.all(Q >= low - 1e-12) and np.all(Q <= high + 1e-12)
    assert np.array_equal(Q, model.random(11, 50))
    a, b = (model.random(np.random.default_rng(1)) for _ in range(2))
    assert np.array_equal(a, b)
    assert not np.array_equal(model.random(), model.random())


def test_fk_is_the_command_line_to_the_bit(model, program):
    def joints(*words):
        return program.json("fk", model.name, "--json", *words)["joints"]

    poses = [(model.rest, ())]
    q = model.random(4)
    poses.append((q, ("--q", *(repr(float(v)) for v in q))))
    for q, words in poses:
        F = model.fk(q)
        for frame, told in zip(F, joints(*words)):
            assert frame[:3, 3].tolist() == told["position"]


def test_one_pose_comes_without_a_copy(figure):
    frames = figure.fk(figure.rest)
    assert frames.strides == (128, 8, 32)
    assert frames.base is not None and not frames.flags.owndata
    first = frames[5].copy()
    del frames
    assert np.array_equal(figure.fk(figure.rest)[5], first)


def test_every_format_loads(inputs, root):
    load, assets = gelenk.load, root / "assets"
    assert load(inputs / "five_dof.dh").nq == 5
    assert load(inputs / "straight.urdf").nv > 0
    assert load(inputs / "tube.obj", skeleton=inputs / "tube.skel").skin
    assert load(assets / "nurbs_arm.nurbs", skeleton=assets / "nurbs_arm.skel").skin
    assert load(inputs / "apose.bvh").clip
    assert load(inputs / "two_clips.gltf", clip="second" if "second" in (inputs / "two_clips.gltf").read_text() else None).clip
    assert load(inputs / "tube.skel").joint_count > 1
    assert load(assets / "tutorial_figure.figure").nq > 0
    assert load(assets / "tutorial_stride.pose", figure=assets / "tutorial_figure.figure").nq > 0
    scene = load(assets / "scenes/reach.json")
    assert scene.pose.shape == (scene.nq,)
    cm, m = load(inputs / "tube.skel", unit="cm"), load(inputs / "tube.skel")
    assert np.abs(m.fk(m.rest)[:, :3, 3]).max() / np.abs(cm.fk(cm.rest)[:, :3, 3]).max() == pytest.approx(100)
    assert load(inputs / "apose.bvh", up="z").up.tolist() == [0, 0, 1]
    with pytest.raises(ValueError, match="y or z"):
        load(inputs / "apose.bvh", up="w")


data = Path(os.environ.get("GELENK_DATA_DIR") or "/nowhere")


@pytest.mark.skipif(not data.exists(), reason="the trial data are not there")
def test_strangers_files_load():
    asf = data / "mocap/asf/02.asf"
    walk = gelenk.load(data / "mocap/asf/02_01.amc", asf=asf)
    assert len(walk.clip) == 343 and walk.fk(walk.clip.q).shape[1:] == (walk.joint_count, 4, 4)
    assert gelenk.load(data / "mocap/asf/02_01.amc", asf=asf, fps=60).clip.duration == pytest.approx(2 * walk.clip.duration)
    body = gelenk.load(data / "pinocchio/mh_male.game_engine.skel")
    assert body.joint_count > 10
    for file in ("characters/gltf/Fox.glb", "characters/kaykit/Knight.glb", "robots/panda/urdf/panda.urdf", "mocap/bvh/mh_walk1.bvh"):
        model = gelenk.load(data / file)
        assert np.isfinite(model.fk(model.rest)).all(), file
    assert gelenk.load(data / "robots/panda/urdf/panda.urdf").nv == 8  # the second finger follows the first


def places(model):
    """Where the joints stand, whatever they are called: as a motion begins, else at rest."""
    return np.sort(model.fk(model.clip.q[0] if model.clip else model.rest)[:, :3, 3], axis=0)


@pytest.mark.parametrize("ending", ["glb", "gltf", "bvh", "asf", "skel", "figure", "json"])
def test_what_is_saved_loads_again(ending, inputs, tmp_path):
    tube = gelenk.load(inputs / "tube.obj", skeleton=inputs / "tube.skel")
    notes = gelenk.save(tmp_path / f"tube.{ending}", tube)
    assert all(len(note) == 2 for note in notes)
    again = gelenk.load(tmp_path / f"tube.{ending}")
    for end in places(again)[[0, -1]]:  # bones that end nowhere get an end of their own
        assert np.abs(places(tube) - end).max(1).min() < 1e-5, ending


def test_motions_robots_and_bodies_are_saved(inputs, tmp_path):
    tube = gelenk.load(inputs / "tube.obj", skeleton=inputs / "tube.skel")
    gelenk.save(tmp_path / "tube.obj", tube)
    gelenk.save(tmp_path / "tube.attachment", tube)
    gelenk.save(tmp_path / "tube.skel", tube)
    again = gelenk.load(tmp_path / "tube.obj", skeleton=tmp_path / "tube.skel", weights=tmp_path / "tube.attachment")
    assert np.allclose(again.skin.vertices, tube.skin.vertices, atol=1e-6)
    gelenk.save(tmp_path / "ur5.dh", gelenk.model("ur5"))
    ur5 = gelenk.load(tmp_path / "ur5.dh")
    q = ur5.random(1)
    assert np.allclose(ur5.fk(q)[-1], gelenk.model("ur5").fk(q)[-1], atol=1e-9)
    motion = gelenk.load(inputs / "apose.bvh")
    gelenk.save(tmp_path / "a.asf", motion)
    gelenk.save(tmp_path / "a.amc", motion)
    assert len(gelenk.load(tmp_path / "a.amc", asf=tmp_path / "a.asf").clip) == len(motion.clip)
    with pytest.raises(ValueError, match="no clip"):
        gelenk.save(tmp_path / "a.json", motion, motion.clip)
    with pytest.raises(ValueError, match="read only"):
        gelenk.save(tmp_path / "a.urdf", motion)


def test_rows_are_answered_one_by_one(model):
    Q = model.integrate(model.random(1, 6), np.random.default_rng(2).normal(size=(6, model.nv)))
    for f in (model.project, model.violation, model.coupled, model.fk):
        assert np.array_equal(f(Q), [f(q) for q in Q])
    assert isinstance(model.violation(Q[0]), float)
    s = np.linspace(0, 1, 6)
    a = model.interpolate(Q, Q[::-1].copy(), s)
    assert np.array_equal(a, [model.interpolate(p, q, t) for p, q, t in zip(Q, Q[::-1], s)])
    assert np.array_equal(model.interpolate(Q[0], Q[1], s)[3], model.interpolate(Q[0], Q[1], s[3]))
    with pytest.raises(ValueError, match="of them"):
        model.interpolate(Q, Q[:3], 0.5)


def test_a_file_that_does_not_parse_says_where(tmp_path):
    bad = tmp_path / "bad.dh"
    bad.write_text("dh modified\nrow nonsense\n")
    with pytest.raises(gelenk.ParseError, match="bad.dh:2") as error:
        gelenk.load(bad)
    assert error.value.line == 2 and error.value.expected and error.value.found
    assert isinstance(error.value, ValueError)


def test_joints_make_a_model_and_tell_it_again(panda):
    again = gelenk.Model.from_joints([panda.joint(i) for i in range(panda.joint_count)], rest=panda.rest)
    q = panda.random(9)
    assert np.array_equal(again.fk(q), panda.fk(q))
    arm = gelenk.Model.from_joints([
        dict(name="shoulder", axes=[dict(axis=(0, 0, 1), lower=-1, upper=1)]),
        dict(name="hand", parent="shoulder", offset=(2, 0, 0)),
    ])
    assert np.allclose(arm.fk([np.pi / 6])[1][:3, 3], [2 * np.cos(np.pi / 6), 1, 0])
    with pytest.raises(ValueError, match="does not come before"):
        gelenk.Model.from_joints([dict(name="a", parent="b")])


def again_from_joints(model):
    return gelenk.Model.from_joints([model.joint(i) for i in range(model.joint_count)], rest=model.rest)


def test_every_model_comes_back_from_its_joints(model):
    again = again_from_joints(model)
    assert (again.nq, again.nv) == (model.nq, model.nv)
    assert np.array_equal(again.limits, model.limits) and np.array_equal(again.rest, model.rest)
    assert str(again.ball_limits) == str(model.ball_limits)
    wild = model.integrate(model.random(1), np.random.default_rng(2).normal(size=model.nv))
    for q in (model.random(3), wild):
        assert np.array_equal(again.fk(q), model.fk(q))
        assert again.violation(q) == model.violation(q)
        assert np.array_equal(again.project(q), model.project(q))


gripper = [
    dict(name="wrist", axes=[dict(axis=(0, 0, 1), lower=-1, upper=1)]),
    dict(name="left", parent="wrist", offset=(0, 0.1, 0), axes=[dict(kind="translation", axis=(0, 1, 0), lower=-0.5, upper=1)],
         mimic=dict(joint="right", multiplier=-2, offset=0.1)),  # of a joint that comes later
    dict(name="right", parent="wrist", axes=[dict(axis=(1, 0, 0), lower=-1, upper=1)]),
]


def test_joints_that_follow_others_keep_doing_so():
    model = gelenk.Model.from_joints(gripper)
    assert (model.nq, model.nv) == (3, 2)
    assert model.coupled([0.5, 0, 0.2]).tolist() == [0.5, -2 * 0.2 + 0.1, 0.2]
    assert model.joint("left")["mimic"] == dict(joint="right", multiplier=-2, offset=0.1)
    again = again_from_joints(model)
    assert again.nv == 2
    q = model.random(4)
    assert np.array_equal(again.jacobian(q, "left"), model.jacobian(q, "left"))
    for wrong, word in ((dict(joint="nobody"), "no joint"), (dict(), "no joint"), (3, "expected a dict"), (dict(joint="left"), "left"),
                        (dict(joint="right", multiplier=np.nan), "finite"), (dict(joint="right", gear=2), "unknown entry")):
        with pytest.raises(ValueError, match=word):
            gelenk.Model.from_joints([gripper[0], dict(gripper[1], mimic=wrong), gripper[2]])


def test_balls_keep_their_limits():
    shoulder = dict(name="shoulder", ball=True, ball_limit=dict(swing_centre=(0.1, 0), swing_radii=(0.5, 0.8), twist=(-0.3, 0.4)))
    model = gelenk.Model.from_joints([shoulder, dict(name="hand", parent="shoulder", offset=(0, 0, 1))])
    told = model.ball_limits["shoulder"]
    assert told["swing_radii"].tolist() == [0.5, 0.8] and told["twist"] == (-0.3, 0.4)
    assert model.joint("shoulder")["ball_limit"]["swing_centre"].tolist() == [0.1, 0]
    far = model.integrate(model.rest, [0, 0, 1.0])  # a turn about the bone
    assert model.violation(far) == pytest.approx(0.6)
    for wrong, word in ((dict(swing_radii=(0, 1)), "shoulder"), (dict(twist=(1, 0)), "shoulder"), (dict(twist=3), "two numbers"),
                        (dict(swing_centre="x"), "swing_centre"), (dict(cone=1), "unknown entry"), (3, "expected a dict")):
        with pytest.raises(ValueError, match=word):
            gelenk.Model.from_joints([dict(shoulder, ball_limit=wrong)])
    with pytest.raises(ValueError, match="without a ball"):
        gelenk.Model.from_joints([dict(shoulder, ball=False)])


def test_mirror_twice_is_nothing(figure):
    q = figure.random(6)
    assert np.allclose(figure.mirror(figure.mirror(q)), q, atol=1e-12)
    assert np.array_equal(figure.mirror([q, figure.rest])[0], figure.mirror(q))
    with pytest.raises(ValueError):
        gelenk.model("panda").mirror(gelenk.model("panda").rest)


def test_centre_of_mass(figure):
    assert figure.mass == pytest.approx(73)
    assert 0.8 < figure.centre_of_mass(figure.rest)[1] < 1.2
    assert np.array_equal(figure.centre_of_mass([figure.rest] * 3)[2], figure.centre_of_mass(figure.rest))
    with pytest.raises(ValueError, match="no masses"):
        gelenk.model("planar").centre_of_mass(gelenk.model("planar").rest)


@pytest.mark.parametrize("ending", ["glb", "gltf", "bvh", "asf", "amc", "skel", "obj", "json"])
def test_files_that_cannot_be_opened_or_written_are_os_errors(ending, tmp_path):
    figure = gelenk.model("figure")
    clip = gelenk.Clip(figure, figure.rest[None], 30) if ending in ("bvh", "amc") else None
    (tmp_path / "file").write_text("")
    for place, kind in ((tmp_path / "nowhere" / f"a.{ending}", FileNotFoundError), (tmp_path / "file" / f"a.{ending}", NotADirectoryError)):
        with pytest.raises(kind, match="cannot write .*a." + ending) as error:
            gelenk.save(place, figure, clip)
        assert error.value.errno in (errno.ENOENT, errno.ENOTDIR)
        with pytest.raises(FileNotFoundError if kind is FileNotFoundError else OSError, match="a." + ending):
            gelenk.load(place)
