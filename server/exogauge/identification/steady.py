"""How much of what each axis moves is steady motion, which alone gives rows to fit and errors to judge by."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.identifying import Identifying
from exogauge.identification.preparation import Prepared
from exogauge.identification.result import SteadyShare
from exogauge.identification.turns import way_of_axes, way_since_turn
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

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


def hardly_sliding(robot: Robot, fitted: Sequence[Prepared], criteria: Criteria) -> Mapping[str, float]:
    """Joints -> share of their steady motion in which they have gone on far enough since their last turn to slide.

    Before, friction is a gear that gives way: its parameters, and what is told from it, are of another law.
    """
    steady, slid = np.zeros(len(robot.joints)), np.zeros(len(robot.joints))
    for log in fitted:
        way = way_of_axes(robot, way_since_turn(log.motion.q, log.motion.dq))
        far = log.steady & (way >= criteria.comparison.slides)
        steady, slid = steady + log.steady.sum(axis=0) / log.log.rate_hz, slid + far.sum(axis=0) / log.log.rate_hz
    share = slid / np.maximum(steady, criteria.identifying.moved_s)
    moved = (steady >= criteria.identifying.moved_s) & (share < criteria.identifying.least_sliding)
    return {joint.name: float(share[a]) for a, joint in enumerate(robot.joints) if moved[a]}


def remarks_on_sliding(hardly: Mapping[str, float], criteria: Criteria, sliding: Collection[str]) -> list[Remark]:
    """hardly: of `hardly_sliding`. sliding: joints whose position is in m."""
    shares = tuple((share,) for share in hardly.values())
    way, unit = criteria.comparison.slides, "m" if set(hardly) <= set(sliding) else "rad"
    return [Remark(About.HARDLY_SLIDES, tuple(hardly), shares, (unit,), (way,))] if hardly else []


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
