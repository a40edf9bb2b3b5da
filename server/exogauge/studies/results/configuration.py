"""`configuration` in results.json: on which robot, with which wear in which log, and how it was evaluated."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from exogauge.devices.device import Band
from exogauge.identification.result import Identification
from exogauge.identification.settings import Settings
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Input
from exogauge.studies.results.study_record import LogRecord, StudyRecord, WearRecord
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
