"""One device in several labs: every study that the caller may see and that wore it, and whether the labs agree."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from typing import Annotated, Any, Literal, final

from fastapi import Query, Request
from pydantic import BaseModel

from exogauge.api.datacite import permalink
from exogauge.api.dependencies import NO_NUL, CallerDep, InstallationDep, Limit, PublicAddress
from exogauge.api.lists import Mark, part
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import NotFound
from exogauge.storage.blobs import BlobStore
from exogauge.storage.shares import VisibleResult, visible_results
from exogauge.storage.store import Installation
from exogauge.studies.results.between_labs import DeviceKey, Wearing, compared, wearings

router = Router(tags=["compare"])
MOST = 500  # studies, and as many publications, the newest
Words = Annotated[str, Query(max_length=200, pattern=NO_NUL)]
Found = tuple[VisibleResult, Wearing]


@final
class MeasuredOut(Answer):
    value: float | None
    std: float | None
    unit: str


@final
class WornBand(Answer):
    """approach: the headline one. Intervals: 95 %, [low, high], null where open."""

    group: str
    band: str
    approach: str
    stiffness_n_per_m: MeasuredOut
    stiffness_interval: list[float | None]
    identifiable: bool
    natural_length_m: MeasuredOut
    length_interval: list[float | None]
    length_identifiable: bool


@final
class WornTorque(Answer):
    """mean: null where another approach tells it."""

    motion: str
    joint: str
    unit: str
    approach: str
    peak: MeasuredOut
    mean: MeasuredOut | None


@final
class WornIn(BaseModel):
    """seen: own, shared with one's lab, or published. study_id, job_id: null where one reads the publication alone.
    specimen: `record` of its device.yaml. synthetic: its files say of themselves that they are."""

    lab: str
    seen: Literal["own", "shared", "published"]
    study_id: str | None
    job_id: str | None
    published: str | None
    at: datetime
    study: str
    robot: str
    device: str
    synthetic: bool
    specimen: dict[str, str | None]
    bands: list[WornBand]
    torques: list[WornTorque]


@final
class AgreementOut(Answer):
    """mean, std: weighted; std is larger by the Birge ratio where that is above 1. q: Cochran's; probability: of such
    a q by chance. tau: standard deviation between labs, tau_interval: 95 %. provisional: of fewer labs than ISO 5725-2
    asks for. undecided: of fewer than two."""

    labs: int
    verdict: Literal["agree", "differ", "undecided"]
    provisional: bool
    mean: float | None
    std: float | None
    q: float | None
    probability: float | None
    i_squared: float | None
    birge_ratio: float | None
    tau: float | None
    tau_interval: list[float] | None


@final
class QuantityOut(Answer):
    """rows: which of `studies` count: of each lab the newest that decides the quantity."""

    quantity: Literal["stiffness", "natural_length", "peak_torque", "mean_torque"]
    of: str
    unit: str
    rows: list[int]
    values: list[float]
    found: AgreementOut


@final
class ComparedDevice(BaseModel):
    """studies: newest first."""

    model: str
    size: str | None
    studies: list[WornIn]
    quantities: list[QuantityOut]


@final
class DeviceSeen(BaseModel):
    """model: of its record, else its name. labs, studies: how many one sees."""

    model: str
    size: str | None
    labs: int
    studies: int


@final
class DevicesSeen(ListOf):
    items: list[DeviceSeen]


@final
class Extracts:
    """What results say of devices, by the hash of their bytes, which never change."""

    def __init__(self, most: int = 4 * MOST) -> None:
        self._kept: OrderedDict[str, list[Wearing]] = OrderedDict()
        self._most, self._lock = most, threading.Lock()

    def of(self, blobs: BlobStore, sha256: str) -> list[Wearing]:
        with self._lock:
            if sha256 in self._kept:
                self._kept.move_to_end(sha256)
                return self._kept[sha256]
        found = wearings(opened(blobs, sha256))
        with self._lock:
            self._kept[sha256] = found
            if len(self._kept) > self._most:
                self._kept.popitem(last=False)
        return found


@router.get("/compare/devices", operation_id="listComparedDevices")
def list_compared_devices(
    caller: CallerDep, installation: InstallationDep, request: Request, after: Mark, limit: Limit = 50
) -> DevicesSeen:
    """Devices that were worn in studies of one's own lab, in shared ones and in published ones; of most labs first."""
    found: dict[tuple[str, str], list[Found]] = {}
    for seen, worn in all_seen(installation, caller.lab_id or "", request.app.state.extracts):
        found.setdefault(worn.key.same, []).append((seen, worn))
    items = [
        DeviceSeen(
            model=first.key.model, size=first.key.size, labs=len({seen.lab_id for seen, _ in each}), studies=len(each)
        )
        for each in found.values()
        for _, first in each[:1]
    ]
    shown, more = part(items, lambda each: (-each.labs, -each.studies, each.model, each.size or ""), after, limit)
    return DevicesSeen(items=shown, next_cursor=more)


@router.get("/compare/device", operation_id="compareDevice")
def compare_device(
    model: Words,
    caller: CallerDep,
    installation: InstallationDep,
    request: Request,
    address: PublicAddress,
    size: Annotated[
        str | None, Query(max_length=200, pattern=NO_NUL, description="where device.yaml states one")
    ] = None,
) -> ComparedDevice:
    """Who wore it on which robot, what each found, and whether the labs agree; 404 where no study that one sees wore
    it."""
    wanted = DeviceKey(model, size).same
    extracts: Extracts = request.app.state.extracts
    found = [each for each in all_seen(installation, caller.lab_id or "", extracts) if each[1].key.same == wanted]
    if not found:
        raise NotFound(f"no study that you may see wore a device {model!a}")
    key = found[0][1].key
    quantities = compared([worn for _, worn in found], [seen.lab_id for seen, _ in found])
    return ComparedDevice(
        model=key.model,
        size=key.size,
        studies=[worn_in(seen, worn, address) for seen, worn in found],
        quantities=[QuantityOut.model_validate(each) for each in quantities],
    )


def all_seen(installation: Installation, lab_id: str, extracts: Extracts) -> Iterable[Found]:
    """Newest first."""
    with installation.reading() as session:
        results = visible_results(session, lab_id, MOST)
    return [(seen, worn) for seen in results for worn in extracts.of(installation.blobs, seen.sha256)]


def worn_in(seen: VisibleResult, worn: Wearing, address: str) -> WornIn:
    shown: Mapping[str, Any] = vars(seen) | vars(worn)
    parts: Mapping[str, Sequence[Any]] = {
        "bands": [WornBand.model_validate(each) for each in worn.bands],
        "torques": [WornTorque.model_validate(each) for each in worn.torques],
    }
    published = None if seen.published is None else permalink(seen.published, address)
    return WornIn.model_validate(dict(shown) | dict(parts) | {"published": published})


def opened(blobs: BlobStore, sha256: str) -> dict[str, Any]:
    with blobs.open(sha256) as stream:
        content: dict[str, Any] = json.load(stream)
    return content
