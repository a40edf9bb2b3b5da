"""Logs as both stages see them, and what both stages say of these."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.payload.calibration import Calibration
from exogauge.payload.contact import Compensation
from exogauge.payload.contract import Role
from exogauge.payload.dynamics import static_prior
from exogauge.payload.intake import Payload
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
