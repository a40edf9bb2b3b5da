"""How much of what each axis moves is steady motion, which alone gives rows to fit and errors to judge by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import Identifying
from exogauge.identification.preparation import Prepared
from exogauge.identification.result import SteadyShare

Array = NDArray[np.float64]


def steady_shares(
    joints: Sequence[str], fitted: Sequence[Prepared], held_out: Sequence[Prepared]
) -> tuple[SteadyShare, ...]:
    """One entry per joint."""
    own, others = _seconds(fitted, len(joints)), _seconds(held_out, len(joints))
    return tuple(
        SteadyShare(
            joint,
            fitted_s=float(own[1, :, a].sum()),
            fitted_of_s=float(own[0, :, a].sum()),
            held_out_s=float(others[1, :, a].sum()),
            held_out_of_s=float(others[0, :, a].sum()),
            both_directions=bool((own[1, :, a] > 0.0).all() or (own[0, :, a] == 0.0).any()),
        )
        for a, joint in enumerate(joints)
    )


def steady_warnings(shares: Sequence[SteadyShare], criteria: Identifying) -> list[str]:
    """Joints of which little motion is left to fit, and those that are left one direction."""
    moved = [each for each in shares if each.fitted_of_s >= criteria.moved_s]
    little = [each for each in moved if each.fitted_s < criteria.enough_steady * each.fitted_of_s]
    warnings = []
    if little:
        said = ", ".join(f"{each.joint} ({each.fitted_s:.1f} of {each.fitted_of_s:.1f} s)" for each in little)
        warnings.append(
            f"Of what these joints move, less than a quarter is steady motion, which alone is fitted: {said}. Record "
            "longer moves in one direction, or raise cutoff_hz: less is left out around every turn then."
        )
    one_way = [each.joint for each in moved if not each.both_directions]
    if one_way:
        warnings.append(
            f"Steady in one direction only: {', '.join(one_way)}. Coulomb friction and offset look alike there."
        )
    return warnings


def creeping_warnings(creeping: Mapping[str, float]) -> list[str]:
    """creeping: as `Settings.creeping`."""
    if not creeping:
        return []
    said = ", ".join(f"{joint} (below {speed:.2g} rad/s)" for joint, speed in creeping.items())
    return [
        f"Friction turns round over a span of speeds, not at once, while these joints creep: {said}. What they do "
        "there is not taken for steady motion: it is neither fitted nor judged."
    ]


def keeps_most(log: Prepared, criteria: Identifying) -> bool:
    """Whether what is left out around turns takes neither most of the axes' motion nor one direction of any axis."""
    moving, steady = _counts(log)
    counted = moving > criteria.hardly * log.log.samples
    if not counted.any():
        return True
    pooled = float(steady[counted].sum() / moving[counted].sum())
    return pooled >= criteria.most_steady and bool(np.all(steady[counted] >= criteria.least_steady * moving[counted]))


def _seconds(logs: Sequence[Prepared], axes: int) -> Array:
    """(2, 2, A) over all logs together."""
    return np.asarray(np.sum([np.zeros((2, 2, axes)), *(_counts(log) / log.log.rate_hz for log in logs)], axis=0))


def _counts(log: Prepared) -> Array:
    """(2, 2, A) samples: moving and of these steady, backwards and forwards. The log's unsettled ends count as moving:
    what is lost there is lost to the fit."""
    signs = np.stack([log.raw_direction < 0.0, log.raw_direction > 0.0])
    steady = log.steady & log.settled[:, None]
    return np.array([signs.sum(axis=1), (signs & steady).sum(axis=1)], dtype=np.float64)
