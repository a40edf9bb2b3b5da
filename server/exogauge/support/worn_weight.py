"""What a device, or what else is carried with it, weighs: by the feet, which no motor and no band is in the balance of.

    m = -Σ r·a / Σ a·a

of each log; r: (n, 3) [N] what the identified robot leaves of the sum of all forces on it, a: (n, 3) [m/s²] proper
acceleration of the base. Held against the same of logs without the device, so that what the model misses cancels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exogauge.identification.disturbances import zeros_in_doubt
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import of_x
from exogauge.identification.preparation import Prepared
from exogauge.logs.units import STANDARD_GRAVITY
from exogauge.remarks import About, Remark
from exogauge.side_by_side import each as side_by_side
from exogauge.support.balance import prepare_worn
from exogauge.support.settings import PlainLog, WornLog

FORCE = slice(0, 3)  # of the base rows


def notes_on_weight(model: RobotModel, plain: Sequence[PlainLog], worn: Sequence[WornLog]) -> list[Remark]:
    """One for each device with which the feet bear surely more, or less, than without.

    Doubt: of one log the zeros of all feet together, as they are declared, or as logs of one kind scatter.
    """
    robot = model.robot
    bare = [each for each in plain if each.held_out] or list(plain)
    if not robot.floating or not robot.contacts or not bare or not worn:
        return []
    without = np.array([*side_by_side(lambda each: _excess(model, model.prepare(each.log)), bare)])
    with_it = np.array([*side_by_side(lambda each: _excess(model, prepare_worn(model, each.log)), worn)])
    zero = float(np.linalg.norm(zeros_in_doubt(robot).reshape(-1, 6)[:, 2])) / STANDARD_GRAVITY
    found = list[Remark]()
    for name in dict.fromkeys(each.device.name for each in worn):
        own = with_it[[each.device.name == name for each in worn]]
        groups = [each - each.mean() for each in (own, without)]
        free = sum(len(each) - 1 for each in groups)
        scatter = np.sqrt(sum(float(each @ each) for each in groups) / free) if free else 0.0
        more, std = own.mean() - without.mean(), max(zero, scatter) * np.sqrt(1.0 / len(own) + 1.0 / len(without))
        if abs(more) > model.criteria.identifying.feet_against_mass * std:
            found.append(Remark(About.WORN_WEIGHT, beside=(name,), numbers=(float(more), float(std))))
    return found


def _excess(model: RobotModel, prepared: Prepared) -> float:
    """[kg] that the feet bear beyond the robot that was identified."""
    equations, rows = model.equations, model.equations.layout.base
    kept = prepared.kept[~prepared.left_out[prepared.kept]]
    asked = equations.asked(prepared, (), prepared.added, of_x(equations, [model.identified]), rows)[0].T
    r = (asked - equations.outside(prepared)[:, rows])[kept, FORCE]
    a = prepared.motion.acc[kept]
    return -float(np.sum(r * a)) / float(np.sum(a * a))
