"""Long lists made short for people: names in a sentence, findings of one sort. Nothing is lost, only folded away."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

_LONG_LIST = re.compile(r"(?:[\w.\[\]/-]+, ){6,}[\w\[\]/-]+(?:\.[\w\[\]/-]+)*")
_NUMBER = re.compile(r"[_.-]?\d+$")
SHOWN_NAMES = 3
SEVERITIES = ("error", "warning", "note")


@final
@dataclass(frozen=True)
class Notice:
    """A sentence whose long list of names is cut to the first few; names: all of them, empty where none was cut."""

    text: str
    names: tuple[str, ...]


@final
@dataclass(frozen=True)
class Findings:
    """What the doctor says of one sort: the same rule with the same severity, on one or many channels."""

    severity: str
    rule: str
    advice: str
    each: tuple[Mapping[str, Any], ...]


def notice(warning: str) -> Notice:
    """`… of a, b, c, d, e, f, g. Ask …` -> `… of a, b, c and 4 more. Ask …` and the seven names."""
    match = _LONG_LIST.search(warning)
    if match is None:
        return Notice(warning, ())
    names = tuple(match.group().split(", "))
    short = f"{', '.join(names[:SHOWN_NAMES])} and {len(names) - SHOWN_NAMES} more"
    return Notice(warning[: match.start()] + short + warning[match.end() :], names)


def repeats(logs: Iterable[str]) -> dict[str, list[str]]:
    """Logs that differ by a number at the end: `bend_1`, `bend_2`, `twist` -> bend: both, twist: itself."""
    groups: dict[str, list[str]] = {}
    for log in dict.fromkeys(logs):
        groups.setdefault(_NUMBER.sub("", log) or log, []).append(log)
    return groups


def by_sort(findings: Sequence[Mapping[str, Any]]) -> list[Findings]:
    """Grouped by severity and rule: errors first, then in the order of appearance."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for finding in findings:
        groups.setdefault((str(finding["severity"]), str(finding.get("rule", ""))), []).append(finding)
    sorts = [
        Findings(severity, rule.replace("_", " "), str(each[0].get("advice") or ""), tuple(each))
        for (severity, rule), each in groups.items()
    ]
    return sorted(sorts, key=lambda sort: SEVERITIES.index(sort.severity) if sort.severity in SEVERITIES else 0)
