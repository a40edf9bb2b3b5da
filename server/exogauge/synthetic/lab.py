"""The laboratory of one study: every disturbance drawn once, from the seed, by a stream of its own;
and when each log of the session began, and how warm the drives were.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.disturbances import BY_NAME, Disturbances
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.sensors import ENCODER_STEP, Sensing
from exogauge.synthetic.simulation import DriveState
from exogauge.synthetic.suit import BANDS, Suit, ViaPoint
from exogauge.synthetic.variation import Variation

Array = NDArray[np.float64]

COMMON, OWN = 0.8, 0.6  # of a foot sensor's gain: what both share, what each has alone
MOMENT_ARM = 0.2  # a zero's drift in moment, of that in force [m]
COULOMB_WARMS = 0.5  # of the share by which k_d falls
PRELOAD = 2 / 3  # std of a natural length, of that of the bands' ends


@final
@dataclass(frozen=True)
class Lab:
    """What happens in this study, and when.

    gain: (2,) of the feet, 1 is right; drift: (2, 6) [N, N·m] of their zeros by the session's end; tilt: (2, 3) [rad]
    rotation vectors of the feet, imu: (3,) that of the IMU; place: (2, 3) [m] of the feet's sensors; late: (3,) [s] of
    them and of the IMU; encoder_zero: (J,) [rad]; k_T, k_d: (J,) shares by which they fall from cold to the
    session's end; load: (J,) share of the load that Coulomb friction grows by. The rest is drawn log by log.
    """

    seed: int
    sizes: Disturbances
    session: Session
    gain: Array
    drift: Array
    tilt: Array
    imu: Array
    place: Array
    late: Array
    encoder_zero: Array
    k_T: Array
    k_d: Array
    load: Array

    def drives(self, plan: LogPlan) -> DriveState | None:
        """How the drives are in this log; None: as in the robot's record, throughout."""
        if not (self.k_T.any() or self.k_d.any() or self.load.any()):
            return None
        start = self.session.start_s[plan.name]

        def factors(seconds: float) -> tuple[Array, Array, Array]:
            warmer = self.session.warmer(start + seconds)
            return 1.0 - self.k_T * warmer, 1.0 - self.k_d * warmer, 1.0 - COULOMB_WARMS * self.k_d * warmer

        return DriveState(factors, self.load)

    @property
    def encoder_step(self) -> float:
        return self.sizes.get("encoder_steps", ENCODER_STEP)

    def variation(self, plan: LogPlan) -> Variation | None:
        """How this run of a motion differs from its plan."""
        kinds = {
            "smooth": "runs_differ", "offset": "runs_offset", "amplitude_std": "runs_amplitude", "timing": "runs_timing"
        }  # fmt: skip
        if not plan.repeats or not any(kind in self.sizes for kind in kinds.values()):
            return None
        sizes = {what: self.sizes.get(kind, 0.0) for what, kind in kinds.items()}
        return Variation(**sizes, seed=self.seed, run=plan.name)

    def sensing(self, plan: LogPlan) -> Sensing | None:
        """How the sensors are wrong in this log; None: they have but noise."""
        names = {"encoder_steps", "encoder_zeros", "feet_gain", "foot_gains", "feet_drift", "feet_tilt", "feet_place",
                 "imu_mounting", "streams_late", "clock_jitter"}  # fmt: skip
        if not names & set(self.sizes):
            return None
        start, end = self.session.start_s[plan.name], self.session.end_s
        jitter = stream(self.seed, f"clock_jitter {plan.name}")
        return Sensing(
            self.encoder_step, self.encoder_zero, self.gain, self.drift * start / end, self.drift / end, self.tilt,
            self.imu, self.place, self.late, self.sizes.get("clock_jitter", 0.0), jitter,
        )  # fmt: skip

    def worn(self, suit: Suit, plan: LogPlan) -> Suit:
        """The suit as it was put on for this log: the bands' ends and natural lengths are a little different."""
        size = self.sizes.get("donning", 0.0)
        if not size:
            return suit
        rng, bands = stream(self.seed, f"donning {plan.name}"), []
        for band in suit.bands:
            points, ends = list(band.facts.via_points), size * rng.standard_normal((2, 3))
            for place, end in zip((0, -1), ends, strict=True):
                points[place] = _moved(points[place], end)
            length = band.natural_length + PRELOAD * size * float(rng.standard_normal())
            facts = replace(band.facts, via_points=tuple(points))
            bands.append(replace(band, facts=facts, natural_length=length))
        return replace(suit, bands=tuple(bands))

    def as_measured(self, suit: Suit) -> Suit:
        """The suit as the device file describes it: via points found by tape measure, in whole millimetres."""
        size = self.sizes.get("via_points", 0.0)
        if not size:
            return suit
        rng, bands = stream(self.seed, "via_points"), []
        for band in suit.bands:
            points = tuple(_moved(p, size * rng.standard_normal(3), whole_mm=True) for p in band.facts.via_points)
            bands.append(replace(band, facts=replace(band.facts, via_points=points)))
        return replace(suit, bands=tuple(bands))

    def record(self, plans: Sequence[LogPlan], suits: Mapping[str, Suit]) -> dict[str, Any]:
        """What truth.json says of it; nothing where nothing happens."""
        if not self.sizes:
            return {}
        drawn = {name: {"size": size, "unit": BY_NAME[name].si} for name, size in self.sizes.items()}
        by_name: dict[str, Any] = drawn
        for name, share in (("kt_warming", self.k_T), ("friction_warming", self.k_d), ("load_friction", self.load)):
            if name in drawn:
                by_name[name]["share"] = dict(zip(JOINT_NAMES, share.tolist(), strict=True))
        for name in ("feet_gain", "foot_gains"):
            if name in drawn:
                by_name[name]["gain"] = dict(zip(FEET, self.gain.tolist(), strict=True))
        if "feet_drift" in drawn:
            by_name["feet_drift"]["zero_at_end"] = dict(zip(FEET, self.drift.tolist(), strict=True))
        if "feet_tilt" in drawn:
            by_name["feet_tilt"]["rotation_vector"] = dict(zip(FEET, self.tilt.tolist(), strict=True))
        if "feet_place" in drawn:
            by_name["feet_place"]["beside_m"] = dict(zip(FEET, self.place.tolist(), strict=True))
        if "encoder_zeros" in drawn:
            by_name["encoder_zeros"]["zero"] = dict(zip(JOINT_NAMES, self.encoder_zero.tolist(), strict=True))
        if "streams_late" in drawn:
            by_name["streams_late"]["late_s"] = dict(zip((*FEET, "imu"), self.late.tolist(), strict=True))
        if "imu_mounting" in drawn:
            by_name["imu_mounting"]["rotation_vector"] = self.imu.tolist()
        if "via_points" in drawn:
            by_name["via_points"]["true"] = {band.name: _points(band.via_points) for band in BANDS}
        return {"disturbances": by_name, "session": self._session(plans, suits)}

    def _session(self, plans: Sequence[LogPlan], suits: Mapping[str, Suit]) -> dict[str, Any]:
        """Log by log: start_s, warmer (at both ends; 0 is the mean of the identification logs), the run, the suit."""
        logs: dict[str, Any] = {}
        for plan in plans:
            start = self.session.start_s[plan.name]
            ends = self.session.warmer(np.array([start, start + plan.duration_s]))
            entry: dict[str, Any] = {"start_s": start, "warmer": ends.tolist()}
            varied = self.variation(plan)
            if varied is not None:
                entry["amplitude"] = varied.amplitude
            if plan.suit is not None and "donning" in self.sizes:
                entry["bands"] = {
                    band.facts.name: {
                        "natural_length_m": band.natural_length,
                        "ends": _points((band.facts.via_points[0], band.facts.via_points[-1])),
                    }
                    for band in self.worn(suits[plan.suit], plan).bands
                }
            logs[plan.name] = entry
        return {"end_s": self.session.end_s, "logs": logs}


def drawn_lab(seed: int, sizes: Disturbances, plans: Sequence[LogPlan]) -> Lab:
    """Every disturbance has random numbers of its own: leaving one out changes nothing of the others."""

    def size(name: str) -> float:
        return sizes.get(name, 0.0)

    def rng(name: str) -> np.random.Generator:
        return stream(seed, f"lab {name}")

    feet, joints = len(FEET), len(JOINT_NAMES)
    gains = rng("foot_gains")
    own = COMMON * gains.standard_normal() + OWN * gains.standard_normal(feet)
    drifts, side = rng("feet_drift"), rng("imu_mounting").uniform(0.0, 2 * np.pi)
    way = drifts.choice([-1.0, 1.0], (feet, 6)) * drifts.uniform(0.5, 1.0, (feet, 6))
    return Lab(
        seed,
        sizes,
        session(plans),
        gain=(1.0 + size("feet_gain")) * (1.0 + size("foot_gains") * own),
        drift=size("feet_drift") * way * np.repeat([1.0, MOMENT_ARM], 3),
        tilt=size("feet_tilt") * rng("feet_tilt").standard_normal((feet, 3)),
        imu=size("imu_mounting") * np.array([np.cos(side), np.sin(side), 0.0]),
        place=size("feet_place") * rng("feet_place").standard_normal((feet, 3)),
        late=size("streams_late") * rng("streams_late").standard_normal(feet + 1),
        encoder_zero=size("encoder_zeros") * rng("encoder_zeros").standard_normal(joints),
        k_T=size("kt_warming") * rng("kt_warming").uniform(0.5, 1.5, joints),
        k_d=size("friction_warming") * rng("friction_warming").uniform(0.5, 1.5, joints),
        load=size("load_friction") * rng("load_friction").uniform(0.6, 1.4, joints),
    )


def _moved(point: ViaPoint, by: Array, whole_mm: bool = False) -> ViaPoint:
    x, y, z = (float(v) for v in np.array(point.xyz) + by)
    return ViaPoint(point.link, (round(x, 3), round(y, 3), round(z, 3)) if whole_mm else (x, y, z))


def _points(points: Sequence[ViaPoint]) -> list[dict[str, Any]]:
    return [{"link": point.link, "xyz": list(point.xyz)} for point in points]


PAUSE_S = 45.0  # from one log to the next
DONNING_S = 120.0  # the same, where the suit is put on for it
WARM_UP_S = 1200.0  # time constant of a drive's windings and grease


@final
@dataclass(frozen=True)
class Session:
    """start_s: when each log began, by its name. end_s: of the last. reference: warmth in the identification logs."""

    start_s: Mapping[str, float]
    end_s: float
    reference: float

    def warmth(self, time_s: Array | float) -> Array:
        """0 when the session begins, 1 when it ends; first order. time_s: from its beginning."""
        return np.asarray(np.expm1(-np.asarray(time_s) / WARM_UP_S) / np.expm1(-self.end_s / WARM_UP_S))

    def warmer(self, time_s: Array | float) -> Array:
        """Warmth above that of the identification logs: parameters are what they were there, on the average."""
        return self.warmth(time_s) - self.reference


def session(plans: Sequence[LogPlan]) -> Session:
    """Logs in the order in which they are listed."""
    start_s, now = {}, 0.0
    for plan in plans:
        now += DONNING_S if plan.suit else PAUSE_S
        start_s[plan.name] = now
        now += plan.duration_s
    cold = Session(start_s, max(now, 1.0), 0.0)
    fitted = [plan for plan in plans if plan.role == "identification"]
    middles = np.array([start_s[plan.name] + plan.duration_s / 2 for plan in fitted])
    weights = np.array([plan.duration_s for plan in fitted])
    reference = float(np.average(cold.warmth(middles), weights=weights)) if fitted else 0.0
    return Session(start_s, cold.end_s, reference)
