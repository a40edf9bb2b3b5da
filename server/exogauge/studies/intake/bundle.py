"""The study's folder, or a zip of it unpacked under caps; no path leaves it."""

from __future__ import annotations

import errno
import hashlib
import lzma
import shutil
import stat
import tempfile
import weakref
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import final

from exogauge.errors import BadStudy, Fault, TooLarge
from exogauge.studies.intake.yaml_file import listed, suggestion

MAX_MEMBERS = 2_000
MAX_UNPACKED = 4_000_000_000
MAX_RATIO = 200
_CHUNK = 1 << 20
_BAD_ZIP = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, NotImplementedError, EOFError, RuntimeError,
            IsADirectoryError, FileExistsError, NotADirectoryError, UnicodeError)  # fmt: skip


@final
@dataclass(frozen=True)
class Input:
    """One file that an evaluation read: path relative to the study, SHA-256 of its bytes, size in bytes."""

    file: str
    sha256: str
    bytes: int


@final
class Bundle:
    """root: folder that holds study_file. A zip's unpacked copy ends with the bundle."""

    def __init__(self, root: Path, study_file: str, temporary: Path | None = None) -> None:
        self.root, self.study_file = root.resolve(), study_file
        self._inputs: dict[str, Input] = {}
        self._cleanup = None if temporary is None else weakref.finalize(self, shutil.rmtree, temporary, True)

    def close(self) -> None:
        if self._cleanup is not None:
            self._cleanup()

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Every file asked for so far, by name."""
        return tuple(self._inputs[name] for name in sorted(self._inputs))

    def path(
        self, name: str, *, named_in: str | None = None, column: str | None = None, row: int | None = None
    ) -> Path:
        """The file on disk; refused when it is missing or a link leads out of the folder.

        named_in, row, column: where the name is written.
        """
        pure = PurePosixPath(name)

        def refuse(detail: str, rule: str, advice: str = "") -> BadStudy:
            return BadStudy(Fault(detail, rule, advice, named_in or name, row, column, name))

        if pure.is_absolute() or ".." in pure.parts or "\\" in name:
            raise refuse("the path leaves the study's folder", "path_escapes")
        found = self.root / pure
        if not found.resolve().is_relative_to(self.root):
            raise refuse("a link leads out of the study's folder", "path_escapes", "Copy the file into the folder.")
        if found.is_dir():
            inside = sorted(self._names(pure), key=lambda each: not each.endswith((".yaml", ".yml")))
            advice = f"Name a file in it. {listed(inside)}".strip()
            raise refuse("is a folder", "a_folder", advice)
        if not found.is_file():
            raise refuse("no such file", "missing_file", suggestion(name, self._names()))
        if name not in self._inputs:
            with found.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
            self._inputs[name] = Input(name, digest, found.stat().st_size)
        return found

    def read(
        self, name: str, *, limit: int, named_in: str | None = None, column: str | None = None, row: int | None = None
    ) -> bytes:
        path = self.path(name, named_in=named_in, column=column, row=row)
        if path.stat().st_size > limit:
            raise TooLarge(Fault(f"the file is larger than {limit} bytes", "file_too_large", "", name))
        return path.read_bytes()

    def _names(self, within: str | PurePosixPath = "") -> list[str]:
        found = (path for path in (self.root / within).rglob("*") if path.is_file())
        return sorted(str(path.relative_to(self.root).as_posix()) for path, _ in zip(found, range(500), strict=False))


def open_bundle(path: Path) -> Bundle:
    """path: the study's YAML file, its folder (holding study.yaml), or a zip of the folder."""
    if path.is_dir():
        if not (path / "study.yaml").is_file():
            raise BadStudy(Fault("the folder holds no study.yaml", "missing_file", "", path.name))
        return Bundle(path, "study.yaml")
    if not path.is_file():
        raise BadStudy(Fault("no such file", "missing_file", "", path.name))
    if path.suffix.lower() == ".zip" or zipfile.is_zipfile(path):
        return _unpack(path)
    return Bundle(path.parent, path.name)


def _unpack(path: Path) -> Bundle:
    temporary = Path(tempfile.mkdtemp(prefix="exogauge-study-"))
    try:
        return _unpack_into(path, temporary)
    except BaseException as problem:
        shutil.rmtree(temporary, ignore_errors=True)
        outside = isinstance(problem, OSError) and problem.errno == errno.EINVAL  # the zip points outside itself
        if outside or isinstance(problem, _BAD_ZIP):
            raise BadStudy(Fault(f"not readable as a zip: {problem}", "not_zip", "Pack it anew.", path.name)) from None
        raise


def _unpack_into(path: Path, temporary: Path) -> Bundle:
    with zipfile.ZipFile(path) as archive:
        written = 0
        for member in _checked(archive.infolist(), path.name):
            written += _extract(archive, member, temporary, path.name, MAX_UNPACKED - written)
    studies = sorted(temporary.rglob("study.yaml"), key=lambda found: len(found.parts))
    if not studies:
        raise BadStudy(Fault("the zip holds no study.yaml", "missing_file", "", path.name))
    if len(studies) > 1 and len(studies[0].parts) == len(studies[1].parts):
        raise BadStudy(Fault("the zip holds several studies", "ambiguous_study", "Pack one each.", path.name))
    return Bundle(studies[0].parent, "study.yaml", temporary)


def _checked(members: Iterable[zipfile.ZipInfo], file: str) -> list[zipfile.ZipInfo]:
    kept, seen = [], set[str]()
    for member in members:
        name = member.filename
        if not PurePosixPath(name).parts or member.is_dir() or name.startswith("__MACOSX/"):
            continue
        pure = PurePosixPath(name)
        if not name.isprintable() or len(name) > 400 or any(len(part.encode()) > 200 for part in pure.parts):
            raise BadStudy(Fault("a member's name is too long or odd", "odd_name", "Rename it.", file, value=name[:80]))
        if pure.is_absolute() or ".." in pure.parts or "\\" in name or ":" in pure.parts[0]:
            raise BadStudy(Fault("a member's path leaves the zip", "path_escapes", "", file, value=name[:200]))
        if stat.S_ISLNK(member.external_attr >> 16):
            raise BadStudy(Fault("a member is a symbolic link", "path_escapes", "Pack the file.", file, value=name))
        if member.flag_bits & 0x1:
            raise BadStudy(Fault("a member is encrypted", "encrypted", "Pack without password.", file, value=name))
        if str(pure) in seen or any(str(parent) in seen for parent in pure.parents):
            raise BadStudy(Fault("a member is in the zip twice", "duplicate_member", "", file, value=name))
        seen.add(str(pure))
        kept.append(member)
    if len(kept) > MAX_MEMBERS:
        raise TooLarge(Fault(f"{len(kept)} files, at most {MAX_MEMBERS}", "zip_too_many", "", file))
    return kept


def _extract(archive: zipfile.ZipFile, member: zipfile.ZipInfo, root: Path, file: str, left: int) -> int:
    """Copy one member, counting what really comes out (a zip's own sizes may lie). left: bytes that may come."""
    target = root / member.filename
    target.parent.mkdir(parents=True, exist_ok=True)
    allowed = min(left, 10_000_000 + MAX_RATIO * member.compress_size)
    count = 0
    with archive.open(member) as source, target.open("wb") as sink:
        while block := source.read(_CHUNK):
            count += len(block)
            if count > allowed:
                advice = "Pack logs as Parquet, which is compressed already."
                raise TooLarge(Fault("unpacks to too many bytes", "zip_too_large", advice, file, value=member.filename))
            sink.write(block)
    return count
