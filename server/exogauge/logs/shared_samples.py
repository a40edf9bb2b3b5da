"""Samples that stand in two logs: who is judged by what was fitted is not held out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import final

import numpy as np

from exogauge.criteria.examining import Examining
from exogauge.logs.findings import Finding, kind_of, runs
from exogauge.logs.model import Log

SENSED = ("i", "tau", "acc", "gyro", "ft")


def shared_samples(logs: Sequence[Log], held_out: Sequence[bool], criteria: Examining) -> Iterator[tuple[str, Finding]]:
    """(name of the log, finding): of two that share samples the one that is held out, else the later one.

    Shared is a stretch in which all sensors read the same, number for number: noise never comes twice.
    """
    samples = [_Samples(logs[k], held_out[k]) for k in sorted(range(len(logs)), key=lambda k: held_out[k])]
    twice, seen = _in_several(samples), list[_Samples]()
    for own in samples:
        others = [each for each in seen if own in twice and each in twice]
        shares = [(own.share_in(other, criteria.shared_samples), other) for other in others]
        share, other = max(shares, key=lambda each: each[0], default=(0.0, own))
        if share > 0.0:
            yield own.name, _finding(share, other, held_out=own.held_out > other.held_out)
        seen.append(own)


def _in_several(samples: Sequence[_Samples]) -> set[_Samples]:
    """Logs with a word that stands in another, too: hardly ever any, and only these are compared in pairs."""
    every = np.sort(np.concatenate([np.zeros(0, np.uint64), *(np.unique(each.words) for each in samples)]))
    again = every[1:][every[1:] == every[:-1]]
    return {each for each in samples if again.size and np.isin(each.words, again).any()}


def _finding(share: float, other: _Samples, held_out: bool) -> Finding:
    detail = f"{100 * share:.0f} % of what its sensors read stands in {other.name} as well, number for number"
    advice = "hand each recording in once: counted twice, its noise looks smaller than it is"
    if held_out:
        advice = "what was fitted judges nothing: hand in another recording, or other `rows` of this one"
    return Finding("error", "t", "samples_shared", detail, advice, value=share)


@final
class _Samples:
    """One word for all that the sensors read at a moment, so that two logs are compared by one sort."""

    def __init__(self, log: Log, held_out: bool) -> None:
        self.name, self.held_out = log.name, held_out
        self._channels = sorted(name for name in log.channels if kind_of(name) in SENSED)
        read = np.ascontiguousarray(np.column_stack([log.channels[name] for name in self._channels] or [log.time]))
        mix = np.random.default_rng(0).integers(1, 2**63, read.shape[1], dtype=np.uint64)
        self.words = (read.view(np.uint64) * mix).sum(axis=1, dtype=np.uint64)
        self._changes = np.concatenate([[0], np.cumsum(np.diff(self.words) != 0)])

    def share_in(self, other: _Samples, in_a_row: int) -> float:
        """Of this log's samples, in stretches that do not stand still; 0 where other sensors were logged."""
        if not self._channels or self._channels != other._channels:
            return 0.0
        starts, lengths = runs(np.isin(self.words, other.words))
        changes = self._changes[starts + lengths - 1] - self._changes[starts]
        told = lengths[(lengths >= in_a_row) & (2 * changes > lengths)]
        return float(told.sum() / self.words.size)
