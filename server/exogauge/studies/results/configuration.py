"""`configuration` in results.json: on which robot, with which wear in which log, and how it was evaluated.

What was handed in, gathered for the configuration record: conditions, wears, logs, how far and fast joints went.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from typing import Any, final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.devices.device import Band, Device
from exogauge.identification.result import Identification
from exogauge.identification.settings import Settings
from exogauge.logs.derivatives import differentiate
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Input
from exogauge.studies.intake.contract import Conditions, DeviceFile, DeviceRecord, LogEntry, Role
from exogauge.studies.intake.open import Study
from exogauge.studies.intake.yaml_file import MAX_BYTES, load_yaml
from exogauge.support.settings import SupportSettings

PACKAGES = ("exogauge", "numpy", "scipy", "pin", "pyarrow")


def configuration_entry(
    record: StudyRecord,
    robot: Robot,
    settings: Settings,
    support_settings: SupportSettings,
    found: Identification,
    inputs: Iterable[Input],
) -> dict[str, Any]:
    """What nobody stated is null; `settings` are those used, also where the data chose them."""
    return {
        "synthetic": list(record.synthetic),
        "conditions": record.conditions.model_dump(),
        "robot": {
            "name": robot.name,
            "base": "floating" if robot.floating else "fixed",
            "moving_links": len(robot.tree.bodies),
            "joints": [
                {"joint": each.name, "actuation": each.actuation, "gear_ratio": each.gear_ratio}
                for each in robot.joints
            ],
            "sensors": [{"name": each.name, "role": each.role, "frame": each.frame} for each in robot.sensors],
        },
        "devices": [_wear(each, record.logs) for each in record.wears],
        "logs": [_log(each) for each in record.logs],
        "settings": {
            **stated_settings(settings),
            "cutoff_hz": found.cutoff_hz,
            "prior_strength": found.prior_strength,
            "motion_doubtful": support_settings.doubtful,
            "motion_different": support_settings.different,
        },
        "inputs_sha256": inputs_digest(inputs),
    }


def stated_settings(settings: Settings) -> dict[str, Any]:
    """Without the criteria, which are told with their reasons elsewhere."""
    return {name: value for name, value in asdict(settings).items() if name != "criteria"}


def inputs_digest(inputs: Iterable[Input]) -> str:
    """SHA-256 over one line `hash  file` per file read, sorted by name: as `sha256sum` writes, hashed again."""
    lines = [f"{each.sha256}  {each.file}\n" for each in sorted(inputs, key=lambda each: each.file)]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _wear(wear: WearRecord, logs: Iterable[LogRecord]) -> dict[str, Any]:
    return {
        "device": wear.device.name,
        "file": wear.file,
        "logs": [each.log for each in logs if each.device == wear.device.name],
        "record": wear.told.model_dump(),
        "bands": [_band(band) for band in wear.device.bands],
        "tied": sorted(wear.device.tied),
    }


def _band(band: Band) -> dict[str, Any]:
    """Values as stated in the file, before any data."""
    return {
        "band": band.name,
        "group": band.group,
        "via_points": [{"link": point.link, "xyz": list(point.xyz)} for point in band.via_points],
        "stiffness_n_per_m": band.stiffness,
        "natural_length_m": band.natural_length,
        "ground_truth": band.ground_truth,
        "law": band.law,
        "law_values": dict(band.law_values),
        "bench": band.bench is not None,
    }


def _log(log: LogRecord) -> dict[str, Any]:
    entry = log.entry
    return {
        "log": log.log,
        "files": list(entry.file),
        "mapping": entry.mapping,
        "rows": list(entry.rows) if entry.rows else None,
        "role": log.role,
        "motion": log.motion,
        "device": log.device,
        "duration_s": log.duration_s,
        "samples": log.samples,
        "rate_hz": log.rate_hz,
    }


def software() -> dict[str, str]:
    """Versions that may change a number."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


Array = NDArray[np.float64]

SYNTHETIC = "synthetic"
MOVING_SHARE = 0.01  # of a log's samples above the joint's threshold, from which it counts as moved


@final
@dataclass(frozen=True)
class JointTravel:
    """One joint in one log: lowest, highest position [rad, or m], top speed [per s], all low-passed as for the fit.

    moved: faster than what identification tells from rest for at least `MOVING_SHARE` of the samples.
    """

    joint: str
    lowest: float
    highest: float
    top_speed: float
    moved: bool


@final
@dataclass(frozen=True)
class LogRecord:
    """entry: as study.yaml has it. device: name of what was worn, None for nothing. motion: None without a name."""

    log: str
    entry: LogEntry
    role: Role
    motion: str | None
    device: str | None
    duration_s: float
    samples: int
    rate_hz: float
    joints: tuple[JointTravel, ...]


@final
@dataclass(frozen=True)
class WearRecord:
    """A device file: what it describes, and what it says of the specimen."""

    file: str
    device: Device
    told: DeviceRecord


@final
@dataclass(frozen=True)
class StudyRecord:
    """synthetic: files that say so of themselves, first study.yaml where its name does; empty for measured data."""

    synthetic: tuple[str, ...] = ()
    conditions: Conditions = field(default_factory=Conditions)
    wears: tuple[WearRecord, ...] = ()
    logs: tuple[LogRecord, ...] = ()


def study_record(study: Study, logs: Sequence[Log], found: Identification) -> StudyRecord:
    """logs: every log that was read, with and without a device."""
    named = zip(study.log_names, study.file.logs, study.log_devices, strict=True)
    return StudyRecord(
        synthetic=synthetic_signs(study),
        conditions=study.file.conditions,
        wears=tuple(
            WearRecord(file, device, load_yaml(study.bundle.read(file, limit=MAX_BYTES), DeviceFile, file=file).record)
            for file, device in study.devices.items()
        ),
        logs=tuple(
            _log_record(study, entry, file, log, found)
            for name, entry, file in named
            for log in logs
            if log.recording == name
        ),
    )


def _log_record(study: Study, entry: LogEntry, file: str | None, log: Log, found: Identification) -> LogRecord:
    return LogRecord(
        log=log.name,
        entry=entry,
        role=entry.role,
        motion=entry.motion,
        device=None if file is None else study.devices[file].name,
        duration_s=float(log.time[-1] - log.time[0]),
        samples=log.samples,
        rate_hz=log.rate_hz,
        joints=travels(study.robot, log, found.cutoff_hz, found.velocity_threshold),
    )


def travels(robot: Robot, log: Log, cutoff_hz: float, threshold: Array) -> tuple[JointTravel, ...]:
    """threshold: [rad/s, m/s] by joint, below which identification counts it as at rest."""
    names = [joint.name for joint in robot.joints]
    low_pass = LowPass(cutoff_hz, log.rate_hz)
    settle = min(low_pass.settle_samples, log.samples // 10)  # ends that lean on what was never measured
    kept = slice(settle, log.samples - settle)
    q = low_pass.apply(log.stack([f"q.{name}" for name in names]))
    speed, q = np.abs(differentiate(q, log.rate_hz))[kept], q[kept]
    moving = (speed > np.asarray(threshold)).mean(axis=0)
    return tuple(
        JointTravel(name, float(low), float(high), float(top), bool(share >= MOVING_SHARE))
        for name, low, high, top, share in zip(
            names, q.min(axis=0), q.max(axis=0), speed.max(axis=0), moving, strict=True
        )
    )


def synthetic_signs(study: Study) -> tuple[str, ...]:
    """Files that call themselves synthetic: study.yaml by its name, descriptions by a comment, Parquet by metadata."""
    bundle = study.bundle
    signs = [bundle.study_file] if says_synthetic(study.name) else []
    described = [bundle.study_file, study.file.robot, *study.devices]
    signs += [file for file in described if _comment_says_so(bundle.read(file, limit=MAX_BYTES))]
    logs = [file for entry in study.file.logs for file in entry.file if file.endswith(".parquet")]
    signs += [file for file in logs if _metadata_says_so(str(bundle.path(file)))]
    return tuple(dict.fromkeys(signs))


def says_synthetic(text: str) -> bool:
    return SYNTHETIC in text.lower()


def _comment_says_so(data: bytes) -> bool:
    return any(line.lstrip().startswith(b"#") and SYNTHETIC.encode() in line.lower() for line in data.splitlines()[:20])


def _metadata_says_so(path: str) -> bool:
    try:
        metadata = pq.read_schema(path).metadata or {}
    except (pa.ArrowException, OSError):
        return False
    return says_synthetic(metadata.get(b"exogauge", b"").decode("utf-8", "replace"))
