"""A URDF from a stranger, checked before any C++ parser sees it: XML, size, tree, numbers, inertias, mesh paths."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, ParseError
from xml.parsers import expat

import defusedxml.ElementTree
import numpy as np
from defusedxml import DefusedXmlException
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.errors import BadRobot, Fault
from exogauge.remarks import About, Remark
from exogauge.stand_ins import stands_in

if TYPE_CHECKING:
    from exogauge.robots.tree import RigidTree

MAX_BYTES = 20_000_000
MAX_LINKS = 500
MAX_DEPTH = 200
MAX_FAULTS = 50
INERTIA_TOLERANCE = 1e-6  # of the trace: what rounding to six digits may cost
SLIGHT = (
    1e-5  # kg·m²: below, an inertia matters to no motion of a joint (a gram at 10 cm), and how far it misses does not
)
UNBOUND_PREFIX = expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]
LATE_DECLARATION = expat.errors.codes[expat.errors.XML_ERROR_MISPLACED_XML_PI]
BARE = frozenset({"property", "arg", "macro"})  # of xacro: they make no link by themselves
RESERVED = "universe"  # what pinocchio calls the world
ROUNDED = 1e-12  # kg·m²: less than that is a zero that was computed

EXPAND = "expand it first: xacro FILE.xacro > robot.urdf"
JOINT_TYPES = frozenset({"revolute", "continuous", "prismatic", "fixed", "floating", "planar"})
MOVING_TYPES = frozenset({"revolute", "continuous", "prismatic"})
PLACES = {"ixx": (0, 0), "ixy": (0, 1), "iyy": (1, 1), "ixz": (0, 2), "iyz": (1, 2), "izz": (2, 2)}
INERTIA_NAMES = tuple(PLACES)
Array = NDArray[np.float64]


def check_urdf(urdf: bytes, file: str = "robot.urdf") -> None:
    """Raise BadRobot with one fault per broken rule; return in silence when there is none."""
    read_urdf(urdf, file)


def read_urdf(urdf: bytes, file: str = "robot.urdf") -> Element:
    """The checked <robot> element. Raises BadRobot.

    Inertias that miss a possible body by no more than `SLIGHT` are those of the nearest one (`raised_inertias`).
    """
    robot = _parse(urdf, file)
    _raise_slightly_impossible(robot)
    links, joints = robot.findall("link"), robot.findall("joint")
    if len(links) > MAX_LINKS:
        raise BadRobot(Fault(f"{len(links)} links, at most {MAX_LINKS} are accepted", "too_many_links", file=file))
    faults = [*_name_faults("link", links, file), *_name_faults("joint", joints, file)]
    faults += [fault for joint in joints for fault in _joint_faults(joint, file)]
    for link in links:
        faults += _inertial_faults(link, file)
    faults += [fault for link in links for fault in _mesh_faults(link, file)]
    faults += _tree_faults(links, joints, file)
    if faults:
        raise BadRobot(faults[:MAX_FAULTS])
    return robot


def raised_inertias(urdf: bytes, file: str = "robot.urdf") -> tuple[Remark, ...]:
    """Which links' inertia had to be raised to that of a body; rounded zeros are not told."""
    raised = [each for each in _raise_slightly_impossible(_parse(urdf, file)) if each[1] > ROUNDED]
    if not raised:
        return ()
    link, short, moments = max(raised, key=lambda each: each[1])
    names = tuple(name for name, _, _ in raised)
    return (Remark(About.INERTIA_RAISED, names, beside=(file, link), numbers=(short, *moments)),)


def impossible_density(urdf: bytes, file: str, criteria: Examining) -> tuple[Remark, ...]:
    """Whether half of the robot's mass, as ellipsoids of the links' mass and inertia, is denser or lighter than matter
    is: a unit is not SI then. Single links do not count: fingers and frames often have a point's inertia."""
    masses, densities = list[float](), list[float]()
    for _, _, mass, matrix in _bodies(_parse(urdf, file)):
        if mass > 0.0:
            principal = np.linalg.eigvalsh(matrix)
            second = np.maximum(0.5 * principal.sum() - principal, 0.0)
            volume = 4.0 / 3.0 * math.pi * float(np.prod(np.sqrt(5.0 * second / mass)))
            masses.append(mass)
            densities.append(mass / volume if volume > 0.0 else math.inf)
    if not masses:
        return ()
    order = np.argsort(densities)
    share = np.cumsum(np.array(masses)[order]) / sum(masses)
    half = densities[order[int(np.searchsorted(share, 0.5))]]
    if criteria.lightest <= half <= criteria.densest:
        return ()
    if math.isinf(half):
        return (Remark(About.NO_EXTENT, beside=(file,), numbers=(sum(masses),)),)
    about = About.TOO_DENSE if half > criteria.densest else About.TOO_LIGHT
    return (Remark(about, beside=(file,), numbers=(sum(masses), half)),)


def masses_alike(urdf: bytes, file: str) -> tuple[Remark, ...]:
    """Whether every link that weighs weighs the same: no robot is so, but one whose masses stand in for what nobody
    knew. Of 2 links it may be true."""
    masses = [mass for _, _, mass, _ in _bodies(_parse(urdf, file)) if mass > 0.0]
    if len(masses) < 3 or min(masses) < max(masses):
        return ()
    return (Remark(About.MASSES_ALIKE, beside=(file,), numbers=(masses[0], len(masses))),)


def limits_in_degrees(urdf: bytes, file: str, criteria: Examining) -> tuple[Remark, ...]:
    """Whether joints turn further than cables bear: an end beyond 1000 rad stands for none."""
    ends = list[float]()
    for limit in _parse(urdf, file).findall("joint[@type='revolute']/limit"):
        low, high = (next(iter(numbers(limit.get(key, ""))), 0.0) for key in ("lower", "upper"))
        if low < high and max(-low, high) < 1e3:
            ends.append(max(-low, high))
    median = float(np.median(ends)) if ends else 0.0
    return (Remark(About.LIMITS_IN_DEGREES, beside=(file,), numbers=(median,)),) if median > criteria.turned else ()


def idle_joints(tree: RigidTree, file: str) -> tuple[Remark, ...]:
    """Which joints move nothing that weighs. Raises BadRobot where all do: there is nothing to identify from."""
    if tree.joints and len(tree.idle) == len(tree.joints):
        raise BadRobot(Fault("nothing that its joints move has a mass", "weightless",
                             "Give the links an <inertial>: the maker's, or an estimate", file))  # fmt: skip
    return (Remark(About.MOVES_NOTHING, tree.idle, beside=(file,)),) if tree.idle else ()


def numbers(text: str) -> list[float]:
    """Blank-separated finite numbers. Raises ValueError."""
    values = [float(word) for word in text.split()]
    if not all(math.isfinite(value) for value in values):
        raise ValueError("not finite")
    return values


def _parse(urdf: bytes, file: str) -> Element:
    def refuse(detail: str, rule: str, advice: str = "") -> BadRobot:
        return BadRobot(Fault(detail, rule, advice, file=file))

    if len(urdf) > MAX_BYTES:
        raise refuse(f"{len(urdf)} bytes, at most {MAX_BYTES} are accepted", "urdf_too_large", "Leave meshes out")
    urdf = as_utf8(urdf)
    if other := stands_in(urdf[:1000]):
        raise refuse(f"is {other[0]}", "stands_in", other[1])
    try:
        robot = _read(urdf)
    except DefusedXmlException:
        raise refuse("holds a DOCTYPE or an entity", "xml_doctype", "Remove it: a URDF needs none") from None
    except (ParseError, ValueError, LookupError) as error:
        raise BadRobot(_not_xml(urdf, error, file)) from None
    if robot.tag != "robot":
        raise refuse(f"its root is <{robot.tag}>, not <robot>", "not_urdf", "Hand in a URDF")
    if robot.find("link") is None:
        raise refuse("holds no <link>", "no_links", f"If it is a xacro, {EXPAND}")
    left = {tag for each in robot if (tag := _of_xacro(each)) and tag not in BARE}
    if left:
        raise refuse(f"holds <xacro:{min(left)}>, and what it stands for is not there", "xacro_left", _sentence(EXPAND))
    return robot


def as_utf8(urdf: bytes) -> bytes:
    """Of a file in UTF-16 the same in UTF-8; every other as it is."""
    if not urdf.startswith((b"\xff\xfe", b"\xfe\xff")):
        return urdf
    text = urdf.decode("utf-16", "replace")
    return re.sub(r"(<\?xml[^>]*?)\s+encoding\s*=\s*(\"[^\"]*\"|'[^']*')", r"\1", text, count=1).encode()


def _of_xacro(element: Element) -> str:
    """Its name, of an element that xacro would have replaced."""
    space, _, tag = str(element.tag).removeprefix("{").rpartition("}")
    return tag if "xacro" in space else ""


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _not_xml(urdf: bytes, error: Exception, file: str) -> Fault:
    advice = "Mend that line: a tag that is not closed, & in place of &amp;, or -- in a comment"
    try:
        urdf.decode()
    except UnicodeDecodeError as bad:
        line = urdf.count(b"\n", 0, bad.start) + 1
        advice = f'Line {line} is not UTF-8: save it so, or name its encoding: <?xml version="1.0" encoding="…"?>'
    if getattr(error, "code", None) == LATE_DECLARATION:
        advice = "Remove what stands before <?xml …?>, blank lines too"
    elif not urdf.strip():
        advice = "It is empty"
    elif not urdf.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        advice = "Hand in the URDF itself, not an archive"
    return Fault(f"is not XML: {error}", "not_xml", advice, file)


def _read(urdf: bytes) -> Element:
    """Prefixes that a file does not declare (`drake:`, `gazebo:`) are declared: readers of URDF know no namespaces."""
    try:
        return defusedxml.ElementTree.fromstring(urdf, forbid_dtd=True)
    except ParseError as error:
        if error.code != UNBOUND_PREFIX:
            raise
    declared = set(re.findall(rb"xmlns:([\w.-]+)\s*=", urdf))
    used = set(re.findall(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*[\s=>/]", urdf))
    words = b"".join(b' xmlns:%b="%b"' % (each, each) for each in sorted(used - declared - {b"xml", b"xmlns"}))
    return defusedxml.ElementTree.fromstring(
        re.sub(rb"<robot(?=[\s>])", b"<robot" + words, urdf, count=1), forbid_dtd=True
    )


def _name_faults(kind: str, elements: list[Element], file: str) -> Iterator[Fault]:
    count = Counter(element.get("name") or "" for element in elements)
    if count.pop("", 0):
        yield Fault(f"a {kind} has no name", f"{kind}_without_name", file=file)
    for name, times in count.items():
        if "$" in name and re.search(r"\$[{(]", name):
            yield Fault(f"the name of {kind} {name!r} is not resolved", "name_not_resolved", _sentence(EXPAND), file)
        if kind == "joint" and name == RESERVED:
            yield Fault(f"no joint may be called {name!r}", "name_reserved", "Rename it", file)
        if times > 1:
            yield Fault(f"{kind} {name!r} appears {times} times", f"{kind}_name_twice", "Rename one", file=file)


def _joint_faults(joint: Element, file: str) -> Iterator[Fault]:
    what, kind = f"joint {joint.get('name')!r}", joint.get("type")
    if kind not in JOINT_TYPES:
        yield Fault(f"{what} has an unknown type", "joint_type", f"One of {', '.join(sorted(JOINT_TYPES))}", file,
                    value=str(kind))  # fmt: skip
    for tag, attribute, size in (("origin", "xyz", 3), ("origin", "rpy", 3), ("axis", "xyz", 3)):
        yield from _number_faults(joint.find(tag), attribute, size, what, file)
    for attribute in ("lower", "upper", "effort", "velocity"):
        yield from _number_faults(joint.find("limit"), attribute, 1, what, file)
    axis = joint.find("axis")
    if axis is not None and kind in MOVING_TYPES:
        try:
            if math.hypot(*numbers(axis.get("xyz") or "1 0 0")) < 1e-9:
                yield Fault(f"{what} has an axis of zero length", "joint_axis_zero", file=file, value=axis.get("xyz"))
        except ValueError:
            pass  # told above


def _number_faults(
    element: Element | None, attribute: str, size: int, what: str, file: str, required: bool = False
) -> Iterator[Fault]:
    text = None if element is None else element.get(attribute)
    if text is None:
        if required:
            yield Fault(f"{what} lacks {attribute}", "number_missing",
                        "Give it; a frame that weighs nothing has no <inertial> element", file)  # fmt: skip
        return
    try:
        good = len(numbers(text)) == size
    except ValueError:
        good = False
    if not good:
        need = "a finite number" if size == 1 else f"{size} finite numbers"
        tag = element.tag if element is not None else ""
        commas = "Write a decimal point, and blanks between numbers" if "," in text else ""
        advice = f"If it is a xacro, {EXPAND}" if "$" in text else commas
        detail = f"{what.removesuffix(f': <{tag}>')}: <{tag}> {attribute} is not {need}"
        yield Fault(detail, "not_a_number", advice, file, value=text[:80])


def _inertial_faults(link: Element, file: str) -> Iterator[Fault]:
    """Mass positive; inertia about the centre of mass positive semi-definite and within the triangle inequality. An
    <inertial> of nothing but zeros is none: frames often have one, and fingers."""
    inertial, what = link.find("inertial"), f"link {link.get('name')!r}"
    if inertial is None:
        return
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    bad = [
        *_number_faults(inertial.find("origin"), "xyz", 3, what, file),
        *_number_faults(inertial.find("origin"), "rpy", 3, what, file),
        *_number_faults(mass, "value", 1, f"{what}: <mass>", file, required=True),
        *(f for n in INERTIA_NAMES for f in _number_faults(inertia, n, 1, f"{what}: <inertia>", file, required=True)),
    ]
    if bad or mass is None or inertia is None:
        yield from bad
        return
    value = float(mass.get("value", ""))
    frame_only = value == 0.0 and not any(float(inertia.get(name, "")) for name in INERTIA_NAMES)
    if value <= 0.0 and not frame_only:
        advice = "Give the body's mass [kg]; of a frame that weighs nothing take the <inertial> element out"
        yield Fault(f"{what}: the mass must be positive", "mass_not_positive", advice, file, value=mass.get("value"))
    xx, xy, yy, xz, yz, zz = (float(inertia.get(name, "")) for name in INERTIA_NAMES)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    low, middle, high = np.linalg.eigvalsh(matrix)
    margin = INERTIA_TOLERANCE * (abs(low) + abs(middle) + abs(high))
    moments = f"principal moments {low:.6g}, {middle:.6g}, {high:.6g}"
    if low < -margin:
        yield Fault(f"{what}: the inertia about the centre of mass is not positive semi-definite",
                    "inertia_not_positive", "Check signs and units (kg·m²)", file, value=moments)  # fmt: skip
    elif low + middle < high - margin:
        nearest = _nearest_possible(matrix)
        possible = " ".join(f'{name}="{nearest[place]:.6g}"' for name, place in PLACES.items())
        advice = f"Give more digits, or check that it is about the centre of mass. The nearest of a body: {possible}"
        yield Fault(f"{what}: no body has these moments, the largest exceeds the sum of the others",
                    "inertia_triangle", advice, file, value=moments)  # fmt: skip


def _nearest_possible(matrix: Array) -> Array:
    """(3, 3) The principal second moments ∫ r² dm that are negative become 0; axes stay."""
    principal, axes = np.linalg.eigh(matrix)
    second = np.maximum(0.5 * principal.sum() - principal, 0.0)
    return np.asarray((axes * (second.sum() - second)) @ axes.T)


def _raise_slightly_impossible(robot: Element) -> list[tuple[str, float, tuple[float, ...]]]:
    """Write the nearest possible inertia where a link's misses it by little; (link, by how much, its moments).

    Mass, centre and axes stay. Inertias beyond that, and what is no number, are left to `_inertial_faults`.
    """
    raised = []
    for link, inertia, mass, matrix in _bodies(robot):
        principal = np.linalg.eigvalsh(matrix)
        short = float(2.0 * principal[2] - principal.sum())
        if mass <= 0.0 or not INERTIA_TOLERANCE * np.abs(principal).sum() < short <= SLIGHT:
            continue
        possible = _nearest_possible(matrix)
        for name, place in PLACES.items():
            inertia.set(name, repr(float(possible[place])))
        raised.append((link.get("name", ""), short, tuple(map(float, principal))))
    return raised


def _bodies(robot: Element) -> Iterator[tuple[Element, Element, float, Array]]:
    """Link, its <inertia>, mass and (3, 3) inertia about the centre of mass, where all are finite numbers."""
    for link in robot.findall("link"):
        inertia = link.find("inertial/inertia")
        try:
            mass = float(link.find("inertial/mass").get("value", ""))  # type: ignore[union-attr]
            xx, xy, yy, xz, yz, zz = (float(inertia.get(name, "")) for name in INERTIA_NAMES)  # type: ignore[union-attr]
        except (AttributeError, ValueError):
            continue
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if inertia is not None and math.isfinite(mass) and np.all(np.isfinite(matrix)):
            yield link, inertia, mass, matrix


def _mesh_faults(link: Element, file: str) -> Iterator[Fault]:
    """Meshes are never opened here; one of the network is refused. A path upwards, as many makers write it beside their
    `urdf` folder, and one of the maker's machine, as xacro writes `file://$(find …)`, are taken: whoever opens meshes
    reads what lies in the bundle alone, by how its path ends."""
    for element in link.iter():
        path = (element.get("filename") or "").replace("\\", "/") if element.tag in ("mesh", "texture") else ""
        if not path:
            continue
        scheme, _, rest = path.rpartition("://")
        upwards = scheme in ("package", "model") and ".." in rest.split("/")  # out of a package
        if upwards or scheme not in ("", "package", "model", "file"):
            yield Fault(f"link {link.get('name')!r}: a mesh outside the bundle", "mesh_outside",
                        "Write package://NAME/meshes/…: a file is found by how its path ends", file,
                        value=path[:80])  # fmt: skip


def _tree_faults(links: list[Element], joints: list[Element], file: str) -> list[Fault]:
    """One root, every other link the child of one joint, no loop, not too deep."""
    faults: list[Fault] = []
    names = {link.get("name") or "" for link in links}
    children: dict[str, list[str]] = {}
    parents = Counter[str]()
    for joint in joints:
        ends = {}
        for end in ("parent", "child"):
            element = joint.find(end)
            ends[end] = (element.get("link") if element is not None else None) or ""
            if ends[end] not in names:
                faults.append(Fault(f"joint {joint.get('name')!r}: its {end} is no link", f"joint_{end}_unknown",
                                    file=file, value=ends[end][:80]))  # fmt: skip
        children.setdefault(ends["parent"], []).append(ends["child"])
        parents[ends["child"]] += 1
    if faults:
        return faults
    for name, times in parents.items():
        if times > 1:
            faults.append(Fault(f"link {name!r} is the child of {times} joints", "link_two_parents", file=file))
    roots = sorted(names - set(parents))
    if len(roots) > 1:
        faults.append(Fault("more than one link has no parent", "two_roots", "Join them by a fixed joint", file,
                            value=", ".join(roots[:5])))  # fmt: skip
    depth, level, seen = 0, roots, set(roots)
    while level and depth <= MAX_DEPTH:
        level = [child for link in level for child in children.get(link, []) if child not in seen]
        seen.update(level)
        depth += 1
    if depth > MAX_DEPTH:
        faults.append(Fault(f"more than {MAX_DEPTH} links in one chain", "tree_too_deep", file=file))
    elif len(seen) < len(names):
        lost = sorted(names - seen)
        faults.append(Fault("links form a loop", "loop", "A URDF is a tree", file, value=", ".join(lost[:5])))
    return faults
