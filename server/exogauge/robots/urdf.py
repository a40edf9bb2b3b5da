"""From a URDF to the tree of moving bodies, rooted where the IMU is and ended where the contact sensors are."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import final
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import BadRobot, Fault
from exogauge.robots.cuts import Beyond, split
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf_check import INERTIA_NAMES, MOVING_TYPES, numbers, read_urdf

Array = NDArray[np.float64]


def load_tree(
    urdf: bytes,
    *,
    joints: Sequence[str],
    base_link: str,
    floating: bool,
    cut_frames: Sequence[str] = (),
    carrying: Sequence[str] = (),
    file: str = "robot.urdf",
) -> RigidTree:
    """The moving bodies of a URDF. Raises BadRobot.

    joints: the actuated joints, in the order of q; other movable joints are held at zero (`RigidTree.locked`).
    base_link: floating: any link, it becomes body 0; fixed: a link that no joint moves.
    cut_frames: links, or fixed joints, at which a sensor measures the contact wrench. What hangs rigidly beyond them
    (seen from the base) keeps its frames and loses its inertia; beyond a fixed joint its child is meant too.
    carrying: links, or fixed joints, at which a sensor measures what the bodies beyond it ask for (`robots.cuts`).
    """
    described = _Description.of(read_urdf(urdf, file), file)
    described.check_names(joints, base_link, [*cut_frames, *carrying])
    dropped = {link for frame in cut_frames for link in described.beyond(frame, base_link, set(joints))}
    links = list(described.links)
    model = pin.buildModelFromXML(described.reduced(set(joints), dropped), pin.JointModelFreeFlyer())
    tree = _rooted(model, described, links, tuple(joints), base_link, floating, tuple(sorted(dropped)))
    return (
        split(tree, [_beyond(described, tree, frame, base_link, dropped) for frame in carrying]) if carrying else tree
    )


def load_whole(urdf: bytes, file: str = "robot.urdf") -> RigidTree:
    """All that moves, on the root link: what a URDF offers before anybody says which joints count. Raises BadRobot."""
    described = _Description.of(read_urdf(urdf, file), file)
    joints = [joint.name for joint in described.joints.values() if joint.kind in MOVING_TYPES and not joint.mimics]
    return load_tree(urdf, joints=joints, base_link=described.root, floating=False, file=file)


def model_text(urdf: bytes, file: str = "robot.urdf") -> str:
    """What pinocchio may read of a URDF under its own names: masses, fixed joints and those that may be driven, with
    ends. All else (materials, shapes, what simulators add) its parser could stumble over. Raises BadRobot."""
    described = _Description.of(read_urdf(urdf, file), file)
    moving = {joint.name for joint in described.joints.values() if joint.kind in MOVING_TYPES and not joint.mimics}
    return described.reduced(moving, set(), own_names=True)


def _beyond(described: _Description, tree: RigidTree, frame: str, base_link: str, dropped: set[str]) -> Beyond:
    near = base_link if tree.floating else described.root
    links, joints = described.carried(frame, near, set(tree.joints))
    links.sort(key=lambda link: not described.has_mass(link))  # the body gets the name of one that weighs something
    if not links and not joints:
        raise BadRobot(Fault(f"nothing hangs on the sensor at {frame!r}", "nothing_beyond_cut",
                             "Name the frame between the robot and what the sensor carries", described.file,
                             value=frame))  # fmt: skip
    others = {link for link in described.links if link not in links}
    model = pin.buildModelFromXML(described.reduced(set(tree.joints), others | dropped), pin.JointModelFreeFlyer())
    index = {name: k for k, name in enumerate(described.links)}
    inertia = pin.Inertia.Zero()
    if links:
        place = model.frames[model.getFrameId(f"l{index[links[0]]}")]
        T_body_joint = tree.frames[links[0]][1] * place.placement.inverse()
        inertia = T_body_joint.act(model.inertias[place.parentJoint])
    return Beyond(frame, tuple(links), tuple(joints), inertia)


@final
@dataclass(frozen=True)
class _UrdfJoint:
    name: str
    kind: str
    parent: str
    child: str
    mimics: bool
    element: Element

    @property
    def movable(self) -> bool:
        return self.kind != "fixed"


@final
@dataclass(frozen=True)
class _Description:
    """links and joints of the checked URDF by name, in its order."""

    links: dict[str, Element]
    joints: dict[str, _UrdfJoint]
    file: str

    @classmethod
    def of(cls, robot: Element, file: str) -> _Description:
        links = {link.get("name", ""): link for link in robot.findall("link")}
        joints = {}
        for element in robot.findall("joint"):
            parent, child = element.find("parent"), element.find("child")
            assert parent is not None
            assert child is not None
            name = element.get("name", "")
            joints[name] = _UrdfJoint(name, element.get("type", ""), parent.get("link", ""), child.get("link", ""),
                                      element.find("mimic") is not None, element)  # fmt: skip
        return cls(links, joints, file)

    def check_names(self, joints: Sequence[str], base_link: str, cut_frames: Sequence[str]) -> None:
        """Every name exists and is of the right kind."""
        faults = []
        for name in dict.fromkeys(joints):
            joint = self.joints.get(name)
            if joint is None:
                faults.append(self._unknown("joint", name, [j.name for j in self.joints.values() if j.movable]))
            elif joint.kind not in MOVING_TYPES:
                faults.append(Fault(f"joint {name!r} is {joint.kind}", "joint_not_actuated",
                                    "Take it off the list of actuated joints", self.file, value=name))  # fmt: skip
            elif joint.mimics:
                faults.append(Fault(f"joint {name!r} mimics another", "joint_mimics",
                                    "Leave it out: it is then held at zero", self.file, value=name))  # fmt: skip
            if list(joints).count(name) > 1:
                faults.append(Fault(f"joint {name!r} is listed twice", "joint_twice", file=self.file, value=name))
        if base_link not in self.links:
            faults.append(self._unknown("base_link", base_link, self.links))
        fixed = [joint.name for joint in self.joints.values() if not joint.movable]
        for name in cut_frames:
            if name not in self.links and name not in fixed:
                faults.append(self._unknown("frame", name, [*self.links, *fixed]))
        if faults:
            raise BadRobot(faults)

    def _unknown(self, kind: str, name: str, known: Iterable[str]) -> Fault:
        close = get_close_matches(name, list(known), n=1)
        advice = f"Did you mean {close[0]!r}?" if close else f"The URDF has no such {kind}"
        return Fault(f"{kind} {name!r} is not in the URDF", f"{kind}_unknown", advice, self.file, value=name[:80])

    def beyond(self, frame: str, base_link: str, moving: set[str]) -> set[str]:
        """Links cut off from base_link at the frame. A moving joint among them is refused."""
        neighbours: dict[str, list[tuple[str, str]]] = {link: [] for link in self.links}
        for joint in self.joints.values():
            neighbours[joint.parent].append((joint.child, joint.name))
            neighbours[joint.child].append((joint.parent, joint.name))
        order, toward = [base_link], {base_link: ("", "")}
        for link in order:
            for other, name in neighbours[link]:
                if other not in toward:
                    toward[other] = (link, name)
                    order.append(other)
        if frame in self.links:
            cut = {frame}
        else:
            joint = self.joints[frame]
            cut = {joint.child if toward[joint.child][1] == frame else joint.parent}
        beyond = set() if frame in self.links else set(cut)
        for link in order:
            before, name = toward[link]
            if before in cut or before in beyond:
                if name in moving:
                    raise BadRobot(Fault(f"joint {name!r} lies beyond the contact sensor at {frame!r}",
                                         "joint_beyond_cut", "The robot must end at a contact sensor: use role cut, "
                                         "or take the joint off the list", self.file, value=frame))  # fmt: skip
                beyond.add(link)
        return beyond

    @property
    def root(self) -> str:
        children = {joint.child for joint in self.joints.values()}
        return next(link for link in self.links if link not in children)

    def carried(self, frame: str, near: str, moving: set[str]) -> tuple[list[str], list[str]]:
        """Links rigidly beyond a sensor's frame, seen from the link `near`, and moving joints that hang on it or them.

        A sensor that nothing hangs on carries its own link; without mass and fixed to `near` it stands under the robot
        and carries all of it.
        """
        neighbours: dict[str, list[tuple[str, _UrdfJoint]]] = {link: [] for link in self.links}
        for joint in self.joints.values():
            neighbours[joint.parent].append((joint.child, joint))
            neighbours[joint.child].append((joint.parent, joint))

        def outward(start: str, seen: set[str]) -> tuple[list[str], list[str]]:
            links, joints, stack = list[str](), list[str](), [start]
            while stack:
                for other, joint in neighbours[stack.pop(0)]:
                    if other in seen:
                        continue
                    seen.add(other)
                    if joint.name in moving:
                        joints.append(joint.name)
                    else:
                        links.append(other)
                        stack.append(other)
            return links, joints

        toward = self._toward(near)
        if frame not in self.links:
            joint = self.joints[frame]
            far = joint.child if toward.get(joint.child) == joint.parent else joint.parent
            links, joints = outward(far, {far, toward[far]})
            return [far, *links], joints
        before = {toward[frame]} if frame in toward else set()
        links, joints = outward(frame, {frame, *before})
        if joints or any(self.has_mass(link) for link in links):
            return links, joints
        at_base = outward(near, {near})[0]
        if not self.has_mass(frame) and (frame == near or frame in at_base):
            links, joints = outward(frame, {frame})
            return [link for link in links if self.has_mass(link)], joints
        return [frame, *links], []

    def _toward(self, near: str) -> dict[str, str]:
        """Link -> the next one on the way to `near`."""
        toward, order = dict[str, str](), [near]
        for link in order:
            for joint in self.joints.values():
                for a, b in ((joint.parent, joint.child), (joint.child, joint.parent)):
                    if a == link and b != near and b not in toward:
                        toward[b] = a
                        order.append(b)
        return toward

    def has_mass(self, link: str) -> bool:
        inertial = self.links[link].find("inertial")
        return inertial is not None and _attribute(inertial, "mass", "value") not in ([], [0.0])

    def reduced(self, moving: set[str], dropped: set[str], *, own_names: bool = False) -> str:
        """The URDF anew, with nothing but masses and moving or fixed joints: links l0, l1 … and joints j0, j1 …, or
        under their own names, which pinocchio takes unless a link is called as a joint is."""
        robot = Element("robot", name="robot")
        links = {name: name if own_names else f"l{i}" for i, name in enumerate(self.links)}
        for name, link in self.links.items():
            copy = SubElement(robot, "link", name=links[name])
            inertial = link.find("inertial")
            if inertial is None or name in dropped or _attribute(inertial, "mass", "value") == [0.0]:
                continue
            body = SubElement(copy, "inertial")
            _copy(inertial, body, "origin", "xyz", "rpy")
            _copy(inertial, body, "mass", "value")
            _copy(inertial, body, "inertia", *INERTIA_NAMES)
        for i, (joint, ends) in enumerate(zip(self.joints.values(), self.limits(self.joints), strict=True)):
            kind = "fixed" if joint.name not in moving else "prismatic" if joint.kind == "prismatic" else "revolute"
            copy = SubElement(robot, "joint", name=joint.name if own_names else f"j{i}", type=kind)
            SubElement(copy, "parent", link=links[joint.parent])
            SubElement(copy, "child", link=links[joint.child])
            _copy(joint.element, copy, "origin", "xyz", "rpy")
            if kind != "fixed":
                _copy(joint.element, copy, "axis", "xyz")
                endless = 1e9  # rad, m: for a parser, of a joint without ends
                low, high = (str(min(max(end, -endless), endless)) for end in ends[:2])
                SubElement(copy, "limit", lower=low, upper=high, effort="1", velocity="1")
        return tostring(robot, encoding="unicode")

    def limits(self, names: Iterable[str]) -> Iterator[tuple[float, float, float, float]]:
        """lower, upper, velocity, effort; infinite where missing, zero or upside down."""
        for name in names:
            joint = self.joints[name]
            low, high, velocity, effort = (
                next(iter(_attribute(joint.element, "limit", key)), 0.0)
                for key in ("lower", "upper", "velocity", "effort")
            )
            if joint.kind == "continuous" or low >= high:
                low, high = -math.inf, math.inf
            yield low, high, velocity if velocity > 0 else math.inf, effort if effort > 0 else math.inf


def _attribute(parent: Element, tag: str, name: str) -> list[float]:
    element = parent.find(tag)
    return numbers(element.get(name, "")) if element is not None else []


def _copy(source: Element, target: Element, tag: str, *names: str) -> None:
    found = {name: _attribute(source, tag, name) for name in names}
    if any(found.values()):
        SubElement(target, tag, {name: " ".join(map(repr, values)) for name, values in found.items() if values})


def _rooted(
    model: pin.Model,
    described: _Description,
    links: list[str],
    joints: tuple[str, ...],
    base_link: str,
    floating: bool,
    dropped: tuple[str, ...],
) -> RigidTree:
    """Walk pinocchio's tree from the base link outwards, against the joints where need be.

    Pinocchio's joint 1 is the free-flyer of the URDF's root. A joint u met from its child's side is turned round:
    T_u_parent(q) = motion(-axis_u, q) · T_parent_u⁻¹.
    """
    identity = pin.SE3.Identity()
    names = list(described.joints)
    moved_by = {i: names[int(model.names[i][1:])] for i in range(2, model.njoints)}
    place = {links[int(f.name[1:])]: (f.parentJoint, f.placement) for f in model.frames if f.type == pin.FrameType.BODY}
    for joint in described.joints.values():
        if not joint.movable:
            place.setdefault(joint.name, place[joint.child])
    root, T_root_base = place[base_link]
    T_base_root = T_root_base.inverse()
    if not floating and root != 1:
        detail, advice = f"joint {moved_by[root]!r} moves base_link {base_link!r}", "A fixed base must stand still"
        raise BadRobot(Fault(detail, "base_link_moves", advice, described.file, value=base_link))

    order: list[int] = []
    parent, edge = {root: -1}, {root: -1}
    stack = [root]
    while stack:  # depth first, so that subtrees are contiguous
        u = stack.pop()
        order.append(u)
        near = [i for i in range(2, model.njoints) if model.parents[i] == u] + ([model.parents[u]] if u > 1 else [])
        for v in reversed([v for v in near if v not in parent]):
            parent[v], edge[v] = u, v if model.parents[v] == u else u
            stack.append(v)
    if not floating:
        order.remove(root)
    body = {u: i for i, u in enumerate(order)} | ({} if floating else {root: -1})

    axis, prismatic, before, after, phi = [], [], [], [], []
    for u in order:
        inertia = model.inertias[u]
        phi.append((T_base_root.act(inertia) if u == root else inertia).toDynamicParameters())
        T_before = T_base_root if parent[u] == root else identity
        if u == root:
            axis.append(np.zeros(3))
            prismatic.append(False)
            before.append(identity)
            after.append(identity)
            continue
        j = edge[u]
        S = np.asarray(model.joints[j].createData().S).ravel()
        prismatic.append(bool(np.linalg.norm(S[:3]) > 0.5))
        direction = S[:3] if prismatic[-1] else S[3:]
        forward = j == u
        axis.append((1.0 if forward else -1.0) * direction / np.linalg.norm(direction) + 0.0)
        placement = model.jointPlacements[j]
        before.append(T_before * placement if forward else T_before)
        after.append(identity if forward else placement.inverse())
    moved_link = {u: described.joints[name].child for u, name in moved_by.items()}
    root_link = described.root
    limits = np.array(list(described.limits(joints))).reshape(-1, 4)
    return RigidTree(
        bodies=tuple(base_link if u == root else moved_link.get(u, root_link) for u in order),
        joints=joints,
        floating=floating,
        parent=np.array([body[parent[u]] if u != root else -1 for u in order], dtype=np.intp),
        dof=np.array([joints.index(moved_by[edge[u]]) if u != root else -1 for u in order], dtype=np.intp),
        axis=np.array(axis).reshape(-1, 3),
        prismatic=np.array(prismatic, dtype=np.bool_),
        T_before=tuple(before),
        T_after=tuple(after),
        phi=np.array(phi).reshape(-1, 10),
        frames={name: (body[u], T_base_root * T if u == root else T) for name, (u, T) in place.items()},
        lower=limits[:, 0],
        upper=limits[:, 1],
        velocity_limit=limits[:, 2],
        effort_limit=limits[:, 3],
        locked=tuple(j.name for j in described.joints.values() if j.movable and j.name not in joints),
        dropped=dropped,
    )
