"""An IMU beside the sensor: how it sits, by the postures, and how late it is, by the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.errors import BadStudy, Fault
from exogauge.payload.imu import ImuFrame, farther_lag, find_axes, find_lag
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.prepare import moving, rows_of
from exogauge.payload.stages import Postures

Array = NDArray[np.float64]


def placed_imu(payload: Payload, postures: Postures, gravity: Array, criteria: Criteria) -> ImuFrame | None:
    """None where no posture has it. Raises BadStudy where it reads another size than gravity's, or is too late."""
    if postures.acceleration is None:
        return None
    frame = find_axes(postures.acceleration, postures.holds.rotation, gravity)
    most, imu = criteria.payload_doctor.other_gain, payload.file.imu
    gain = 1.0 / float(np.median(frame.gain))
    if imu is not None and not 1.0 / most < gain < most:
        detail = f"the IMU reads {gain:.4g} times gravity in the postures"
        files = payload.of("postures")[0].acceleration
        advice = "Check `imu.unit`: m/s^2, g, mg."
        file = "" if files is None else files.file
        raise BadStudy(Fault(detail, "imu_unit", advice, file, None, imu.acceleration[0], f"{gain:.4g}"))
    if payload.file.imu is not None and payload.file.imu.delay_s is not None:
        return replace(frame, lag_s=0.0)  # taken off when the file was read
    carrying = [
        each for each in (*payload.of("excitation"), *payload.of("test"))
        if each.acceleration is not None and each.rotation is not None and each.position is None
    ]  # fmt: skip
    sign = postures.chosen.sign

    def rows(lag: float) -> list[Array]:
        """Of the logs one by one: each has its own zero, and all share the stamps of one IMU."""
        moved = (
            moving(payload, recording, gravity, replace(frame, lag_s=lag), criteria.payload_dynamic)
            for recording in carrying
        )
        return [rows_of(payload, [each], gravity, sign).z for each in moved]

    if not carrying:
        return frame
    found = find_lag(frame, rows, criteria.payload_static)
    other = farther_lag(found, rows, criteria.payload_static)
    if other is not None and imu is not None:
        detail = f"the IMU is about {abs(other):.2f} s {'late' if other > 0 else 'early'} against wrench and pose"
        advice = "All must be stamped when they were measured, by one clock; or state `imu.delay_s`."
        file = carrying[0].acceleration.file if carrying[0].acceleration else ""
        raise BadStudy(Fault(detail, "clocks_apart", advice, file, None, imu.acceleration[0], f"{other:.2f} s"))
    return replace(found, lag_std_s=float(np.hypot(found.lag_std_s, max(map(_clocks_std, carrying)))))


def _clocks_std(recording: Recording) -> float:
    """Std [s] of what stamps of several clocks leave open: each says when a sample was there, which was taken at any
    time in the period before. 0 with one clock."""
    streams = (recording.wrench, recording.pose, recording.acceleration)
    periods = {each.file: float(np.median(np.diff(each.time))) for each in streams if each is not None}
    return float(np.linalg.norm(list(periods.values()))) / np.sqrt(12.0) if len(periods) > 1 else 0.0
