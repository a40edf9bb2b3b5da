"""A robot with odd axes and two sliding joints, written out as URDF for us and as MJCF for MuJoCo, and its bands."""

from __future__ import annotations

import sysconfig
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from exogauge.devices.device import Band, ViaPoint
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

# joint: kind, parent, child, xyz, rpy, axis
JOINTS = {
    "slide": ("prismatic", "trunk", "rail", (0.1, 0.2, 0.3), (0.1, -0.7, 0.4), (0.6, 0.0, 0.8)),
    "spin": ("revolute", "rail", "arm", (0.3, -0.1, 0.2), (1.0, 0.2, 0.3), (0.48, -0.6, 0.64)),
    "weld": ("fixed", "arm", "tip", (0.0, 0.0, 0.4), (0.5, 0.0, 0.0), (1.0, 0.0, 0.0)),
    "grip": ("revolute", "tip", "finger", (0.0, 0.1, 0.1), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)),
    "hip": ("revolute", "trunk", "leg", (-0.2, 0.0, -0.3), (0.0, 0.3, 0.0), (0.0, 1.0, 0.0)),
    "reach": ("prismatic", "leg", "shin", (0.1, 0.1, -0.4), (0.3, 0.0, -0.2), (0.0, -0.28, -0.96)),
    "ankle": ("revolute", "shin", "foot", (0.0, 0.0, -0.3), (0.0, -0.4, 0.1), (-0.36, 0.48, 0.8)),
    "nod": ("revolute", "trunk", "head", (0.0, 0.0, 0.5), (0.0, 0.0, 0.7), (0.8, 0.6, 0.0)),
}
MOVING = tuple(name for name, joint in JOINTS.items() if joint[0] != "fixed")
ORDER = ("ankle", "slide", "nod", "grip", "reach", "spin", "hip")  # in q, none where the tree has it


def band(name: str, *via: tuple[str, float, float, float], **values: object) -> Band:
    return replace(Band(name, name, tuple(ViaPoint(link, (x, y, z)) for link, x, y, z in via)), **values)


BANDS = (
    band("back", ("rail", -0.1, 0.2, 0.1), ("trunk", -0.2, 0.1, 0.0), ("trunk", -0.2, 0.0, -0.2),
         ("leg", -0.1, 0.1, -0.2), ("shin", -0.1, 0.0, -0.1)),
    band("over", ("finger", 0.1, 0.0, 0.1), ("tip", 0.0, 0.1, 0.2), ("arm", 0.1, 0.1, 0.1), ("head", 0.2, 0.0, 0.3)),
    band("zigzag", ("foot", 0.2, 0.0, 0.0), ("trunk", 0.3, 0.0, 0.1), ("foot", 0.1, 0.1, -0.1),
         ("finger", 0.0, 0.2, 0.1), ("finger", 0.0, 0.1, 0.2)),
)  # fmt: skip


@dataclass(frozen=True)
class Pair:
    """One robot for us, pinocchio and MuJoCo. joints: our order in q."""

    tree: RigidTree
    model: pin.Model
    mjcf: Callable[[Sequence[Band]], mujoco.MjModel]
    joints: tuple[str, ...] = ORDER


@pytest.fixture(scope="session", params=["floating", "fixed"])
def pair(request: pytest.FixtureRequest) -> Pair:
    """Fixed: the trunk is welded to a link `ground`."""
    return make_pair(floating=request.param == "floating")


@pytest.fixture(scope="session")
def floating_pair() -> Pair:
    return make_pair(floating=True)


@pytest.fixture(scope="session")
def bands() -> tuple[Band, ...]:
    return BANDS


@pytest.fixture(scope="session")
def odd_tree() -> Callable[[str], RigidTree]:
    """The floating robot, rooted at any of its links."""
    return lambda base: load_tree(urdf(floating=True), joints=ORDER, base_link=base, floating=True)


@pytest.fixture(scope="session")
def talos() -> RigidTree:
    share = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"
    content = (share / "talos_data/robots/talos_reduced.urdf").read_bytes()
    joints = pin.buildModelFromXML(content.decode()).names.tolist()[1:]
    return load_tree(content, joints=joints, base_link="base_link", floating=True)


@pytest.fixture(scope="session")
def suit() -> tuple[Band, ...]:
    """Two bands from the shoulders over the back to the thighs and two about the waist, eight via points each."""
    found = []
    for side, s in (("left", 1.0), ("right", -1.0)):
        thigh = f"leg_{side}_3_link"
        found.append(
            band(f"A_{side}", ("torso_2_link", -0.05, 0.15 * s, 0.45), ("torso_2_link", -0.12, 0.12 * s, 0.3),
                 ("torso_2_link", -0.13, 0.1 * s, 0.1), ("base_link", -0.14, 0.09 * s, 0.05),
                 ("base_link", -0.15, 0.1 * s, -0.05), (thigh, -0.11, 0.0, -0.05), (thigh, -0.1, 0.0, -0.15),
                 (thigh, -0.09, 0.0, -0.25))
        )  # fmt: skip
        found.append(
            band(f"B_{side}", ("torso_2_link", 0.12, 0.15 * s, 0.3), ("torso_2_link", 0.1, 0.18 * s, 0.2),
                 ("torso_2_link", 0.0, 0.2 * s, 0.15), ("torso_1_link", -0.08, 0.12 * s, 0.05),
                 ("base_link", -0.12, 0.02 * s, 0.02), ("base_link", -0.1, -0.1 * s, -0.02),
                 ("base_link", 0.0, -0.17 * s, -0.04), ("base_link", 0.1, -0.14 * s, -0.05))
        )  # fmt: skip
    return tuple(found)


def make_pair(*, floating: bool) -> Pair:
    content = urdf(floating=floating)
    tree = load_tree(content, joints=ORDER, base_link="trunk" if floating else "ground", floating=floating)
    xml = content.decode()
    model = pin.buildModelFromXML(xml, pin.JointModelFreeFlyer()) if floating else pin.buildModelFromXML(xml)
    return Pair(tree, model, lambda bands: mujoco.MjModel.from_xml_string(mjcf(bands, floating=floating)))


def numbers(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def urdf(*, floating: bool) -> bytes:
    links = ["trunk", *(child for _, _, child, *_ in JOINTS.values())]
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    parts = [f'<link name="{name}">{inertial}</link>' for name in links]
    joints = JOINTS if floating else {"feet": ("fixed", "ground", "trunk", *GROUND, (1.0, 0.0, 0.0)), **JOINTS}
    if not floating:
        parts.append('<link name="ground"/>')
    for name, (kind, parent, child, xyz, rpy, axis) in joints.items():
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/><axis xyz="{numbers(axis)}"/>'
            '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
        )
    return f'<robot name="odd">{"".join(parts)}</robot>'.encode()


GROUND = ((0.3, -0.2, 1.0), (0.2, -0.1, 0.5))


def mjcf(bands: Sequence[Band], *, floating: bool) -> str:
    """Every via point a site, every band a spatial tendon through its sites."""

    def sites(link: str) -> str:
        return "".join(
            f'<site name="{band.name}{i}" pos="{numbers(via.xyz)}"/>'
            for band in bands for i, via in enumerate(band.via_points) if via.link == link
        )  # fmt: skip

    def body(link: str, joint: str, xyz: Sequence[float], rpy: Sequence[float]) -> str:
        w = Rotation.from_euler("xyz", rpy).as_quat()[[3, 0, 1, 2]]
        inside = "".join(
            body(child, moving(name, kind, axis), at, turn)
            for name, (kind, parent, child, at, turn, axis) in JOINTS.items() if parent == link
        )  # fmt: skip
        mass = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        return f'<body name="{link}" pos="{numbers(xyz)}" quat="{numbers(w)}">{joint}{mass}{sites(link)}{inside}</body>'

    def moving(name: str, kind: str, axis: Sequence[float]) -> str:
        word = {"prismatic": "slide", "revolute": "hinge"}.get(kind)
        return f'<joint name="{name}" type="{word}" axis="{numbers(axis)}"/>' if word else ""

    tendons = "".join(
        f'<spatial name="{b.name}" stiffness="{b.stiffness or 0.0!r}" springlength="0 {b.natural_length or 9.0!r}">'
        + "".join(f'<site site="{b.name}{i}"/>' for i in range(len(b.via_points))) + "</spatial>"
        for b in bands
    )  # fmt: skip
    trunk = body("trunk", "<freejoint/>" if floating else "", *(((0.0,) * 3, (0.0,) * 3) if floating else GROUND))
    return (
        '<mujoco><compiler angle="radian"/><option gravity="0 0 0"/>'
        f"<worldbody>{sites('ground')}{trunk}</worldbody><tendon>{tendons}</tendon></mujoco>"
    )
