"""The logs of a study for plots, as they were read: whether or not a job has used them, and whatever became of it.

A log is read when it is first asked for, by a short-lived child (as all that opens uploads), which leaves a series
file; that is kept on a shelf beside the data.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from fastapi import Depends, Query, Request, Response
from fastapi.responses import StreamingResponse

from exogauge.api.dependencies import Id, SettingsDep, StorageDep
from exogauge.api.opening_raw import RAW
from exogauge.api.routing import Router
from exogauge.api.scenes import hashed
from exogauge.api.series import (
    FILE,
    NEVER_CHANGES,
    Channels,
    End,
    Name,
    SeriesOut,
    Start,
    TilesOut,
    Width,
    described,
    tiled,
    windowed,
)
from exogauge.api.uploads import scratch_folder
from exogauge.api.what_if import lay_out
from exogauge.errors import BadStudy, NotFound
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.settings import Settings
from exogauge.storage.records import StudyRecord
from exogauge.storage.shelf import Shelf
from exogauge.storage.store import Storage

if TYPE_CHECKING:
    from exogauge.studies.series.file import SeriesFile

router = Router(prefix="/studies/{study_id}/series/{name}", tags=["series"])
CHILD = "exogauge.api.opening_raw"
VERSION = "1"  # of what the child writes
KEPT_BYTES = 4 << 30
CREATING = threading.Lock()


def raw_file(study_id: Id, name: Name, request: Request, storage: StorageDep, settings: SettingsDep) -> Path:
    """The log as a series file, read now where it is not kept."""
    with storage.reading() as store:
        study = store.studies.get(str(study_id))
    names = [str(log["name"]) for log in study.summary.get("logs", [])]
    if name not in names:
        raise NotFound(f"the study has no log {name!a}; it has {', '.join(names) or 'none'}")
    key = hashed(study.content_hash, name, VERSION)
    return shelf_of(request, settings).filled(key, lambda path: read_now(study, name, path, storage, settings))


RawFile = Annotated[Path, Depends(raw_file)]


@router.get("", operation_id="getRawSeries")
def get_raw_series(name: Name, path: RawFile, response: Response) -> SeriesOut:
    """What a log holds, by the names of its channels: `q.torso_pitch`, `ft.wrist.fx`. Reads it, the first time."""
    response.headers["Cache-Control"] = NEVER_CHANGES
    return described(name, opened(path))


@router.get("/tiles", operation_id="getRawSeriesTiles")
def get_raw_series_tiles(
    path: RawFile,
    channels: Channels,
    request: Request,
    response: Response,
    start: Start = None,
    end: End = None,
    width: Width = 1200,
) -> TilesOut:
    """As the tiles of a job's series."""
    response.headers["Cache-Control"] = NEVER_CHANGES
    return tiled(opened(path), path.name, channels, start, end, width, request)


@router.get("/window", operation_id="exportRawSeries", responses=FILE, response_class=Response)
def export_raw_series(
    name: Name,
    path: RawFile,
    channels: Channels = (),
    start: Start = None,
    end: End = None,
    form: Annotated[Literal["csv", "parquet"], Query(alias="format")] = "csv",
) -> StreamingResponse:
    """Every sample of the window as a file; all channels where none is named."""
    return windowed(opened(path), name, channels, start, end, form)


def opened(path: Path) -> SeriesFile:
    from exogauge.studies.series.file import SeriesFile

    return SeriesFile(path)


def shelf_of(request: Request, settings: Settings) -> Shelf:
    with CREATING:
        if not hasattr(request.app.state, "raw_shelf"):
            request.app.state.raw_shelf = Shelf(settings.data_dir / "raw-series", KEPT_BYTES, ".parquet")
    shelf: Shelf = request.app.state.raw_shelf
    return shelf


def read_now(study: StudyRecord, log: str, path: Path, storage: Storage, settings: Settings) -> None:
    """The file appears at `path`."""
    with storage.reading() as store:
        files = store.studies.files(study.id)
    with scratch_folder(settings) as scratch:
        folder, own = scratch / "study", scratch / "own"
        own.mkdir()
        lay_out(study, files, log, storage, folder)
        limits = Limits.for_bytes(sum(each.stat().st_size for each in folder.rglob("*") if each.is_file()))
        ask(CHILD, "raw", {"folder": str(folder), "log": log}, own, limits, BadStudy, what="study")
        os.replace(own / RAW, path)
