"""From the motor side of the gears to the joint side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from exogauge.errors import BadLog, Fault
from exogauge.logs.model import Array


def joint_side(
    channels: Mapping[str, Array],
    motor_side: Mapping[str, float],
    joints: Sequence[str],
    motor_from_joint: Array | None,
) -> dict[str, Array]:
    """All channels joint-side. motor_side: channel -> offset [SI] to add on the joint side.

    With M = motor_from_joint (J, J), motor angle = M @ joint angle: q = M^-1 q_motor (also rates), tau = M.T tau_motor.
    A current keeps its amperes; it is counted positive where it drives its own joint forward (sign of M's diagonal).
    A motor named like a joint is the one of the same row.
    """
    result = dict(channels)
    if not motor_side:
        return result
    M = _checked(motor_from_joint, len(joints))
    for kind in ("q", "dq", "ddq", "tau", "i"):
        names = [f"{kind}.{joint}" for joint in joints]
        given = [k for k, name in enumerate(names) if name in motor_side]
        if not given:
            continue
        A = {"tau": M.T, "i": np.diag(np.sign(np.diag(M)))}.get(kind)
        A = np.linalg.inv(M) if A is None else A
        A = np.where(np.abs(A) > 1e-12 * np.abs(A).max(), A, 0.0)
        values = np.stack([channels[names[k]] for k in given])
        for k in given:
            missing = [joints[j] for j in np.flatnonzero(A[k]).tolist() if j not in given]
            if missing:
                detail = f"its joint is coupled with {', '.join(missing)}, whose motor-side values are not mapped"
                raise BadLog(Fault(detail, "coupling_incomplete", "Map all motors of the coupling.", column=names[k]))
            result[names[k]] = A[k, given] @ values + motor_side[names[k]]
    return result


def _checked(motor_from_joint: Array | None, size: int) -> Array:
    rule = "no_transmission"
    if motor_from_joint is None:
        detail = "the mapping reads motor-side values, the robot has no gear ratios"
        raise BadLog(Fault(detail, rule, "Give `gear_ratio` per joint, or `transmission`, in robot.yaml."))
    M = np.asarray(motor_from_joint, np.float64)
    if M.shape != (size, size) or not np.isfinite(M).all() or not np.diag(M).all() or np.linalg.cond(M) > 1e12:
        raise BadLog(Fault(f"motor_from_joint must be an invertible {size} x {size} matrix", rule, ""))
    return M
