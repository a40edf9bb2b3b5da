"""Long lists made short for people: names in a sentence, findings of one sort. Nothing is lost, only folded away."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from exogauge.remarks import Remark
from exogauge.studies.words.remark_words import named_with_numbers, sentence, short_sentence

_NUMBER = re.compile(r"[_.-]?\d+$")
LONG_LIST = 6  # names, above which a sentence shows the first few
SHOWN_FIRST = 3  # sorts of findings: who reads three may mend three; 551 notes are read by nobody
SEVERITIES = ("error", "warning", "note")


@final
@dataclass(frozen=True)
class Notice:
    """What has to be kept in mind. code: what it is about. remark: the same as data, where it is more than a
    sentence."""

    code: str
    sentence: str
    remark: Remark | None = None

    @property
    def short(self) -> str:
        """With a long list of names cut to the first few."""
        return self.sentence if self.remark is None or not self.names else short_sentence(self.remark)

    @property
    def names(self) -> tuple[str, ...]:
        """All of a list of names that is long, with their numbers; else ()."""
        long = self.remark is not None and len(self.remark.names) > LONG_LIST
        return tuple(named_with_numbers(self.remark)) if self.remark and long else ()

    def as_data(self) -> dict[str, Any]:
        """As results.json has it."""
        facts = self.remark
        return {
            "code": self.code,
            "sentence": self.sentence,
            "short": self.short,
            "names": list(facts.names) if facts else [],
            "each": [list(each) for each in facts.each] if facts else [],
            "beside": list(facts.beside) if facts else [],
            "numbers": list(facts.numbers) if facts else [],
        }


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


def notice(remark: Remark) -> Notice:
    """In a sentence."""
    return Notice(remark.about, sentence(remark), remark)


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
