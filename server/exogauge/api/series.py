"""Series of a job for plots: which there are, minimum and maximum per screen column, a window of them as a file.

pyarrow is imported with the first question.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal, final

from fastapi import Path, Query, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import BaseModel

from exogauge.api.dependencies import Id, Limit, ReaderDep
from exogauge.api.lists import Key, Mark, part
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import BadInput, Fault, NotFound
from exogauge.storage.blobs import BlobStore
from exogauge.storage.store import Store

if TYPE_CHECKING:
    from exogauge.studies.series.file import SeriesFile
    from exogauge.studies.series.tiles import BlockCache

router = Router(tags=["series"])
FOLDER, SUFFIX = "series/", ".parquet"
MOST_CHANNELS = 64
NEVER_CHANGES = "private, max-age=86400, immutable"  # what a job made never changes
CREATING = threading.Lock()
MEDIA_TYPES = {"csv": "text/csv; charset=utf-8", "parquet": "application/vnd.apache.parquet"}
FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "The window", "content": {kind: {"schema": {"type": "string", "format": "binary"}}
                                                  for kind in ("text/csv", "application/vnd.apache.parquet")}},
}  # fmt: skip

Name = Annotated[str, Path(max_length=200, pattern=r"^[^\x00/]+$", description="name of the series: its log")]
Channels = Annotated[
    tuple[str, ...], Query(max_length=MOST_CHANNELS, description="names of channels, one parameter each")
]
Start = Annotated[float | None, Query(allow_inf_nan=False, description="[s]; default: the first sample")]
End = Annotated[float | None, Query(allow_inf_nan=False, description="[s]; default: the last sample")]

Width = Annotated[int, Query(ge=1, le=8000, description="most stretches: columns of the screen")]


@final
class ChannelOut(Answer):
    """kind: number; truth, drawn as 0 and 1; words, drawn as their place in `words`."""

    name: str
    unit: str
    kind: Literal["number", "truth", "words"]
    words: list[str]


@final
class SeriesOut(BaseModel):
    """start, end: first and last time [s]. rate_hz: mean; null of a single sample."""

    name: str
    log: str
    samples: int
    start: float
    end: float
    rate_hz: float | None
    channels: list[ChannelOut]


@final
class SeriesList(ListOf):
    items: list[SeriesOut]


@final
class ChannelTiles(BaseModel):
    """null: no value in this stretch."""

    min: list[float | None]
    max: list[float | None]


@final
class TilesOut(BaseModel):
    """t: first sample of each stretch [s]. samples: how many the stretches hold. For drawing only: numbers come from
    results.json, which is made of every sample."""

    start: float
    end: float
    t: list[float]
    channels: dict[str, ChannelTiles]
    samples: int


@router.get("/jobs/{job_id}/series", operation_id="listSeries")
def list_series(
    job_id: Id,
    store: ReaderDep,
    response: Response,
    after: Mark,
    limit: Limit = 50,
    name: Annotated[str | None, Query(max_length=200, description="only the series of this name")] = None,
) -> SeriesList:
    """Every series that the job made, by name; empty until it has succeeded."""
    hashes = series_of(store, str(job_id))
    if name is not None:
        hashes = {each: sha256 for each, sha256 in hashes.items() if each == name}
    if hashes:
        response.headers["Cache-Control"] = NEVER_CHANGES
    return page_of(store, hashes, after, limit)


def page_of(store: Store, hashes: Mapping[str, str], after: Key | None, limit: int) -> SeriesList:
    """hashes: name -> SHA-256 of the file."""
    shown, more = part(hashes, lambda name: (name,), after, limit)
    return SeriesList(items=[described(name, opened(store.blobs, hashes[name])) for name in shown], next_cursor=more)


@router.get("/jobs/{job_id}/series/{name}/tiles", operation_id="getSeriesTiles")
def get_series_tiles(
    job_id: Id,
    name: Name,
    channels: Channels,
    store: ReaderDep,
    request: Request,
    response: Response,
    start: Start = None,
    end: End = None,
    width: Width = 1200,
) -> TilesOut:
    """Minimum and maximum of each channel over `width` stretches of the window, and one sample beyond each end.

    Few samples are given as they are, minimum = maximum.
    """
    sha256 = find(store, str(job_id), name)
    response.headers["Cache-Control"] = NEVER_CHANGES
    return tiled(opened(store.blobs, sha256), sha256, channels, start, end, width, request)


@router.get("/jobs/{job_id}/series/{name}/window", operation_id="exportSeries", responses=FILE, response_class=Response)
def export_series(
    job_id: Id,
    name: Name,
    store: ReaderDep,
    channels: Channels = (),
    start: Start = None,
    end: End = None,
    form: Annotated[Literal["csv", "parquet"], Query(alias="format")] = "csv",
) -> StreamingResponse:
    """Every sample of the window as a file; all channels where none is named."""
    return windowed(opened(store.blobs, find(store, str(job_id), name)), name, channels, start, end, form)


def tiled(
    series: SeriesFile,
    key: str,
    channels: tuple[str, ...],
    start: float | None,
    end: float | None,
    width: int,
    request: Request,
) -> TilesOut:
    """key: of what the file holds, under which its blocks are kept."""
    from exogauge.studies.series.tiles import make_blocks, tiles

    names = series.checked(channels)
    first, last = bounds(series, start, end)
    found = tiles(series, cache(request).get(key, lambda: make_blocks(series)), names, first, last, width)
    columns = {each: ChannelTiles(min=plain(found.low[each]), max=plain(found.high[each])) for each in names}
    return TilesOut(start=first, end=last, t=found.t.tolist(), channels=columns, samples=found.samples)


def windowed(
    series: SeriesFile,
    name: str,
    channels: tuple[str, ...],
    start: float | None,
    end: float | None,
    form: Literal["csv", "parquet"],
) -> StreamingResponse:
    """name: of the file that is saved."""
    from exogauge.studies.series.file import window

    names = series.checked(channels) or series.names
    parts: Iterator[bytes] = window(series, names, *bounds(series, start, end), form)
    headers = {"Content-Disposition": f'attachment; filename="{file_name(name)}.{form}"'}
    return StreamingResponse(parts, media_type=MEDIA_TYPES[form], headers=headers)


def series_of(store: Store, job_id: str) -> dict[str, str]:
    """Name -> SHA-256 of the file."""
    paths = ((PurePosixPath(each.name), each) for each in store.results.artifacts(job_id))
    return {path.stem: each.sha256 for path, each in paths if each.name == f"{FOLDER}{path.stem}{SUFFIX}"}


def find(store: Store, job_id: str, name: str) -> str:
    """The SHA-256 of one series; NotFound says which there are."""
    hashes = series_of(store, job_id)
    if name not in hashes:
        listed = ", ".join(hashes) or f"none: it is {store.jobs.get(job_id).state}"
        raise NotFound(f"job {job_id} has no series {name!a}; it has {listed}")
    return hashes[name]


def opened(blobs: BlobStore, sha256: str) -> SeriesFile:
    """A file that a job of ours wrote, never one that was handed in."""
    from exogauge.studies.series.file import SeriesFile

    return SeriesFile(blobs.path_for(sha256) or blobs.open(sha256))


def described(name: str, series: SeriesFile) -> SeriesOut:
    start, end = series.span()
    return SeriesOut(
        name=name,
        log=series.log or name,
        samples=series.samples,
        start=start,
        end=end,
        rate_hz=(series.samples - 1) / (end - start) if end > start else None,
        channels=[ChannelOut.model_validate(each) for each in series.channels()],
    )


def bounds(series: SeriesFile, start: float | None, end: float | None) -> tuple[float, float]:
    """The window; by default the whole. BadInput where it ends before it starts."""
    first, last = series.span()
    first, last = first if start is None else start, last if end is None else end
    if last < first:
        detail = "the window ends before it starts"
        raise BadInput(Fault(detail, "window_reversed", "Give start <= end.", column="end", value=f"{first} … {last}"))
    return first, last


def cache(request: Request) -> BlockCache:
    """The blocks that this process keeps, made when they are first needed."""
    from exogauge.studies.series.tiles import BlockCache

    with CREATING:
        if not hasattr(request.app.state, "series_blocks"):
            request.app.state.series_blocks = BlockCache()
    kept: BlockCache = request.app.state.series_blocks
    return kept


def plain(values: Any) -> list[float | None]:
    """NaN becomes null."""
    return [value if value == value else None for value in values.tolist()]


def file_name(name: str) -> str:
    """What a header may hold of a name."""
    return "".join(sign if sign.isascii() and (sign.isalnum() or sign in "-_.+") else "_" for sign in name)
