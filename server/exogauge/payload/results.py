"""results.json of a payload, by its schema, and the same in a terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exogauge import __version__
from exogauge.criteria.criterion import Z95, entries
from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.payload.both_stages import Stages
from exogauge.payload.calibration import said_of as said_of_sensor
from exogauge.payload.contact import Compensation
from exogauge.payload.dynamics import NAMES, ZERO_NAMES, enough
from exogauge.payload.evaluate import Evaluation
from exogauge.payload.missing.search import Finding
from exogauge.payload.missing.words import said_of, verdict_of
from exogauge.payload.remainder import Figures, Remainder
from exogauge.payload.schema import (
    CalibrationResults,
    ChannelRatios,
    ContactResults,
    Deciding,
    DynamicResults,
    FigureResults,
    Further,
    ImuResults,
    LeftOutErrors,
    MissingEffect,
    MissingParameter,
    MissingResults,
    PayloadResults,
    RemainderResults,
    StaticResults,
    Value,
)
from exogauge.robots.parameters import UNITS
from exogauge.terminal import text_table

Array = NDArray[np.float64]

DECIDING = ("judging", "payload", "payload_doctor", "payload_static", "payload_dynamic")
ZERO_UNITS = ("N",) * 3 + ("N·m",) * 3


def results(evaluation: Evaluation) -> PayloadResults:
    """What was found, in the schema's shape."""
    file, stages = evaluation.payload.file, evaluation.stages
    mass = (stages.excitation.chosen.value[0] if stages.excitation
            else stages.postures.chosen.mass if stages.postures else np.nan)  # fmt: skip
    truth = file.ground_truth.mass_kg
    return PayloadResults(
        version=1, exogauge=__version__, name=file.name,
        frame=f"axes and origin of the sensor{f' ({file.sensor.frame})' if file.sensor.frame else ''}",
        sees="payload_on_sensor" if evaluation.sign < 0 else "sensor_on_payload",
        static=_static(stages), dynamic=_dynamic(stages, evaluation.level, evaluation.criteria.payload_dynamic),
        tests={log: {way: _remainder(each) for way, each in ways.items()} for log, ways in evaluation.tests.items()},
        contacts={
            log: [ContactResults(start_s=t.start, end_s=t.end, force_n=tuple(t.force)) for t in touches]
            for log, touches in evaluation.touches.items()
        },
        contact_threshold_n=dict(evaluation.thresholds), imu=_imu(evaluation), missing=_missing(evaluation),
        calibration=_calibration(stages),
        mass_error_kg=None if truth is None else float(mass - truth), warnings=list(evaluation.warnings),
        criteria=[Deciding(**each) for each in entries(evaluation.criteria, DECIDING)],
    )  # fmt: skip


def write_results(evaluation: Evaluation, out: Path) -> Path:
    """results.json and its JSON schema, in `out`."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / "results.json"
    content = results(evaluation).model_dump(mode="json")
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    schema = json.dumps(PayloadResults.model_json_schema(), indent=1, ensure_ascii=False) + "\n"
    (out / "results.schema.json").write_text(schema, encoding="utf-8")
    return path


def summary(found: PayloadResults) -> str:
    """Text for a terminal."""
    parts = [found.name]
    if found.static:
        s = found.static
        level, inclined = (
            "cannot be told" if each is None else f"{each.force_n:.3g} N"
            for each in (s.left_out_level, s.left_out_inclined)
        )
        parts.append(
            f"{s.postures} postures, condition {s.condition_force:.1f} (force) and {s.condition_moment:.1f} (moment). "
            f"Error in a left-out posture: {level} level, {inclined} inclined: "
            f"inclination {'taken' if s.inclined else 'left out'}."
        )
    values = _told_of(found.dynamic, found.static)
    rows = [[v.name, f"{v.value:.6g}", f"{v.std:.2g}", v.unit, "" if v.identified else "not decided"] for v in values]
    parts.append(text_table(("", "value", "±", "unit", ""), rows))
    if found.dynamic and found.dynamic.mu is not None:
        said = "LS would have done." if found.dynamic.least_squares_would_do else "LS differs by more than its scatter."
        parts.append(f"{found.dynamic.method}: μ = {found.dynamic.mu:.3f} ± {found.dynamic.mu_std:.3f}. {said}")
    if found.dynamic and found.dynamic.possible:
        cost = found.dynamic.cost_of_possible
        parts.append(f"No body has all of these; the likeliest one that can exist costs χ² = {cost:.3g}: `possible`.")
    if found.imu:
        parts.append(f"IMU: {found.imu.angle_deg:.1f}° off the sensor's axes, {found.imu.lag_ms:.1f} ms late.")
    for log, ways in found.tests.items():
        lines = [[way, *(f"{x:.3g}" for pair in zip(r.first, r.mean, r.std, strict=True) for x in pair)]
                 for way, r in ways.items()]  # fmt: skip
        parts.append(f"{log}: what is left")
        parts.append(text_table(("", "|f| t=0", "|f| mean", "|f| std", "|τ| t=0", "|τ| mean", "|τ| std"),
                                [[way, *cells] for way, *cells in lines]))  # fmt: skip
    for log, touches in found.contacts.items():
        parts.append(f"{log}: contact from {found.contact_threshold_n[log]:.3g} N on")
        parts += [f"  {t.start_s:.2f} to {t.end_s:.2f} s, up to {np.linalg.norm(t.force_n):.3g} N" for t in touches]
    if found.calibration:
        parts.append(f"± holds the sensor's calibration: {found.calibration.said}")
    parts.append(found.missing.said)
    parts += [f"  {each.said}" for each in (*found.missing.found, *found.missing.suspected)]
    if found.mass_error_kg is not None:
        parts.append(f"mass against the weighed one: {1e3 * found.mass_error_kg:+.1f} g")
    return "\n".join([*parts, *(f"warning: {each}" for each in found.warnings)])


def _told_of(moved: DynamicResults | None, still: StaticResults | None) -> list[Value]:
    """Those of motion, where there is any, and of postures what motion does not tell."""
    shown = [] if still is None else [each for each in still.values if moved is None or each.name in "UV"]
    return [*(moved.values if moved else []), *shown]


def _value(name: str, unit: str, value: float, std: float, identified: bool = True) -> Value:
    low, high = float(value - Z95 * std), float(value + Z95 * std)
    return Value(
        name=name, unit=unit, value=float(value), std=float(std), low=low, high=high, identified=identified
    )  # fmt: skip


def _static(stages: Stages) -> StaticResults | None:
    if stages.postures is None:
        return None
    postures, found = stages.postures, stages.postures.chosen
    names = ("m", "cx", "cy", "cz", *ZERO_NAMES, "U", "V")
    units = ("kg", *("m",) * 3, *ZERO_UNITS, "°", "°")
    scale = np.array([1.0] * 10 + [np.degrees(1.0)] * 2)

    def stacked(each: Any) -> Array:
        return np.asarray(scale * np.concatenate([[each.mass], each.centre, each.zero, each.tilt]))

    values = [
        _value(name, unit, x, s, found.inclined or name not in "UV")
        for name, unit, x, s in zip(names, units, stacked(found), scale * found.std, strict=True)
    ]
    direction, then = postures.further

    def errors(each: Any) -> LeftOutErrors | None:
        return None if each is None else LeftOutErrors(force_n=each.force, moment_nm=each.moment)

    return StaticResults(
        postures=len(postures.holds), condition_force=found.condition[0], condition_moment=found.condition[1],
        inclined=found.inclined, left_out_level=errors(postures.level), left_out_inclined=errors(postures.inclined),
        values=values, covariance=(scale[:, None] * found.covariance * scale).tolist(),
        by_method={m: dict(zip(names, map(float, stacked(s)), strict=True)) for m, s in postures.by_method.items()},
        further=Further(gravity=tuple(direction), std_then=dict(zip(names, map(float, scale * then), strict=True))),
        residual_force_n=float(np.sqrt(np.mean(found.residual[:, :3] ** 2))),
        residual_moment_nm=float(np.sqrt(np.mean(found.residual[:, 3:] ** 2))),
    )  # fmt: skip


def _dynamic(stages: Stages, level: Compensation | None, deciding: Moving) -> DynamicResults | None:
    if stages.excitation is None:
        return None
    excitation, found = stages.excitation, stages.excitation.chosen
    names = (*NAMES, *ZERO_NAMES)
    units = (*UNITS, *ZERO_UNITS)
    surer = found.decided.copy()
    if stages.postures is not None:  # postures decided these before
        surer[[0, 1, 2, 3, *range(10, 16)]] |= found.prior_std[[0, 1, 2, 3, *range(10, 16)]] < 1.0

    def named(x: Array) -> dict[str, float]:
        return dict(zip(names, map(float, x), strict=True))

    known = excitation.noise_known
    methods = excitation.by_method
    return DynamicResults(
        method=found.method, mu=found.mu if known else None, mu_std=found.mu_std if known else None,
        values=[_value(*each) for each in zip(names, units, found.value, found.std, map(bool, surer), strict=True)],
        covariance=found.covariance.tolist(),
        by_method={m: named(s.value) for m, s in methods.items()}, recursion=named(excitation.recursion),
        least_squares_would_do=enough(methods["ls"], methods["gtls"], deciding) if known else None,
        mass_from_motion_alone=_value("m", "kg", *excitation.mass_alone),
        level=None if level is None else named(level.x),
        possible=named(found.physical) if found.cost > 0 else None, cost_of_possible=found.cost,
        residual_rms=list(map(float, np.sqrt(np.mean(found.residual**2, axis=0)))),
        jerk_density=list(map(float, excitation.density)), left_out_s=list(excitation.left_out),
    )  # fmt: skip


def _missing(evaluation: Evaluation) -> MissingResults:
    missing, rigid = evaluation.missing, evaluation.rigid

    def told(each: Finding) -> MissingEffect:
        parameters = [MissingParameter(name=p.name, unit=p.unit, value=p.value, std=p.std) for p in each.parameters]
        return MissingEffect(
            effect=each.effect, place=each.place, parameters=parameters, evidence=each.evidence, before=each.before,
            after=each.after, rivals=list(each.rivals), said=said_of(each),
        )  # fmt: skip

    decision = missing.decision
    moved, still = (
        (None, None) if rigid is None else (_dynamic(rigid, None, evaluation.criteria.payload_dynamic), _static(rigid))
    )
    return MissingResults(
        verdict=decision.verdict, reason=None if decision.reason is None else decision.reason.why,
        found=[told(each) for each in missing.found], suspected=[told(each) for each in missing.suspected],
        left={
            log: ChannelRatios(before=list(map(float, before)), after=list(map(float, missing.after[log])))
            for log, before in missing.before.items()
        },
        in_the_model=missing.in_the_model, without=_told_of(moved, still),
        candidates=missing.tried, said=verdict_of(missing),
    )  # fmt: skip


def _calibration(stages: Stages) -> CalibrationResults | None:
    found, exact = stages.calibration, stages.exact
    if found is None or exact is None or found.exact:
        return None
    without = {each.name: each.std for each in _told_of(_dynamic(exact, None, USUAL), _static(exact))}
    std, common = found.left(stages.body)
    said = f"{said_of_sensor(found)} With an exact sensor the mass would be known to {without['m']:.2g} kg."
    declared = found.declared
    return CalibrationResults(
        ft_gain=declared.gain, ft_gain_common=declared.common, ft_crosstalk=declared.crosstalk,
        defaulted=sorted(declared.defaulted), worse=found.scale,
        taken_out=found.taken.tolist() if found.taken.any() else None, std=std.tolist(),
        common=(float(np.diag(found.taken).mean()), common), std_without=without, said=said,
    )  # fmt: skip


def _remainder(each: Remainder) -> RemainderResults:
    return RemainderResults(**_figures(each.before), after_zero=FigureResults(**_figures(each.after)),
                            zero_helps=each.helps)  # fmt: skip


def _figures(each: Figures) -> dict[str, Any]:
    return {
        "first": tuple(each.first), "mean": tuple(each.mean), "std": tuple(each.std), "axes": each.axes.tolist(),
        "rms": each.rms.tolist(), "most": each.most.tolist(),
    }  # fmt: skip


def _imu(evaluation: Evaluation) -> ImuResults | None:
    imu = evaluation.imu
    if imu is None:
        return None
    return ImuResults(
        rotation_sensor_imu=imu.rotation.tolist(), angle_deg=float(np.degrees(imu.angle)), bias=tuple(imu.bias),
        lag_ms=1e3 * imu.lag_s, lag_std_ms=1e3 * imu.lag_std_s, rms=imu.rms,
        place_m=tuple(imu.place), place_std_m=tuple(imu.place_std),
    )  # fmt: skip
