"""A link that nothing hangs on, as a place for effects: what a change of its mass does to every row that carries it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.link import LinkSignals
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import Seen
from exogauge.robots.cut_rows import in_sensor
from exogauge.robots.ends import carries_nothing
from exogauge.robots.kinematics import Kinematics, subtree
from exogauge.robots.row_blocks import mass_columns
from exogauge.robots.tree import RigidTree

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LinkSite:
    """body: of the tree."""

    body: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "link", equations.robot.tree.bodies[self.body], ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        """Base rows, axes on the way to the base, sensors that carry it."""
        robot = equations.robot
        above = subtree(robot.tree)[:, self.body] & (robot.tree.dof >= 0)
        acts = robot.axes_from_joints[:, robot.tree.dof[above]] != 0.0
        axes = [
            equations.first_axis + axis
            for axis, joint in enumerate(robot.joints)
            if acts[axis].any() and joint.actuation != "none"
        ]
        cuts = [
            equations.first_cut + 6 * index + row
            for index, sensor in enumerate(robot.cuts)
            if self.body in robot.tree.cuts[sensor.frame]
            for row in range(6)
        ]
        return (*range(equations.first_axis), *axes, *cuts)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        number = model.order.get(prepared.log.name, -1)
        time = prepared.log.time - prepared.log.time[0]
        signals = LinkSignals(time, number, carries_nothing(model.robot.tree, self.body))
        rows: list[Array] = []

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            if not rows:
                rows.append(self._rows(model.equations, prepared))
            return np.asarray(-effect.present(signals, shape) * rows[0])

        return Seen(signals, columns)

    def _rows(self, equations: Equations, prepared: Prepared) -> Array:
        """(T, 4, kinds) Y φ per kg and kg·m of this link."""
        robot, tree, motion = equations.robot, equations.robot.tree, prepared.motion
        sweep = Kinematics(tree).sweep(motion)
        wrench = mass_columns(4 * self.body + np.arange(4), sweep)  # (6, 4, T)
        every = np.zeros((equations.kinds, 4, motion.samples))
        every[: equations.first_axis] = wrench[: equations.first_axis]
        above = np.flatnonzero(subtree(tree)[:, self.body] & (tree.dof >= 0))
        joints = np.zeros((len(robot.joints), 4, motion.samples))
        joints[tree.dof[above]] = np.einsum("bct,ckt->bkt", sweep.S[above], wrench)
        axes = slice(equations.first_axis, equations.first_axis + len(robot.joints))
        every[axes] = np.einsum("aj,jkt->akt", np.linalg.inv(robot.axes_from_joints).T, joints)
        for index, sensor in enumerate(robot.cuts):
            first = equations.first_cut + 6 * index
            every[first : first + 6] = in_sensor(tree, sensor.frame, sweep, wrench)
        rows: Array = np.ascontiguousarray(every[list(self.kinds(equations))].transpose(2, 1, 0))
        return rows

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def end_links(equations: Equations) -> list[LinkSite]:
    """Bodies that carry nothing and move, or hang behind a sensor."""
    tree = equations.robot.tree
    behind = {tree.bodies.index(name) for name in tree.parts}
    return [
        LinkSite(body)
        for body in range(len(tree.bodies))
        if carries_nothing(tree, body) and (tree.dof[body] >= 0 or body in behind) and not _finger(tree, body)
    ]


def _finger(tree: RigidTree, body: int) -> bool:
    """Whether it is what hardly weighs on a link that carries nothing else."""
    parent = int(tree.parent[body])
    return parent >= 0 and carries_nothing(tree, parent)
