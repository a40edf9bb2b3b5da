"""Which device each log of a study wears, and every device file that is named.

`known` of study.yaml: weighed loads, on links of the robot, in logs of the study.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.devices.device import Device
from exogauge.errors import BadStudy, Fault
from exogauge.robots.description import KnownLoad, Robot
from exogauge.robots.tree import RigidTree
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.contract import KnownEntry, StudyFile
from exogauge.studies.intake.device_check import device_doubts
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.yaml_file import Pointer, dotted, place, suggestion
from exogauge.studies.words.notices import Notice


@final
@dataclass(frozen=True)
class WornDevices:
    """devices: by file. of_log: the device file of each log, None where it wears none. notices: doubts of them."""

    devices: Mapping[str, Device]
    of_log: tuple[str | None, ...]
    notices: tuple[Notice, ...]


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
    notices = list[Notice]()
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
        notices += [Notice(doubt.rule, str(doubt)) for doubt in device_doubts(bundle, written, robot, device)]
    if faults:
        raise BadStudy(faults)
    return WornDevices(devices, of_log, tuple(notices))


def _named(file: StudyFile) -> dict[str, Pointer]:
    """Every device file, and where it is named first."""
    places: dict[str, Pointer] = {} if file.device is None else {file.device: ("device",)}
    for k, entry in enumerate(file.logs):
        if entry.device is not None:
            places.setdefault(entry.device, ("logs", k, "device"))
    return places


UNKNOWN_CENTRE_M = 0.1  # from the link's origin, where nothing is stated: a load on a flange seldom reaches further
MEASURED_CENTRE_M = 0.02  # where it is, without a doubt: what a ruler and a guess at a lump's inside are worth


def read_known_loads(file: StudyFile, tree: RigidTree, logs: Sequence[str], data: bytes, name: str) -> list[KnownLoad]:
    """logs: names of the study's. data, name: study.yaml as written, and its own. Raises BadStudy with every fault."""
    faults = [fault for k, entry in enumerate(file.known) for fault in _faults(entry, k, tree, logs, data, name)]
    if faults:
        raise BadStudy(faults)
    links = [entry.link for entry in file.known]
    return [_load(entry, tree, _numbered(links, k)) for k, entry in enumerate(file.known)]


def _load(entry: KnownEntry, tree: RigidTree, name: str) -> KnownLoad:
    body, T_body_link = tree.frames[entry.link]
    x, y, z = T_body_link.act(np.array(entry.com_m or (0.0, 0.0, 0.0))).tolist()
    usual = UNKNOWN_CENTRE_M if entry.com_m is None else MEASURED_CENTRE_M
    std_centre = usual if entry.std_com_m is None else entry.std_com_m
    return KnownLoad(name, body, entry.mass_kg, entry.std_kg, (x, y, z), std_centre, tuple(dict.fromkeys(entry.logs)))


def _numbered(links: Sequence[str], k: int) -> str:
    """The link's name; from its second load on with a number."""
    before = links[:k].count(links[k])
    return f"{links[k]} {before + 1}" if before else links[k]


def _faults(entry: KnownEntry, k: int, tree: RigidTree, logs: Sequence[str], data: bytes, name: str) -> Iterator[Fault]:
    def fault(detail: str, rule: str, advice: str, key: str, value: object, *more: int) -> Fault:
        pointer: Pointer = ("known", k, key, *more)
        return Fault(detail, rule, advice, name, place(data, pointer), dotted(pointer), str(value))

    if entry.mass_kg <= 0.0:
        advice = "Give what the scales say, in kg; a log without a load is left out of `logs`."
        yield fault("a load weighs more than nothing", "mass_not_positive", advice, "mass_kg", f"{entry.mass_kg:g}")
    if entry.std_kg <= 0.0 or entry.std_kg >= max(entry.mass_kg, 0.0) > 0.0:
        advice = "Give the standard deviation of the weighing in kg: 0.005 for scales that are good to 10 g."
        yield fault(
            "the doubt of a weighed mass lies between 0 and the mass",
            "mass_doubt_impossible",
            advice,
            "std_kg",
            f"{entry.std_kg:g}",
        )
    if entry.link in tree.dropped:
        advice = "The robot ends at that sensor: what hangs beyond it is in its reading."
        yield fault(f"link {entry.link!r} lies beyond a contact sensor", "link_left_out", advice, "link", entry.link)
    elif entry.link not in tree.frames:
        advice = suggestion(entry.link, list(tree.frames))
        yield fault(f"the URDF holds no link {entry.link!r}", "unknown_link", advice, "link", entry.link)
    elif tree.frames[entry.link][0] < 0:
        advice = "Name the moving link that carries it."
        yield fault(
            f"no joint moves {entry.link!r}: nothing feels a load there", "link_fixed", advice, "link", entry.link
        )
    for place_of, log in enumerate(entry.logs):
        if log not in logs:
            advice = suggestion(log, list(logs))
            yield fault(f"no log is named {log!r}", "unknown_log", advice, "logs", log, place_of)
