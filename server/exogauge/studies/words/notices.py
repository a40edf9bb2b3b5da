"""Long lists made short for people: names in a sentence, findings of one sort. Nothing is lost, only folded away."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

_LONG_LIST = re.compile(r"(?:[\w.\[\]/-]+, ){6,}[\w\[\]/-]+(?:\.[\w\[\]/-]+)*")
_NUMBER = re.compile(r"[_.-]?\d+$")
SHOWN_NAMES = 3
SHOWN_FIRST = 3  # sorts of findings: who reads three may mend three; 551 notes are read by nobody
SEVERITIES = ("error", "warning", "note")


@final
@dataclass(frozen=True)
class Notice:
    """A sentence whose long list of names is cut to the first few; names: all of them, empty where none was cut."""

    text: str
    names: tuple[str, ...]


@final
@dataclass(frozen=True)
class Place:
    """One channel, in one log or in many that show the same; finding: the first of them."""

    channel: str
    logs: tuple[str, ...]
    finding: Mapping[str, Any]


@final
@dataclass(frozen=True)
class Findings:
    """What the doctor says of one sort: the same rule with the same severity, on one or many channels.

    first: among the few that matter most, shown before the rest is unfolded.
    """

    severity: str
    rule: str
    advice: str
    each: tuple[Mapping[str, Any], ...]
    first: bool

    @property
    def places(self) -> tuple[Place, ...]:
        """By channel, in the order of appearance."""
        channels: dict[str, list[Mapping[str, Any]]] = {}
        for finding in self.each:
            channels.setdefault(str(finding.get("channel") or ""), []).append(finding)
        return tuple(
            Place(channel, tuple(dict.fromkeys(str(one.get("log") or "") for one in found)), found[0])
            for channel, found in channels.items()
        )


def notice(warning: str) -> Notice:
    """`… of a, b, c, d, e, f, g. Ask …` -> `… of a, b, c and 4 more. Ask …` and the seven names."""
    match = _LONG_LIST.search(warning)
    if match is None:
        return Notice(warning, ())
    names = tuple(match.group().split(", "))
    return Notice(warning[: match.start()] + named(names) + warning[match.end() :], names)


def named(names: Sequence[str]) -> str:
    """`a, b, c and 4 more`"""
    shown = ", ".join(names[:SHOWN_NAMES])
    return f"{shown} and {len(names) - SHOWN_NAMES} more" if len(names) > SHOWN_NAMES else shown


def repeats(logs: Iterable[str]) -> dict[str, list[str]]:
    """Logs that differ by a number at the end: `bend_1`, `bend_2`, `twist` -> bend: both, twist: itself."""
    groups: dict[str, list[str]] = {}
    for log in dict.fromkeys(logs):
        groups.setdefault(_NUMBER.sub("", log) or log, []).append(log)
    return groups


def by_sort(findings: Sequence[Mapping[str, Any]]) -> list[Findings]:
    """Grouped by severity and rule: errors first, then in the order of appearance; the first three matter most."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for finding in findings:
        groups.setdefault((str(finding["severity"]), str(finding.get("rule", ""))), []).append(finding)
    ordered = sorted(
        groups.items(), key=lambda group: SEVERITIES.index(group[0][0]) if group[0][0] in SEVERITIES else 0
    )
    return [
        Findings(severity, rule.replace("_", " "), str(each[0].get("advice") or ""), tuple(each), k < SHOWN_FIRST)
        for k, ((severity, rule), each) in enumerate(ordered)
    ]
