"""A link that nothing hangs on, as a place for effects: what a change of its mass does to every row that carries it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.link import LinkSignals
from exogauge.identification.equations import Equations
from exogauge.identification.load_columns import kinds_of_body
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import Seen
from exogauge.robots.ends import carries_nothing, takes_payload
from exogauge.robots.motion import Motion
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
        return kinds_of_body(equations.robot, self.body)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        number = model.order.get(prepared.log.name, -1)
        time = prepared.log.time - prepared.log.time[0]
        signals = LinkSignals(time, number, carries_nothing(model.robot.tree, self.body))
        rows: list[Array] = []

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            present = effect.present(signals, shape)
            if not present:
                return np.zeros((prepared.log.samples, 4, len(self.kinds(model.equations))))
            if not rows:
                rows.append(self._rows(model.equations, prepared.motion))
            return np.asarray(-present * rows[0])

        return Seen(signals, columns)

    def _rows(self, equations: Equations, motion: Motion) -> Array:
        """(T, 4, kinds) Y φ per kg and kg·m of this link."""
        per_unit = equations.base.regroup[:, 10 * self.body : 10 * self.body + 4]
        rows = equations.of_told(motion, per_unit)[:, equations.layout.in_told(self.kinds(equations))]
        return np.ascontiguousarray(rows.transpose(0, 2, 1))

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def end_links(equations: Equations) -> list[LinkSite]:
    """Bodies that carry nothing and move, or hang behind a sensor."""
    tree = equations.robot.tree
    behind = {tree.bodies.index(name) for name in tree.parts}
    return [
        LinkSite(body)
        for body in range(len(tree.bodies))
        if takes_payload(equations.robot, body) and (tree.dof[body] >= 0 or body in behind) and not _finger(tree, body)
    ]


def _finger(tree: RigidTree, body: int) -> bool:
    """Whether it is what hardly weighs on a link that carries nothing else."""
    parent = int(tree.parent[body])
    return parent >= 0 and carries_nothing(tree, parent)
