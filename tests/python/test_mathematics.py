"""The notations of the slides against their formulas."""

import numpy as np
import pytest

import gelenk


def test_planar_chain_is_the_sum_of_its_links():
    rng = np.random.default_rng(1)
    for n in range(1, 6):
        lengths, base, phi = rng.uniform(0.5, 2, n), rng.normal(size=2), rng.uniform(-3, 3, n)
        chain = gelenk.PlanarChain(lengths, base)
        angle = np.cumsum(phi)
        X = base + (lengths[:, None] * np.c_[np.cos(angle), np.sin(angle)]).sum(0)
        assert np.allclose(chain.end_effector(phi), X, atol=1e-14 * n)
        P = chain.points(phi)
        assert P.shape == (n + 1, 2) and np.array_equal(P[-1], chain.end_effector(phi))
        turned = (X - P[:-1]) @ [[0, 1], [-1, 0]]
        assert np.allclose(chain.jacobian(phi), turned.T, atol=1e-13)
        assert np.allclose(chain.frames(phi)[-1][:2, 2], X, atol=1e-13)
        assert np.allclose(chain.model().fk(phi)[-1][:2, 3], X, atol=1e-13)


def test_the_lectures_chain():
    chain = gelenk.PlanarChain.lecture()
    assert chain.base.tolist() == [50, 400] and chain.lengths == [150, 200, 100]
    assert chain.degrees_of_freedom == 5


def test_two_links_reach_with_both_elbows():
    rng = np.random.default_rng(2)
    for _ in range(200):
        l1, l2 = rng.uniform(0.2, 2, 2)
        r = rng.uniform(abs(l1 - l2) + 1e-3, l1 + l2 - 1e-3)
        t = rng.uniform(-np.pi, np.pi)
        base = rng.normal(size=2)
        target = base + r * np.array([np.cos(t), np.sin(t)])
        found = gelenk.two_link(l1, l2, target, base)
        assert found["phi"].shape == (2, 2) and found["exact"] and found["case"] == "two elbows"
        chain = gelenk.PlanarChain([l1, l2], base)
        for phi in found["phi"]:
            assert np.allclose(chain.end_effector(phi), target, atol=1e-13 * (l1 + l2) + 1e-15)
        holds = gelenk.two_link_candidates(l1, l2, target, base)
        assert (holds[:, 2] < 1e-9).sum() == 2
    far = gelenk.two_link(1, 1, (3, 0))
    assert far["gap"] == pytest.approx(1) and not far["exact"]


@pytest.mark.parametrize("name", ["puma560", "ur5", "panda", "iiwa14", "scara"])
def test_dh_tables_agree_with_their_models_in_both_conventions(name):
    table = gelenk.DhTable.robot(name)
    model = table.model()
    q = model.random(3)
    tool = table.frames(q)[-1]
    assert np.allclose(model.fk(q)[-1], tool, atol=1e-13)
    product = table.base.copy()
    variable = 0
    for i, row in enumerate(table.rows):
        moving = row["kind"] != "fixed"
        product = product @ table.transform(i, q[variable] if moving else 0.0)
        variable += moving
    assert np.allclose(product @ table.tool, tool, atol=1e-13)
    for convention in ("modified", "standard"):
        assert np.allclose(table.to_convention(convention).frames(q)[-1], tool, atol=1e-12)
    again = gelenk.DhTable.parse(table.text())
    assert np.array_equal(again.frames(q), table.frames(q))
    assert np.allclose(gelenk.DhTable.of(model).frames(q)[-1], tool, atol=1e-9)


def test_a_table_from_four_numbers_a_row():
    table = gelenk.DhTable([(0, 0, 0, 0), (1, 0, 0, 0), dict(kind="fixed", a=1)])
    assert table.parameter_count == 15 and table.variable_count == 2
    assert np.allclose(table.frames([np.pi / 2, 0])[-1][:3, 3], [0, 2, 0])


def test_euler_angles_and_rotation_vectors():
    rng = np.random.default_rng(3)
    for order in ("xyz", "zyx", "zxz"):
        R = gelenk.rotation_from_euler(order, rng.uniform(-1, 1, 3))
        assert np.allclose(R @ R.T, np.eye(3), atol=1e-15)
        assert np.allclose(gelenk.rotation_from_euler(order, gelenk.euler_from_rotation(order, R)), R, atol=1e-14)
    for _ in range(20):
        w = rng.uniform(-1.7, 1.7, 3)  # shorter than pi
        assert np.allclose(gelenk.log(gelenk.exp(w)), w, atol=1e-14)
    with pytest.raises(ValueError, match="there are"):
        gelenk.rotation_from_euler("xxz", [0, 0, 0])


def test_the_lecture_holds():
    checks = gelenk.lecture()
    assert len(checks) > 50
    assert all(check["ok"] for check in checks)
    assert {check["topic"] for check in gelenk.lecture(checks[0]["topic"])} == {checks[0]["topic"]}
