"""Opens a table by its first bytes, not by its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from exogauge.errors import BadLog, Fault
from exogauge.logs.limits import check_bytes
from exogauge.logs.tables import Table, TextLayout


def open_table(path: Path, file: str, layout: TextLayout | None = None, rows: tuple[int, int] | None = None) -> Table:
    """The table in a file. file: the name that faults carry.

    rows: those that are wanted. Only a text can be broken in one row and good in another, so only of a text are they
    taken here (`Table.part`); other formats hand out all.
    """
    size = path.stat().st_size
    check_bytes(size, file)
    if size == 0:
        raise BadLog(Fault("the file is empty", "empty_file", "Record again or check the export.", file=file))
    with path.open("rb") as stream:
        head = stream.read(1024)
    for opener, matches in _FORMATS:
        if matches(head):
            return opener(path, file)
    _refuse_known_others(head, file)
    from exogauge.logs.text_table import TextTable

    return TextTable(path, file, layout or TextLayout(), rows)


def _parquet(path: Path, file: str) -> Table:
    from exogauge.logs.parquet_table import ParquetTable

    return ParquetTable(path, file)


def _hdf5(path: Path, file: str) -> Table:
    from exogauge.logs.hdf5_table import Hdf5Table

    return Hdf5Table(path, file)


def _matlab(path: Path, file: str) -> Table:
    from exogauge.logs.matlab_table import MatlabTable

    return MatlabTable(path, file)


def _numpy(path: Path, file: str) -> Table:
    from exogauge.logs.numpy_table import NumpyTable

    return NumpyTable(path, file)


def _bag(path: Path, file: str) -> Table:
    from exogauge.logs.bag_table import BagTable

    return BagTable(path, file)


_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FORMATS: tuple[tuple[Callable[[Path, str], Table], Callable[[bytes], bool]], ...] = (
    (_parquet, lambda head: head[:4] == b"PAR1"),
    (_hdf5, lambda head: head[:8] == _HDF5_SIGNATURE or head[512:520] == _HDF5_SIGNATURE),
    (_matlab, lambda head: head[:10] == b"MATLAB 5.0"),
    (_bag, lambda head: head[:16] == b"SQLite format 3\0" or head[:8] == b"\x89MCAP0\r\n"),
    (_numpy, lambda head: head[:4] == b"PK\x03\x04" or head[:6] == b"\x93NUMPY"),
)
_OTHERS = (
    (b"#ROSBAG", "a ROS 1 bag"),
    (b"PARE", "an encrypted Parquet file"),
    (b"ARROW1", "an Arrow file"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ", "an xz archive"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive"),
    (b"%PDF", "a PDF"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Office file"),
)


def _refuse_known_others(head: bytes, file: str) -> None:
    for magic, what in _OTHERS:
        if head.startswith(magic):
            raise BadLog(
                Fault(
                    f"the file is {what}, which is not read here",
                    "unknown_format",
                    "Export it as CSV, Parquet, MAT, HDF5 or NPZ.",
                    file=file,
                )
            )
