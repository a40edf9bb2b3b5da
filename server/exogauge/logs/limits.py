"""How large a log may be; checked on what a file declares, before its values are read."""

from __future__ import annotations

from exogauge.criteria.logs import LOGS
from exogauge.errors import Fault, TooLarge


def check_bytes(size: int, file: str) -> None:
    """size: bytes of the file, unpacked."""
    if size > LOGS.most_bytes:
        raise TooLarge(
            Fault(
                f"the file holds more than {LOGS.most_bytes / 1e9:g} GB",
                "too_many_bytes",
                "Split the recording, or hand it in as Parquet with only the columns needed.",
                file=file,
                value=str(size),
            )
        )


def check_cells(rows: int, columns: int, file: str, column: str | None = None) -> None:
    """rows x columns as declared by the file or counted without parsing."""
    if columns > LOGS.most_columns:
        raise TooLarge(
            Fault(
                f"the table has more than {LOGS.most_columns} columns",
                "too_many_columns",
                "Keep the columns that are needed.",
                file=file,
                value=str(columns),
            )
        )
    if rows * max(columns, 1) > LOGS.most_cells:
        raise TooLarge(
            Fault(
                f"the file declares {rows} rows x {columns} columns; at most {LOGS.most_cells} values are read",
                "too_many_values",
                "Split the recording, drop columns, or lower the rate.",
                file=file,
                column=column,
                value=str(rows * columns),
            )
        )


def rows_outside(rows: tuple[int, int], size: int, file: str) -> Fault:
    """size: rows of the table."""
    return Fault(
        f"rows {rows[0]}:{rows[1]} are asked for, the table has {size}",
        "rows_outside",
        "Give start and stop within the table.",
        file,
        value=f"{rows[0]}:{rows[1]}",
    )
