"""An IMU beside the sensor: how it sits, by the postures, and how late it is, by the motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.errors import BadStudy, Fault
from exogauge.payload.dynamics import Rows, dynamic_rows, static_prior
from exogauge.payload.imu import ImuFrame, Open, find_axes
from exogauge.payload.imu_place import farther_lag, find_place
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.prepare import carried_of, into_sensor, low_passed, std_of
from exogauge.payload.stages import Postures

Array = NDArray[np.float64]


def placed_imu(payload: Payload, postures: Postures, gravity: Array, criteria: Criteria) -> ImuFrame | None:
    """None where no posture has it. Raises BadStudy where it reads another size than gravity's, or is too late."""
    if postures.acceleration is None:
        return None
    still = criteria.payload_static
    frame = find_axes(postures.acceleration, postures.holds.rotation, gravity, still)
    most, imu = criteria.payload_doctor.other_gain, payload.file.imu
    gain = 1.0 / float(np.median(frame.gain))
    if imu is not None and not 1.0 / most < gain < most:
        detail = f"the IMU reads {gain:.4g} times gravity in the postures"
        files = payload.of("postures")[0].acceleration
        advice = "Check `imu.unit`: m/s^2, g, mg."
        file = "" if files is None else files.file
        raise BadStudy(Fault(detail, "imu_unit", advice, file, None, imu.acceleration[0], f"{gain:.4g}"))
    carrying = [
        (recording, carried)
        for recording in (*payload.of("excitation"), *payload.of("test"))
        if (carried := carried_of(payload, recording, criteria.payload_dynamic)) is not None
    ]
    if not carrying:
        return frame
    sign, std, cutoff_hz = postures.chosen.sign, std_of(payload), payload.file.settings.cutoff_hz
    body = static_prior(postures.chosen, criteria=criteria.payload_dynamic)
    mass, arm = body.value[0], body.value[1:4]

    def rows(tried: ImuFrame, every: int) -> list[Array]:
        out = []
        for recording, carried in carrying:
            motion, slopes = carried.motion(recording.wrench.time[::every], tried, gravity)
            if len(motion.time) < 2:
                continue
            read = recording.wrench.values[np.isin(recording.wrench.time, motion.time)]
            if payload.file.sensor.axes == "base":
                read = into_sensor(motion.rotation, read)
            z = dynamic_rows(motion, read, gravity, sign, std).z
            J = sign * np.concatenate([mass * slopes, np.cross(arm, slopes, axisb=1, axisc=1)], axis=1) / std[:, None]
            both = np.concatenate([z[:, :, :10], J, z[:, :, -1:]], axis=2)
            out.append(low_passed(Rows(both, np.zeros((len(both), 1, 1)), std, sign), motion.time, cutoff_hz).z)
        return out

    clocks = max(_clocks_std(recording) for recording, _ in carrying)
    known = None if imu is None or imu.delay_s is None else clocks  # taken off when the file was read
    found = find_place(frame, rows, body, known, still)
    other = farther_lag(found, rows, body, still) if known is None else None
    if other is not None and imu is not None:
        detail = f"the IMU is about {abs(other):.2f} s {'late' if other > 0 else 'early'} against wrench and pose"
        advice = "All must be stamped when they were measured, by one clock; or state `imu.delay_s`."
        acceleration = carrying[0][0].acceleration
        file = acceleration.file if acceleration else ""
        raise BadStudy(Fault(detail, "clocks_apart", advice, file, None, imu.acceleration[0], f"{other:.2f} s"))
    if known is None:
        found.covariance[Open.LAG, Open.LAG] += clocks**2
    return found


def _clocks_std(recording: Recording) -> float:
    """Std [s] of what stamps of several clocks leave open: each says when a sample was there, which was taken at any
    time in the period before. 0 with one clock."""
    streams = (recording.wrench, recording.pose, recording.acceleration)
    periods = {each.file: float(np.median(np.diff(each.time))) for each in streams if each is not None}
    return float(np.linalg.norm(list(periods.values()))) / np.sqrt(12.0) if len(periods) > 1 else 0.0
