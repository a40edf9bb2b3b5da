"""Devices: device.yaml and its bench tests, handed in as files or as a zip, and checked against a robot."""

from __future__ import annotations

import hashlib
import math
from functools import partial
from pathlib import Path
from typing import Annotated

from fastapi import Depends, Response

from exogauge.api import checking
from exogauge.api.bodies import BundleUpload, bundle_schema, device_body
from exogauge.api.bundles import give_files, keep, let_go, listed, shown
from exogauge.api.dependencies import (
    Cursor,
    Id,
    Key,
    Limit,
    Name,
    ReaderDep,
    Search,
    SettingsDep,
    StorageDep,
)
from exogauge.api.logs import lay_out_robot
from exogauge.api.routing import Router
from exogauge.api.shapes import DeviceList, DeviceOut, LawOut, LawsOut, LawValueOut
from exogauge.api.uploads import lay_out, scratch_folder
from exogauge.errors import BadStudy, Fault
from exogauge.storage.blobs import copy_out
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Storage

router = Router(tags=["devices"])
DEVICE = "device.yaml"
ROBOT = {"type": "string", "maxLength": 64, "description": "id of the robot whose links the via points name"}
FORM = bundle_schema(
    "device.yaml and the bench tests it names, under their relative paths, or one zip of them", needed={"robot": ROBOT}
)


@router.post(
    "/devices",
    operation_id="createDevice",
    status_code=201,
    responses={200: {"model": DeviceOut, "description": "The same files were checked against this robot before"}},
    openapi_extra=FORM,
)
def create_device(
    upload: Annotated[BundleUpload, Depends(device_body)],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
) -> DeviceOut:
    """Check and store a device. Other files under the same name, or another robot, make its next version."""
    robot_id = upload.robot or ""
    with scratch_folder(settings) as scratch:
        lay_out_robot(robot_id, storage, scratch / "robot")
        lay_out(upload.files, scratch / "device", settings)
        check = partial(checking.check_device, robot_folder=scratch / "robot")
        device, files, new = keep(
            scratch / "device", DEVICE, check, storage, lambda store: store.devices, upload.name, robot_id=robot_id
        )
    response.status_code = 201 if new else 200
    return DeviceOut.of(device, files=files)


@router.get("/devices", operation_id="listDevices")
def list_devices(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    search: Search = "",
    name: Name = None,
    robot_id: Key = None,
) -> DeviceList:
    page = store.devices.page(cursor, limit, search=search, name=name, robot_id=robot_id)
    return listed(store, store.devices, page, DeviceOut, DeviceList)


@router.get("/band-laws", operation_id="getBandLaws")
def get_band_laws() -> LawsOut:
    """How a band of a device may pull: `law` and `law_values` of device.yaml."""
    from exogauge.effects.band_laws import BandLaw, all_laws

    def told(law: BandLaw) -> LawOut:
        values = [
            LawValueOut(
                name=each.name, unit=each.unit, words=each.words, typical=each.stated.typical, low=each.stated.low,
                high=each.stated.high if math.isfinite(each.stated.high) else None, default=each.stated.default,
            )
            for each in law.values
        ]  # fmt: skip
        return LawOut(name=law.name, sentence=law.sentence, values=values)

    return LawsOut(laws=[told(law) for law in all_laws().values()])


@router.get("/devices/{device_id}", operation_id="getDevice")
def get_device(device_id: Id, store: ReaderDep) -> DeviceOut:
    return shown(store, store.devices, str(device_id), DeviceOut)


give_files(router, "device", "devices", lambda store: store.devices)
let_go(
    router,
    "device",
    "devices",
    lambda store: store.devices,
    "Its files go. Studies keep their own files.",
)


def lay_out_device(device_id: str, number: int, storage: Storage, folder: Path) -> str:
    """Write what a stored device's check read below `folder`; returns the path of its description there.

    Bench tests keep their paths, because device.yaml names them by their path from the study's folder.
    """
    with storage.reading() as store:
        device = store.devices.get(device_id)
        files = store.devices.files(device_id)
    read, description = device.summary.get("reads"), f"device_{number}.yaml"
    for file in files:
        if read is not None and file.path not in read:
            continue
        place = description if file.path == DEVICE else file.path
        refuse_clash(folder / place, file, device.name)
        copy_out(storage.blobs, file.sha256, folder / place)
    return description


def refuse_clash(there: Path, file: PinnedFile, device: str) -> None:
    """Two parts of a study may share one file, but no path may lead to two."""
    other = there.is_file() and hashlib.sha256(there.read_bytes()).hexdigest() != file.sha256
    if other or there.is_dir() or any(folder.is_file() for folder in there.parents):
        detail = f"another part of the study has something else where the device {device!r} has this file"
        raise BadStudy(Fault(detail, "path_clash", "Rename it in one of them.", file=file.path))
