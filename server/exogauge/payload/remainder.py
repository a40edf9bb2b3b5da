"""What compensation leaves of the wrench where nothing touches: the figures of [Payload] Table III, and per axis;
and what each method of [Payload] V leaves of the test logs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.payload.both_stages import Logs, Stages
from exogauge.payload.contact import Compensation, second_zero
from exogauge.payload.dynamics import batch
from exogauge.payload.intake import Payload
from exogauge.payload.prepare import low_pass_of, rows_of
from exogauge.payload.sensor_motion import SensorMotion
from exogauge.payload.stages import prior_of
from exogauge.payload.statics import static_stage

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Figures:
    """first, mean, std: (2,) of |f| [N] and |τ| [N·m]: at t = 0, over the log. axes: (3, 6) the same of every axis,
    with its sign. rms, most: (6,) root mean square and largest size per axis."""

    first: Array
    mean: Array
    std: Array
    axes: Array
    rms: Array
    most: Array


@final
@dataclass(frozen=True)
class Remainder:
    """In a log without contact, before and after the secondary zero (44): after, where it helps, and helps: the share
    of time in which it does."""

    before: Figures
    after: Figures
    helps: float


def remainder(left: Array, motion: SensorMotion, gravity: Array, criteria: Moving = USUAL) -> Remainder:
    """left: (T, 6) of a log without contact, below the cut-off if there is one. gravity: (3,) [m/s²] in {B}."""
    zeroed, helps = second_zero(motion, left, gravity, criteria)
    return Remainder(figures(left), figures(zeroed[helps]), float(helps.mean()))


def figures(left: Array) -> Figures:
    """left: (T, 6)."""
    norms = np.column_stack([np.linalg.norm(left[:, :3], axis=1), np.linalg.norm(left[:, 3:], axis=1)])
    return Figures(
        norms[0], norms.mean(axis=0), norms.std(axis=0),
        np.array([left[0], left.mean(axis=0), left.std(axis=0)]),
        np.sqrt(np.mean(left**2, axis=0)), np.abs(left).max(axis=0),
    )  # fmt: skip


def left_by_method(
    stages: Stages, rigid: Stages | None, level: Compensation | None, logs: Logs, clean: Logs
) -> dict[str, dict[str, Remainder]]:
    """By log and way. `all`: everything taken out; `rigid`: but what was named missing; `level`, `static`: the first
    two methods, of wrenches as read. clean: the logs without what was named missing."""
    out: dict[str, dict[str, Remainder]] = {}
    plain = rigid or stages
    for recording, read, test in zip(logs.payload.of("test"), logs.test, clean.test, strict=True):
        read = read.rows(np.isin(read.motion.time, test.motion.time))
        ways = {"all": stages.compensation.external(test.motion, test.wrench)}
        if rigid is not None:
            ways["rigid"] = rigid.compensation.external(read.motion, read.wrench)
        if level is not None and plain.postures is not None:
            ways["level"] = level.external(read.motion, read.wrench)
            ways["static"] = read.wrench - plain.postures.by_method["tls"].predict(read.motion.rotation)
        inner, passed = _slow(logs.payload, test.motion.time)
        out[recording.name] = {
            name: remainder(passed(left)[inner], test.motion.rows(inner), stages.gravity, logs.criteria.payload_dynamic)
            for name, left in ways.items()
        }
    return out


def _slow(payload: Payload, time: Array) -> tuple[slice, Callable[[Array], Array]]:
    """What keeps of (T, 6) what lies below the cut-off, if there is one, and the samples then to be trusted."""
    low_pass = low_pass_of(payload.file.settings.cutoff_hz, time)
    if low_pass is None:
        return slice(None), lambda values: values
    return slice(low_pass.settle_samples, len(time) - low_pass.settle_samples), low_pass.apply


def taken_to_be_level(logs: Logs, stages: Stages) -> Compensation | None:
    """What is found where the base is taken to be level: by TLS, as the second method of [Payload] V, where noise is
    known. None without postures or excitation."""
    payload, moved, postures, criteria = logs.payload, logs.excitation, stages.postures, logs.criteria
    if postures is None or not moved:
        return None
    gravity, sign = np.array(payload.file.gravity), postures.chosen.sign
    chosen = static_stage(postures.holds, gravity, sign, inclined=False, criteria=criteria.payload_static)
    other = replace(postures, chosen=chosen)
    known = payload.file.settings.cutoff_hz is None and all(each.noise_known for each in moved)
    rows = rows_of(payload, moved, gravity, sign)
    found = batch(rows, prior_of(payload, other, criteria), "tls" if known else "ls")
    return Compensation(found.value, np.zeros((16, 16)), gravity, sign, rows.std)
