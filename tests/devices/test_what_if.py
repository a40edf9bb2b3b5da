"""What another device would do over the same motion: what must follow from what a wire is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.devices.band_changes import (
    AddBand,
    CopyBand,
    InsertPoint,
    MirrorBand,
    MovePoint,
    PlacePoint,
    RemoveBand,
    RemovePoint,
)
from exogauge.devices.bench import Bench, wire_bytes
from exogauge.devices.changes import Law, NaturalLength, Pretension, Stiffness, apply
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.devices.what_if import compare, what_if
from exogauge.effects.band_laws import all_laws
from exogauge.errors import BadInput
from exogauge.remarks import About, Remark
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

LINK = (
    '<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
    "</inertial></link>"
)
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="{3}"/><axis xyz="{4}"/>'
    '<limit lower="-2" upper="2" effort="9" velocity="9"/></joint>'
)
LINKS = ("waist", "spine", "chest", "l_hip", "l_thigh", "r_hip", "r_thigh")
JOINTS = {
    "yaw": ("waist", "spine", "0 0 0.1", "0 0 1"),
    "pitch": ("spine", "chest", "0 0 0.05", "0 1 0"),
    "l_hip_roll": ("waist", "l_hip", "0 0.09 -0.05", "1 0 0"),
    "l_hip_pitch": ("l_hip", "l_thigh", "0 0 -0.02", "0 1 0"),
    "r_hip_roll": ("waist", "r_hip", "0 -0.09 -0.05", "1 0 0"),
    "r_hip_pitch": ("r_hip", "r_thigh", "0 0 -0.02", "0 1 0"),
}
MIRRORED_Q = {"yaw": ("yaw", -1), "pitch": ("pitch", 1)} | {
    f"{side}_hip_{axis}": (f"{other}_hip_{axis}", sign)
    for side, other in ("lr", "rl")
    for axis, sign in (("roll", -1), ("pitch", 1))
}
POINTS = (
    ViaPoint("chest", (-0.08, 0.1, 0.3)),
    ViaPoint("chest", (-0.11, 0.08, 0.1)),
    ViaPoint("waist", (-0.12, 0.07, 0.0)),
    ViaPoint("l_thigh", (-0.09, 0.02, -0.2)),
)
LEFT = Band("A_left", "A", POINTS, stiffness=200.0, natural_length=0.5)
T = 300


@pytest.fixture(scope="module")
def tree() -> RigidTree:
    """A trunk on two legs, alike on both sides."""
    parts = [LINK.format(name) for name in LINKS] + [JOINT.format(name, *rest) for name, rest in JOINTS.items()]
    urdf = f"<robot name='trunk'>{''.join(parts)}</robot>".encode()
    return load_tree(urdf, joints=tuple(JOINTS), base_link="waist", floating=True)


@pytest.fixture(scope="module")
def device(tree: RigidTree) -> Device:
    """Two bands over the back and one across it."""
    across = (ViaPoint("chest", (-0.1, 0.15, 0.2)), ViaPoint("waist", (-0.1, -0.12, 0.0)))
    alone = Device("suit", (LEFT, Band("B", "B", across, stiffness=300.0, natural_length=0.35)))
    return apply(alone, [MirrorBand("A_left", "A_right")], tree)


@pytest.fixture(scope="module")
def time() -> np.ndarray:
    return np.arange(T) / 100.0


@pytest.fixture(scope="module")
def q(time: np.ndarray) -> np.ndarray:
    return np.column_stack([0.5 * np.sin((1 + 0.3 * k) * time + k) for k in range(len(JOINTS))])


@pytest.fixture(scope="module")
def bench(tree: RigidTree, device: Device, q: np.ndarray, time: np.ndarray) -> Bench:
    return Bench(tree, device, q, time)


def torques(loads) -> dict[str, np.ndarray]:
    return {joint.joint: joint.after.torque for joint in loads.joints}


def test_the_torque_is_that_of_the_band_model(bench, tree, device, q, time):
    found = compare(bench, device)
    routing = Routing(tree, device.bands)
    expected = band_torque(routing, device.bands, q, time)
    assert tuple(joint.joint for joint in found.joints) == routing.joints
    for k, joint in enumerate(found.joints):
        np.testing.assert_allclose(joint.before.torque, expected.torque[:, k], atol=1e-12)
        np.testing.assert_array_equal(joint.after.torque, joint.before.torque)
        assert set(joint.percent.values()) <= {0.0, None}
    for k, band in enumerate(found.bands):
        np.testing.assert_allclose(band.after.tension, expected.tension[:, k], atol=1e-9)


@pytest.mark.parametrize("name", sorted(all_laws()))
def test_every_law_pulls_on_the_bench_as_in_the_band_model(tree, q, time, name):
    law = all_laws()[name]
    values = {quantity.name: quantity.stated.typical for quantity in law.values}
    band = replace(LEFT, law=name, law_values=values)
    expected = band_torque(Routing(tree, [band]), [band], q, time)
    pull = Bench(tree, Device("one", (band,)), q, time).pull(band)
    np.testing.assert_allclose(pull.torque.T, expected.torque, atol=1e-9)
    np.testing.assert_allclose(pull.tension, expected.tension[:, 0], atol=1e-9)


def test_twice_the_stiffness_is_twice_the_torque_on_every_joint(bench, tree, device):
    found = compare(bench, apply(device, [Stiffness("*", times=2.0)], tree))
    for joint in found.joints:
        np.testing.assert_allclose(joint.after.torque, 2.0 * joint.before.torque, rtol=1e-12, atol=1e-12)
        assert list(joint.percent.values()) == pytest.approx([100.0] * 5)
    shares = [(each.before, each.after) for each in found.interference]
    np.testing.assert_allclose([before for before, _ in shares], [after for _, after in shares])


def test_without_bands_nothing_pulls(bench, tree, device):
    found = compare(bench, apply(device, [RemoveBand("*")], tree))
    assert len(found.joints) == 6
    for joint in found.joints:
        assert not joint.after.torque.any()
        assert list(joint.percent.values()) == pytest.approx([-100.0] * 5)
    assert {each.after for each in found.interference} == {None}
    assert {band.after for band in found.bands} == {None}


def test_a_mirrored_band_mirrors_the_torque(tree, q, time):
    left = Device("left", (LEFT,))
    right = apply(left, [MirrorBand("A_left", "A_right"), RemoveBand("A_left")], tree)
    mirror = [MIRRORED_Q[name] for name in JOINTS]
    order, sign = [list(JOINTS).index(name) for name, _ in mirror], np.array([sign for _, sign in mirror])
    turned = q[:, order] * sign
    one, other = torques(what_if(tree, left, left, q, time)), torques(what_if(tree, right, right, turned, time))
    for name, torque in one.items():
        twin, factor = MIRRORED_Q[name]
        np.testing.assert_allclose(other[twin], factor * torque, atol=1e-12)


def test_two_copies_pull_as_one_band_of_twice_the_stiffness(bench, tree, device):
    copied = compare(bench, apply(device, [CopyBand("A_left", "extra")], tree))
    stiffer = compare(bench, apply(device, [Stiffness("A_left", times=2.0)], tree))
    for name, torque in torques(copied).items():
        np.testing.assert_allclose(torque, torques(stiffer)[name], atol=1e-12)


def test_a_moved_point_pulls_as_a_device_made_with_it_there(bench, tree, device, q, time):
    moved = apply(device, [MovePoint("A_left", 2, (0.0, 0.0, 0.03))], tree)
    points = (*POINTS[:2], ViaPoint("waist", (-0.12, 0.07, 0.03)), POINTS[3])
    made = replace(device, bands=(replace(LEFT, via_points=points), *device.bands[1:]))
    assert moved == made
    expected = band_torque(Routing(tree, made.bands), made.bands, q, time).torque
    for k, torque in enumerate(torques(compare(bench, moved)).values()):
        np.testing.assert_allclose(torque, expected[:, k], atol=1e-12)


def test_pretension_is_the_stretch_with_all_joints_at_zero(tree, device):
    zero, at = np.zeros((1, 6)), np.zeros(1)
    for stretch in (0.02, -0.01):
        taut = apply(device, [Pretension("A", to=stretch)], tree)
        found = what_if(tree, taut, taut, zero, at)
        for band in found.bands[:3:2]:
            assert band.after.tension_max == pytest.approx(200.0 * max(stretch, 0.0), abs=1e-9)


def test_the_bench_answers_as_a_fresh_computation_whatever_was_asked_before(bench, tree, device, q, time):
    rng = np.random.default_rng(5)
    for _ in range(20):
        changes = [
            MovePoint("A_left", int(rng.integers(4)), tuple(0.02 * rng.normal(size=3))),
            NaturalLength("B", by=float(0.02 * rng.normal())),
            Stiffness("A", to=float(rng.uniform(50, 500))),
        ]
        changed = apply(device, [changes[k] for k in rng.permutation(3)], tree)
        fresh = what_if(tree, device, changed, q, time)
        for one, other in zip(compare(bench, changed).joints, fresh.joints, strict=True):
            np.testing.assert_array_equal(one.after.torque, other.after.torque)
            assert one.percent == other.percent


def test_other_values_of_a_band_measure_no_routing_anew(tree, device, q, time):
    bench = Bench(tree, device, q, time)
    measured = dict(bench._wires)
    changes = [Stiffness("A", times=2.0), NaturalLength("B", by=0.01), Pretension("A", 0.02), CopyBand("B", "C")]
    compare(bench, apply(device, changes, tree))
    assert dict(bench._wires) == measured
    compare(bench, apply(device, [MovePoint("A_left", 1, (0.0, 0.0, 0.01))], tree))
    assert len(bench._wires) == len(measured) + 1


def test_a_long_session_does_not_fill_the_memory(tree, device, q, time):
    one = Bench(tree, device, q, time).wire(LEFT)
    assert wire_bytes(tree, LEFT, T) == one.slopes.nbytes
    bench = Bench(tree, device, q, time, kept_bytes=3 * one.nbytes)
    own = bench.nbytes
    for k in range(1, 30):
        bench.pull(apply(device, [MovePoint("A_left", 1, (0.0, 0.0, 0.001 * k))], tree).bands[0])
        assert sum(wire.nbytes for wire in bench._wires.values()) <= own
    assert bench.nbytes == own


def test_sizes_are_those_of_a_known_torque(tree, device, q, time):
    """Mean, rms, integral and work of a torque against closed forms, with a clock that is not even."""
    ticks = np.sort(np.concatenate([time, time[:-1] + 0.003]))
    ramp = np.zeros((len(ticks), 6))
    ramp[:, 1] = 0.2 + 0.1 * ticks
    found = what_if(tree, device, device, ramp, ticks, main=["pitch"])
    pitch = next(joint for joint in found.joints if joint.joint == "pitch").before
    assert pitch.mean == pytest.approx(pitch.integral / (ticks[-1] - ticks[0]))
    assert pitch.work == pytest.approx(0.1 * pitch.integral)
    assert pitch.peak == pitch.torque[np.argmax(np.abs(pitch.torque))]
    assert abs(pitch.mean) < pitch.rms < abs(pitch.peak)


def test_work_over_a_closed_motion_is_zero(tree, device, time):
    closed = np.outer(np.sin(2 * np.pi * np.linspace(0, 1, 4001)), np.linspace(0.2, 0.5, 6))
    found = what_if(tree, device, device, closed, np.linspace(0, 3, 4001))
    for joint in found.joints:
        assert joint.before.work == pytest.approx(0.0, abs=1e-4 * abs(joint.before.peak))


def test_bending_forward_is_supported_and_the_rest_is_interference(bench, device):
    found = compare(bench, device)
    sizes = {joint.joint: joint.before.rms for joint in found.joints}
    assert found.main == (max(sizes, key=sizes.__getitem__),)
    assert {each.joint for each in found.interference} == set(sizes) - set(found.main)
    for each in found.interference:
        assert each.before == pytest.approx(sizes[each.joint] / sizes[found.main[0]])
    both = compare(bench, device, main=("pitch", "yaw"))
    whole = np.hypot(sizes["pitch"], sizes["yaw"])
    assert {each.joint: each.before for each in both.interference} == pytest.approx(
        {name: size / whole for name, size in sizes.items() if name not in ("pitch", "yaw")}
    )


def test_a_band_says_how_far_it_is_stretched_and_how_long_it_hangs_slack(bench, tree, device, q):
    length = Routing(tree, [LEFT]).lengths(q)[:, 0]
    middle = float(np.median(length))
    found = compare(bench, apply(device, [NaturalLength("A_left", to=middle)], tree))
    load = next(band for band in found.bands if band.band == "A_left").after
    assert load.slack_share == pytest.approx(0.5, abs=0.01)
    assert load.tension_max == pytest.approx(200.0 * (length.max() - middle))
    assert (load.length_min, load.length_max) == pytest.approx((length.min(), length.max()))
    assert load.stretch_max == pytest.approx(length.max() / middle - 1.0)
    hanging = compare(bench, apply(device, [NaturalLength("A_left", to=2.0)], tree))
    assert Remark(About.SLACK, ("A_left",)) in hanging.notes


def test_unknown_values_are_asked_for_after_and_left_out_before(tree, device, q, time):
    unknown = replace(device, bands=(*device.bands[:-1], replace(device.bands[-1], stiffness=None)))
    with pytest.raises(BadInput) as refused:
        what_if(tree, unknown, unknown, q, time)
    (fault,) = refused.value.faults
    assert (fault.rule, fault.column) == ("value_missing", "A_right.stiffness")
    found = what_if(tree, unknown, apply(unknown, [Stiffness("A", to=100.0)], tree), q, time)
    assert "A_right" in found.notes[0].names
    assert next(band for band in found.bands if band.band == "A_right").before is None


def test_a_main_joint_that_the_robot_lacks_is_refused(bench, device):
    with pytest.raises(BadInput, match="Did you mean 'pitch'"):
        compare(bench, device, main=("pich",))


def test_points_come_and_go_and_change_their_link(tree, device):
    straight = apply(device, [RemovePoint("A_left", 1)], tree)
    assert [point.link for point in straight.bands[0].via_points] == ["chest", "waist", "l_thigh"]
    assert apply(straight, [InsertPoint("A_left", 1, "chest", (-0.11, 0.08, 0.1))], tree) == device
    placed = apply(device, [PlacePoint("A_left", 2, link="spine")], tree).bands[0].via_points[2]
    assert placed == ViaPoint("spine", POINTS[2].xyz)


def test_laws_are_exchanged(tree, device):
    assert apply(device, [Law("A", "linear")], tree).bands[0].law == "linear"
    assert apply(device, [AddBand(replace(LEFT, name="C", group="C"))], tree).bands[-1].name == "C"
