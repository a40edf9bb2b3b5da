"""The two stages on what was recorded: postures, then motion; each says what it used and left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.errors import BadStudy, Fault, NotIdentifiable
from exogauge.payload.contact import Compensation
from exogauge.payload.dynamics import (
    DynamicSolution,
    Method,
    Prior,
    Rows,
    batch,
    dynamic_stage,
    recursive,
    require_excitation,
    static_prior,
)
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.limits import saturated
from exogauge.payload.prepare import Moved, rows_of, std_of
from exogauge.payload.slips import by_own_noise, clock_offset, explained, moments_over_forces, units_for
from exogauge.payload.statics import (
    Holds,
    LeftOut,
    StaticSolution,
    forces_among_moments,
    further_posture,
    leave_one_out,
    misread_rotation,
    static_stage,
    told_sign,
    touched_postures,
)
from exogauge.payload.turned_axes import axes_in_motion, exchanged_moments, other_axes, said_of_moments
from exogauge.payload.turned_axes import said as said_of_axes
from exogauge.studies.intake.robot_file import SIGN

Array = NDArray[np.float64]

METHODS: tuple[Method, ...] = ("ls", "tls", "gtls")


@final
@dataclass(frozen=True)
class Postures:
    """holds; level, inclined: errors in left-out postures without and with U, V, None where one cannot be missed;
    chosen: the solution used; by_method: the same by LS, TLS, GTLS; further: gravity's direction in {S} and std (12,)
    with one more posture. acceleration: (K, 3) the IMU's mean in each, if there is one. touched: what is said of
    postures that were left out."""

    holds: Holds
    level: LeftOut | None
    inclined: LeftOut | None
    chosen: StaticSolution
    by_method: Mapping[Method, StaticSolution]
    further: tuple[Array, Array]
    acceleration: Array | None
    touched: tuple[str, ...]


@final
@dataclass(frozen=True)
class Excitation:
    """by_method: solutions; chosen: the one used. recursion: what the recursion ends with, (16,); mass_alone: mass and
    its std from motion, without the postures' mass. noise_known: whether μ may be read. density: of each channel.
    other: mass of another body than that of the postures, and its std, which alone explains the motion; else None."""

    by_method: Mapping[Method, DynamicSolution]
    chosen: DynamicSolution
    recursion: Array
    mass_alone: tuple[float, float]
    noise_known: bool
    density: Array
    left_out: tuple[tuple[float, float], ...]
    other: tuple[float, float] | None


@contextmanager
def naming(recordings: Sequence[Recording]) -> Iterator[None]:
    """What cannot be identified is told with the files that it is not in."""
    try:
        yield
    except NotIdentifiable as error:
        files = ", ".join(dict.fromkeys(each.wrench.file for each in recordings))
        raise NotIdentifiable(f"{files}: {error}", error.parameters) from error


def postures_stage(
    payload: Payload, holds: Holds, acceleration: Array | None, warnings: list[str], criteria: Criteria = USUAL
) -> Postures:
    """holds: every posture of every log. acceleration: (K, 3) of the IMU in each, if there is one. Raises BadStudy."""
    gravity, settings, limits = np.array(payload.file.gravity), payload.file.settings, criteria.payload
    still, sees = criteria.payload_static, payload.file.sensor.sees
    flat = np.all(holds.wrench[:, :3].std(axis=0) < limits.no_weight * holds.std[:3])
    if flat and not holds.alike(gravity, still):
        advice = "Is the payload on the sensor, and are these the columns of a sensor that is read?"
        detail = f"the force is the same in all {len(holds)} postures: nothing hangs on the sensor"
        steps = max((float(np.max(each.steps.size[:3] * (each.steps.size > each.steps.noise)[:3]))
                     for each in payload.of("postures")), default=0.0)  # fmt: skip
        if steps > 0.0:
            detail += f", or less than its steps of {steps:.3g} N show"
        raise BadStudy(Fault(detail, "no_weight", advice, payload.of("postures")[0].wrench.file))
    misread = misread_rotation(holds, gravity, still)
    if misread is not None and payload.file.pose.quaternion is not None:
        _require_order(payload, holds, gravity, criteria)
    turned = other_axes(holds, gravity, None if sees is None else _sign(sees), still)
    first = payload.of("postures")[0]
    if misread == "unexplained" and turned is not None:
        detail, advice = said_of_axes(turned, payload.file.sensor.wrench, payload.file.sensor.frame or "")
        name = payload.file.sensor.wrench[0]
        raise BadStudy(Fault(detail, "other_axes", advice, first.wrench.file, None, name))
    if misread == "unexplained" and forces_among_moments(holds, still):
        detail, advice = "the weight is in the last three columns", "Name forces first, then moments: fx, fy, fz, mx, …"
        raise BadStudy(Fault(detail, "forces_last", advice, payload.name, None, "sensor.wrench"))
    if misread is not None:
        detail, advice = {
            "transposed": ("the postures fit the transpose of this pose", "Give R_base_sensor: its columns are the "
                           "sensor's axes in the base. Check the order of a quaternion too."),
            "world_axes": ("the postures fit wrenches in the base's axes", "Say `sensor.axes: base`."),
            "sensor_axes": ("the postures fit wrenches in the sensor's own axes", "Say `sensor.axes: sensor`."),
            "unexplained": ("no weight explains the forces of these postures", "Check that nothing touched the "
                            "payload, that it does not shift, the order and axes of pose and wrench, the unit of "
                            "angles, and that clocks of several files count from the same instant."),
        }[misread]  # fmt: skip
        raise BadStudy(Fault(detail, f"pose_{misread}", advice, payload.of("postures")[0].pose.file))
    exchanged = exchanged_moments(holds, still)
    if exchanged is not None:
        detail, advice = said_of_moments(exchanged, payload.file.sensor.wrench)
        raise BadStudy(Fault(detail, "other_axes", advice, first.wrench.file, None, payload.file.sensor.wrench[3]))
    sign = told_sign(holds, gravity, still)
    stated = sees
    if turned is not None and turned.angle is not None and turned.angle > np.radians(still.turned_deg):
        detail, advice = said_of_axes(turned, payload.file.sensor.wrench, payload.file.sensor.frame or "")
        warnings.append(f"{first.wrench.file}: {detail}. {advice}")
    if stated is not None and _sign(stated) != sign:
        other = next(name for name in ("payload_on_sensor", "sensor_on_payload") if name != stated)
        detail = "the weight points the other way than `sensor.sees` and `gravity` say"
        advice = f"Say `sees: {other}`, or turn `gravity` round."
        raise BadStudy(Fault(detail, "sees_contradicted", advice, payload.name, None, "sensor.sees", stated))
    touched, said = touched_postures(holds, gravity, sign, still), list[str]()
    for number, beyond in touched.items():
        span = "" if holds.spans is None else f", {_span_of(holds.spans[number])}"
        said.append(
            f"Posture {number + 1}{span}: {np.linalg.norm(beyond[:3]):.3g} N and {np.linalg.norm(beyond[3:]):.3g} N·m "
            "beyond what the others say. Something touched the payload there, or it had moved: left out."
        )
    if touched:
        keep = ~np.isin(np.arange(len(holds)), list(touched))
        holds, acceleration = holds.only(keep), None if acceleration is None else acceleration[keep]
    errors: list[LeftOut | None] = []
    for inclined in (False, True):
        try:
            errors.append(leave_one_out(holds, gravity, sign, inclined=inclined, criteria=still))
        except NotIdentifiable:
            errors.append(None)
    level, tilted = errors
    better = level is None or tilted is None or tilted.force < level.force
    fit = {"fit": True, "ignore": False, "auto": better and tilted is not None}[settings.inclination]
    by_method = {
        method: static_stage(holds, gravity, sign, inclined=fit, method=method, criteria=still) for method in METHODS
    }
    chosen = by_method["ls"]
    if float(np.abs(chosen.tilt).max()) > np.radians(limits.steep_deg):
        degrees = np.degrees(chosen.tilt)
        warnings.append(
            f"The base comes out inclined by {degrees[0]:.3g}° and {degrees[1]:.3g}°: the pose, `gravity` or the "
            "sensor's axes are wrong, or the base really leans."
        )
    if float(np.linalg.norm(chosen.centre)) > limits.far_m:
        detail = f"the centre of mass comes out {np.linalg.norm(chosen.centre):.3g} m from the sensor"
        advice = "Check `sensor.moment_unit` (Nmm is a thousandth of Nm) and `sensor.force_unit`."
        file = payload.of("postures")[0].wrench.file
        raise BadStudy(Fault(detail, "centre_too_far", advice, file, None, payload.file.sensor.wrench[3]))
    further = further_posture(holds, chosen, still)
    return Postures(holds, level, tilted, chosen, by_method, further, acceleration, tuple(said))


def excitation_stage(
    payload: Payload, postures: Postures | None, moved: Sequence[Moved], gravity: Array, sign: int,
    warnings: list[str], criteria: Criteria = USUAL,
) -> Excitation:  # fmt: skip
    """moved: the logs of this role. Raises NotIdentifiable where nothing was excited."""
    settings, prior, limits = payload.file.settings, prior_of(payload, postures, criteria), criteria.payload
    deciding = criteria.payload_dynamic
    known = all(each.noise_known for each in moved) and settings.cutoff_hz is None
    method: Method = settings.method if known else "ls"
    if settings.method != method:
        warnings.append(
            "An IMU or a low-pass: the noise of the regressor is not known, so LS decides and μ is not read."
        )

    rows = rows_of(payload, moved, gravity, sign)
    solution = dynamic_stage(rows, prior, method, criteria=deciding)
    pushed: list[tuple[float, float]] = []
    if settings.cutoff_hz is None and known:
        keep, pushed = _without_contact(payload, moved, solution, gravity, sign, criteria)
        if pushed:
            rows = rows_of(payload, moved, gravity, sign, keep)
            solution = dynamic_stage(rows, prior, method, criteria=deciding)
    with naming(payload.of("excitation")):
        require_excitation(solution)
    if known and solution.mu > criteria.payload_static.clearly:
        _require_one_clock(payload, moved, gravity, solution.mu, criteria)
        _require_down(payload, rows_of(payload, moved, -gravity, -sign), prior, solution.mu, criteria)
    if postures is None:
        _require_axes(payload, rows, solution, criteria)
    _require_units(payload, rows, criteria)
    by_method = {method: solution}
    by_method |= {
        each: dynamic_stage(rows, prior, each, criteria=deciding) for each in METHODS if known and each != method
    }
    if solution.cost > limits.impossible:
        warnings.append(
            "No body has this mass, centre and inertia, and not by chance: check `sensor.force_unit` and "
            "`sensor.moment_unit`, and that nothing touched."
        )
    alone = dynamic_stage(rows, released(prior, 1), method, criteria=deciding)
    track, _ = recursive(rows, prior, method)
    return Excitation(
        by_method, solution, track[-1], (float(alone.value[0]), float(alone.std[0])), known,
        np.concatenate([np.zeros(0) if m.motion.density is None else m.motion.density for m in moved]), tuple(pushed),
        _another_body(rows, prior, solution, criteria) if known and postures is not None else None,
    )  # fmt: skip


def released(prior: Prior, count: int) -> Prior:
    """The same, but that of the first `count` of [m, m c] next to nothing is known: the mass, in kg and at 1 m."""
    covariance, lean = prior.covariance.copy(), prior.lean.copy()
    covariance[:count], covariance[:, :count], lean[:count] = 0.0, 0.0, 0.0
    covariance[range(count), range(count)] = max(prior.value[0], 1.0) ** 2
    return Prior(prior.value, covariance, lean)


def _another_body(
    rows: Rows, prior: Prior, solution: DynamicSolution, criteria: Criteria
) -> tuple[float, float] | None:
    """Mass and its std of the body that explains the motion with the zero of the postures, where their body does not:
    as of a payload that was changed, or gripped otherwise, in between."""
    noise = criteria.judging.above**2
    if solution.mu < criteria.payload_static.clearly * noise:
        return None
    other = dynamic_stage(rows, released(prior, 4), "gtls", criteria=criteria.payload_dynamic)
    return (float(other.value[0]), float(other.std[0])) if other.mu < noise else None


def _require_units(payload: Payload, rows: Rows, criteria: Criteria) -> None:
    """Forces and moments must agree on m c: else one of them is in another unit. An IMU that sits elsewhere, and a zero
    moment arm, say nothing of it."""
    sensor, settings = payload.file.sensor, payload.file.settings
    if settings.moments == "from_motion" or payload.file.imu is not None:
        return
    if settings.cutoff_hz is None:
        step = np.max([each.steps.size for each in payload.of("excitation")], axis=0)
        rows = by_own_noise(rows, step, criteria.payload)
    found = moments_over_forces(rows, criteria.payload)
    most = criteria.payload.other_ratio
    if found is None or 1.0 / most <= found[0] <= most:
        return
    ratio, std = found
    if abs(ratio - 1.0) < criteria.payload_dynamic.mu_stds * std:
        return
    if any(True for each in payload.of("excitation") for _ in saturated(payload, each, criteria)):
        return  # what is cut off or dead says nothing of units, and is told
    if not explained(rows, ratio, criteria.payload_dynamic.misfit, criteria.judging.above**2):
        return
    if ratio < 0.0:
        if 1.0 / most <= -ratio <= most:
            file = payload.of("excitation")[0].wrench.file
            detail = f"moments are {ratio:.4g} ± {std:.1g} times what forces say of the payload in motion"
            advice = "Turn the sign of the three columns of the moment, or of the force: one is action, one reaction."
            raise BadStudy(Fault(detail, "moments_reversed", advice, file, None, sensor.wrench[3], f"{ratio:.4g}"))
        return
    file, said = payload.of("excitation")[0].wrench.file, units_for(ratio, std, sensor.force_unit, sensor.moment_unit)
    detail = f"moments are {ratio:.4g} ± {std:.1g} times what forces say of the payload in motion: a unit is wrong"
    advice = f"Say {said}." if said else "Check `sensor.force_unit` and `sensor.moment_unit`, and the clocks."
    raise BadStudy(Fault(detail, "units_disagree", advice, file, None, sensor.wrench[3], f"{ratio:.4g}"))


def _require_axes(payload: Payload, rows: Rows, solution: DynamicSolution, criteria: Criteria) -> None:
    """Raises BadStudy where, without postures, motion says that the wrench is of the other sign, or in other axes."""
    sensor, file = payload.file.sensor, payload.of("excitation")[0].wrench.file
    moving, still = criteria.payload_dynamic, criteria.payload_static
    if solution.mu > moving.misfit and (found := axes_in_motion(rows, still)) is not None:
        turned, moments = found
        detail, advice = (
            said_of_moments(turned.Q, sensor.wrench) if moments
            else said_of_axes(turned, sensor.wrench, sensor.frame or "")
        )  # fmt: skip
        raise BadStudy(Fault(detail, "other_axes", advice, file, None, sensor.wrench[3 if moments else 0]))
    if solution.value[0] < -still.noises * solution.std[0]:
        other = next(each for each in ("payload_on_sensor", "sensor_on_payload") if _sign(each) == -rows.sign)
        detail = "the weight points the other way than `sensor.sees` and `gravity` say"
        advice = f"Say `sees: {other}`, or turn `gravity` round."
        raise BadStudy(Fault(detail, "sees_contradicted", advice, payload.name, None, "sensor.sees", sensor.sees or ""))


def _require_one_clock(payload: Payload, moved: Sequence[Moved], gravity: Array, mu: float, criteria: Criteria) -> None:
    """Raises BadStudy where the wrench fits the pose clearly better so much later or earlier that no filter does it."""
    for recording, each in zip(payload.of("excitation"), moved, strict=True):
        found = clock_offset(each.motion, each.wrench, gravity, std_of(payload), criteria.payload_dynamic)
        if found is None or abs(found[0]) <= criteria.payload.latest_s:
            continue
        late, left = found
        alone = left < criteria.judging.above**2  # nothing but noise is left there
        clearly = criteria.payload_static.clearly
        if left * (clearly if alone else clearly**2) < mu:
            detail = f"the wrench is {abs(late):.3f} s {'late' if late > 0 else 'early'} against the pose"
            advice = "Both must be stamped when they were measured, by one clock: take that off the wrench's stamps."
            file = recording.wrench.file
            raise BadStudy(Fault(detail, "clocks_apart", advice, file, None, payload.file.time.column, f"{late:.3f} s"))


def _require_down(payload: Payload, upwards: Rows, prior: Prior, mu: float, criteria: Criteria) -> None:
    """Raises BadStudy where motion fits clearly better with gravity and the wrench's sign turned round: postures fit
    both alike. upwards: the rows so."""
    if batch(upwards, prior, "gtls").mu * criteria.payload_static.clearly**2 < mu:
        detail = "motion says that gravity points the other way, though postures fit"
        file, value = payload.name, str(list(payload.file.gravity))
        advice = "Turn `gravity` round: it is what falls, so [0, 0, -9.81] where z of the base points up; and `sees`."
        raise BadStudy(Fault(detail, "gravity_reversed", advice, file, None, "gravity", value))


def _require_order(payload: Payload, holds: Holds, gravity: Array, criteria: Criteria) -> None:
    """Raises BadStudy where the quaternion is explained by its other order."""
    q = Rotation.from_matrix(holds.rotation).as_quat()
    stated = payload.file.pose.quaternion_order
    other = "wxyz" if stated == "xyzw" else "xyzw"
    turned = Rotation.from_quat(np.roll(q, -1 if other == "wxyz" else 1, axis=1)).as_matrix()
    if misread_rotation(replace(holds, rotation=turned), gravity, criteria.payload_static) is None:
        detail, advice = f"the postures fit the order {other}, not {stated}", f"Say `pose.quaternion_order: {other}`."
        file, key = payload.of("postures")[0].pose.file, "pose.quaternion_order"
        raise BadStudy(Fault(detail, "quaternion_order", advice, file, None, key, stated or ""))


def _span_of(span: Array) -> str:
    return f"row {span[0]:.0f}" if span[0] == span[1] else f"{span[0]:.2f} to {span[1]:.2f} s"


def prior_of(payload: Payload, postures: Postures | None, criteria: Criteria = USUAL) -> Prior:
    """From the postures, with what the settings release: a zero that drifted since, moments that motion decides."""
    prior = static_prior(postures.chosen if postures else None, criteria=criteria.payload_dynamic)
    settings, covariance, lean = payload.file.settings, prior.covariance.copy(), prior.lean.copy()
    released = []
    if settings.zero == "drifted":
        released += [(k, criteria.payload_dynamic.released) for k in range(10, 16)]
    if settings.moments == "from_motion":
        released += [(k, max(float(prior.value[0]), 1.0)) for k in range(1, 4)]
    for k, std in released:
        covariance[k], covariance[:, k] = 0.0, 0.0
        covariance[k, k], lean[k] = std**2, 0.0
    return Prior(prior.value, covariance, lean)


def _without_contact(
    payload: Payload, moved: Sequence[Moved], solution: DynamicSolution, gravity: Array, sign: int, criteria: Criteria
) -> tuple[list[NDArray[np.bool_]], list[tuple[float, float]]]:
    """Which samples nothing touched, and the contacts; all samples where so many stand out that the model is wrong."""
    compensation = Compensation(solution.value, solution.covariance, gravity, sign, std_of(payload))
    keep, found, margin = [], list[tuple[float, float]](), criteria.payload.margin_s
    rate = payload.file.settings.false_alarms_per_hour
    for each in moved:
        time = each.motion.time
        touched = [
            (max(a - margin, float(time[0])), min(b + margin, float(time[-1])))
            for a, b in compensation.pushes(each.motion, each.wrench, rate, criteria.payload_dynamic)
            if b - a > margin / 4
        ]
        free = ~np.any([(time >= a) & (time <= b) for a, b in touched], axis=0) if touched else np.ones(len(time), bool)
        keep.append(np.asarray(free, dtype=bool))
        found += touched
    if np.mean(np.concatenate(keep)) < 1.0 - criteria.payload.touched:
        return [np.ones(len(each.wrench), dtype=bool) for each in moved], []
    return keep, found


def _sign(sees: str) -> int:
    """s of [Payload]: +1 where the sensor reads what it does to the payload; `role: cut` counts the other way round."""
    return -int(SIGN[sees])


def stated_sign(payload: Payload) -> int:
    """s of [Payload], where no posture tells it."""
    if payload.file.sensor.sees is None:
        advice = "Say payload_on_sensor or sensor_on_payload, or hand in postures, which tell it."
        raise BadStudy(Fault("without postures the sign is not known", "no_sign", advice, payload.name, None, "sensor"))
    return _sign(payload.file.sensor.sees)
