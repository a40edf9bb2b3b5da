"""results.json of an evaluation made by hand: two suits in two motions, on a record whose ranges are known."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.studies.discrepancy.conftest import discrepancy  # noqa: F401
from tests.studies.support.conftest import DEVICES, JOINTS, stiffness, support  # noqa: F401

from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.result import StiffnessResult
from exogauge.findings.result import Discrepancy
from exogauge.identification.result import Identification
from exogauge.studies.intake.contract import Conditions, DeviceRecord, LogEntry
from exogauge.studies.intake.open import open_study
from exogauge.studies.results.configuration import JointTravel, LogRecord, StudyRecord, WearRecord
from exogauge.studies.results.document import Evaluation, results
from exogauge.support.result import SupportResult

FITTED = {"torso_yaw": (-0.7, 0.6, 1.0), "torso_pitch": (-0.1, 0.8, 0.9), "r_elbow": (0.0, 0.0, 0.0)}
WORN = {"torso_yaw": (-0.5, 0.4, 0.5), "torso_pitch": (0.0, 1.2, 0.7), "r_elbow": (0.0, 0.0, 0.0)}


def log_record(name: str, role: str, device: str | None = None, motion: str | None = None) -> LogRecord:
    reach = WORN if device else FITTED
    joints = tuple(JointTravel(joint, *reach[joint], joint != "r_elbow") for joint in JOINTS)
    entry = LogEntry(file=f"logs/{name}.parquet", role=role, motion=motion)
    return LogRecord(name, entry, role, motion, device, 12.0, 2401, 200.0, joints)


def wear(name: str, stated: float) -> WearRecord:
    points = (ViaPoint("chest_1", (-0.1, 0.0, 0.2)), ViaPoint("BODY", (-0.12, 0.0, 0.1)))
    bands = (Band("A_left", "A", points, stated, 0.612, True), Band("A_right", "A", points, stated, 0.613, True),
             Band("B_left", "B", points))  # fmt: skip
    told = DeviceRecord(model="SSL-2", serial="0042") if stated < 300 else DeviceRecord()
    return WearRecord(f"{name.split()[0].lower()}.yaml", Device(name, bands), told)


@pytest.fixture(scope="session")
def record(support: SupportResult) -> StudyRecord:  # noqa: F811
    worn = tuple(log_record(each.log, "with_device", each.device, each.motion) for each in support.trials)
    plain = tuple(log_record(f"{motion}_plain_1", "without_device", None, motion) for motion in ("bend", "twist"))
    return StudyRecord(
        synthetic=("study.yaml",),
        conditions=Conditions(recorded="2026-03-01", robot_cover="none"),
        wears=tuple(wear(name, stated) for name, stated in DEVICES.items()),
        logs=(log_record("id_1", "identification"), log_record("val_1", "validation"), *plain, *worn),
    )


@pytest.fixture(scope="session")
def evaluation(
    pristine: Path,
    identification: Identification,
    support: SupportResult,  # noqa: F811
    stiffness: tuple[StiffnessResult, ...],  # noqa: F811
    discrepancy: Discrepancy,  # noqa: F811
    record: StudyRecord,
) -> Evaluation:
    with open_study(pristine) as study:
        return Evaluation(
            study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification, [], {},
            support, stiffness, discrepancy, record,
        )  # fmt: skip


@pytest.fixture(scope="session")
def whole(evaluation: Evaluation) -> dict[str, Any]:
    """results.json; not to be changed."""
    return results(evaluation)


@pytest.fixture
def content(whole: dict[str, Any]) -> dict[str, Any]:
    """A copy, to be changed at will."""
    return copy.deepcopy(whole)


@pytest.fixture(scope="session")
def evaluated(evaluation: Evaluation) -> Callable[..., dict[str, Any]]:
    """evaluated(support=None, …): results.json with parts of the evaluation replaced."""
    return lambda **parts: results(dataclasses.replace(evaluation, **parts))
