"""A name for every log of a payload: everything that is told of a log is kept under it, so no two share one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from exogauge.errors import BadStudy, Fault
from exogauge.payload.contract import LogEntry

OF_HOLDS = "postures"  # what is told of all postures together, of whatever logs, stands under it


def log_names(entries: Sequence[LogEntry], file: str) -> list[str]:
    """The first file's own name; where several logs would have it, what tells them apart. file: payload.yaml.

    Raises BadStudy where nothing does.
    """
    said = [0] * len(entries)
    while True:
        names = [FORMS[form](entry) for form, entry in zip(said, entries, strict=True)]
        shared = [k for k, name in enumerate(names) if names.count(name) > 1 or _reserved(name, entries[k])]
        if not shared:
            return names
        last = next((k for k in reversed(shared) if said[k] + 1 == len(FORMS)), None)
        if last is not None:
            detail = f"two logs are the same file in the same role: {names[last]}"
            advice = "Leave one of them out, or give each a `span` of its own."
            raise BadStudy(
                Fault(detail, "log_twice", advice, file, None, f"logs[{last}]", ", ".join(entries[last].file))
            )
        for k in shared:
            said[k] += 1


def _reserved(name: str, entry: LogEntry) -> bool:
    return name == OF_HOLDS and entry.role != "postures"


def _stem(path: str) -> str:
    return path.rpartition("/")[2].rpartition(".")[0] or path


def _span(entry: LogEntry) -> str:
    return "" if entry.span is None else f" {entry.span[0]:.12g}–{entry.span[1]:.12g} s"


FORMS: tuple[Callable[[LogEntry], str], ...] = (
    lambda entry: _stem(entry.file[0]),
    lambda entry: _stem(entry.file[0]) + _span(entry),
    lambda entry: f"{_stem(entry.file[0])} {entry.role}",
    lambda entry: entry.file[0].rpartition(".")[0] or entry.file[0],
    lambda entry: entry.file[0],
    lambda entry: ", ".join(entry.file),
    lambda entry: ", ".join(entry.file) + _span(entry),
    lambda entry: f"{', '.join(entry.file)}{_span(entry)} {entry.role}",
)
