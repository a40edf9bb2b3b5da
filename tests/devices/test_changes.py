"""Changes of a device: what they leave alone, and what is said where one cannot be made."""

from __future__ import annotations

from dataclasses import replace

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
    twin_of,
)
from exogauge.devices.changes import Change, Law, NaturalLength, Pretension, Stiffness, apply
from exogauge.devices.device import Band, BenchTest, Device, ViaPoint
from exogauge.errors import BadInput
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

LINK = (
    '<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
    "</inertial></link>"
)
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="waist"/><child link="{1}"/><origin xyz="{2}"/><axis xyz="0 1 0"/>'
    '<limit lower="-2" upper="2" effort="9" velocity="9"/></joint>'
)
JOINTS = (
    ("pitch", "chest", "0 0 0.1"),
    ("l_hip", "l_thigh", "0 0.09 0"),
    ("r_hip", "r_thigh", "0 -0.09 0"),
    ("l_arm", "l_hand", "0 0.2 0.3"),
    ("r_arm", "r_hand", "0 -0.2 0.25"),
    ("tail", "tail_left", "-0.1 0 0"),
)
TEST = BenchTest((0.5, 0.6), (0.0, 20.0))


@pytest.fixture(scope="module")
def tree() -> RigidTree:
    """Its hips are alike on both sides, its arms are not."""
    links = "".join(LINK.format(name) for name in ("waist", *(link for _, link, _ in JOINTS)))
    urdf = f"<robot name='r'>{links}{''.join(JOINT.format(*joint) for joint in JOINTS)}</robot>".encode()
    return load_tree(urdf, joints=tuple(name for name, *_ in JOINTS), base_link="waist", floating=True)


def band(name: str, group: str, side: float = 1.0) -> Band:
    points = (ViaPoint("chest", (-0.1, 0.1 * side, 0.2)), ViaPoint("waist", (-0.1, 0.1 * side, 0.0)))
    return Band(name, group, points, stiffness=200.0, natural_length=0.25, ground_truth=True, bench=TEST)


@pytest.fixture
def device() -> Device:
    return Device("suit", (band("A_left", "A"), band("A_right", "A", -1.0), band("B", "B", 0.5)), frozenset({"A"}))


def test_a_later_change_sees_what_an_earlier_one_did(tree, device):
    made = apply(device, [CopyBand("B", "C", group="C"), Stiffness("C", to=50.0), Stiffness("C", times=3.0)], tree)
    assert [(each.name, each.stiffness) for each in made.bands][2:] == [("B", 200.0), ("C", 150.0)]
    assert device.bands[2].stiffness == 200.0


def test_a_changed_value_is_no_longer_true_and_no_longer_tested(tree, device):
    for change in (Stiffness("B", to=1.0), NaturalLength("B", by=0.01), Pretension("B", 0.01), Law("B", "linear")):
        changed = apply(device, [change], tree).bands[2]
        assert (changed.ground_truth, changed.bench) == (False, None)
    for change in (MovePoint("B", 0, (0.0, 0.01, 0.0)), MirrorBand("B", "C"), CopyBand("B", "C")):
        changed = apply(device, [change], tree).bands[-1]
        assert (changed.ground_truth, changed.bench) == (True, TEST)


def test_a_band_that_leaves_its_groups_stiffness_is_a_group_of_its_own(tree, device):
    one = apply(device, [Stiffness("A_left", to=300.0)], tree)
    assert [each.group for each in one.bands] == ["A_left", "A", "B"]
    both = apply(device, [Stiffness("A", to=300.0)], tree)
    assert [each.group for each in both.bands] == ["A", "A", "B"]
    assert both.bands[0].stiffness == both.bands[1].stiffness == 300.0


def test_a_band_of_a_tied_group_that_gets_a_length_of_its_own_unties_it(tree, device):
    assert apply(device, [NaturalLength("A_left", times=0.9)], tree).tied == frozenset()
    assert apply(device, [NaturalLength("A", times=0.9)], tree).tied == {"A"}
    assert apply(device, [NaturalLength("B", to=0.3)], tree).tied == {"A"}
    assert apply(device, [RemoveBand("A")], tree).tied == frozenset()


def test_a_new_band_takes_the_stiffness_of_its_group(tree, device):
    new = replace(band("A_middle", "A", 0.0), stiffness=None)
    assert apply(device, [AddBand(new)], tree).bands[-1].stiffness == 200.0


def test_the_other_side_of_a_band_mirrored_twice_is_the_band(tree, device):
    points = (ViaPoint("chest", (-0.1, 0.05, 0.2)), ViaPoint("l_thigh", (-0.1, 0.02, -0.1)))
    thigh = replace(band("T", "T"), via_points=points)
    there = apply(device, [AddBand(thigh), MirrorBand("T", "T2"), MirrorBand("T2", "T3")], tree)
    second, third = there.bands[-2:]
    assert second.via_points[1].link == "r_thigh"
    assert second.via_points[1].xyz == pytest.approx((-0.1, -0.02, -0.1))
    for one, other in zip(third.via_points, points, strict=True):
        assert one.link == other.link
        assert one.xyz == pytest.approx(other.xyz)


@pytest.mark.parametrize(
    ("link", "twin"),
    [
        ("l_thigh", "r_thigh"),
        ("leg_right_3_link", "leg_left_3_link"),
        ("L_HIP_P_LINK", "R_HIP_P_LINK"),
        ("LeftFoot", "RightFoot"),
        ("thigh_r", "thigh_l"),
        ("pelvis", "pelvis"),
        ("torso_2_link", "torso_2_link"),
    ],
)
def test_the_twin_of_a_link_has_left_and_right_exchanged(link, twin):
    assert twin_of(link) == twin
    assert twin_of(twin) == link


FAULTS: list[tuple[Change, str, str, str]] = [
    (Stiffness("A_lef", to=1.0), "unknown_band", "of", "Did you mean 'A_left'?"),
    (Stiffness("nothing", to=1.0), "unknown_band", "of", "Known here: A, B, A_left, A_right"),
    (Stiffness("A", to=-3.0), "out_of_range", "to", "above 0"),
    (Stiffness("A", times=0.0), "out_of_range", "times", "above 0"),
    (Stiffness("A", to=float("nan")), "out_of_range", "to", "above 0"),
    (NaturalLength("B", to=0.0), "natural_length_impossible", "to", "would be 0 m"),
    (NaturalLength("B", by=-0.3), "natural_length_impossible", "by", "would be -0.05 m"),
    (Pretension("B", 0.9), "natural_length_impossible", "to", "would be -0.6"),
    (Law("B", "lineer"), "unknown_law", "law", "Did you mean 'linear'?"),
    (Law("B", "linear", {"x": 1.0}), "unknown_law_value", "values.x", "no parameter 'x'"),
    (MovePoint("A", 0, (0.0, 0.0, 0.1)), "unknown_band", "band", "Known here: A_left, A_right, B"),
    (MovePoint("B", 2, (0.0, 0.0, 0.1)), "unknown_via_point", "point", "has 2 via points, 0 to 1"),
    (MovePoint("B", 0, (0.0, 0.0, 1e9)), "too_far", "by", "metres"),
    (MovePoint("B", 0, (0.0, 0.0, float("inf"))), "too_far", "by", "metres"),
    (PlacePoint("B", 0, link="chst"), "unknown_link", "link", "Did you mean 'chest'"),
    (PlacePoint("B", 0, link="pitch"), "unknown_link", "link", "the link that it moves is 'chest'"),
    (PlacePoint("B", 0, link="waist"), "acts_on_no_joint", "link", "must cross a joint"),
    (InsertPoint("B", 5, "chest", (0.0, 0.0, 0.0)), "unknown_via_point", "at", "number 0 to 2"),
    (InsertPoint("B", 1, "chest", (-0.1, 0.05, 0.2)), "no_segment", "link", "via points 0 and 1"),
    (RemovePoint("B", 0), "number_of_points", "point", "2 to 50"),
    (RemoveBand("C"), "unknown_band", "of", "Known here"),
    (CopyBand("B", "A_left"), "duplicate_name", "name", "but not a name"),
    (AddBand(replace(band("C", "A"), stiffness=1.0)), "group_differs", "band.group", "a group of its own"),
    (
        AddBand(replace(band("C", "C"), natural_length=-1.0)),
        "natural_length_impossible",
        "band.natural_length",
        "above 0",
    ),
    (AddBand(replace(band("C", "C"), via_points=())), "number_of_points", "band.via_points", "2 to 50"),
]


@pytest.mark.parametrize(("change", "rule", "key", "said"), FAULTS)
def test_what_cannot_be_done_is_said_at_its_place_with_advice(tree, device, change, rule, key, said):
    with pytest.raises(BadInput) as refused:
        apply(device, [Stiffness("B", to=100.0), change], tree)
    fault = refused.value.faults[0]
    assert (fault.rule, fault.column) == (rule, f"changes.1.{key}")
    assert said in str(fault)


def test_a_change_is_named_where_the_user_wrote_it(tree, device):
    with pytest.raises(BadInput) as refused:
        apply(device, [Stiffness("C", to=1.0)], tree, place="settings.changes")
    assert refused.value.faults[0].column == "settings.changes.0.of"


def test_values_that_are_not_known_cannot_be_scaled(tree, device):
    bare = replace(device, bands=(replace(device.bands[0], stiffness=None, natural_length=None),))
    for change in (Stiffness("A", times=2.0), NaturalLength("A", by=0.1), NaturalLength("A", times=2.0)):
        with pytest.raises(BadInput, match="Set it `to` a value first"):
            apply(bare, [change], tree)
    assert apply(bare, [NaturalLength("A", to=0.4)], tree).bands[0].natural_length == 0.4


def test_a_side_that_is_not_alike_is_refused_unless_named(tree, device):
    points = (ViaPoint("l_hand", (0.0, 0.0, 0.1)), ViaPoint("waist", (0.0, 0.1, 0.0)))
    arm = AddBand(replace(band("arm", "arm"), via_points=points))
    with pytest.raises(BadInput, match=r"do not lie opposite each other at zero posture \(50 mm off\)"):
        apply(device, [arm, MirrorBand("arm", "arm_2")], tree)
    assert apply(device, [arm, MirrorBand("arm", "arm_2", links={"l_hand": "r_hand"})], tree)
    tail = AddBand(replace(band("tail", "tail"), via_points=(ViaPoint("tail_left", (0.0, 0.0, 0.1)), points[1])))
    with pytest.raises(BadInput, match="'tail_left' has no twin"):
        apply(device, [tail, MirrorBand("tail", "tail_2")], tree)


def test_a_name_of_a_band_and_of_another_group_is_ambiguous(tree, device):
    odd = replace(device, bands=(replace(device.bands[0], name="B", group="A"), device.bands[2]))
    odd = replace(odd, bands=(odd.bands[0], replace(odd.bands[1], name="C")))
    with pytest.raises(BadInput, match="the name of a band and of a group"):
        apply(odd, [Stiffness("B", to=1.0)], tree)
