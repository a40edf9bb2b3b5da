"""A payload in words that a list can show, before anything is identified."""

from __future__ import annotations

from typing import Any

from exogauge.payload.intake import Payload, Recording


def summary(payload: Payload) -> dict[str, Any]:
    """logs: rate_hz and duration_s of the wrench, None where each row is one posture. plan: joints that move."""
    file = payload.file
    pose = file.pose
    return {
        "name": file.name,
        "gravity": list(file.gravity),
        "sensor": file.sensor.model_dump(mode="json"),
        "pose": "joints" if pose.joints else "quaternion" if pose.quaternion else "rotation",
        "joints": list(pose.joints or ()),
        "imu": file.imu is not None,
        "settings": file.settings.model_dump(mode="json"),
        "ground_truth": file.ground_truth.model_dump(mode="json"),
        "logs": [
            {"file": list(entry.file)} | _seen(each) for entry, each in zip(file.logs, payload.recordings, strict=True)
        ],
        "plan": None if file.plan is None else {"joints": list(file.plan.joints)},
    }


def _seen(recording: Recording) -> dict[str, Any]:
    time = recording.wrench.time
    duration = None if recording.each_row else float(time[-1] - time[0])
    rate = None if not duration else (len(time) - 1) / duration
    return {
        "name": recording.name,
        "role": recording.role,
        "samples": len(time),
        "rate_hz": rate,
        "duration_s": duration,
    }
