"""What of a robot may touch what: pairs of shapes, their distances over a motion, and how these change."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import APART_M
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

FLOOR = "floor"


@final
@dataclass(frozen=True)
class Near:
    """B moments at which a pair is near: sample (B,), none before another, and pair (B,) indices; distance (B,) [m],
    negative inside each other."""

    sample: IntArray
    pair: IntArray
    distance: Array


def hulls_alone(robot: MotionRobot, pairs: Iterable[tuple[str, str]], clearance: float) -> dict[tuple[str, str], float]:
    """Of pairs of links those that are nearer than `clearance` [m] at home as convex hulls alone: how far the surfaces
    of their meshes are apart there [m]."""
    assert robot.home is not None
    data, request = robot.model.createData(), coal.DistanceRequest()
    pin.forwardKinematics(robot.model, data, robot.home)
    solids = dict[str, list[tuple[coal.CollisionGeometry, coal.Transform3s]]]()
    meshes = {shape.link for shape in robot.shapes if shape.mesh is not None}

    def placed(link: str) -> list[tuple[coal.CollisionGeometry, coal.Transform3s]]:
        if link not in solids:
            at = pin.updateFramePlacement(robot.model, data, robot.frame(link))
            poses = [(shape, at * shape.at) for shape in robot.shapes if shape.link == link]
            solids[link] = [(each.surface(), coal.Transform3s(pose.rotation, pose.translation)) for each, pose in poses]
        return solids[link]

    found = dict[tuple[str, str], float]()
    for one, other in pairs:
        if not {one, other} & meshes or FLOOR in (one, other):
            continue
        apart = min(coal.distance(*a, *b, request, coal.DistanceResult()) for a in placed(one) for b in placed(other))
        if apart >= clearance:
            found[one, other] = float(apart)
    return found


@final
class Pairs:
    """Shapes of a robot, and the floor where its base floats, two by two.

    names: (P,) links of each pair; at_home: (P,) [m] how far apart they are there, inf where far. left_out: pairs of
    which no distance is asked, as links: those that the robot file names, and those that are nearer than `clearance`
    [m] at home, which touch by construction. What one joint or none lies between is in neither.
    """

    def __init__(self, robot: MotionRobot, clearance: float) -> None:
        model = self.model = robot.model
        self.data = model.createData()
        geometry = self.geometry = pin.GeometryModel()
        links = list[str]()
        if robot.floating and robot.shapes:
            floor = coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
            geometry.addGeometryObject(pin.GeometryObject(FLOOR, 0, 0, pin.SE3.Identity(), floor))
            links.append(FLOOR)
        for k, shape in enumerate(robot.shapes):
            index = robot.frame(shape.link)
            frame = model.frames[index]
            made = pin.GeometryObject(f"{shape.link} {k}", frame.parentJoint, index, frame.placement * shape.at,
                                      shape.solid())  # fmt: skip
            geometry.addGeometryObject(made)
            links.append(shape.link)
        soles = {sole.link for sole in robot.soles}
        ignored = {frozenset(pair) for pair in robot.ignored}
        objects, parents = geometry.geometryObjects, list(model.parents)
        left_out, asked = list[tuple[str, str]](), list[tuple[int, int]]()
        for i in range(len(links)):
            for j in range(i + 1, len(links)):
                one, other = objects[i].parentJoint, objects[j].parentJoint
                joined = one == other or (links[i] != FLOOR and (parents[other] == one or parents[one] == other))
                if joined or (links[i] == FLOOR and self._carried_by(other, robot, soles)):
                    continue
                if frozenset((links[i], links[j])) in ignored:
                    left_out.append((links[i], links[j]))
                else:
                    asked.append((i, j))
        for i, j in asked:
            geometry.addCollisionPair(pin.CollisionPair(i, j))
        self._start()
        self.at_home = np.full(len(asked), np.inf)
        if asked and robot.home is not None:
            at_home = self.near(robot.home[None], APART_M)
            self.at_home[at_home.pair] = at_home.distance
            touching = set(np.flatnonzero(self.at_home < clearance).tolist())
            self.at_home = self.at_home[self.at_home >= clearance]
            left_out += [(links[i], links[j]) for k, (i, j) in enumerate(asked) if k in touching]
            geometry.removeAllCollisionPairs()
            asked = [pair for k, pair in enumerate(asked) if k not in touching]
            for i, j in asked:
                geometry.addCollisionPair(pin.CollisionPair(i, j))
            self._start()
        self.names = tuple((links[i], links[j]) for i, j in asked)
        self.left_out = tuple(dict.fromkeys(left_out))

    @staticmethod
    def _carried_by(joint: int, robot: MotionRobot, soles: set[str]) -> bool:
        return any(robot.model.frames[robot.frame(link)].parentJoint == joint for link in soles)

    def _start(self) -> None:
        self.found = pin.GeometryData(self.geometry)
        for request in self.found.distanceRequests:
            request.enable_signed_distance = True
        model, joints = self.model, [shape.parentJoint for shape in self.geometry.geometryObjects]
        pairs = [(pair.first, pair.second) for pair in self.geometry.collisionPairs]
        self.levers = np.stack([self._lever(i, j) for i, j in pairs]) if pairs else np.zeros((0, model.nq))
        self._apart, self._where = np.full(len(pairs), -np.inf), np.zeros(self.levers.shape)  # when last looked at
        self._joints = np.array([(joints[i], joints[j]) for i, j in pairs], dtype=np.intp).reshape(-1, 2)
        self._moves = np.zeros((model.njoints, model.nq))
        for k in range(1, model.njoints):
            self._moves[k, [model.joints[each].idx_q for each in list(model.supports[k])[1:]]] = 1.0

    def _lever(self, i: int, j: int) -> Array:
        """(n,) [m/rad or m/m] by which a joint changes the pair's distance at most."""
        model, out = self.model, np.zeros(self.model.nq)
        supports = [list(model.supports[self.geometry.geometryObjects[k].parentJoint]) for k in (i, j)]
        for k, own, others in ((i, supports[0], supports[1]), (j, supports[1], supports[0])):
            shape = self.geometry.geometryObjects[k]
            if shape.parentJoint == 0:
                continue  # the floor, without end
            shape.geometry.computeLocalAABB()
            far = float(np.linalg.norm(shape.placement.act(shape.geometry.aabb_center))) + shape.geometry.aabb_radius
            for joint in reversed([each for each in own if each not in others]):
                column = model.joints[joint].idx_q
                slides = "P" in model.joints[joint].shortname()
                out[column] = 1.0 if slides else far
                far += float(np.linalg.norm(model.jointPlacements[joint].translation))
                if slides:
                    ends = model.lowerPositionLimit[column], model.upperPositionLimit[column]
                    far += float(np.abs(ends).max())
        return out

    def near(self, q: Array, within: float) -> Near:
        """Pairs nearer than `within` [m] in postures q (T, n), all of them: a pair is looked at again no later than
        the levers of its joints let it come so near, since the sample before or the call before."""
        P, block = len(self.levers), 2000  # samples whose ways are held at once
        samples, found, distances = list[int](), list[int](), list[float]()
        for start in range(0, len(q) if P else 0, block):
            part = q[start : start + block]
            steps = np.abs(np.diff(part, axis=0, prepend=part[:1]))
            way = np.cumsum(self.levers @ steps.T, axis=1)  # (P, B) [m]
            spare = self._apart - within - np.sum(self.levers * np.abs(part[0] - self._where), axis=1)
            due = [list[int]() for _ in range(len(part) + 1)]
            due[0] = np.flatnonzero(spare <= 0.0).tolist()
            for p in np.flatnonzero((spare > 0.0) & (way[:, -1] > spare)).tolist():
                due[int(way[p].searchsorted(spare[p], side="right"))].append(p)
            last = np.full(P, -1)
            for t, pairs in enumerate(due[:-1]):
                if not pairs:
                    continue
                pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.found, part[t])
                for p in pairs:
                    distance = self._apart[p] = pin.computeDistance(self.geometry, self.found, p).min_distance
                    last[p] = t
                    if distance < within:
                        due[t + 1].append(p)
                        samples.append(start + t)
                        found.append(p)
                        distances.append(distance)
                    elif t + 1 < len(part):
                        far = int(way[p].searchsorted(way[p, t] + distance - within, side="right"))
                        due[max(far, t + 1)].append(p)
            self._where[last >= 0] = part[last[last >= 0]]
        return Near(np.array(samples, np.intp), np.array(found, np.intp), np.array(distances, np.float64))

    def where(self, q: Array, near: Near) -> Array:
        """(B, 3, 3) [m] points of the first of each pair and of the second where they are nearest, and the normal from
        the first to the second."""
        out = np.empty((len(near.sample), 3, 3))
        results, now = self.found.distanceResults, -1
        for row, t, p in zip(out, near.sample.tolist(), near.pair.tolist(), strict=True):
            if t != now:
                now = t
                pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.found, q[t])
            pin.computeDistance(self.geometry, self.found, p)
            found = results[p]
            row[0], row[1], row[2] = found.getNearestPoint1(), found.getNearestPoint2(), found.normal
        return out

    def slopes(self, q: Array, near: Near) -> Array:
        """(B, n) of the distances by the coordinates."""
        out = np.zeros((len(near.sample), self.model.nq))
        first, second, normal = np.moveaxis(self.where(q, near), 1, 0)
        pushes = [np.concatenate([normal, np.cross(point, normal)], axis=1) for point in (first, second)]
        samples, begins = np.unique(near.sample, return_index=True)
        for t, begin, end in zip(samples, begins, np.append(begins, len(out))[1:], strict=True):
            rows = slice(begin, end)
            J = pin.computeJointJacobians(self.model, self.data, q[t])
            for side, sign in enumerate((-1.0, 1.0)):
                out[rows] += sign * (pushes[side][rows] @ J) * self._moves[self._joints[near.pair[rows], side]]
        return out
