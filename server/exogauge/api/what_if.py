"""What if the device were another: changes in, supporting torque before and after out, in milliseconds.

The first question about a log reads it (a second or so); what is read stays ready in this process. The numerics are
imported with the first question.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, final

from fastapi import APIRouter, Request
from pydantic import BaseModel, ConfigDict, Field

from exogauge.api.dependencies import Id, SettingsDep, StorageDep
from exogauge.api.uploads import scratch_folder
from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import StudyRecord
from exogauge.storage.store import Storage
from exogauge.studies.change_entries import ChangeEntries
from exogauge.studies.contract import Name, RelativePath
from exogauge.studies.yaml_file import suggestion

if TYPE_CHECKING:
    from exogauge.api.benches import Ready

router = APIRouter(tags=["what-if"])
CREATING = threading.Lock()


@final
class WhatIfRequest(BaseModel):
    """log: of the study. device: a file of the study to start from; default what the log wears. changes: one after
    another. main: joints that the device is for; default the one with the largest rms torque. series: sample by sample
    too."""

    model_config = ConfigDict(extra="forbid")
    log: Name
    device: RelativePath | None = None
    changes: ChangeEntries = []
    main: Annotated[list[Name], Field(max_length=50)] = []
    series: Annotated[bool, Field(strict=True)] = False


@final
class TorqueOut(BaseModel):
    """peak: of the largest size, with its sign; mean, rms: over time [unit]; integral [unit·s]; work: on the joint
    [J]."""

    peak: float
    mean: float
    rms: float
    integral: float
    work: float


@final
class PercentOut(BaseModel):
    """100 (after / before - 1): 100 is twice as much, -100 nothing left, less is the other way round; null where before
    is 0."""

    peak: float | None
    mean: float | None
    rms: float | None
    integral: float | None
    work: float | None


@final
class JointOut(BaseModel):
    """Torque of all bands together on one joint, positive along it. unit: N·m, N for a prismatic joint."""

    joint: str
    unit: str
    before: TorqueOut
    after: TorqueOut
    percent: PercentOut


@final
class InterferenceOut(BaseModel):
    """A joint that is not main: its rms as a share of that of the main joints; null where theirs is 0."""

    joint: str
    before: float | None
    after: float | None


@final
class BandLoadOut(BaseModel):
    """stretch_max: of the natural length, a ratio; slack_share: of the time."""

    tension_max_n: float
    length_min_m: float
    length_max_m: float
    stretch_max: float
    slack_share: float


@final
class BandOut(BaseModel):
    """null: the band is not there, or (before) its values are not known."""

    band: str
    before: BandLoadOut | None
    after: BandLoadOut | None


@final
class DeviceNameOut(BaseModel):
    file: str
    name: str


@final
class BeforeAfter(BaseModel):
    before: list[float]
    after: list[float]


@final
class BandSeries(BaseModel):
    tension_n: list[float]
    length_m: list[float]


@final
class BandSeriesPair(BaseModel):
    before: BandSeries | None
    after: BandSeries | None


@final
class SeriesOut(BaseModel):
    """t [s]; torque by joint; tension and length by band."""

    t: list[float]
    joints: dict[str, BeforeAfter]
    bands: dict[str, BandSeriesPair]


@final
class WhatIfOut(BaseModel):
    """samples: of the answer, every `every`-th of the log's `of_samples`, low-passed at cutoff_hz before. changed: the
    changed device as the content of a device.yaml. elapsed_ms: for the answer; opening_ms: for reading the log, 0 where
    it was at hand."""

    log: str
    device: DeviceNameOut
    samples: int
    of_samples: int
    every: int
    duration_s: float
    cutoff_hz: float | None
    joints: list[JointOut]
    main: list[str]
    interference: list[InterferenceOut]
    bands: list[BandOut]
    notes: list[str]
    changed: dict[str, Any]
    series: SeriesOut | None
    elapsed_ms: float
    opening_ms: float


@router.post("/studies/{study_id}/whatif", operation_id="whatIf")
def what_if(
    study_id: Id, wanted: WhatIfRequest, request: Request, storage: StorageDep, settings: SettingsDep
) -> WhatIfOut:
    """What the changed device would do over a recorded motion, beside what the present one does.

    At most 5000 samples: a longer log is low-passed as a whole and every n-th sample kept. Each of them is exact, and a
    peak between two of them is missed; a job of kind `whatif` takes them all.
    """
    started = time.perf_counter()
    with storage.reading() as store:
        study = store.studies.get(str(study_id))
        files = store.studies.files(study.id)
    ready = bench_of(request, study, files, wanted, storage, settings)
    opened = time.perf_counter()
    answer = answered(ready, wanted)
    done = time.perf_counter()
    return WhatIfOut(**answer, elapsed_ms=1e3 * (done - opened), opening_ms=1e3 * (opened - started))


def bench_of(
    request: Request,
    study: StudyRecord,
    files: Sequence[PinnedFile],
    wanted: WhatIfRequest,
    storage: Storage,
    settings: Settings,
) -> Ready:
    """The log and its device, kept or read now."""
    from exogauge.api.benches import Benches, open_bench

    refuse_unknown(study, files, wanted)
    with CREATING:
        if not hasattr(request.app.state, "benches"):
            request.app.state.benches = Benches()
    benches: Benches = request.app.state.benches

    def make() -> Ready:
        with scratch_folder(settings) as folder:
            lay_out(study, files, wanted.log, storage, folder)
            return open_bench(folder, wanted.log, wanted.device)

    return benches.get((study.content_hash, wanted.log, wanted.device), make)


def answered(ready: Ready, wanted: WhatIfRequest) -> dict[str, Any]:
    from exogauge.api.benches import BENCH_BYTES, refuse_large
    from exogauge.devices.changes import apply
    from exogauge.devices.what_if import compare
    from exogauge.studies.entry_changes import changes_of
    from exogauge.studies.what_if import answer, series

    changed = apply(ready.motion.device, changes_of(wanted.changes), ready.motion.tree)
    refuse_large(ready.motion, changed, BENCH_BYTES)
    found = compare(ready.bench, changed, wanted.main)
    return answer(found, ready.motion) | {"series": series(found) if wanted.series else None}


def refuse_unknown(study: StudyRecord, files: Sequence[PinnedFile], wanted: WhatIfRequest) -> None:
    """A log or a device file that the study does not hold: nothing else may reach the reader."""
    names = [str(log["name"]) for log in study.summary.get("logs", [])]
    if wanted.log not in names:
        advice = suggestion(wanted.log, names)
        raise BadStudy(
            Fault("the study has no log of this name", "unknown_log", advice, column="log", value=wanted.log)
        )
    paths = [file.path for file in files]
    if wanted.device is not None and wanted.device not in paths:
        near = suggestion(wanted.device, [path for path in paths if path.endswith((".yaml", ".yml"))])
        raise BadInput(Fault("the study has no such file", "missing_file", near, column="device", value=wanted.device))


def lay_out(study: StudyRecord, files: Sequence[PinnedFile], log: str, storage: Storage, folder: Path) -> None:
    """The study's files without the tables of other logs, which may be large."""
    tables = {str(each["name"]): set(each.get("file", ())) for each in study.summary.get("logs", [])}
    others = set[str]().union(*tables.values()) - tables[log]
    for file in files:
        if file.path not in others:
            copy_out(storage.blobs, file.sha256, folder / file.path)
