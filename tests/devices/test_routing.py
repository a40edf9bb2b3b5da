"""Lengths and Jacobians: MuJoCo's tendons, differences, and what must not matter."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.errors import BadInput


def postures(tree, samples=23, seed=0):
    return np.random.default_rng(seed).uniform(-1.2, 1.2, (samples, len(tree.joints)))


def ground_band():
    way = (
        ("ground", (0.1, 0.2, 0.3)),
        ("leg", (0.0, 0.1, -0.2)),
        ("ground", (0.5, -0.3, 0.4)),
        ("finger", (0, 0, 0.1)),
    )
    return Band("anchor", "anchor", tuple(ViaPoint(link, xyz) for link, xyz in way))


def tendons(pair, bands, q, seed=1):
    """MuJoCo's lengths (T, W) and Jacobians (T, W, J), the base's columns (T, W, 6), at random base poses."""
    model = pair.mjcf(bands)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    places = [model.joint(name).qposadr[0] for name in pair.joints]
    columns = [model.joint(name).dofadr[0] for name in pair.joints]
    found = []
    for row in q:
        if pair.tree.floating:
            data.qpos[:3], data.qpos[3:7] = rng.normal(size=3), rng.normal(size=4)
        data.qpos[places] = row
        mujoco.mj_forward(model, data)
        dense = np.zeros((model.ntendon, model.nv))
        for w in range(model.ntendon):
            part = slice(model.ten_J_rowadr[w], model.ten_J_rowadr[w] + model.ten_J_rownnz[w])
            dense[w, model.ten_J_colind[part]] = data.ten_J[part]
        found.append((data.ten_length.copy(), dense[:, columns], np.delete(dense, columns, axis=1)))
    return [np.array(each) for each in zip(*found, strict=True)]


def spread(routing, jacobian):
    """(T, W, J) with zeros for the joints that no band passes."""
    full = np.zeros((*jacobian.shape[:2], len(routing.tree.joints)))
    full[:, :, routing.columns] = jacobian
    return full


def test_lengths_and_jacobians_are_those_of_mujocos_tendons_at_any_base_pose(pair, bands):
    q = postures(pair.tree)
    chosen = bands if pair.tree.floating else (*bands, ground_band())
    length, jacobian, base = tendons(pair, chosen, q)
    routing = Routing(pair.tree, chosen)
    measured = routing.geometry(q)
    assert np.abs(measured.length - length).max() < 1e-10
    assert np.abs(spread(routing, measured.jacobian) - jacobian).max() < 1e-8
    assert np.abs(base).max(initial=0.0) < 1e-14
    np.testing.assert_array_equal(routing.lengths(q), measured.length)


def test_jacobian_is_the_slope_of_the_length(pair, bands):
    routing, q, step = Routing(pair.tree, bands), postures(pair.tree), 1e-6
    jacobian = routing.geometry(q).jacobian
    for d, column in enumerate(routing.columns):
        ahead, behind = q.copy(), q.copy()
        ahead[:, column] += step
        behind[:, column] -= step
        slope = (routing.lengths(ahead) - routing.lengths(behind)) / (2 * step)
        assert np.abs(jacobian[:, :, d] - slope).max() < 1e-8


@pytest.mark.parametrize("base", ["rail", "finger", "shin", "tip"])
def test_the_link_that_carries_the_imu_changes_nothing(odd_tree, bands, base):
    q = postures(odd_tree("trunk"))
    here, there = (Routing(odd_tree(link), bands) for link in ("trunk", base))
    assert here.joints == there.joints
    one, other = here.geometry(q), there.geometry(q)
    assert np.abs(one.length - other.length).max() < 1e-12
    assert np.abs(one.jacobian - other.jacobian).max() < 1e-12


def test_turning_and_shifting_the_whole_robot_changes_no_length(floating_pair, bands):
    """Points by pinocchio, the free-flyer anywhere in the world, and the slope along the base's six directions."""
    model, tree = floating_pair.model, floating_pair.tree
    data, rng, q = model.createData(), np.random.default_rng(2), postures(tree, 5)
    expected = Routing(tree, bands).lengths(q)
    for row, length in zip(q, expected, strict=True):
        full = pin.neutral(model)
        full[:7] = np.r_[rng.normal(size=3) * 10, Rotation.random(random_state=3).as_quat()]
        for name, value in zip(tree.joints, row, strict=True):
            full[model.joints[model.getJointId(name)].idx_q] = value
        pin.computeJointJacobians(model, data, full)
        pin.updateFramePlacements(model, data)
        for band, l in zip(bands, length, strict=True):  # noqa: E741
            p, jacobians = zip(*(point(model, data, via) for via in band.via_points), strict=True)
            assert abs(np.linalg.norm(np.diff(p, axis=0), axis=1).sum() - l) < 1e-12
            e = np.diff(p, axis=0) / np.linalg.norm(np.diff(p, axis=0), axis=1)[:, None]
            slope = np.einsum("sx,sxv->v", e, np.diff(jacobians, axis=0))
            assert np.abs(slope[:6]).max() < 1e-12


def point(model, data, via):
    """Position and Jacobian of a via point in the world, by pinocchio."""
    frame = model.getFrameId(via.link)
    T = data.oMf[frame]
    J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    x = T.rotation @ np.array(via.xyz)
    return T.translation + x, J[:3] - pin.skew(x) @ J[3:]


def test_only_joints_between_neighbouring_via_points_count(talos, suit, pair, bands):
    names = set(Routing(talos, suit).joints)
    assert names == {"torso_1_joint", "torso_2_joint"} | {
        f"leg_{s}_{n}_joint" for s in ("left", "right") for n in "123"
    }
    assert set(Routing(pair.tree, bands[:1]).joints) == {"slide", "hip", "reach"}
    assert set(Routing(pair.tree, bands[1:2]).joints) == {"grip", "spin", "slide", "nod"}
    routing = Routing(pair.tree, bands)
    assert list(routing.columns) == sorted(routing.columns)
    assert [pair.tree.joints[c] for c in routing.columns] == list(routing.joints)


def test_other_joints_may_be_anywhere(talos, suit):
    routing, q = Routing(talos, suit), postures(talos)
    elsewhere = postures(talos, seed=5)
    elsewhere[:, routing.columns] = q[:, routing.columns]
    np.testing.assert_array_equal(routing.geometry(q).jacobian, routing.geometry(elsewhere).jacobian)


@pytest.mark.slow
def test_a_band_on_one_body_has_one_length_and_acts_on_no_joint(pair, bands):
    still = Band(
        "still", "s", (ViaPoint("arm", (0, 0, 0)), ViaPoint("arm", (0.3, 0, 0)), ViaPoint("arm", (0.3, 0.4, 0)))
    )
    alone = Routing(pair.tree, [still]).geometry(postures(pair.tree, 4))
    np.testing.assert_allclose(alone.length, 0.7, atol=1e-15)
    assert alone.jacobian.shape == (4, 1, 0)
    beside = Routing(pair.tree, [still, *bands]).geometry(postures(pair.tree, 4))
    np.testing.assert_allclose(beside.length[:, 0], 0.7, atol=1e-15)
    assert not beside.jacobian[:, 0].any()


def test_a_segment_without_length_has_no_direction_and_no_nan(floating_pair):
    """Via points of trunk and leg both on the hip's axis, at its origin: one place in every posture."""
    way = (("trunk", (-0.2, 0.0, -0.3)), ("leg", (0.0, 0.0, 0.0)), ("shin", (0.0, 0.0, 0.0)))
    met = Band("met", "m", tuple(ViaPoint(link, xyz) for link, xyz in way))
    routing, q = Routing(floating_pair.tree, [met]), postures(floating_pair.tree)
    measured, whole = routing.geometry(q), Routing(floating_pair.tree, [replace(met, via_points=met.via_points[1:])])
    assert np.isfinite(measured.jacobian).all()
    assert np.abs(measured.length - whole.lengths(q)).max() < 1e-12
    hip = routing.joints.index("hip")
    assert np.abs(measured.jacobian[:, 0, hip]).max() < 1e-12
    segments = routing.segments(q, 0)
    assert np.isfinite(segments.jacobian).all()
    assert np.isfinite(segments.wrap).all()


def test_whole_bands_are_their_segments_over_chunks_and_tiles(talos, suit):
    routing, q = Routing(talos, suit), postures(talos, 8300)
    whole = routing.geometry(q)
    for w in range(len(suit)):
        segments = routing.segments(q, w)
        assert np.abs(segments.length.sum(axis=1) - whole.length[:, w]).max() < 1e-12
        assert np.abs(segments.jacobian.sum(axis=1) - whole.jacobian[:, w]).max() < 1e-12


@pytest.mark.parametrize("samples", [0, 1, 70])
def test_each_sample_stands_alone(talos, suit, samples):
    routing, q = Routing(talos, suit), postures(talos, 70)
    whole, part = routing.geometry(q), routing.geometry(q[:samples])
    assert part.length.shape == (samples, 4)
    assert part.jacobian.shape == (samples, 4, 8)
    np.testing.assert_allclose(part.jacobian, whole.jacobian[:samples], atol=1e-14)
    np.testing.assert_allclose(routing.lengths(q[::2])[: samples // 2], whole.length[::2][: samples // 2], atol=1e-14)


def test_segments_add_up_to_the_band(pair, bands):
    routing, q = Routing(pair.tree, bands), postures(pair.tree)
    whole = routing.geometry(q)
    for w in range(len(bands)):
        segments = routing.segments(q, w)
        assert np.abs(segments.length.sum(axis=1) - whole.length[:, w]).max() < 1e-12
        assert np.abs(segments.jacobian.sum(axis=1) - whole.jacobian[:, w]).max() < 1e-12


def test_wrap_is_by_how_much_the_band_turns(floating_pair):
    """A square corner on one body, none on a straight way, and about the hip what the hip turns."""
    tree = floating_pair.tree
    corner = Band("c", "c", tuple(ViaPoint("arm", xyz) for xyz in ((0, 0, 0), (0.1, 0, 0), (0.2, 0, 0), (0.2, 0, 0.3))))
    q = np.zeros((5, len(tree.joints)))
    np.testing.assert_allclose(Routing(tree, [corner]).segments(q, 0).wrap, [[0.0, np.pi / 2]] * 5, atol=1e-15)
    q[:, tree.joints.index("hip")] = angles = np.linspace(-1.0, 1.0, 5)
    turned = tree.T_before[tree.bodies.index("leg")].rotation @ np.array([0.0, 0.0, -1.0])
    above = np.array([-0.2, 0.0, -0.3]) - 0.1 * turned
    way = (ViaPoint("trunk", tuple(above)), ViaPoint("trunk", (-0.2, 0.0, -0.3)), ViaPoint("leg", (0.0, 0.0, -0.2)))
    wrap = Routing(tree, [Band("h", "h", way)]).segments(q, 0).wrap
    np.testing.assert_allclose(wrap[:, 0], np.abs(angles), atol=1e-12)


@pytest.mark.parametrize("degrees", [5.0, 89.0, 91.0, 135.0, 175.0])
def test_a_band_that_turns_back_wraps_by_more_than_a_right_angle(floating_pair, degrees):
    """A pulley that sends it back the way it came is 180 degrees, not none; a law of friction grows with it."""
    turn = np.radians(degrees)
    way = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1 + 0.3 * np.cos(turn), 0.0, 0.3 * np.sin(turn)))
    band = Band("back", "b", tuple(ViaPoint("arm", xyz) for xyz in way))
    wrap = Routing(floating_pair.tree, [band]).segments(np.zeros((2, len(floating_pair.tree.joints))), 0).wrap
    np.testing.assert_allclose(np.degrees(wrap), [[degrees]] * 2, atol=1e-9)


def test_unknown_links_and_short_bands_are_all_named(talos):
    bands = [
        Band("one", "a", (ViaPoint("torso_2_lnik", (0, 0, 0)), ViaPoint("base_link", (0, 0, 0)))),
        Band("two", "a", (ViaPoint("base_link", (0, 0, 0)),)),
    ]
    with pytest.raises(BadInput) as caught:
        Routing(talos, bands)
    assert [fault.rule for fault in caught.value.faults] == ["link_unknown", "band_too_short"]
    assert "'torso_2_link'" in caught.value.faults[0].advice
    assert "'two'" in caught.value.faults[1].detail
