"""The maker's URDF with identified masses and inertias; every other byte stays as it was."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final
from xml.etree.ElementTree import Element
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import BadRobot, Fault, PhysicallyImpossible
from exogauge.robots.consistency import is_physical, violations
from exogauge.robots.cuts import links_of, pose_in_body
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree
from exogauge.robots.urdf_check import INERTIA_NAMES, as_utf8, numbers, read_urdf

Array = NDArray[np.float64]

ROUNDING = 1e-9
"""How far, relatively, a body may lie outside the possible ones (a plate without thickness), and a number be off."""

_TAG = re.compile(rb"""<[^"'>]*(?:"[^"]*"[^"'>]*|'[^']*'[^"'>]*)*>""")


def export_urdf(urdf: bytes, tree: RigidTree, phi: Array) -> bytes:
    """The URDF that `tree` was loaded from, with phi (N, 10), layout of `RigidTree.phi`, as its inertias.

    A body's whole inertia goes on its main link, the one its joint moves; links fixed to that one lose their
    <inertial>, for which a comment stands in. Links beyond a joint that was held at zero keep the maker's, and so much
    less goes on the main link, unless what remains is no possible body: then these lose theirs too. Links beyond a
    contact sensor (`tree.dropped`) and those of a fixed base are not part of any body and keep theirs.

    The file is read back before it is returned. Raises PhysicallyImpossible, naming the links that cannot exist.
    """
    wrong = violations(phi, tree.bodies, -ROUNDING)
    if wrong:
        links = [name for name, body in zip(tree.bodies, phi, strict=True) if not is_physical(body, -ROUNDING)]
        raise PhysicallyImpossible("no URDF for a robot that cannot exist: " + "; ".join(wrong), links)
    robot = read_urdf(urdf)
    replacements: dict[str, str] = {}
    for body, name in enumerate(tree.bodies):
        if np.any(phi[body]) or np.any(tree.phi[body]):
            replacements |= _body_elements(robot, tree, body, name, phi[body])
    exported = _splice(as_utf8(urdf), replacements)
    _read_back(exported, tree, phi, robot)
    return exported


def _body_elements(robot: Element, tree: RigidTree, body: int, name: str, phi: Array) -> dict[str, str]:
    """Link name -> what stands in place of its <inertial>, for the links of one body that change."""
    links = {link.get("name", ""): link for link in robot.findall("link")}
    members = links_of(tree, body, [link for link in links if link not in tree.dropped])
    main = name if name in members else members[0]
    rigid = _reached(robot, main, set(members), avoiding=set(tree.locked))
    own = {link: inertia for link in members if (inertia := _inertia(links[link])) is not None}
    pose = {link: pose_in_body(tree, body, link) for link in members}
    held = [link for link in members if link not in rigid and link in own]
    rest = phi - sum((pose[link].act(own[link]).toDynamicParameters() for link in held), np.zeros(10))
    if not is_physical(rest):
        rest, held = phi, []
    moved = [link for link in members if link != main and link not in held and links[link].find("inertial") is not None]
    note = f"with links {', '.join(moved)}" if moved else ""
    if not np.any(rest):
        return {link: _comment("no mass") for link in own}
    inertia = pose[main].actInv(pin.Inertia.FromDynamicParameters(rest))
    gone = _comment(f"mass and inertia are part of link {main}")
    return {main: _comment(f"identified {note}".strip()) + _inertial(inertia), **dict.fromkeys(moved, gone)}


def _reached(robot: Element, start: str, among: set[str], avoiding: set[str]) -> set[str]:
    """Links connected with start through joints that are not to be avoided, and links among the given ones."""
    reached, grew = {start}, True
    ends = [_ends(joint) for joint in robot.findall("joint") if joint.get("name") not in avoiding]
    while grew:
        new = {b for ab in ends for a, b in (ab, ab[::-1]) if a in reached and b in among} - reached
        reached |= new
        grew = bool(new)
    return reached


def _ends(joint: Element) -> tuple[str, str]:
    """(parent link, child link)."""
    parent, child = joint.find("parent"), joint.find("child")
    assert parent is not None  # read_urdf has checked
    assert child is not None
    return parent.get("link", ""), child.get("link", "")


def _inertia(link: Element) -> pin.Inertia | None:
    """The maker's inertia of a link in the link's frame, None without mass."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    found = {element.tag: element for element in inertial}
    mass = float(found["mass"].get("value", ""))
    if mass == 0:
        return None
    origin = found.get("origin", Element("origin"))
    xyz, rpy = (np.array(numbers(origin.get(key, "0 0 0"))) for key in ("xyz", "rpy"))
    xx, xy, yy, xz, yz, zz = (float(found["inertia"].get(key, "")) for key in INERTIA_NAMES)
    R = pin.rpy.rpyToMatrix(rpy)
    return pin.Inertia(mass, xyz, R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T)


def _inertial(body: pin.Inertia) -> str:
    """<inertial> about the centre of mass, axes along the link's, with every digit of a double."""
    I = body.inertia  # noqa: E741
    xyz = " ".join(repr(float(x)) for x in body.lever)
    places = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    values = " ".join(f"{key}={quoteattr(repr(float(I[place])))}" for key, place in places.items())
    return (
        f'<inertial>\n      <origin xyz="{xyz}" rpy="0 0 0"/>\n      <mass value="{float(body.mass)!r}"/>\n'
        f"      <inertia {values}/>\n    </inertial>"
    )


def _comment(text: str) -> str:
    """An XML comment; two hyphens in a row, as a link name may hold, would end it."""
    return f"<!-- exogauge: {re.sub('-(?=-)', '- ', text)} -->"


@final
@dataclass
class _Place:
    """Byte positions of a link's start tag, of its end tag, and of its <inertial> elements."""

    start: int
    end: int
    inertials: list[tuple[int, int]]


def _splice(urdf: bytes, replacements: dict[str, str]) -> bytes:
    """The URDF with each named link's <inertial> replaced, or put in before </link> where there was none."""
    edits: list[tuple[int, int, bytes]] = []
    for name, place in _places(urdf).items():
        if name not in replacements:
            continue
        text = replacements[name].encode("ascii", "xmlcharrefreplace")
        if place.inertials:
            edits += [(start, stop, text if i == 0 else b"") for i, (start, stop) in enumerate(place.inertials)]
        elif _is_empty(urdf, place.start):
            stop = _tag_end(urdf, place.start)
            edits.append((stop - 2, stop, b">\n    " + text + b"\n  </link>"))
        else:
            edits.append((place.end, place.end, b"  " + text + b"\n  "))
    for start, stop, text in sorted(edits, reverse=True):
        urdf = urdf[:start] + text + urdf[stop:]
    return urdf


def _places(urdf: bytes) -> dict[str, _Place]:
    """Where each link of the robot stands. The URDF has passed `read_urdf`: no DOCTYPE, unique names."""
    if urdf[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise BadRobot(Fault("is UTF-16", "urdf_encoding", "Save it as UTF-8", file="robot.urdf"))
    parser = expat.ParserCreate()
    path: list[tuple[str, int]] = []
    places: dict[str, _Place] = {}
    current: list[_Place] = []

    def opened(tag: str, attributes: dict[str, str]) -> None:
        at = parser.CurrentByteIndex
        path.append((tag, at))
        if [name for name, _ in path] == ["robot", "link"]:
            current[:] = [_Place(at, at, [])]
            places[attributes["name"]] = current[0]

    def closed(tag: str) -> None:
        at, names = parser.CurrentByteIndex, [name for name, _ in path]
        _, start = path.pop()
        if names == ["robot", "link", "inertial"]:
            current[0].inertials.append((start, _tag_end(urdf, start if _is_empty(urdf, start) else at)))
        elif names == ["robot", "link"]:
            current[0].end = at

    parser.StartElementHandler, parser.EndElementHandler = opened, closed
    parser.Parse(urdf, True)
    return places


def _tag_end(urdf: bytes, start: int) -> int:
    """Position after the > of the tag that starts here."""
    tag = _TAG.match(urdf, start)
    assert tag is not None
    return tag.end()


def _is_empty(urdf: bytes, start: int) -> bool:
    """Whether the element that starts here is written as <tag/>."""
    return urdf.endswith(b"/>", start, _tag_end(urdf, start))


def _read_back(exported: bytes, tree: RigidTree, phi: Array, robot: Element) -> None:
    """Load what was written and compare."""
    base = tree.bodies[0] if tree.floating else next(
        link.get("name", "") for link in robot.findall("link") if tree.frames[link.get("name", "")][0] == -1
    )  # fmt: skip
    links = {link.get("name") for link in robot.findall("link")}
    cuts = []
    for joint in robot.findall("joint"):
        parent, child = _ends(joint)
        if (parent in tree.dropped) != (child in tree.dropped):
            name, near = joint.get("name", ""), child if parent in tree.dropped else parent
            cuts.append(name if joint.get("type") == "fixed" and name not in links else near)
    again = load_tree(
        exported, joints=tree.joints, base_link=base, floating=tree.floating, cut_frames=cuts, carrying=tuple(tree.cuts)
    )
    scale = np.abs(phi).max(axis=1, keepdims=True, initial=1e-3)
    if again.bodies != tree.bodies or not np.all(np.abs(again.phi - phi) <= ROUNDING * scale):
        raise RuntimeError("the exported URDF does not read back as the identified robot")
