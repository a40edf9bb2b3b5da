"""Uploads become files in a scratch folder: checked paths, counted bytes, nothing opened. What the files mean is read
in a child process (`checking`), never here."""

from __future__ import annotations

import shutil
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import IO, BinaryIO, final

from starlette.datastructures import UploadFile

from exogauge.errors import BadStudy, Fault, TooLarge
from exogauge.settings import Settings
from exogauge.storage.blobs import CHUNK, disk
from exogauge.storage.files import safe_path
from exogauge.storage.held_files import own_folder

UNREADABLE = (
    zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, RuntimeError, EOFError, ValueError, IndexError,
    KeyError, struct.error, zlib.error,
)  # fmt: skip
IGNORED = ("__MACOSX/", ".DS_Store")
LONGEST_ENTRY = 2048  # bytes of a zip's directory per file: name, extra fields, comment
DOS = 0  # where a zip was made (APPNOTE 4.4.2)
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


@contextmanager
def scratch_folder(settings: Settings) -> Iterator[Path]:
    """An empty folder, gone at the end."""
    with disk("prepare a scratch folder"):
        folder = Path(mkdtemp(dir=own_folder(settings.scratch).path))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@final
@dataclass
class Allowance:
    """Bytes and files that one bundle may still take."""

    bytes_left: int
    files_left: int

    @classmethod
    def of(cls, settings: Settings) -> Allowance:
        return cls(settings.max_bundle_bytes, settings.max_bundle_files)

    def file(self) -> None:
        self.files_left -= 1
        if self.files_left < 0:
            raise TooLarge(Fault("the bundle holds too many files", "too_many_files", "Leave out what is not needed."))

    def take(self, count: int) -> None:
        self.bytes_left -= count
        if self.bytes_left < 0:
            raise TooLarge(
                Fault(
                    "the bundle is too large once unpacked", "bundle_too_large", "Hand in less, or ask for more room."
                )
            )


def lay_out(files: Sequence[UploadFile], folder: Path, settings: Settings) -> None:
    """Write the uploaded files below `folder`: a single zip unpacked, several files under their own relative paths."""
    if len(files) == 1 and is_zip(files[0]):
        unpack(files[0].file, files[0].filename or "upload.zip", folder, Allowance.of(settings))
        return
    allowance, taken = Allowance.of(settings), set[str]()
    for file in files:
        path = free_path((file.filename or "").replace("\\", "/"), taken)  # as scripts on Windows name it
        allowance.file()
        write(file.file, folder / path, allowance)


def is_zip(file: UploadFile) -> bool:
    """By its first bytes, not by its name."""
    start = file.file.read(4)
    file.file.seek(0)
    return start in (b"PK\x03\x04", b"PK\x05\x06") or (file.filename or "").lower().endswith(".zip")


def unpack(source: BinaryIO, name: str, folder: Path, allowance: Allowance) -> None:
    """Unpack a zip; its own statements of size are not believed, links and encryption are refused."""
    try:
        refuse_long_directory(source, allowance)
        with zipfile.ZipFile(source) as archive:
            found = ((member, inside(member)) for member in archive.infolist())
            members = [(member, path) for member, path in found if not path.endswith("/") and not ignored(path)]
            for _ in members:
                allowance.file()
            taken: set[str] = set()
            for member, path in members:
                refuse_special(member, name)
                path = free_path(path, taken)
                with archive.open(member) as content:
                    write(content, folder / path, allowance)
    except UNREADABLE as error:
        raise broken_zip(name, error) from error


def refuse_long_directory(source: BinaryIO, allowance: Allowance) -> None:
    """Before zipfile reads the zip's directory into memory, look at the size it will believe."""
    end = zipfile._EndRecData(source)  # type: ignore[attr-defined]  # the reader's own view; a second parser may differ
    if end and end[zipfile._ECD_SIZE] > allowance.files_left * LONGEST_ENTRY:  # type: ignore[attr-defined]
        raise TooLarge(Fault("the bundle holds too many files", "too_many_files", "Leave out what is not needed."))


def broken_zip(name: str, error: Exception) -> BadStudy:
    detail = f"the zip cannot be read: {str(error)[:200] or type(error).__name__}"
    return BadStudy(Fault(detail, "zip_unreadable", "Pack it again.", file=name))


def refuse_special(member: zipfile.ZipInfo, name: str) -> None:
    kind = stat.S_IFMT(member.external_attr >> 16)
    problem = None
    if member.flag_bits & 0x1:
        problem = "is encrypted"
    elif kind not in (0, stat.S_IFREG):
        problem = "is a link or a device, not a file"
    elif member.compress_type not in PACKINGS:
        problem = "is packed in a way other than store or deflate"
    if problem:
        detail = f"an entry of the zip {problem}"
        raise BadStudy(
            Fault(detail, "zip_entry_refused", "Pack plain files with an ordinary zip program.", file=name,
                  value=ascii(member.filename[:200]))
        )  # fmt: skip


def inside(member: zipfile.ZipInfo) -> str:
    """Its path. Older .NET wrote backslashes between folders, which no name on Windows can hold (APPNOTE 4.4.17)."""
    return member.filename.replace("\\", "/") if member.create_system == DOS else member.filename


def ignored(path: str) -> bool:
    return path.startswith(IGNORED[0]) or path.split("/")[-1] == IGNORED[1]


def free_path(text: str, taken: set[str]) -> str:
    """A safe path that no other file of the bundle has, not even in other capitals."""
    path = safe_path(text)
    if path.casefold() in taken:
        raise BadStudy(Fault("two files of the bundle have the same path", "duplicate_path", "Rename one.", file=path))
    taken.add(path.casefold())
    return path


def write(source: IO[bytes], target: Path, allowance: Allowance) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.touch(exist_ok=False)
    except (FileExistsError, NotADirectoryError) as error:
        detail = "a file of the bundle has the path of a folder"
        raise BadStudy(Fault(detail, "path_clash", "Rename one.", value=ascii(target.name))) from error
    with disk("receive the file"), target.open("wb") as out:
        while chunk := source.read(CHUNK):
            allowance.take(len(chunk))
            out.write(chunk)


def root_of(folder: Path, name: str) -> Path:
    """The folder that holds `name`: `folder`, or the nearest below it (bundles are often packed with their folder)."""
    found = sorted(folder.rglob(name), key=lambda path: (len(path.parts), path))
    found = [path for path in found if path.is_file()]
    if not found:
        raise BadStudy(Fault(f"the bundle holds no {name}", "missing_file", f"Put {name} at its top.", file=name))
    if len(found) > 1 and len(found[1].parts) == len(found[0].parts):
        raise BadStudy(Fault(f"the bundle holds several {name}", "ambiguous", "Hand in one at a time.", file=name))
    return found[0].parent
