"""What an evaluation said of one case, against what was hidden in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

MOST_OTHERS = 2  # that `also_possible` may list beside the truth
ALL = "all"  # a place: every joint, axis or log
EXTRA = "extra_band"  # has no name that both sides know: where it is, its ends say
RESTORED = 1.1  # held-out RMSE over the noise floor

Name = tuple[str, str, str]  # effect, kind of place, place


@final
@dataclass(frozen=True)
class Verdict:
    """truth: what was hidden. clutter: small effects that are there as well. named: the findings, best first.

    ranking: the findings, then what else was considered beside the first. also: what the first cannot be told from, by
    its own account. over_floor: the largest held-out RMSE over noise floor that is left on a channel that a finding
    names, by that finding or, if that is less, at the end of the chain with all that was named; None where there is
    none. visible: everything hidden is at least three noise floors large. outside: what is hidden has no name in any
    catalogue; undecidable: it has one that these data cannot tell from another. said: effects, unexplained, undecided,
    none, or "" where nothing was. where_it_is: a channel that is told to stand above its noise, with all that was
    named, is the one that shows what is hidden best, or its neighbour in the same wrench or joint.
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
    outside: bool = False
    undecidable: bool = False
    said: str = ""
    where_it_is: bool = False

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
    def right(self) -> bool:
        """One hidden effect as `first_or_also`; of two, both."""
        return self.first_or_also if len(self.truth) == 1 else bool(self.truth) and self.all_found

    @property
    def wrong(self) -> tuple[Name, ...]:
        """Findings of what is not there at all, at that place. What all joints, axes or logs have, each of them has."""
        there = {*self.truth, *self.clutter}
        return tuple(name for name in self.named if not {name, _everywhere(name)} & there)

    @property
    def restored(self) -> bool:
        return self.over_floor is not None and self.over_floor <= RESTORED


def verdict(answer: Mapping[str, Any], result: Mapping[str, Any]) -> Verdict:
    """answer: an entry of the answers; result: results/<case>.json. A case that failed or was skipped names nothing."""
    at = _Places(answer)
    found: Mapping[str, Any] = result.get("discrepancy") or {"findings": []}
    findings = sorted(found["findings"], key=lambda each: each["rank"])
    named = at.names(findings)
    first: Mapping[str, Any] = findings[0] if findings else {}
    others = sorted(first.get("alternatives", []), key=lambda each: -float(each["score"] or 0.0))
    ranking = [*named, *(name for name in at.names(others) if name not in named)]
    left = _left(found, findings)
    return Verdict(
        case=answer["case"],
        robot=answer["robot"],
        truth=at.names(answer["effects"]),
        clutter=at.names(answer["clutter"]),
        visible=all(each["visible"] for each in answer["effects"]),
        named=named,
        ranking=tuple(ranking),
        also=at.names(first.get("also_possible", [])),
        over_floor=max(left.values()) if left else None,
        seconds=float(result["seconds"]),
        error=result["error"],
        outside=any(each.get("outside") for each in answer["effects"]),
        undecidable=any(each.get("undecidable") for each in answer["effects"]),
        said=str(found.get("verdict", "")),
        where_it_is=_where_it_is(answer, found),
    )


def _where_it_is(answer: Mapping[str, Any], found: Mapping[str, Any]) -> bool:
    """A base's wrench is one place, as a moment is a force's."""
    shown = {_spot(each["channel"]) for each in answer["effects"] if each.get("channel")}
    return bool(shown & {_spot(each["channel"]) for each in found.get("unexplained", [])})


def _spot(channel: str) -> str:
    kind, _, name = channel.partition(".")
    return kind if kind == "base" else name.rpartition(".")[2] if kind == "support" else name


def _left(found: Mapping[str, Any], findings: Sequence[Mapping[str, Any]]) -> Mapping[str, float]:
    """Channel -> held-out RMSE over noise floor with all that was named there: the last one added leaves least."""
    ends = {name: found[name][-1] for name in ("chain", "wear_chain") if found.get(name)}
    left: dict[str, float] = {}
    for held in (each["held_out"] for each in findings if each.get("held_out")):
        if held["noise_floor"]:
            channel, ratio = held["channel"], held["rmse_after"] / held["noise_floor"]
            end = ends.get("wear_chain" if channel.startswith("support.") else "chain")
            if end and end["worst_floor"] and not held.get("log"):  # what is left at worst once all are in the model
                ratio = min(ratio, end["worst_rmse"] / end["worst_floor"])
            left[channel] = min(ratio, left.get(channel, ratio))
    return left


@final
class _Places:
    """Every place in one spelling: of links fixed to each other the moving one, of a sensor its axis."""

    def __init__(self, answer: Mapping[str, Any]) -> None:
        self.body = {link: links[0] for links in answer.get("rigid", []) for link in links}
        self.bands = set(answer.get("bands", {}))
        extra = [each for each in answer["effects"] if each["effect"] == EXTRA]
        self.ends = {self.body.get(link, link) for each in extra for link in each["parameters"]["ends"]}
        self.pulled = {joint for each in extra for joint in each["parameters"]["joints"]}

    def names(self, entries: Sequence[Mapping[str, Any]]) -> tuple[Name, ...]:
        return tuple((each["effect"], *self._place(each["effect"], each["where"])) for each in entries)

    def _place(self, effect: str, where: Mapping[str, Any]) -> tuple[str, str]:
        if "sensor" in where:
            return "sensor", f"{where['sensor']} {where.get('axis', '')}".strip()
        kind, at = next(iter(where.items()))
        at = self.body.get(at, at) if kind == "link" else str(at)
        unnamed = kind == "band" and at not in self.bands
        near = (kind == "link" and at in self.ends) or (kind == "joint" and at in self.pulled)
        if effect == EXTRA and (unnamed or near):
            return "band", "extra"
        return kind, at


def _everywhere(name: Name) -> Name:
    effect, kind, at = name
    return effect, kind, f"{at.split(' ')[0]} {ALL}" if kind == "sensor" else ALL
