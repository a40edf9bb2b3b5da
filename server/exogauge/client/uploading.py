"""The folder of a study, robot or device as one zip, the same bytes each time; what must not leave stays behind.

A large file goes up in pieces (tus 1.0.0); when the line breaks, it goes on behind what the service confirms.
"""

from __future__ import annotations

import base64
import hashlib
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import yaml

from exogauge.client.problems import BUSY, ClientProblem, NotNow, foreign, problem_of
from exogauge.client.transport import Transport, digest
from exogauge.errors import BadStudy, Fault
from exogauge.terminal import bar

STAYS_BEHIND = {"truth.json", "truth"}  # of synthetic studies: what no evaluating code may see
STORED = {".parquet", ".gz", ".zip", ".png"}
NAMES_A_FILE = {"urdf", "file"}
YAML = (".yaml", ".yml")
LARGE = 64 << 20  # bytes from which logs go up in pieces
EPOCH = (1980, 1, 1, 0, 0, 0)


def zipped(folder: Path, main: str, target: Path) -> Path:
    """Pack the files below `folder`, which must hold `main`; hidden files and the truth are left out."""
    if not (folder / main).is_file():
        raise BadStudy(Fault(f"the folder holds no {main}", "missing_file", "Name the folder that does.", str(folder)))
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return packed({path.relative_to(folder): path for path in found}, target)


def zipped_description(description: Path, main: str, target: Path) -> Path:
    """Pack a robot.yaml or device.yaml as `main`, the files it names, and nothing else of the folder they are in."""
    folder = description.parent
    try:
        names = sorted(set(named_files(yaml.safe_load(description.read_text()))))
    except (yaml.YAMLError, UnicodeDecodeError):
        names = []  # the service says where it is broken
    named = {Path(name): folder / name for name in names if ".." not in Path(name).parts}
    there = {name: path for name, path in named.items() if path.is_file()}
    return packed({Path(main): description, **there}, target)


def named_files(content: Any) -> Iterator[str]:
    """The values of all keys that name a file."""
    for key, value in content.items() if isinstance(content, dict) else ():
        if key in NAMES_A_FILE and isinstance(value, str) and not Path(value).is_absolute():
            yield value
    for part in content.values() if isinstance(content, dict) else content if isinstance(content, list) else ():
        yield from named_files(part)


def packed(files: Mapping[Path, Path], target: Path) -> Path:
    """A zip of `files`: path in it -> path on disk."""
    with zipfile.ZipFile(target, "w") as bundle:
        for name, path in files.items():
            if any(part in STAYS_BEHIND or part.startswith(".") for part in name.parts):
                continue
            entry = zipfile.ZipInfo(name.as_posix(), EPOCH)
            entry.compress_type = zipfile.ZIP_STORED if path.suffix in STORED else zipfile.ZIP_DEFLATED
            with path.open("rb") as source, bundle.open(entry, "w", force_zip64=True) as member:
                while chunk := source.read(1 << 20):
                    member.write(chunk)
    return target


@contextmanager
def _bundle(source: Path, main: str) -> Iterator[Path]:
    """The file to send: that of a folder, or of the `main` in it, is a zip."""
    source = source.parent if source.name == main else source
    if not source.is_dir():
        yield source
        return
    with tempfile.TemporaryDirectory() as temporary:
        yield zipped(source, main, Path(temporary) / f"{source.resolve().name}.zip")


def send_logs(http: Transport, path: str, source: Path, main: str) -> Any:
    """A folder with logs, its `main`, or a zip; a large one in pieces, with a bar on stderr."""
    with _bundle(source, main) as file:
        if not (file.is_file() and file.stat().st_size >= LARGE):
            return http.post(path, files={"files": file})
        try:
            return http.post(f"{path}/from-upload", {"upload_ids": [send(http, file, shown=True)]})
        except ClientProblem as gone:
            if gone.status != 404:
                raise
        # another run sent the same file, and was quicker to use it
        return http.post(f"{path}/from-upload", {"upload_ids": [send(http, file, shown=True)]})


def send_described(http: Transport, path: str, source: Path, main: str, form: Mapping[str, str] | None = None) -> Any:
    """A description under any name, with the files it names; or what else makes a bundle."""
    if source.suffix in YAML and source.is_file():
        with tempfile.TemporaryDirectory() as temporary:
            packed = zipped_description(source, main, Path(temporary) / f"{source.stem}.zip")
            return http.post(path, files={"files": packed}, form=form)
    with _bundle(source, main) as file:
        return http.post(path, files={"files": file}, form=form)


def send(http: Transport, file: Path, *, shown: bool) -> str:
    """As `upload`. shown: with a bar on stderr."""
    size = max(file.stat().st_size, 1)
    with bar(f"sending {file.name}", shown=shown) as say:
        return upload(http, file, lambda sent: say(sent / size, file.name, "sending"))


PIECE = 8 << 20
PATIENCE_S = 300.0  # without a byte of progress
TUS = {"Tus-Resumable": "1.0.0"}
AGAIN = {*BUSY, 409, 423, 460}  # busy, at another offset, still held by a broken connection, damaged on the way


def upload(
    http: Transport, file: Path, say: Callable[[int], None] = lambda sent: None, patience_s: float = PATIENCE_S
) -> str:
    """The id of the upload, when all of it has arrived. say(bytes confirmed). Raises ClientProblem.

    Where an earlier run began with the same file, in the last day, this one goes on.
    """
    size = file.stat().st_size
    key, offset = _begun(http, file, size)
    place, moved, pause = f"uploads/{key}", time.monotonic(), 0.2
    with file.open("rb") as source:
        while offset < size:
            source.seek(offset)
            confirmed = _step(http, place, source.read(PIECE), offset)
            if confirmed is None:
                if time.monotonic() - moved > patience_s:
                    raise NotNow(0, f"{file.name} does not get on", f"{offset} of {size} bytes have arrived")
                time.sleep(pause)
                pause = min(2 * pause, 5.0)
                confirmed = _asked(http, place)
            if confirmed is not None and confirmed != offset:
                offset, moved, pause = confirmed, time.monotonic(), 0.2
                say(offset)
    return key


def _begun(http: Transport, file: Path, size: int) -> tuple[str, int]:
    """Its id, and how much has arrived before."""
    name = base64.b64encode(file.name.encode()).decode()
    headers = {**TUS, "Upload-Length": str(size), "Upload-Metadata": f"filename {name}"}
    key = http.begin("uploads", headers, http.own_key(f"{digest(file)} {name}"))
    try:
        return key, _asked(http, f"uploads/{key}") or 0
    except ClientProblem as gone:
        if gone.status != 404:
            raise
    return http.begin("uploads", headers), 0  # the earlier one is used up, or was given up


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
    told = response.headers.get("Upload-Offset", "")
    if not (response.is_success and told.isdecimal()):
        raise foreign(response)
    return int(told)
