"""A stranger's URDF is refused by name and rule before a C++ parser sees it."""

from __future__ import annotations

import sysconfig
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from exogauge.criteria.examining import Examining
from exogauge.errors import BadRobot
from exogauge.remarks import About
from exogauge.robots.urdf import load_tree, load_whole, model_text
from exogauge.robots.urdf_check import (
    INERTIA_NAMES,
    check_urdf,
    idle_joints,
    impossible_density,
    limits_in_degrees,
    masses_alike,
    raised_inertias,
    read_urdf,
)

ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"

INERTIA = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'


def _link(name: str, mass: str = "1", inertia: str = INERTIA, more: str = "") -> str:
    return f'<link name="{name}"><inertial><mass value="{mass}"/>{inertia}</inertial>{more}</link>'


def _joint(name: str, parent: str, child: str, kind: str = "revolute", more: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>'


def _robot(*parts: str) -> bytes:
    return f'<robot name="r">{"".join(parts)}</robot>'.encode()


def _chain(length: int) -> bytes:
    links = [_link(f"l{i}") for i in range(length)]
    return _robot(*links, *(_joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(length - 1)))


def _spread(xx: float, yy: float, zz: float) -> str:
    return f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/>'


TWO = (_link("a"), _link("b"), _joint("j", "a", "b"))
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
BAD = {
    "not_xml": b"PK\x03\x04 not xml",
    "xml_doctype": b'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r"><link name="a"/></robot>',
    "urdf_too_large": b" " * 20_000_001,
    "not_urdf": b"<sdf/>",
    "no_links": b"<robot/>",
    "too_many_links": _chain(4000),
    "tree_too_deep": _chain(300),
    "link_name_twice": _robot(_link("a"), _link("a")),
    "link_without_name": _robot(_link("a"), _link("")),
    "joint_name_twice": _robot(*TWO, _link("c"), _joint("j", "a", "c")),
    "joint_parent_unknown": _robot(_link("a"), _joint("j", "x", "a")),
    "joint_child_unknown": _robot(_link("a"), _joint("j", "a", "x")),
    "joint_type": _robot(_link("a"), _link("b"), _joint("j", "a", "b", "screw")),
    "joint_axis_zero": _robot(_link("a"), _link("b"), _joint("j", "a", "b", more='<axis xyz="0 0 0"/>')),
    "link_two_parents": _robot(*TWO, _link("c"), _joint("k", "a", "c"), _joint("l", "b", "c")),
    "two_roots": _robot(*TWO, _link("c")),
    "loop": _robot(*TWO, _link("c"), _link("d"), _joint("k", "c", "d"), _joint("l", "d", "c")),
    "mass_not_positive": _robot(_link("a", mass="-1")),
    "not_a_number": _robot(_link("a", mass="nan")),
    "number_missing": _robot(_link("a", inertia='<inertia ixx="1"/>')),
    "inertia_not_positive": _robot(_link("a", inertia=_spread(0.1, 0.1, -0.01))),
    "inertia_triangle": _robot(_link("a", inertia=_spread(0.1, 0.1, 0.3))),
    "mesh_outside": _robot(_link("a", more=MESH.format("package://r/../../etc/passwd"))),
}


@pytest.mark.parametrize("rule", BAD)
def test_each_broken_rule_is_named(rule):
    with pytest.raises(BadRobot) as caught:
        check_urdf(BAD[rule], "arm.urdf")
    assert rule in {fault.rule for fault in caught.value.faults}
    assert all(fault.file == "arm.urdf" for fault in caught.value.faults)


@pytest.mark.parametrize("path", ["http://x.org/x.stl", "ftp://x.org/x.stl", "package://r/../../x.stl"])
def test_a_mesh_outside_the_bundle_is_refused(path):
    with pytest.raises(BadRobot, match="outside the bundle"):
        check_urdf(_robot(_link("a", more=MESH.format(path))))


@pytest.mark.parametrize("path", ["../meshes/a.stl", "..\\a.stl", "../../../etc/a.stl", "meshes/../a.stl", "/a.stl",
                                  "file:///opt/ros/share/r/meshes/a.stl", "C:\\a.stl", "C:/a.stl"])  # fmt: skip
def test_a_mesh_by_a_path_upwards_or_of_another_machine_is_taken_as_one_that_may_be_missing(path):
    """24 of 247 stock URDFs name theirs upwards (Vega, Robotiq), xacro writes `file://$(find …)`; none was taken."""
    check_urdf(_robot(_link("a", more=MESH.format(path))))


@pytest.mark.parametrize(
    "moments", [(3.5e-8, 9.1e-8, -3.5e-8), (0.0, 0.0, 3e-6), (1e-20, -1e-20, 0.0), (0.1, 0.2, 0.3 + 5e-6)]
)
def test_an_inertia_that_misses_a_body_by_little_is_raised_to_the_nearest_and_told(moments):
    urdf = _robot(_link("a"), _link("antenna", inertia=_spread(*moments)), _joint("j", "a", "antenna"))
    tree = load_tree(urdf, joints=("j",), base_link="a", floating=False)
    found = np.sort(tree.phi[0][[4, 6, 9]])
    assert found[0] + found[1] >= found[2] * (1 - 1e-9)
    assert np.all(found >= 0.0)
    assert np.max(np.abs(found - np.sort(moments))) <= 1e-5
    told = raised_inertias(urdf, "arm.urdf")
    assert len(told) == (max(np.abs(moments)) > 1e-12)
    assert all((each.names, each.beside) == (("antenna",), ("arm.urdf", "antenna")) for each in told)


def _in_other_units(urdf: bytes, mass: float, inertia: float) -> bytes:
    robot = ElementTree.fromstring(urdf)
    for each in robot.iter("mass"):
        each.set("value", repr(mass * float(each.get("value"))))
    for each in robot.iter("inertia"):
        for name in INERTIA_NAMES:
            each.set(name, repr(inertia * float(each.get(name))))
    return ElementTree.tostring(robot)


STOCK = sorted(path for path in ROBOTS.rglob("*.urdf") if "<mass" in path.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.skipif(not STOCK, reason="no URDFs of example-robot-data are installed")
def test_units_that_are_not_si_are_told_of_every_stock_robot_and_of_none_as_it_is():
    """Masses in g with inertias in g·m², inertias in kg·mm², both as CAD programs write them (g, g·mm²)."""
    assert len(STOCK) > 40
    told = lambda urdf: [each.about for each in impossible_density(urdf, "robot.urdf", Examining())]  # noqa: E731
    for path in STOCK:
        urdf = path.read_bytes()
        assert told(urdf) == [], path.name
        assert told(_in_other_units(urdf, 1e3, 1e3)) == [About.TOO_DENSE], path.name
        assert told(_in_other_units(urdf, 1.0, 1e6)) == [About.TOO_LIGHT], path.name
        assert told(_in_other_units(urdf, 1e3, 1e9)) == [About.TOO_LIGHT], path.name


def test_what_is_told_of_units_has_the_mass_and_how_dense_it_would_be():
    """A ball of lead of 0.1 m, 47.5 kg, in grams; and links without an inertia or a mass beside."""
    mass = 4.0 / 3.0 * np.pi * 0.1**3 * 11_340.0 * 1e3
    ball = _link("ball", repr(mass), _spread(*(3 * [0.4 * mass * 0.1**2])))
    (remark,) = impossible_density(
        _robot(ball, '<link name="tool"/>', _joint("j", "ball", "tool")), "a.urdf", Examining()
    )
    assert (remark.about, remark.beside) == (About.TOO_DENSE, ("a.urdf",))
    np.testing.assert_allclose(remark.numbers, (mass, 11_340.0 * 1e3))
    assert impossible_density(_robot('<link name="tool"/>'), "a.urdf", Examining()) == ()


def test_an_inertia_far_from_any_body_is_refused_whatever_stands_beside_it():
    near, far = _link("near", inertia=_spread(0, 0, 3e-6)), _link("far", inertia=_spread(0.1, 0.1, 0.3))
    with pytest.raises(BadRobot) as caught:
        check_urdf(_robot(near, far, _joint("j", "near", "far")))
    assert [fault.detail.split("'")[1] for fault in caught.value.faults] == ["far"]


@pytest.mark.parametrize(
    ("file", "joints"),
    [
        ("tiago_description/robots/tiago.urdf", ("arm_1_joint", "arm_2_joint")),
        ("icub_description/robots/icub.urdf", ("l_knee", "l_elbow")),
        ("go1_description/urdf/go1.urdf", ("FL_hip_joint",)),
    ],
)
def test_stock_robots_with_such_inertias_are_read(file, joints):
    path = ROBOTS / file
    if not path.is_file():
        pytest.skip(f"example-robot-data has no {file}")
    urdf = path.read_bytes()
    children = {child.get("link") for joint in read_urdf(urdf).findall("joint") for child in joint.findall("child")}
    root = next(name for link in read_urdf(urdf).findall("link") if (name := link.get("name")) not in children)
    assert load_tree(urdf, joints=joints, base_link=root, floating=True).mass > 0.0


def test_a_prefix_that_nobody_declares_is_read_over():
    """As simulators write into published robots; readers of URDF know no namespaces."""
    urdf = _robot(_link("arm")).replace(b"<robot ", b'<robot drake:declare="1" ', 1)
    urdf = urdf.replace(b"</robot>", b"<gazebo:plugin file='x'><sdf:a/></gazebo:plugin></robot>")
    assert read_urdf(urdf).find("link").get("name") == "arm"


def test_the_heavy_moment_is_told_with_its_link_value_and_advice():
    with pytest.raises(BadRobot) as caught:
        check_urdf(_robot(_link("thigh", inertia=_spread(0.1, 0.1, 0.3))))
    (fault,) = caught.value.faults
    assert "thigh" in fault.detail
    assert "0.3" in fault.value
    assert fault.advice


def test_a_link_without_inertia_and_one_of_zeros_are_fine():
    """Fingers of zeros were refused until their <inertial> was deleted, of Romeo by hand, 24 times."""
    frame, finger = (_link(name, mass="0", inertia=_spread(0, 0, 0)) for name in "fg")
    mesh = MESH.format("package://r/meshes/a.stl")
    check_urdf(_robot(*TWO, '<link name="c"/>', frame, finger, _joint("k", "b", "c"), _joint("m", "c", "g"),
                      _joint("l", "b", "f", "fixed", mesh)))  # fmt: skip


def test_a_flat_plate_rounded_to_seven_digits_is_accepted():
    check_urdf(_robot(_link("a", inertia=_spread(0.1, 0.2, 0.3000001))))


def test_the_inertia_that_is_advised_in_place_of_an_impossible_one_is_accepted():
    """A stock robot's upper arm (Romeo): its i_zz is a tenth of what the others ask for."""
    stock = (
        'ixx="0.000742356" ixy="0.000617202" ixz="5.98521e-06" iyy="0.00649989" iyz="-1.07417e-06" izz="0.000664209"'
    )
    with pytest.raises(BadRobot) as caught:
        check_urdf(_robot(_link("a", inertia=f"<inertia {stock}/>")))
    (fault,) = caught.value.faults
    advised = fault.advice.partition("of a body: ")[2]
    assert advised.count("=") == 6
    check_urdf(_robot(_link("a", inertia=f"<inertia {advised}/>")))


LFS = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"
GOOD = _robot(*TWO)
XACRO = b'<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro">'


@pytest.mark.parametrize(
    ("urdf", "said"),
    [
        (b"", "It is empty"),
        (b"\n<?xml version='1.0'?>" + GOOD, "Remove what stands before"),
        (b"<!-- mine -->\n<?xml version='1.0'?>" + GOOD, "Remove what stands before"),
        (GOOD.replace(b"</robot>", "\n<!-- Größe --></robot>".encode("latin-1")), "Line 2 is not UTF-8"),
        (GOOD.replace(b"</robot>", b"<gazebo a='b & c'/></robot>"), "&amp;"),
        (b"PK\x03\x04", "not an archive"),
        (LFS, "git lfs pull"),
        (b"<!DOCTYPE html>\n<html></html>", "is a web page"),
        (GOOD.replace(b'"r">', b'"r"><xacro:arm name="left"/>'), "holds <xacro:arm>"),
        (GOOD.replace(b'<robot name="r">', XACRO + b'<xacro:include filename="a"/>'), "holds <xacro:include>"),
        (_robot(_link("${side}_a")), "expand it first|Expand it first"),
        (_robot(_link("a", mass="0,5")), "a decimal point"),
        (_robot(*TWO[:2], _joint("j", "a", "b", more='<origin xyz="0, 0, 1"/>')), "blanks between numbers"),
        (_robot(_link("a", mass="0")), "of a frame that weighs nothing take"),
        (_robot(_link("a", inertia="")), "<inertia> lacks ixx. Give it"),
        (_robot(*TWO[:2], _joint("universe", "a", "b")), "Rename it"),
    ],
)
def test_what_is_wrong_with_the_file_and_what_to_do_is_said(urdf: bytes, said: str) -> None:
    """Each is a form in which files of others come; advice was that of a xacro for all of them, or none."""
    with pytest.raises(BadRobot, match=said):
        check_urdf(urdf)


@pytest.mark.parametrize("left", [b"<xacro:property name='a' value='1'/>", b"<xacro:macro name='m'/>"])
def test_what_makes_no_link_of_itself_may_be_left_of_a_xacro(left: bytes) -> None:
    check_urdf(GOOD.replace(b'<robot name="r">', XACRO + left))


def test_a_number_is_named_by_its_tag_once() -> None:
    with pytest.raises(BadRobot, match="link 'a': <mass> value is not a finite number"):
        check_urdf(_robot(_link("a", mass="nan")))


def test_joints_that_move_no_mass_are_told_and_a_robot_of_none_else_is_refused() -> None:
    """One without any <inertial> ended the identification with a traceback."""
    links = ['<link name="a"/>', _link("b"), '<link name="c"/>', '<link name="d"/>']
    joints = [_joint("j", "a", "b"), _joint("k", "b", "c"), _joint("l", "c", "d")]
    (remark,) = idle_joints(load_whole(_robot(*links, *joints)), "a.urdf")
    assert (remark.about, remark.names) == (About.MOVES_NOTHING, ("k", "l"))
    assert idle_joints(load_whole(_robot(*links[:2], _link("c"), _link("d"), *joints)), "a.urdf") == ()
    assert idle_joints(load_whole(_robot(links[0], links[2], _link("b"), _joint("j", "a", "c"), _joint("k", "c", "b"))),
                       "a.urdf") == ()  # fmt: skip
    with pytest.raises(BadRobot, match="has a mass"):
        idle_joints(load_whole(_robot(links[0], links[2], _joint("j", "a", "c"))), "a.urdf")


def test_masses_without_inertia_are_not_called_too_dense() -> None:
    points = _robot(*(_link(name, inertia=_spread(0, 0, 0)) for name in "ab"), _joint("j", "a", "b"))
    (remark,) = impossible_density(points, "a.urdf", Examining())
    assert (remark.about, remark.numbers) == (About.NO_EXTENT, (2.0,))


def test_masses_that_are_all_alike_are_told_as_placeholders() -> None:
    """Silent before: a URDF whose masses are all 1. Two links may weigh the same."""
    joints = [_joint("j", "a", "b"), _joint("k", "b", "c")]
    (remark,) = masses_alike(_robot(*(_link(name) for name in "abc"), *joints), "a.urdf")
    assert (remark.about, remark.numbers) == (About.MASSES_ALIKE, (1.0, 3))
    assert masses_alike(_robot(_link("a"), _link("b"), _link("c", "1.1"), *joints), "a.urdf") == ()
    assert masses_alike(_robot(_link("a"), _link("b"), joints[0]), "a.urdf") == ()


@pytest.mark.slow
@pytest.mark.skipif(not STOCK, reason="no URDFs of example-robot-data are installed")
def test_no_stock_robot_has_masses_that_are_all_alike() -> None:
    assert [path.name for path in STOCK if masses_alike(path.read_bytes(), path.name)] == []


NAMED = "<?xml version='1.0' encoding='{}'?>"
ROUGH = {
    "no limit": _robot(*TWO),
    "an empty limit": _robot(*TWO[:2], _joint("j", "a", "b", more="<limit/>")),
    "no effort": _robot(*TWO[:2], _joint("j", "a", "b", more='<limit lower="-1" upper="1" velocity="1"/>')),
    "upside down": _robot(
        *TWO[:2], _joint("j", "a", "b", more='<limit lower="1" upper="-1" effort="1" velocity="1"/>')
    ),
    "a mimic of nothing": _robot(*TWO, _link("c"), _joint("k", "b", "c", more="<mimic/>")),
    "damping that is no number": _robot(*TWO[:2], _joint("j", "a", "b", more='<dynamics damping="x"/>')),
    "calibration": _robot(*TWO[:2], _joint("j", "a", "b", more='<calibration rising="x"/>')),
    "a colour of two numbers": _robot(*TWO, '<material name="m"><color rgba="1 0"/></material><material name="m"/>'),
    "no name": _robot(*TWO).replace(b' name="r"', b""),
    "an undeclared prefix": _robot(*TWO, "<drake:x/>"),
    "UTF-16": (NAMED.format("UTF-16") + _robot(*TWO).decode()).encode("utf-16"),
    "Latin-1": (NAMED.format("ISO-8859-1") + _robot(*TWO).decode() + "<!-- Größe -->").encode("latin-1"),
    "a joint called as its link": _robot(*TWO[:2], _joint("a", "a", "b")),
}


@pytest.mark.parametrize("kind", ROUGH)
def test_what_the_check_lets_pass_pinocchio_reads(kind: str) -> None:
    """Its own reader of URDF raises on all but the last."""
    model = pin.buildModelFromXML(model_text(ROUGH[kind]))
    assert [model.nq, model.nv] == [1, 1]
    assert model.lowerPositionLimit[0] < 0.0 < model.upperPositionLimit[0]


def test_limits_in_degrees_are_told_and_turns_of_makers_are_not() -> None:
    def told(*ends: float) -> list[About]:
        links = [_link(f"l{k}") for k in range(len(ends) + 1)]
        joints = [_joint(f"j{k}", f"l{k}", f"l{k + 1}", more=f'<limit lower="{-end}" upper="{end}"/>')
                  for k, end in enumerate(ends)]  # fmt: skip
        return [each.about for each in limits_in_degrees(_robot(*links, *joints), "a.urdf", Examining())]

    assert told(170.0, 45.0, 0.0) == [About.LIMITS_IN_DEGREES]
    assert told(20.0, 25.0, 30.0) == [About.LIMITS_IN_DEGREES]
    assert told(6.28, 10.0, 12.6) == told(1e16, 1e16) == told(2.9, 360.0, 1.8) == told() == []


@pytest.mark.parametrize("path", sorted(ROBOTS.glob("*/*/*.urdf")), ids=lambda path: path.stem)
def test_no_maker_is_told_of_degrees_but_after_conversion(path: Path) -> None:
    try:
        robot = read_urdf(path.read_bytes())
    except BadRobot:
        pytest.skip("refused for something else")
    assert limits_in_degrees(path.read_bytes(), path.name, Examining()) == ()
    turning = [each for each in robot.findall("joint[@type='revolute']/limit") if "upper" in each.attrib]
    for limit in turning:
        limit.attrib |= {key: str(np.degrees(float(limit.get(key, "0")))) for key in ("lower", "upper")}
    plain = [each for each in turning if float(each.get("lower", "0")) < float(each.get("upper", "0")) < 1e3]
    if plain:
        assert limits_in_degrees(ElementTree.tostring(robot), path.name, Examining())
