from __future__ import annotations

import re
from collections.abc import Callable
from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest

from exogauge.errors import PhysicallyImpossible
from exogauge.robots.consistency import from_log_cholesky, is_physical, nearest_possible, to_log_cholesky
from exogauge.robots.export import export_urdf
from exogauge.robots.urdf import load_tree

Read = Callable[[str], bytes]

BODY = (
    '<inertial><origin xyz="0.1 0 0.05"/><mass value="2"/>'
    '<inertia ixx="0.3" ixy="0.01" ixz="0" iyy="0.25" iyz="0" izz="0.2"/></inertial>'
)
ARM = (
    f'<link name="trunk">{BODY}</link><link name="arm">{{arm}}</link><link name="tip">{{tip}}</link>'
    '<joint name="turn" type="continuous"><parent link="trunk"/><child link="arm"/><axis xyz="0 0 1"/></joint>'
    '<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="0 0.2 0.4"/></joint>'
)


def identified(phi: np.ndarray, seed: int = 0) -> np.ndarray:
    """Another possible robot; massless bodies stay so."""
    rng = np.random.default_rng(seed)
    new, massive = np.zeros_like(phi), phi[:, 0] > 0
    theta = to_log_cholesky(nearest_possible(phi[massive]))
    new[massive] = from_log_cholesky(theta + 0.1 * rng.normal(size=theta.shape))
    return new


def without_inertia(urdf: bytes) -> str:
    """All of a URDF that an export must not touch."""
    text = re.sub(r"<!-- exogauge: .*? -->", "", urdf.decode())
    text = re.sub(r"<link name=\"(\w+)\"\s*/>", r'<link name="\1"></link>', text)
    return re.sub(r"\s+", "", re.sub(r"<inertial>.*?</inertial>", "", text, flags=re.DOTALL))


def moving_joints(urdf: bytes) -> list[str]:
    return [j.get("name", "") for j in fromstring(urdf).findall("joint") if j.get("type") in ("revolute", "continuous")]


def arm(arm_body: str, tip_body: str) -> bytes:
    return f'<robot name="a">{ARM.format(arm=arm_body, tip=tip_body)}</robot>'.encode()


def inertial_of(urdf: bytes, link: str) -> str | None:
    found = re.search(rf'<link name="{link}">.*?</link>', urdf.decode(), flags=re.DOTALL)
    assert found is not None
    inertial = re.search(r"<inertial>.*?</inertial>", found[0], flags=re.DOTALL)
    return inertial and inertial[0]


@pytest.mark.parametrize(("name", "floating"), [("talos", True), ("ur10", False)])
def test_a_makers_urdf_comes_back_with_the_identified_inertias_and_nothing_else_changed(
    urdf_of: Read, name: str, floating: bool
) -> None:
    urdf = urdf_of(name)
    joints = moving_joints(urdf)
    tree = load_tree(urdf, joints=joints, base_link="base_link", floating=floating)
    phi = identified(tree.phi)
    exported = export_urdf(urdf, tree, phi)
    again = load_tree(exported, joints=joints, base_link="base_link", floating=floating)
    np.testing.assert_allclose(again.phi, phi, rtol=1e-9, atol=1e-9)
    assert without_inertia(exported) == without_inertia(urdf)


def test_the_exported_file_moves_like_the_identified_robot(urdf_of: Read) -> None:
    urdf = urdf_of("talos")
    tree = load_tree(urdf, joints=moving_joints(urdf), base_link="base_link", floating=True)
    phi = identified(tree.phi)
    exported = pin.buildModelFromXML(export_urdf(urdf, tree, phi).decode(), pin.JointModelFreeFlyer())
    exported.armature[:] = 0.0
    model = exported.copy()
    for body, dof in enumerate(tree.dof):
        if dof >= 0:
            model.inertias[model.getJointId(tree.joints[dof])] = pin.Inertia.FromDynamicParameters(phi[body])
    T = tree.frames["base_link"][1]
    root = exported.frames[exported.getFrameId("base_link")].placement * T.inverse()
    model.inertias[1] = root.act(pin.Inertia.FromDynamicParameters(phi[0]))
    q, v, a = pin.neutral(model), np.ones(model.nv), np.linspace(-1, 1, model.nv)
    expected = pin.rnea(model, model.createData(), q, v, a)
    np.testing.assert_allclose(pin.rnea(exported, exported.createData(), q, v, a), expected, atol=1e-8)


@pytest.mark.parametrize("base", ["trunk", "arm", "leg"])
@pytest.mark.parametrize("joints", [("spin", "hip", "slide", "grip"), ("slide", "spin", "hip"), ("hip",)])
def test_any_base_link_and_any_choice_of_joints_reads_back(urdf_of: Read, base: str, joints: tuple[str, ...]) -> None:
    tree = load_tree(urdf_of("odd"), joints=joints, base_link=base, floating=True)
    phi = identified(tree.phi)
    exported = export_urdf(urdf_of("odd"), tree, phi)
    again = load_tree(exported, joints=joints, base_link=base, floating=True)
    np.testing.assert_allclose(again.phi, phi, rtol=1e-9, atol=1e-9)


def test_fixed_links_say_where_their_inertia_went(urdf_of: Read) -> None:
    tree = load_tree(urdf_of("odd"), joints=["slide", "spin", "hip", "grip"], base_link="trunk", floating=True)
    exported = export_urdf(urdf_of("odd"), tree, identified(tree.phi))
    assert inertial_of(exported, "tip") is None
    assert b"<!-- exogauge: mass and inertia are part of link arm -->" in exported
    assert b"<!-- exogauge: identified with links tip -->" in exported


def test_links_beyond_a_held_joint_keep_the_makers_inertia(urdf_of: Read) -> None:
    tree = load_tree(urdf_of("odd"), joints=["slide", "spin", "hip"], base_link="trunk", floating=True)
    assert tree.locked == ("grip",)
    exported = export_urdf(urdf_of("odd"), tree, identified(tree.phi))
    assert inertial_of(exported, "finger") == inertial_of(urdf_of("odd"), "finger")
    assert inertial_of(exported, "tip") is None

    light = tree.phi.copy()
    arm_body = tree.bodies.index("arm")
    light[arm_body] *= 0.01  # lighter than the finger alone
    assert inertial_of(export_urdf(urdf_of("odd"), tree, light), "finger") is None


@pytest.mark.parametrize("cut", ["weld", "tip"])
def test_links_beyond_a_contact_sensor_keep_theirs(urdf_of: Read, cut: str) -> None:
    tree = load_tree(
        urdf_of("odd"), joints=["slide", "spin", "hip"], base_link="trunk", floating=True, cut_frames=[cut]
    )
    assert "finger" in tree.dropped
    phi = identified(tree.phi)
    exported = export_urdf(urdf_of("odd"), tree, phi)
    for link in tree.dropped:
        assert inertial_of(exported, link) == inertial_of(urdf_of("odd"), link)
    assert (inertial_of(exported, "tip") is None) == (cut == "tip")
    whole = load_tree(exported, joints=["slide", "spin", "hip"], base_link="trunk", floating=True)
    assert whole.mass == pytest.approx(phi[:, 0].sum() + (0.7 if cut == "weld" else 0.2))


def test_an_impossible_link_is_refused_by_name(urdf_of: Read) -> None:
    tree = load_tree(urdf_of("odd"), joints=["slide", "spin", "hip"], base_link="trunk", floating=True)
    phi = identified(tree.phi)
    bad = tree.bodies.index("leg")
    phi[bad, 9] += 5.0
    with pytest.raises(PhysicallyImpossible, match="leg: principal moments") as refusal:
        export_urdf(urdf_of("odd"), tree, phi)
    assert refusal.value.links == ("leg",)


def test_a_body_without_mass_stays_without() -> None:
    urdf = arm("", "")
    tree = load_tree(urdf, joints=["turn"], base_link="trunk", floating=True)
    assert not tree.phi[1].any()
    exported = export_urdf(urdf, tree, identified(tree.phi))
    assert inertial_of(exported, "arm") is None
    assert inertial_of(exported, "trunk") != inertial_of(urdf, "trunk")


def test_a_main_link_without_inertial_gets_one() -> None:
    for urdf in (arm("", BODY), arm("", BODY).replace(b'<link name="arm"></link>', b"<link name='arm' />")):
        tree = load_tree(urdf, joints=["turn"], base_link="trunk", floating=False)
        exported = export_urdf(urdf, tree, tree.phi)
        assert exported.count(b"<inertial>") == 2  # the fixed base keeps its own
        assert inertial_of(exported, "trunk") == inertial_of(urdf, "trunk")
        again = load_tree(exported, joints=["turn"], base_link="trunk", floating=False)
        np.testing.assert_allclose(again.phi, tree.phi, rtol=1e-9, atol=1e-12)


def test_every_export_is_of_a_possible_robot(urdf_of: Read) -> None:
    urdf = urdf_of("talos")
    tree = load_tree(urdf, joints=moving_joints(urdf), base_link="base_link", floating=True)
    assert all(is_physical(body) for body in load_tree(
        export_urdf(urdf, tree, identified(tree.phi, 5)), joints=tree.joints, base_link="base_link", floating=True
    ).phi)  # fmt: skip


def test_odd_names_neither_break_the_comment_nor_the_file() -> None:
    urdf = arm(BODY, BODY).replace(b'"tip"', '"tip--größe &gt; 2"'.encode())
    tree = load_tree(urdf, joints=["turn"], base_link="trunk", floating=True)
    exported = export_urdf(urdf, tree, identified(tree.phi))
    assert "tip--größe &gt; 2".encode() in exported


@pytest.mark.parametrize("encoding", ["UTF-8", "UTF-16", "ISO-8859-1"])
def test_a_file_in_another_encoding_comes_back_as_one_that_is_read(urdf_of: Read, encoding: str) -> None:
    text = (
        re.sub(r"<\?xml.*?\?>", "", urdf_of("odd").decode()).strip().replace("</robot>", "<drake:x/><!-- ü --></robot>")
    )
    urdf = f"<?xml version='1.0' encoding='{encoding}'?>\n{text}".encode(encoding)
    tree = load_tree(urdf, joints=["slide", "spin", "hip"], base_link="trunk", floating=True)
    phi = identified(tree.phi)
    again = load_tree(export_urdf(urdf, tree, phi), joints=["slide", "spin", "hip"], base_link="trunk", floating=True)
    np.testing.assert_allclose(again.phi, phi, rtol=1e-9, atol=1e-9)
