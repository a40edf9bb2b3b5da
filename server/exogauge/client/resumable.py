"""A large file goes up in pieces (tus 1.0.0); when the line breaks, it goes on behind what the service confirms."""

from __future__ import annotations

import base64
import hashlib
import time
from collections.abc import Callable
from pathlib import Path

import httpx

from exogauge.client.problem import ClientProblem, problem_of
from exogauge.client.transport import BUSY, Transport

PIECE = 8 << 20
PATIENCE_S = 300.0  # without a byte of progress
TUS = {"Tus-Resumable": "1.0.0"}
AGAIN = {*BUSY, 409, 423, 460}  # busy, at another offset, still held by a broken connection, damaged on the way


def upload(
    http: Transport, file: Path, say: Callable[[int], None] = lambda sent: None, patience_s: float = PATIENCE_S
) -> str:
    """The id of the upload, when all of it has arrived. say(bytes confirmed). Raises ClientProblem."""
    size = file.stat().st_size
    name = base64.b64encode(file.name.encode()).decode()
    begun = http.begin("uploads", {**TUS, "Upload-Length": str(size), "Upload-Metadata": f"filename {name}"})
    key = str(begun["id"])
    place, offset, moved, pause = f"uploads/{key}", 0, time.monotonic(), 0.2
    with file.open("rb") as source:
        while offset < size:
            source.seek(offset)
            confirmed = _step(http, place, source.read(PIECE), offset)
            if confirmed is None:
                if time.monotonic() - moved > patience_s:
                    raise ClientProblem(0, f"{file.name} does not get on", f"{offset} of {size} bytes have arrived")
                time.sleep(pause)
                pause = min(2 * pause, 5.0)
                confirmed = _asked(http, place)
            if confirmed is not None and confirmed != offset:
                offset, moved, pause = confirmed, time.monotonic(), 0.2
                say(offset)
    return key


def _step(http: Transport, place: str, piece: bytes, offset: int) -> int | None:
    """How much has arrived with this piece; None where that has to be asked."""
    digest = base64.b64encode(hashlib.sha256(piece).digest()).decode()
    headers = {
        **TUS,
        "Content-Type": "application/offset+octet-stream",
        "Upload-Offset": str(offset),
        "Upload-Checksum": f"sha256 {digest}",
    }
    return _offset(lambda: http.once("PATCH", place, headers=headers, content=piece))


def _asked(http: Transport, place: str) -> int | None:
    return _offset(lambda: http.once("HEAD", place, headers=TUS))


def _offset(send: Callable[[], httpx.Response]) -> int | None:
    try:
        response = send()
    except httpx.TransportError:
        return None
    if response.status_code in AGAIN:
        return None
    if response.is_error:
        raise problem_of(response)
    return int(response.headers["Upload-Offset"])
