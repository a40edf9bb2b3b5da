"""Tables in the contract's columns: what is read, and where a fault is placed."""

from __future__ import annotations

import gzip
import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadInput, BadLog, Fault, TooLarge
from exogauge.logs.model import Log
from exogauge.logs.open_table import open_table
from exogauge.logs.parquet_table import ParquetTable, write_log
from exogauge.logs.reading import read_log
from exogauge.logs.tables import TextLayout, broken
from exogauge.logs.text_table import TextTable

ROWS = [(k / 10.0, k / 4.0 - 1.0) for k in range(12)]
PLAIN = "t,q.a\n" + "".join(f"{t},{q}\n" for t, q in ROWS)


def put(folder: Path, content: str | bytes, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def faults(path: Path, **options: object) -> tuple[Fault, ...]:
    with pytest.raises(BadLog) as caught:
        read_log(path, "log", **options)  # type: ignore[arg-type]
    return caught.value.faults


def decimal_comma(delimiter: str) -> str:
    return PLAIN.replace(",", delimiter).replace("q.a", "Q").replace(".", ",").replace("Q", "q.a")


@pytest.mark.parametrize(
    "content",
    [
        PLAIN,
        PLAIN.replace("\n", "\r\n"),
        PLAIN.rstrip(),
        PLAIN.replace("\n", "\n\n"),
        "\ufeff" + PLAIN,
        PLAIN.replace("t,q.a", '"t", "q.a"'),
        PLAIN.replace(",", " , "),
        decimal_comma(";"),
        decimal_comma("\t"),
        PLAIN.replace(",", "\t"),
        PLAIN.replace(",", "    "),
        "".join(f"  {line}  \n" for line in PLAIN.replace(",", "   ").splitlines()),
        PLAIN.encode("utf-16"),
        gzip.compress(PLAIN.encode(), mtime=0),
        gzip.compress(PLAIN[:30].encode(), mtime=0) + gzip.compress(PLAIN[30:].encode(), mtime=0),
    ],
)
def test_every_common_way_of_writing_a_table_gives_the_same_log(content: str | bytes, tmp_path: Path) -> None:
    log = read_log(put(tmp_path, content), "log")
    assert np.array_equal(np.column_stack([log.time, log.channels["q.a"]]), np.array(ROWS))


def test_other_containers_give_the_same_log(tmp_path: Path) -> None:
    t, q = np.array(ROWS).T
    pq.write_table(pa.table({"t": t, "q.a": q.astype(np.float32)}), tmp_path / "log.parquet")
    np.savez(tmp_path / "log.npz", **{"t": t, "q.a": q})
    with h5py.File(tmp_path / "log.h5", "w") as target:
        target.create_dataset("t", data=t)
        target.create_dataset("q.a", data=q[None, :], compression="gzip")
    for name in ("log.parquet", "log.npz", "log.h5"):
        log = read_log(tmp_path / name, name)
        assert np.array_equal(log.channels["q.a"], q), name


def test_a_file_for_which_memory_is_short_is_not_called_damaged() -> None:
    with pytest.raises(MemoryError, match="malloc"):
        broken(pa.ArrowMemoryError("malloc of size 524288 failed"), "large.parquet")


def test_what_is_written_is_read_back_exactly_and_the_same_log_gives_the_same_bytes(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    log = Log("walk", np.cumsum(rng.uniform(0.001, 0.01, 30_000)), {"q.a": rng.normal(size=30_000)})
    write_log(log, tmp_path / "a")
    write_log(log, tmp_path / "b")
    back = read_log(tmp_path / "a", "walk")
    assert np.array_equal(back.time, log.time)
    assert np.array_equal(back.channels["q.a"], log.channels["q.a"])
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert pq.ParquetFile(tmp_path / "a").metadata.row_group(0).num_rows == 12_000


def test_a_cell_that_is_no_number_is_named_by_row_column_and_value(tmp_path: Path) -> None:
    found = faults(put(tmp_path, PLAIN.replace("0.5,0.25", "0.5,abc").replace("0.7,0.75", "1_0,0.75")))
    assert [(f.row, f.column, f.value) for f in found] == [(8, "t", "1_0"), (6, "q.a", "abc")]


@pytest.mark.slow
def test_a_bad_cell_is_found_far_down_behind_blank_lines(tmp_path: Path) -> None:
    lines = ["t,q.a", *(f"{k / 1000},{k}" for k in range(400_000))]
    lines[300_000] = "299.999,x"
    lines.insert(5, "")
    (found,) = faults(put(tmp_path, "\n".join(lines)))
    assert (found.row, found.column, found.value) == (300_000, "q.a", "x")


@pytest.mark.parametrize("last", ["1.2,0.", "1.2,0.3e", "1.2", "1.", "1.2,", "1.2,-"])
@pytest.mark.parametrize("packed", [False, True])
def test_a_last_line_that_was_cut_off_is_left_out_and_said(tmp_path: Path, last: str, packed: bool) -> None:
    text = PLAIN + last
    if last == "1.2,0.":  # a number for all that anyone can know
        assert read_log(put(tmp_path, text), "log").samples == 13
        return
    log = read_log(put(tmp_path, gzip.compress(text.encode(), mtime=0) if packed else text), "log")
    assert np.array_equal(log.channels["q.a"], np.array(ROWS)[:, 1])
    assert [note.rule for note in log.notes] == ["last_line_cut_off"]


def test_a_short_line_elsewhere_is_no_cut_off_end(tmp_path: Path) -> None:
    assert faults(put(tmp_path, PLAIN.replace("0.5,0.25", "0.5")))[0].rule == "ragged_row"
    assert faults(put(tmp_path, PLAIN + "1.2,0.3,4\n"))[0].rule == "ragged_row"
    assert faults(put(tmp_path, PLAIN + "1.2,x\n"))[0].rule == "not_a_number"


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("bad", ["oops,oops\n", "1\n", "1,2,3\n", "0,nan\n", "-1,inf\n"])
def test_what_is_wrong_outside_the_chosen_rows_does_not_matter(tmp_path: Path, bad: str, packed: bool) -> None:
    text = PLAIN.replace("t,q.a\n", "t,q.a\n" + bad + "\n") + bad + "9,9\n"
    path = put(tmp_path, gzip.compress(text.encode(), mtime=0) if packed else text)
    assert np.array_equal(read_log(path, "log", (1, 13)).channels["q.a"], np.array(ROWS)[:, 1])
    assert faults(path)
    assert faults(path, rows=(3, 14))[0].row in (14, None)  # counted in the file


def test_rows_with_too_many_or_too_few_cells_are_named(tmp_path: Path) -> None:
    found = faults(put(tmp_path, PLAIN.replace("0.5,0.25", "0.5").replace("0.7,0.75", "0.7,0.75,1")))
    assert [f.row for f in found] == [6, 8]


def test_a_decimal_comma_between_commas_is_recognised_in_the_advice(tmp_path: Path) -> None:
    found = faults(put(tmp_path, PLAIN.replace("0.5,", '"0,5",')))
    assert "decimal comma" in found[0].advice


def test_bytes_that_are_no_utf_8_are_named_by_their_row(tmp_path: Path) -> None:
    (found,) = faults(put(tmp_path, PLAIN.encode().replace(b"0.5,0.25", b"0.5,\xb5,1")))
    assert (found.row, found.rule) == (6, "not_utf8")


@pytest.mark.parametrize("before", ["# export v2\n# cell 7, two arms\n", "robot;arm\n\ndate: 1.2.2026 10:00\n"])
def test_lines_before_the_names_of_columns_are_counted_and_refused(tmp_path: Path, before: str) -> None:
    rows = "".join(f"{k / 10:.1f};{k * k / 7:.3f};{-k}\n".replace(".", ",") for k in range(40))
    path = put(tmp_path, f"{before}t;q.a;q.b\n{rows}")
    (fault,) = faults(path)
    assert fault.rule == "lines_before"
    assert fault.value == str(before.count("\n"))
    assert f"skip_lines: {fault.value}" in fault.advice


def test_two_decimal_signs_in_one_table_are_refused(tmp_path: Path) -> None:
    assert faults(put(tmp_path, "t;q.a\n0,1;1.5\n"))[0].rule == "two_decimal_signs"


def test_missing_values_are_refused_unless_gaps_are_asked_for(tmp_path: Path) -> None:
    path = put(tmp_path, PLAIN.replace("0.5,0.25", "0.5,").replace("0.7,0.75", "0.7,NaN"))
    (found,) = faults(path)
    assert (found.row, found.column, found.rule) == (6, "q.a", "missing_value")
    assert "1 more" in found.detail
    assert np.flatnonzero(np.isnan(read_log(path, "log", allow_gaps=True).channels["q.a"])).tolist() == [5, 7]


@pytest.mark.parametrize(
    "cell", ["inf", "-Infinity", "1e999", "1.65e203", "-3.4028235e38"]
)  # the last: FLT_MAX, for "none"
def test_what_no_reading_can_be_is_refused_even_where_gaps_are_allowed(cell: str, tmp_path: Path) -> None:
    (found,) = faults(put(tmp_path, PLAIN.replace("0.5,0.25", f"0.5,{cell}")), allow_gaps=True)
    assert (found.row, found.column) == (6, "q.a")


def test_time_must_increase_and_the_first_row_that_does_not_is_named(tmp_path: Path) -> None:
    (found,) = faults(put(tmp_path, PLAIN.replace("\n0.5,", "\n0.4,")))
    assert (found.row, found.column, found.rule) == (6, "t", "time_not_increasing")


def test_row_numbers_stay_those_of_the_file_when_only_some_rows_are_read(tmp_path: Path) -> None:
    path = put(tmp_path, PLAIN.replace("\n0.5,0.25", "\n0.4,inf"))
    assert {f.row for f in faults(path, rows=(1, 12))} == {6}
    assert read_log(put(tmp_path, PLAIN), "log", (1, 12)).time[0] == 0.1
    assert faults(path, rows=(0, 99))[0].rule == "rows_outside"
    assert faults(put(tmp_path, PLAIN), rows=(0, 5))[0].rule == "too_few_samples"


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (b"", "empty_file"),
        (b"\n\n", "no_header"),
        (b"t,q.a\n", "too_few_samples"),
        (b"1,2\n3,4\n", "no_header"),
        (b"time,q.a\n0,1\n", "no_time"),
        (b"t\n0\n", "no_channels"),
        (b"t,q.a,q.a\n", "duplicate_column"),
        (b"t,,q.a\n", "unnamed_column"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "stands_in"),
        (b"<!DOCTYPE html>\n<html><body>not found</body></html>\n", "stands_in"),
        (b"\n <html lang='en'>\n", "stands_in"),
        (b"t,joint1\n", "unknown_channel"),
        (b"\x00\x01\x02\x03", "unknown_format"),
        (b"SQLite format 3\x00", "unreadable_file"),
        (b"\x89MCAP0\r\n", "unreadable_file"),
        (gzip.compress(PLAIN.encode(), mtime=0)[:-12], "unreadable_file"),
        (b"PAR1 nothing PAR1", "unreadable_file"),
        (b"\x89HDF\r\n\x1a\n", "unreadable_file"),
        (b"MATLAB 5.0 MAT-file", "unreadable_file"),
        (b"PK\x03\x04", "unreadable_file"),
        (b"\x93NUMPY\x01\x00", "unreadable_file"),
    ],
)
def test_what_is_no_log_is_told_so(content: bytes, rule: str, tmp_path: Path) -> None:
    assert rule in {f.rule for f in faults(put(tmp_path, content))}


def test_a_header_unlike_every_row_is_told_once(tmp_path: Path) -> None:
    """A header of seven joints above rows of six was told twenty times as a decimal comma."""
    (found,) = faults(put(tmp_path, "t,q.a,q.b\n" + "".join(f"{k},1\n" for k in range(30))))
    assert (found.rule, found.row) == ("header_unlike_rows", 0)
    assert "names 3 columns, and every row has 2 cells" in found.detail
    some = faults(put(tmp_path, "t,q.a\n" + "".join(f"{k},1\n" for k in range(30)) + "30,1,2\n31,1\n"))
    assert {each.rule for each in some} == {"ragged_row"}


def test_not_more_than_twenty_faults_are_listed(tmp_path: Path) -> None:
    header = ",".join(["t", *(f"column{k}" for k in range(50))])
    found = faults(put(tmp_path, header + "\n"))
    assert len(found) == 20
    assert "more faults" in found[-1].detail


def varint(value: int) -> bytes:
    """A non-negative integer as Thrift's compact protocol writes it (zigzag, 7 bits a byte)."""
    value *= 2
    digits = bytearray()
    while value > 127:
        digits.append(value % 128 + 128)
        value //= 128
    return bytes([*digits, value])


def parquet_bomb() -> bytes:
    """A constant column of a million rows whose footer declares a thousand million."""
    buffer = io.BytesIO()
    pq.write_table(pa.table({"t": np.zeros(1_000_000)}), buffer)
    data = buffer.getvalue()
    size = int.from_bytes(data[-8:-4], "little")
    footer = data[-8 - size : -8].replace(varint(1_000_000), varint(1_000_000_000))
    return data[: -8 - size] + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def test_a_constant_parquet_column_of_a_thousand_million_rows_is_refused_unread(tmp_path: Path) -> None:
    path = put(tmp_path, parquet_bomb(), "bomb.parquet")
    assert path.stat().st_size < 100_000
    with pytest.raises(TooLarge, match="1000000000 rows"):
        open_table(path, path.name)


def npy_claim(shape: str) -> bytes:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    header = header.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()


def test_an_array_file_that_claims_eight_terabytes_is_refused_unread(tmp_path: Path) -> None:
    claim = npy_claim("(1000000000000,)")
    with pytest.raises(TooLarge):
        read_log(put(tmp_path, claim, "a.npy"), "log")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("t.npy", claim)
    with pytest.raises(TooLarge):
        read_log(tmp_path / "a.npz", "log")


@pytest.mark.parametrize(("second", "row"), [([0.1], 2), ([0.1, 0.2, 0.3], 2), (None, 2)])
def test_lists_of_other_lengths_are_refused_with_their_row(
    tmp_path: Path, second: list[float] | None, row: int
) -> None:
    lists = pa.array([[0.0, 1.0], second, [0.0, 1.0]], pa.list_(pa.float64()))
    pq.write_table(pa.table({"q": lists}), tmp_path / "a.parquet")
    with pytest.raises(BadLog) as refused:
        ParquetTable(tmp_path / "a.parquet", "a.parquet").read(["q"])
    (fault,) = refused.value.faults
    assert (fault.rule, fault.row, fault.column) == ("shape_differs", 2, "q")


def test_a_list_that_is_too_long_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pq.write_table(pa.table({"q": [[0.0] * 3000, [0.0] * 3000]}), tmp_path / "a.parquet")
    table = ParquetTable(tmp_path / "a.parquet", "a.parquet")
    assert table.read(["q"])["q"].shape == (2, 3000)
    monkeypatch.setattr("exogauge.logs.limits.LOGS", replace(LOGS, most_cells=5000))
    monkeypatch.setattr(pq.ParquetFile, "iter_batches", lambda *_, **__: pytest.fail("read"))
    with pytest.raises(TooLarge):
        table.read(["q"])


def test_a_dataset_that_claims_eight_terabytes_is_refused_unread(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as target:
        for name in ("t", "q.a"):
            target.create_dataset(name, shape=(10**12,), chunks=(1000,), dtype="f8")
    with pytest.raises(TooLarge):
        read_log(tmp_path / "a.h5", "log")


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=np.array([{}, 1], dtype=object), **{"q.a": np.zeros(2)})
    assert "objects" in faults(tmp_path / "a.npz")[0].advice


def test_text_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exogauge.logs.limits.LOGS", replace(LOGS, most_bytes=100_000))
    with pytest.raises(TooLarge):
        read_log(put(tmp_path, gzip.compress(PLAIN.encode() + b"\n" * 1_000_000, mtime=0)), "log")


def _external_link(target: h5py.File, secret: Path) -> None:
    target["q.a"] = h5py.ExternalLink(str(secret), "/q.a")


def _soft_link(target: h5py.File, secret: Path) -> None:
    target["q.a"] = h5py.SoftLink("/t")


def _external_storage(target: h5py.File, secret: Path) -> None:
    target.create_dataset("q.a", shape=(12,), dtype="f8", external=[(str(secret), 0, h5py.h5f.UNLIMITED)])


def _virtual(target: h5py.File, secret: Path) -> None:
    layout = h5py.VirtualLayout(shape=(12,), dtype="f8")
    layout[:] = h5py.VirtualSource(str(secret), "q.a", shape=(12,))
    target.create_virtual_dataset("q.a", layout)


@pytest.mark.parametrize("trick", [_external_link, _soft_link, _external_storage, _virtual])
@pytest.mark.parametrize("group", ["", "deep/er/"])
def test_a_file_that_points_to_another_file_is_refused(
    trick: Callable[[h5py.File, Path], None], group: str, tmp_path: Path
) -> None:
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as other:
        other["q.a"] = np.arange(12.0)
    with h5py.File(tmp_path / "a.h5", "w") as target:
        target["t"] = np.arange(12.0)
        trick(target.require_group(group) if group else target, secret)
    (found,) = faults(tmp_path / "a.h5")
    assert found.rule in {"hdf5_link", "hdf5_external", "hdf5_virtual"}
    assert found.column == f"{group}q.a"


def _csv() -> bytes:
    return PLAIN.encode()


def _parquet() -> bytes:
    buffer = io.BytesIO()
    t, q = np.array(ROWS).T
    pq.write_table(pa.table({"t": t, "q.a": q}), buffer)
    return buffer.getvalue()


def _npz() -> bytes:
    buffer = io.BytesIO()
    t, q = np.array(ROWS).T
    np.savez_compressed(buffer, **{"t": t, "q.a": q})
    return buffer.getvalue()


def _mat() -> bytes:
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, {"t": np.arange(12.0), "qa": np.arange(12.0)}, do_compression=True)
    return buffer.getvalue()


@st.composite
def mutated(draw: st.DrawFn, original: bytes) -> bytes:
    """The bytes with a few overwritten, a stretch removed or doubled, or the end cut off."""
    data = bytearray(original)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(data) - 1, 0)))
        match draw(st.integers(0, 4)):
            case 0 | 1:
                data[at : at + 1] = draw(st.binary(min_size=1, max_size=4))
            case 2:
                del data[at : at + draw(st.integers(1, 40))]
            case 3:
                data[at:at] = data[at : at + draw(st.integers(1, 40))]
            case 4:
                del data[at:]
    return bytes(data)


@pytest.mark.slow
@pytest.mark.parametrize("original", [_csv(), gzip.compress(_csv(), mtime=0), _parquet(), _npz(), _mat()])
@given(data=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
def test_damaged_bytes_give_a_log_or_a_fault_with_its_place_and_nothing_else(
    original: bytes, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged"
    path.write_bytes(data.draw(mutated(original)))
    result = outcome(path)
    if isinstance(result, BadInput):
        assert result.faults
        assert all(fault.file == "damaged" and fault.detail and fault.rule for fault in result.faults)
    else:
        assert np.isfinite(result.time).all()
        assert (np.diff(result.time) > 0).all()
        assert all(np.isfinite(values).all() for values in result.channels.values())


def outcome(path: Path) -> Log | BadInput:
    try:
        return read_log(path, "damaged")
    except BadInput as bad:
        return bad


@pytest.mark.parametrize("rows", [(0, 3), (2, 5), (0, 6)])
def test_the_first_rows_of_a_table_without_a_header_are_no_more_than_those(
    tmp_path: Path, rows: tuple[int, int]
) -> None:
    """They began where the file does, and all of it was read."""
    path = put(tmp_path, "".join(f"{k},{10 * k}\n" for k in range(6)))
    table = TextTable(path, path.name, TextLayout(header=False), rows)
    assert table.read(["2"])["2"].tolist() == [10.0 * k for k in range(*rows)]
