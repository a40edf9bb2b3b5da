"""Which device each log of a study wears, and every device file that is named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from exogauge.devices.device import Device
from exogauge.errors import BadStudy, Fault
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.contract import StudyFile
from exogauge.studies.intake.device_doubts import device_doubts
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.yaml_file import Pointer, dotted, place


@final
@dataclass(frozen=True)
class WornDevices:
    """devices: by file. of_log: the device file of each log, None where it wears none. warnings: sentences."""

    devices: Mapping[str, Device]
    of_log: tuple[str | None, ...]
    warnings: tuple[str, ...]


def read_devices(bundle: Bundle, file: StudyFile, robot: Robot, data: bytes) -> WornDevices:
    """data: study.yaml as written. Raises BadStudy with the faults of every device file."""
    name = bundle.study_file
    of_log = tuple((e.device or file.device) if e.role == "with_device" else None for e in file.logs)
    faults = list[Fault]()
    for k, (entry, worn) in enumerate(zip(file.logs, of_log, strict=True)):
        if entry.role == "with_device" and worn is None:
            detail = "a log with role with_device, and no device file is named"
            advice = "Name it: `device: device.yaml` at the top of the study, or at this log."
            faults.append(Fault(detail, "no_device", advice, name, place(data, ("logs", k)), f"logs.{k}"))
    devices: dict[str, Device] = {}
    warnings = list[str]()
    for written, at in _named(file).items():
        try:
            device = read_device(bundle, written, robot, name, place(data, at), dotted(at))
        except BadStudy as bad:
            faults += bad.faults
            continue
        for other, known in devices.items():
            if known.name == device.name:
                advice = "Results are told apart by it: give each device its own name."
                detail = f"{other!r} has the same name"
                faults.append(Fault(detail, "duplicate_name", advice, written, column="name", value=device.name))
        devices[written] = device
        warnings += [str(doubt) for doubt in device_doubts(bundle, written, robot, device)]
    if faults:
        raise BadStudy(faults)
    return WornDevices(devices, of_log, tuple(warnings))


def _named(file: StudyFile) -> dict[str, Pointer]:
    """Every device file, and where it is named first."""
    places: dict[str, Pointer] = {} if file.device is None else {file.device: ("device",)}
    for k, entry in enumerate(file.logs):
        if entry.device is not None:
            places.setdefault(entry.device, ("logs", k, "device"))
    return places
