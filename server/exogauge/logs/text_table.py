"""Text tables: comma, semicolon (decimal comma), tab or blanks; plain or gzip; UTF-8, UTF-16 or what the layout says;
read by pyarrow.

pyarrow stops at the first cell that is no number; a second, tolerant pass then finds the offending cells by row,
column and value.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, final, get_args

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pacsv

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault, TooLarge
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_bytes, check_cells, rows_outside
from exogauge.logs.model import Note
from exogauge.logs.tables import Encoding, RawArray, TextLayout, broken, unpacked_head
from exogauge.logs.text_head import (
    ARROW_FAILURES,
    decimal_of,
    delimiter_of,
    is_number,
    refuse_lines_before,
    refuse_numeric_header,
)
from exogauge.stand_ins import stands_in

_MISSING = ["", "NaN", "nan", "NAN", "NA", "N/A", "n/a", "null", "NULL", "None", "-"]


@final
class TextTable:
    """`names` from the header, or "1", "2", … without one; rows are counted from 1 after it, blank lines left out.

    A last line that was cut off when the recording stopped is left out, and said in `notes`. rows: only those are
    looked at.
    """

    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str, layout: TextLayout, rows: tuple[int, int] | None = None) -> None:
        head_bytes = 1 << 18
        self.file = file
        self._path = path
        self._widths = set[int]()  # cells of rows that have other than the header
        head, self._packed = unpacked_head(path, file, head_bytes)
        if other := stands_in(head):
            raise BadLog(Fault(f"the file is {other[0]}", "stands_in", f"{other[1]}.", file=file))
        self._utf16 = head[:2] in (b"\xff\xfe", b"\xfe\xff")
        self._encoding = "utf-16" if self._utf16 else layout.encoding
        text = self._text(head)
        complete = text[: text.rfind("\n")] if len(head) == head_bytes and "\n" in text else text
        lines = complete.splitlines()
        self._skip = layout.skip_lines
        body = lines[self._skip :]
        if not body or not body[0].strip():
            raise BadLog(
                Fault(
                    "there is no text where the table should start",
                    "no_header",
                    "Remove empty lines, or give `skip_lines`.",
                    file=file,
                    row=0,
                )
            )
        if layout.from_the_head:
            refuse_lines_before(lines, file)
        self._delimiter = layout.delimiter or delimiter_of(body[0])
        self._decimal = layout.decimal or decimal_of(body[layout.header :], self._delimiter, file)
        cells = [cell.strip() for cell in self._cells(body[0])]
        self._skip_rows = self._skip + int(layout.header)
        self._names = tuple(cells) if layout.header else tuple(str(1 + index) for index in range(len(cells)))
        if layout.header:
            refuse_numeric_header(cells, file)
        check_cells(1, len(cells), file)
        self._begin, self._end, self._first = 0, 0, 0  # bytes of the unpacked file; rows before them
        self._rows = self._count_rows()
        check_cells(self._rows, 1, file)
        if rows is not None:
            self._keep(rows)

    @property
    def names(self) -> tuple[str, ...]:
        return self._names

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        check_cells(self._rows, len(names), self.file)
        index = {name: self._names.index(name) for name in names}
        try:
            columns = self._convert(index, [name for name in exact if name in index])
        except ARROW_FAILURES as problem:
            faults = self._find_faults(index)
            raise BadLog(faults or broken(problem, self.file)) from None
        except MemoryError:
            raise TooLarge(_memory(self.file)) from None
        return columns

    def _convert(self, index: dict[str, int], exact: Sequence[str]) -> dict[str, RawArray]:
        if exact:
            try:
                return self._convert_as(index, exact)
            except ARROW_FAILURES:
                pass  # not whole numbers everywhere: read them like the others
        return self._convert_as(index, ())

    def _convert_as(self, index: dict[str, int], exact: Sequence[str]) -> dict[str, RawArray]:
        types = {str(k): pa.int64() if name in exact else pa.float64() for name, k in index.items()}
        columns: dict[str, RawArray] = {
            name: np.empty(self._rows, np.int64 if name in exact else np.float64) for name in index
        }
        rows, ragged = 0, list[Fault]()
        self._widths = set()
        for batch in self._batches(types, ragged, null_values=_MISSING, decimal_point=self._decimal):
            for name, k in index.items():
                column = batch.column(batch.schema.get_field_index(str(k)))
                if name in exact and column.null_count:
                    raise ValueError("a missing time stamp")
                columns[name][rows : rows + batch.num_rows] = column.to_numpy(zero_copy_only=False)
            rows += batch.num_rows
        if ragged:
            raise BadLog(self._header_unlike_rows() if not rows and len(self._widths) == 1 else ragged)
        return {name: values[:rows] for name, values in columns.items()}

    def _header_unlike_rows(self) -> Fault:
        (cells,) = self._widths
        return Fault(
            f"the header names {len(self._names)} columns, and every row has {cells} cells",
            "header_unlike_rows",
            "Correct the header: which of its names are there too many, or too few? A name that holds the delimiter "
            "stands in quotes.",
            self.file,
            0,
            value=shorten(", ".join(self._names)),
        )

    def _find_faults(self, index: dict[str, int]) -> list[Fault]:
        """Cells that are no number, at most `LOGS.most_faults`, with the rows that have too few or too many cells."""
        faults, ragged, row = list[Fault](), list[Fault](), self._first
        number = pa.float64()
        try:
            for batch in self._batches(
                {str(k): pa.binary() for k in index.values()}, ragged, strings_can_be_null=False
            ):
                for name, k in index.items():
                    cells = batch.column(batch.schema.get_field_index(str(k)))
                    try:
                        plain = pc.utf8_trim_whitespace(pc.cast(cells, pa.string()))
                        pc.cast(plain, number)
                        continue
                    except ARROW_FAILURES:
                        faults += self._bad_cells(cells, name, row, LOGS.most_faults - len(faults))
                row += batch.num_rows
                if len(faults) + len(ragged) >= LOGS.most_faults:
                    break
        except ARROW_FAILURES as problem:
            faults.append(broken(problem, self.file))
        return (faults + ragged)[: LOGS.most_faults]

    def _bad_cells(self, cells: Any, name: str, row: int, room: int) -> Iterator[Fault]:
        found = 0
        for offset, cell in enumerate(cells.to_pylist()):
            text = cell.decode("utf-8" if self._recoded else self._encoding, "replace").strip()
            if text in _MISSING or is_number(text, self._decimal):
                continue
            if found == room:
                return
            found += 1
            yield Fault(
                "the cell is not a number",
                "not_a_number",
                _number_advice(text, self._decimal),
                self.file,
                row + offset + 1,
                shorten(name),
                shorten(text),
            )

    def _batches(self, types: dict[str, Any], ragged: list[Fault], **convert: Any) -> Iterator[Any]:
        block_bytes = 1 << 20  # of text per step: fastest of those tried; a row must fit into it
        width = len(self._names)
        skip = 0 if self.part else self._skip_rows

        def on_ragged(row: Any) -> str:
            self._widths.add(row.actual_columns)
            if len(ragged) < LOGS.most_faults:
                number = None if row.number is None else row.number - skip + self._first
                ragged.append(
                    Fault(
                        f"the row has {row.actual_columns} cells, the table {width} columns",
                        "ragged_row",
                        "Check quotes and delimiters" + (" (a decimal comma?)." if self._delimiter == "," else "."),
                        self.file,
                        number,
                        value=shorten(row.text),
                    )
                )
            return "skip"

        try:
            reader = pacsv.open_csv(
                self._stream(),
                read_options=pacsv.ReadOptions(
                    use_threads=False,
                    block_size=block_bytes,
                    skip_rows=skip,
                    column_names=[str(k) for k in range(width)],
                ),
                parse_options=pacsv.ParseOptions(delimiter=self._delimiter, invalid_row_handler=on_ragged),
                convert_options=pacsv.ConvertOptions(
                    check_utf8=False, column_types=types, include_columns=list(types), **convert
                ),
            )
        except pa.ArrowInvalid as problem:
            if "Empty CSV" in str(problem):
                return
            raise
        yield from reader

    @property
    def _recoded(self) -> bool:
        return self._utf16 or self._delimiter == " "

    def _stream(self) -> Any:
        if self._recoded:
            with self._unpacked() as source:
                source.seek(self._begin)
                text = self._text(source.read(self._end - self._begin))
            if self._delimiter == " ":
                text = re.sub(r"[^\S\n]+", " ", text.replace("\r\n", "\n"))
                text = "\n".join(line.strip() for line in text.split("\n"))
            return pa.py_buffer(text.encode())
        if self.part is None and not self.notes:
            return pa.input_stream(str(self._path), compression="gzip" if self._packed else None)
        return pa.PythonFile(_Span(self._unpacked(), self._begin, self._end), mode="r")

    def _unpacked(self) -> io.BufferedIOBase:
        return gzip.open(self._path, "rb") if self._packed else self._path.open("rb")

    def _keep(self, rows: tuple[int, int]) -> None:
        """Look at these rows alone. A file whose lines end in an unusual way is read whole, and cut by the caller."""
        start, stop = rows
        offset, count, begin, end = 0, 0, None, None
        if self._utf16 or self._returns > self._feeds:
            return
        with self._unpacked() as source:
            for number, line in enumerate(source):
                if number >= self._skip_rows and line.strip() and offset < self._end:
                    begin = offset if count == start else begin
                    end = offset if count == stop else end
                    if end is not None:
                        break
                    count += 1
                offset += len(line)
        end = self._end if end is None and count == stop else end
        if begin is None or end is None or begin >= end:
            raise BadLog(rows_outside(rows, count, self.file))
        self.part, self._begin, self._end, self._first, self._rows = rows, begin, end, start, stop - start
        self.notes = () if end <= self._whole else self.notes

    def _leave_out_a_cut_line(self, tail: bytes, size: int) -> None:
        """tail: the last bytes of the unpacked file. A line counts as cut off if it has too few cells where the one
        before has all of them, or ends, with the file, in what is no number where the one before has one.
        """
        body = tail.rstrip(b"\r\n")
        lines = body.rsplit(b"\n", 2)
        before = self._feeds - tail[len(body) :].count(b"\n")  # line feeds before the last line
        if self._utf16 or len(lines) < 3 or before <= self._skip_rows:
            return
        whole, last = (self._cells(line.decode(self._encoding, "replace").rstrip("\r")) for line in lines[1:])
        width = len(self._names)
        ended = len(body) < len(tail)
        short = len(last) < width == len(whole)
        broken_off = not ended and len(last) == width == len(whole) and self._is_value(whole[-1])
        if not short and not (broken_off and not self._is_value(last[-1])):
            return
        self._end = self._whole = size - len(tail) + len(body) - len(lines[-1])
        detail = f"the last line ({shorten(lines[-1].decode(self._encoding, 'replace'), 60)}) is cut off: left out"
        self.notes = (Note("last_line_cut_off", f"{self.file}: {detail}", "", None),)

    def _is_value(self, cell: str) -> bool:
        return is_number(cell.strip(), self._decimal)

    def _text(self, data: bytes) -> str:
        """Decoded; in the body a wrong byte becomes a replacement sign, which is then no number."""
        if b"\0" in data and not self._utf16:
            raise BadLog(
                Fault(
                    "the file is neither text nor a format known here",
                    "unknown_format",
                    "Hand in CSV, Parquet, MAT, HDF5, NPZ or rosbag2.",
                    file=self.file,
                )
            )
        return data.decode(self._encoding, "replace").removeprefix(codecs.BOM_UTF8.decode())

    def _cells(self, line: str) -> list[str]:
        if self._delimiter == " ":
            line = re.sub(r"\s+", " ", line.strip())
        try:
            return next(csv.reader([line], delimiter=self._delimiter, skipinitialspace=True))
        except (csv.Error, StopIteration) as problem:
            raise BadLog(broken(problem, self.file)) from None

    def _count_rows(self) -> int:
        """Lines of the unpacked file, an upper bound of its rows; stops at the byte cap and at another encoding."""
        tail_bytes = 1 << 16  # of the end of a file, in which its last two lines are looked for
        size = feeds = returns = 0
        tail = b""
        decoder = codecs.getincrementaldecoder(self._encoding)()
        try:
            with pa.input_stream(str(self._path), compression="gzip" if self._packed else None) as stream:
                while block := stream.read(1 << 22):
                    size += len(block)
                    check_bytes(size, self.file)
                    try:
                        decoder.decode(block)
                    except UnicodeDecodeError as problem:
                        row = feeds + problem.object[: problem.start].count(b"\n") - self._skip_rows + 1
                        raise BadLog(self._other_encoding(row, problem)) from None
                    feeds += block.count(b"\n")
                    returns += block.count(b"\r")
                    tail = (tail + block)[-tail_bytes:]
        except (pa.ArrowException, OSError) as problem:
            raise BadLog(broken(problem, self.file)) from None
        self._feeds, self._returns, self._end, self._whole = feeds, returns, size, size
        self._leave_out_a_cut_line(tail, size)
        return max(feeds, returns) + 1

    def _other_encoding(self, row: int, problem: UnicodeDecodeError) -> Fault:
        value = repr(problem.object[problem.start : problem.end])
        others = ", ".join(each for each in get_args(Encoding) if each != self._encoding)
        advice = f"Save the file as UTF-8, or say `layout: {{encoding: …}}` in a mapping: {others}."
        return Fault(
            f"the text is not {self._encoding.upper()}", "not_utf8", advice, self.file, max(row, 0), value=value
        )


@final
class _Span(io.RawIOBase):
    """The bytes of a stream from begin to end."""

    def __init__(self, source: io.BufferedIOBase, begin: int, end: int) -> None:
        self._source, self._left = source, end - begin
        source.seek(begin)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        found = self._source.read(min(len(buffer), self._left))
        buffer[: len(found)] = found
        self._left -= len(found)
        return len(found)

    def close(self) -> None:
        self._source.close()
        super().close()


def _number_advice(text: str, decimal: str) -> str:
    if decimal == "." and re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", text):
        return "Numbers with a decimal comma need ';' or tab between the columns of the whole file."
    return "Correct the cell, or remove the row; a missing value is an empty cell."


def _memory(file: str) -> Fault:
    return Fault(
        f"the values do not fit into memory (at most {LOGS.most_cells} values in {LOGS.most_columns} columns are read)",
        "memory_limit",
        "Split the recording or drop columns.",
        file=file,
    )
