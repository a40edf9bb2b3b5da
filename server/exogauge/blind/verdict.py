"""What an evaluation said of one case, against what was hidden in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

MOST_OTHERS = 2  # that `also_possible` may list beside the truth
ALL = "all"  # a place: every joint
RESTORED = 1.1  # held-out RMSE over the noise floor

Name = tuple[str, str, str]  # effect, kind of place, place


@final
@dataclass(frozen=True)
class Verdict:
    """truth: what was hidden. clutter: small effects that are there as well. named: the findings, best first.

    ranking: the findings, then what else was considered beside the first. also: what the first cannot be told from, by
    its own account. over_floor: the largest held-out RMSE over noise floor that is left on a channel that a finding
    names; None where none is. visible: everything hidden is at least three noise floors large.
    """

    case: str
    robot: str
    truth: tuple[Name, ...]
    clutter: tuple[Name, ...]
    visible: bool
    named: tuple[Name, ...]
    ranking: tuple[Name, ...]
    also: tuple[Name, ...]
    over_floor: float | None
    seconds: float
    error: str | None

    @property
    def first(self) -> bool:
        """The first finding is one that was hidden, at its place."""
        return bool(self.named) and self.named[0] in self.truth

    @property
    def among_three(self) -> bool:
        return any(name in self.truth for name in self.ranking[:3])

    @property
    def first_or_also(self) -> bool:
        """As `first`; or the first finding says itself that it could be the truth, and hardly anything else."""
        told = bool(self.named) and len(self.also) <= MOST_OTHERS + 1
        return self.first or (told and any(name in self.truth for name in self.also))

    @property
    def all_found(self) -> bool:
        return set(self.truth) <= set(self.named)

    @property
    def exact(self) -> bool:
        return set(self.truth) == set(self.named)

    @property
    def wrong(self) -> tuple[Name, ...]:
        """Findings of what is not there at all, at that place. What all joints have, each of them has."""
        there = {*self.truth, *self.clutter}
        return tuple((e, kind, at) for e, kind, at in self.named if not {(e, kind, at), (e, kind, ALL)} & there)

    @property
    def restored(self) -> bool:
        return self.over_floor is not None and self.over_floor <= RESTORED


def verdict(answer: Mapping[str, Any], result: Mapping[str, Any]) -> Verdict:
    """answer: an entry of the answers; result: results/<case>.json. A case that failed or was skipped names nothing."""
    found: Mapping[str, Any] = result.get("discrepancy") or {"findings": []}
    findings = sorted(found["findings"], key=lambda each: each["rank"])
    named = _names(findings)
    first: Mapping[str, Any] = findings[0] if findings else {}
    others = sorted(first.get("alternatives", []), key=lambda each: -float(each["score"] or 0.0))
    ranking = [*named, *(name for name in _names(others) if name not in named)]
    left = [
        each["held_out"]["rmse_after"] / each["held_out"]["noise_floor"]
        for each in findings
        if each.get("held_out") and each["held_out"]["noise_floor"]
    ]
    return Verdict(
        case=answer["case"],
        robot=answer["robot"],
        truth=_names(answer["effects"]),
        clutter=_names(answer["clutter"]),
        visible=all(each["visible"] for each in answer["effects"]),
        named=named,
        ranking=tuple(ranking),
        also=_names(first.get("also_possible", [])),
        over_floor=max(left) if left else None,
        seconds=float(result["seconds"]),
        error=result["error"],
    )


def _names(entries: Sequence[Mapping[str, Any]]) -> tuple[Name, ...]:
    return tuple((each["effect"], *next(iter(each["where"].items()))) for each in entries)
