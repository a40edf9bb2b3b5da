"""Logs as both stages see them, and what both stages say of these.

Also with what the sensor's calibration leaves in doubt, and what data show of it taken out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.payload.calibration import Calibration, Declared, calibrate, uncalibrated
from exogauge.payload.contact import Compensation
from exogauge.payload.contract import Role
from exogauge.payload.dynamics import static_prior
from exogauge.payload.intake import Payload
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.search import Missing
from exogauge.payload.missing.sensor_effects import such_as_a_sensor_has
from exogauge.payload.missing.stretch import Stretch, moving_stretch, still_stretch
from exogauge.payload.prepare import Moved, std_of
from exogauge.payload.stages import Excitation, Postures, excitation_stage, naming, postures_stage
from exogauge.payload.statics import Holds

Array = NDArray[np.float64]

NO_DOUBT = np.zeros((18, 18))


@final
@dataclass(frozen=True)
class Stages:
    """What both stages say, of wrenches as read or with what was named missing taken out of them. compensation: in what
    the sensor reads, so that what its calibration leaves in doubt is none there. exact: the same, were that exact."""

    postures: Postures | None
    excitation: Excitation | None
    gravity: Array
    compensation: Compensation
    warnings: tuple[str, ...]
    calibration: Calibration | None = None
    exact: Stages | None = None

    @property
    def body(self) -> Array:
        """(10,) [m, m c, I]; without motion the inertia is 0."""
        out = np.zeros(10)
        if self.excitation is not None:
            return self.excitation.chosen.value[:10]
        if self.postures is not None:
            out[:4] = self.postures.chosen.moments[0][:4]
        return out

    @property
    def scale(self) -> tuple[float, float]:
        """By which gains and crosstalk are worse than declared."""
        return (1.0, 1.0) if self.calibration is None else self.calibration.scale


@final
@dataclass(frozen=True)
class Logs:
    """What was read, on one clock each. sign: s of [Payload]. acceleration: (K, 3) of the IMU in the postures."""

    payload: Payload
    sign: int
    criteria: Criteria
    holds: Holds | None
    acceleration: Array | None
    excitation: Sequence[Moved]
    test: Sequence[Moved]
    contact: Sequence[Moved]

    @property
    def moved(self) -> dict[Role, Sequence[Moved]]:
        return {"excitation": self.excitation, "test": self.test, "contact": self.contact}

    def each(self, read: Callable[[Array], Array]) -> Logs:
        """read: of (T, 6) wrenches what is put in their place, of the postures first."""
        holds = self.holds and replace(self.holds, wrench=read(self.holds.wrench))
        excitation, test, contact = (
            [replace(moved, wrench=read(moved.wrench)) for moved in logs]
            for logs in (self.excitation, self.test, self.contact)
        )
        return replace(self, holds=holds, excitation=excitation, test=test, contact=contact)

    def without(self, wrenches: Sequence[Array]) -> Logs:
        """wrenches: (T, 6) of what is taken out, in the same order; NaN at samples that are left out."""
        parts = iter(wrenches)
        logs = self.each(lambda read: read - next(parts))
        excitation, test, contact = (
            [each.rows(np.asarray(np.isfinite(each.wrench).all(axis=1))) for each in some]
            for some in (logs.excitation, logs.test, logs.contact)
        )
        return replace(logs, excitation=excitation, test=test, contact=contact)

    def still(self) -> tuple[Postures | None, list[str]]:
        """What the postures say, without those that were touched; and warnings."""
        warnings: list[str] = []
        if self.holds is None:
            return None, warnings
        with naming(self.payload.of("postures")):
            return postures_stage(self.payload, self.holds, self.acceleration, warnings, self.criteria), warnings

    def stages(self, postures: Postures | None, said: Sequence[str], doubt: Array = NO_DOUBT) -> Stages:
        """postures, said: as `still` gives them. doubt: (18, 18) that is added to what is known of body, zero and turn
        of gravity."""
        warnings = list(said)
        gravity = postures.chosen.gravity if postures else np.array(self.payload.file.gravity)
        excitation = None
        if self.excitation:
            excitation = excitation_stage(
                self.payload, postures, self.excitation, gravity, self.sign, warnings, self.criteria
            )
            chosen = excitation.chosen.doubted(doubt[:16, :16], self.criteria.payload_dynamic)
            excitation = replace(excitation, chosen=chosen)
        if postures:
            postures = replace(postures, chosen=postures.chosen.doubted(doubt))
        compensation = self._compensation(postures, excitation, gravity)
        return Stages(postures, excitation, gravity, compensation, tuple(warnings))

    def _compensation(self, postures: Postures | None, excitation: Excitation | None, gravity: Array) -> Compensation:
        if excitation is not None:
            x, covariance = excitation.chosen.value, excitation.chosen.covariance
        else:
            assert postures is not None
            prior = static_prior(postures.chosen, criteria=self.criteria.payload_dynamic)
            known = np.array([0, 1, 2, 3, *range(10, 16)])
            x, covariance = prior.value, np.zeros((16, 16))
            covariance[np.ix_(known, known)] = prior.covariance[np.ix_(known, known)]
        return Compensation(x, covariance, gravity, self.sign, std_of(self.payload))

    def still_stretches(self, stages: Stages) -> list[Stretch]:
        if stages.postures is None:
            return []
        holds, begun = stages.postures.holds, self.payload.session
        still = still_stretch(holds, stages.gravity, self.sign, self.criteria.payload)
        return [still if begun is None or holds.stamps is None else replace(still, session=holds.stamps - begun)]

    def stretches(self, role: Role, stages: Stages) -> list[Stretch]:
        """Motion of this role, with the floors of the body that was found in the excitation."""
        assert stages.excitation is not None
        body = stages.excitation.chosen.value[:10]
        at_rest = None if stages.postures is None else stages.postures.holds.noise
        begun = self.payload.session
        return [
            replace(moving_stretch(
                recording.name, each.motion, each.wrench, stages.gravity, self.sign, body, std_of(self.payload),
                self.criteria.payload, at_rest,
            ), session=None if begun is None else each.motion.time + recording.begun - begun)
            for recording, each in zip(self.payload.of(role), self.moved[role], strict=True)
        ]  # fmt: skip


def calibrated(
    logs: Logs, stages: Stages, sensor: Declared, doubt: Array, *, take: bool,
    scale: tuple[float, float] | None = None,
) -> tuple[Stages, Logs]:  # fmt: skip
    """With the doubt that the sensor's calibration adds; what is likeliest of it taken out of all logs where `take`.
    doubt: beside that. scale: by which the sensor is worse than declared, where that is known by now."""
    if sensor.exact:
        return replace(stages, calibration=uncalibrated(sensor), exact=stages), logs
    still, moving = logs.still_stretches(stages), list[Stretch]()
    if stages.excitation is not None:
        moving = [each.without(stages.excitation.left_out) for each in logs.stretches("excitation", stages)]
    inclined = stages.postures is None or stages.postures.chosen.inclined  # without postures nobody knows
    frame = Frame(stages.gravity, logs.sign, stages.body)
    found = calibrate(sensor, [*still, *moving], frame, inclined, take=take, scale=scale)
    if found.taken.any():
        logs = logs.each(found.corrected)
        stages = logs.stages(*logs.still(), doubt)
    postures, excitation, body = stages.postures, stages.excitation, stages.body
    if postures is not None:
        postures = replace(postures, chosen=postures.chosen.doubted(found.doubt(body, found.still)))
    if excitation is not None:
        more = found.doubt(body, (*found.still, *found.moving))[:16, :16]
        chosen = excitation.chosen.doubted(more, logs.criteria.payload_dynamic)
        mass, std = excitation.mass_alone
        alone = (mass, float(np.hypot(std, np.sqrt(more[0, 0]))))
        excitation = replace(excitation, chosen=chosen, mass_alone=alone)
    return replace(stages, postures=postures, excitation=excitation, calibration=found, exact=stages), logs


def in_place_of_named(
    logs: Logs, stages: Stages, sensor: Declared, missing: Missing
) -> tuple[Stages, Logs, Missing] | None:
    """With gains and crosstalk of all axes at once in place of what was named, where these are such as a sensor has and
    leave nothing above the noise; None where they do not."""
    criteria = logs.criteria
    found, clean = calibrated(logs, stages, sensor, missing.slight_doubt, take=True)
    assert found.calibration is not None
    assert found.exact is not None
    left = dict[str, Array]()
    for each in (*clean.stretches("excitation", found.exact), *clean.stretches("test", found.exact)):
        external = found.compensation.external(each.motion, each.wrench)
        left[each.name] = np.sqrt(np.mean((external / each.floor)[each.use] ** 2, axis=0))
    above = any(bool(np.any(ratios > criteria.judging.above)) for ratios in left.values())
    E = found.calibration.taken
    absurd = any(not such_as_a_sensor_has(float(E[i, k]), criteria.payload) for i, k in product(range(6), repeat=2)
                 if (i < 3) == (k < 3))  # fmt: skip
    if above or absurd or found.calibration.evidence < criteria.payload.worth:
        return None
    return found, clean, missing.with_sensor(found.calibration, left, criteria)
