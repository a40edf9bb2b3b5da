"""How much of what each axis moves is steady motion, which alone gives rows to fit and errors to judge by."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import Identifying
from exogauge.identification.preparation import Prepared
from exogauge.identification.result import SteadyShare
from exogauge.remarks import About, Remark

Array = NDArray[np.float64]


def steady_shares(joints: Sequence[str], fitted: Sequence[Array], held_out: Sequence[Array]) -> tuple[SteadyShare, ...]:
    """One entry per joint. fitted, held_out: `seconds` of every log."""
    nothing = np.zeros((2, 2, len(joints)))
    own, others = (np.sum([nothing, *logs], axis=0) for logs in (fitted, held_out))
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


def remarks_on_steady(shares: Sequence[SteadyShare], criteria: Identifying) -> list[Remark]:
    """Joints of which little motion is left to fit, and those that are left one direction."""
    moved = [each for each in shares if each.fitted_of_s >= criteria.moved_s]
    little = [each for each in moved if each.fitted_s < criteria.enough_steady * each.fitted_of_s]
    remarks = []
    if little:
        seconds = tuple((each.fitted_s, each.fitted_of_s) for each in little)
        asked = (criteria.enough_steady,)
        remarks.append(Remark(About.LITTLE_STEADY, tuple(each.joint for each in little), seconds, numbers=asked))
    one_way = tuple(each.joint for each in moved if not each.both_directions)
    return [*remarks, Remark(About.ONE_DIRECTION, one_way)] if one_way else remarks


def remarks_on_creeping(creeping: Mapping[str, float], sliding: Collection[str]) -> list[Remark]:
    """creeping: as `Settings.creeping`. sliding: joints whose speed is in m/s."""
    speeds = tuple((speed,) for speed in creeping.values())
    units = tuple("m/s" if joint in sliding else "rad/s" for joint in creeping)
    return [Remark(About.CREEPING, tuple(creeping), speeds, units)] if creeping else []


def keeps_most(log: Prepared, criteria: Identifying) -> bool:
    """Whether what is left out around turns takes neither most of the axes' motion nor one direction of any axis."""
    moving, steady = _counts(log)
    counted = moving > criteria.hardly * log.log.samples
    if not counted.any():
        return True
    pooled = float(steady[counted].sum() / moving[counted].sum())
    return pooled >= criteria.most_steady and bool(np.all(steady[counted] >= criteria.least_steady * moving[counted]))


def seconds(log: Prepared) -> Array:
    """(2, 2, A) [s] moving and of this steady, backwards and forwards."""
    return _counts(log) / log.log.rate_hz


def _counts(log: Prepared) -> Array:
    """(2, 2, A) samples: moving and of these steady, backwards and forwards. The log's unsettled ends count as moving:
    what is lost there is lost to the fit."""
    signs = np.stack([log.raw_direction < 0.0, log.raw_direction > 0.0])
    steady = log.steady & log.settled[:, None]
    return np.array([signs.sum(axis=1), (signs & steady).sum(axis=1)], dtype=np.float64)
