"""What is wrong with a payload's logs before anything is identified: range, steps, noise, drift, zero, delays, axes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.errors import BadInput, NotIdentifiable
from exogauge.logs.findings import Finding
from exogauge.payload.dynamics import dynamic_rows
from exogauge.payload.evaluate import evaluate
from exogauge.payload.holds import find_holds
from exogauge.payload.imu import find_axes
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.limits import axes, saturated, saturation
from exogauge.payload.prepare import holds_of, moving, stated_of, std_of
from exogauge.payload.statics import static_stage, told_sign

Array = NDArray[np.float64]


def examine(payload: Payload, criteria: Criteria = USUAL) -> list[tuple[str, Finding]]:
    """Log and finding. Raises BadInput where `evaluate` would, before anything is fitted."""
    found = [
        (each.name, finding)
        for each in payload.recordings
        for rule in (saturated, quantised, noise_in_holds, drift_in_holds)
        for finding in rule(payload, each, criteria)
    ]
    if payload.of("postures"):
        found += [("postures", finding) for finding in (*zero_steps(payload, criteria), *imu_axes(payload, criteria))]
    try:
        evaluation = evaluate(payload, criteria=criteria)
    except (BadInput, NotIdentifiable) as problem:
        return [*found, ("all", Finding("error", "ft", "not_identifiable", str(problem), "see what is said there"))]
    gravity = evaluation.stages.gravity
    for each in payload.of("excitation"):
        moved = moving(payload, each, gravity, evaluation.imu)
        rows = dynamic_rows(moved.motion, moved.wrench, gravity, evaluation.sign, std_of(payload))
        found += [(each.name, finding) for finding in delayed(moved.motion.time, rows.z, criteria)]
    doubts = [text for text in evaluation.warnings if text not in saturation(payload, criteria)]
    return [*found, *(("all", Finding("warning", "ft", "doubt", text, "")) for text in doubts)]


def quantised(payload: Payload, recording: Recording, criteria: Criteria = USUAL) -> Iterator[Finding]:
    for name, values, std in axes(payload, recording, std_of(payload)):
        levels = np.unique(values)
        step = float(np.diff(levels).min()) if 1 < len(levels) < len(values) / 2 else 0.0
        if step > criteria.payload_doctor.coarse * std:
            detail = f"values come in steps of {step:.3g}, {step / std:.1f} times the stated noise"
            yield Finding("warning", name, "coarse_steps", detail, "log more digits, or state more noise", None, step)


def noise_in_holds(payload: Payload, recording: Recording, criteria: Criteria = USUAL) -> Iterator[Finding]:
    spans = _spans(payload, recording, criteria)
    for name, values, std in axes(payload, recording, stated_of(payload)) if spans else ():
        time = recording.wrench.time
        within = [np.diff(values[(time >= a) & (time <= b)]).std() / np.sqrt(2.0) for a, b in spans]
        ratio = float(np.median(within)) / std
        least, most = criteria.payload_doctor.noise_ratio
        if not least <= ratio <= most:
            detail = f"samples of a hold scatter by {ratio * std:.3g}, {ratio:.2g} times what is stated"
            advice = "state what was found; a filtered channel scatters less and is late"
            yield Finding("warning", name, "noise_differs", detail, advice, None, ratio * std)


def drift_in_holds(payload: Payload, recording: Recording, criteria: Criteria = USUAL) -> Iterator[Finding]:
    spans = _spans(payload, recording, criteria)
    for name, values, std in axes(payload, recording, std_of(payload)) if spans else ():
        time = recording.wrench.time
        worst = (0.0, 0.0, 0.0)
        for a, b in spans:
            inside = (time >= a) & (time <= b)
            t, y = time[inside] - time[inside].mean(), values[inside]
            slope = float(t @ y / (t @ t))
            chance = std / np.sqrt(t @ t)
            worst = max(worst, (abs(slope) / chance, slope * (b - a), a))
        if worst[0] > criteria.payload_doctor.clear and abs(worst[1]) > std:
            detail = f"the value drifts by {worst[1]:.3g} within the hold at {worst[2]:.2f} s"
            advice = "let the sensor warm up, or wait until the payload has stopped swinging"
            yield Finding("warning", name, "drift_in_hold", detail, advice, None, worst[1])


def zero_steps(payload: Payload, criteria: Criteria = USUAL) -> Iterator[Finding]:
    """A sensor that was zeroed between two postures leaves residuals that change their mean there; one that drifts
    leaves some that go on changing, before and after."""
    holds, _ = holds_of(payload, criteria.payload_static)
    gravity, still, beside = (
        np.array(payload.file.gravity),
        criteria.payload_static,
        criteria.payload_doctor.fewest_beside,
    )
    try:
        left = static_stage(holds, gravity, told_sign(holds, gravity, still), criteria=still).residual
    except NotIdentifiable:
        return
    for axis, name in enumerate(payload.file.sensor.wrench):
        best = (0.0, 0, 0.0)
        for k in range(beside, len(left) - beside + 1):
            before, after = left[:k, axis], left[k:, axis]
            spread = max(float(np.hypot(before.std() / np.sqrt(k), after.std() / np.sqrt(len(after)))),
                         float(holds.std[axis]) * np.sqrt(1 / k + 1 / len(after)))  # fmt: skip
            step = float(after.mean() - before.mean())
            best = max(best, (abs(step) / spread, k, step))
        drifted = _drifted(left[:, axis], best[1])
        if best[0] > criteria.payload_doctor.clear and drifted is not None:
            detail = f"the zero moves on from posture to posture, by {drifted:.3g} or more from the first to the last"
            advice = "let the sensor warm up first; a motion beside the postures tells how it drifts"
            yield Finding("warning", name, "zero_drifts", detail, advice, None, drifted)
        elif best[0] > criteria.payload_doctor.clear:
            detail = f"from posture {best[1] + 1} on the zero is another one, by about {best[2]:.3g}"
            advice = "do not zero the sensor between postures; give the postures before or after it as `span`"
            yield Finding("error", name, "zeroed", detail, advice, None, best[2])


def _drifted(left: Array, at: int) -> float | None:
    """How far a line that bends once, at posture `at`, goes from the first to the last of what is left, (K,); None
    where a step there leaves no more than it. What goes with the postures the fit took up: it is that much or more."""
    K = len(left)
    late, n = np.arange(K) >= at, np.arange(K) - at
    stepped = left - np.where(late, left[late].mean(), left[~late].mean())
    bent = np.column_stack([np.ones(K), np.minimum(n, 0), np.maximum(n, 0)])
    line = bent @ np.linalg.lstsq(bent, left)[0]
    if np.sum((left - line) ** 2) * (K - 2) >= np.sum(stepped**2) * (K - 3):
        return None
    return float(line[-1] - line[0])


def imu_axes(payload: Payload, criteria: Criteria = USUAL) -> Iterator[Finding]:
    holds, acceleration = holds_of(payload, criteria.payload_static)
    if payload.file.imu is None or acceleration is None:
        return
    frame = find_axes(acceleration, holds.rotation, np.array(payload.file.gravity))
    name = payload.file.imu.acceleration[0]
    if frame.angle > np.radians(criteria.payload_doctor.other_axes_deg):
        detail = f"the IMU's axes stand {np.degrees(frame.angle):.1f}° off the sensor's; they are turned as found"
        yield Finding("note", name, "imu_axes", detail, "", None, float(np.degrees(frame.angle)))
    if np.abs(frame.gain - 1.0).max() > criteria.payload_doctor.gain:
        factor = float(frame.gain[np.argmax(np.abs(frame.gain - 1.0))])
        detail = f"the IMU's readings are to be multiplied by {factor:.4g}"
        yield Finding("warning", name, "imu_gain", detail, "is `imu.unit` right?", None, factor)


def delayed(time: Array, z: Array, criteria: Criteria = USUAL) -> Iterator[Finding]:
    """The wrench comes late by δ: F(t - δ) = F - δ Ḟ, one column more. z: (T, 6, n+1) rows [A b]."""
    A = z[:, :, :-1].reshape(-1, z.shape[2] - 1)
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-12)
    b = z[:, :, -1].ravel()
    x = np.linalg.lstsq(A / scale, b, rcond=1e-8)[0]
    rate = np.gradient((A / scale @ x).reshape(-1, 6), time, axis=0).ravel()
    full = np.column_stack([A / scale, -rate])
    y = np.linalg.lstsq(full, b, rcond=1e-8)[0]
    left = b - full @ y
    # Errors of smoothed accelerations repeat themselves over some samples: a quarter of the rows count.
    chance = float(np.sqrt(left @ left / len(b) * np.linalg.pinv(full.T @ full)[-1, -1] * 4.0))
    period = float(np.median(np.diff(time)))
    delta = float(y[-1])
    if abs(delta) > max(criteria.payload_doctor.clear * chance, period / 2):
        detail = f"the wrench is {1e3 * delta:.1f} ± {1e3 * chance:.1f} ms late against the pose"
        advice = "take the same filter off both channels, or shift the stamps by that"
        yield Finding("warning", "ft", "late", detail, advice, None, delta)


def _spans(payload: Payload, recording: Recording, criteria: Criteria) -> list[tuple[float, float]]:
    if recording.each_row:
        return []
    found = find_holds(recording.pose.time, recording.pose.values, payload.file.pose.noise_rad, criteria.payload_static)
    time = recording.wrench.time
    return [(a, b) for a, b in found if np.sum((time >= a) & (time <= b)) > 10]
