"""A recording with gaps in time becomes several logs: neither filter nor derivative may reach across them. So does one
of which a sensor was dead for a while. Parts without a gap between them are filtered as one: what lies beside a part is
kept with it, and cut off again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault
from exogauge.logs.even_stamps import jitter_followed
from exogauge.logs.model import Beside, Log, Note
from exogauge.logs.resampling import uniform


def segments(log: Log, first: int = 0, dead: Mapping[str, Sequence[slice]] = MappingProxyType({})) -> list[Log]:
    """The stretches of the log without a gap, in order; the log itself where it has none.

    A few missing samples (steps up to 5 periods) are bridged by interpolation. Elsewhere the log is cut, and what is
    shorter than 2 s is left out; both are said in `Log.notes`. first: data row of the file, from 0, that the log's
    first sample is: a segment is named `<log>_<start>_<stop>` by the rows that it holds, as `rows` would have it.
    dead: where which channels tell nothing; these samples are left out as well, if anything else is long enough.
    Raises BadLog where nothing is long enough.
    """
    step = np.diff(log.time)
    nominal = float(np.median(step))
    out = [span for spans in dead.values() for span in spans]
    if not out and not (step > LOGS.late * nominal).any():
        return [_on_even_clock(log)]
    gaps = (np.flatnonzero(step > LOGS.longest_gap * nominal) + 1).tolist()
    gone = np.zeros(log.samples, dtype=bool)
    for span in out:
        gone[span] = True
    edges = sorted({0, *gaps, *(np.flatnonzero(np.diff(gone)) + 1).tolist(), log.samples})
    pieces = [(a, b) for a, b in pairwise(edges) if not gone[a]]
    long = [
        (a, b)
        for a, b in pieces
        if b - a >= LOGS.fewest_samples and log.time[b - 1] - log.time[a] >= LOGS.shortest_part_s
    ]
    if not long and out:
        return segments(log, first)
    if not long:
        raise BadLog(_nothing_left(log, step, nominal, first))
    if len(edges) == 2:
        return [_bridged(log, step, nominal)]
    why = [*([_of_gaps(log, step, gaps, nominal, first)] if gaps else []), *_of_dead(log, dead)]
    told = _told(log, why, pieces, long, first, "cut_at_gaps" if gaps else "cut_where_dead")
    made = []
    for number, (a, b) in enumerate(long):
        part = Log(
            name=f"{log.name}_{first + a}_{first + b}",
            time=log.time[a:b],
            channels={name: values[a:b] for name, values in log.channels.items()},
            notes=(*log.notes, told) if number == 0 else (),
            part_of=log.recording,
        )
        made.append(_bridged(part, np.diff(part.time), nominal))
    return made


def _bridged(log: Log, step: NDArray[np.float64], nominal: float) -> Log:
    """On an even clock where single samples are missing."""
    late = step > LOGS.late * nominal
    if not late.any():
        return log
    lost = round(float(log.time[-1] - log.time[0]) / nominal) + 1 - log.samples
    where = f"at {int(late.sum())} places"
    detail = (
        f"{lost} samples are missing {where}, never more than a few together: interpolated"
        if lost > 0
        else f"stamps are more than half a period late {where}: brought to an even clock by interpolation"
    )
    note = Note("samples_bridged", detail, "look for what drops or delays samples", int(np.flatnonzero(late)[0]) + 2)
    return replace(uniform(log), part_of=log.part_of, notes=(*log.notes, note))


def _on_even_clock(log: Log) -> Log:
    """Whether samples were taken when their stamps say, or evenly, positions tell."""
    positions = [name for name, values in log.channels.items() if name.startswith("q.") and np.isfinite(values).all()]
    followed = jitter_followed([(log.time, log.stack(positions))]) if positions else None
    if followed is None:
        return log
    varies = f"sample periods vary by {100.0 * float(np.std(np.diff(log.time))) * log.rate_hz:.2g} %"
    follow = f"positions follow {100.0 * followed.share:.0f} ± {100.0 * followed.std:.1g} % of that"
    if followed.at_stamps:
        note = Note("samples_evened", f"{varies}: resampled to an even clock, as {follow}", "", None)
        return replace(uniform(log), part_of=log.part_of, notes=(*log.notes, note))
    if followed.evenly:
        even = np.linspace(log.time[0], log.time[-1], log.samples)
        note = Note("stamps_evened", f"{varies} by their stamps alone, as {follow}", "", None)
        return replace(log, time=even, notes=(*log.notes, note))
    return log


def _of_gaps(log: Log, step: NDArray[np.float64], places: Sequence[int], nominal: float, first: int) -> str:
    gaps = "1 gap" if len(places) == 1 else f"{len(places)} gaps"
    longest = max(places, key=lambda b: step[b - 1])
    return (
        f"{log.recording!r} has {gaps} in time, the longest of {step[longest - 1]:.4g} s before row {first + longest}, "
        f"where {nominal:.4g} s is usual"
    )


def _of_dead(log: Log, dead: Mapping[str, Sequence[slice]]) -> Iterator[str]:
    for channel, spans in dead.items():
        where = _listed([f"{log.time[each.start]:.4g} to {log.time[each.stop - 1]:.4g} s" for each in spans])
        yield f"{channel} of {log.recording!r} does not change while joints move, t = {where}"


def _listed(places: Sequence[str]) -> str:
    most_told = 5
    more = f" and {len(places) - most_told} more" if len(places) > most_told else ""
    return f"{', '.join(places[:most_told])}{more}"


def _told(
    log: Log, why: Sequence[str], pieces: list[tuple[int, int]], long: list[tuple[int, int]], first: int, rule: str
) -> Note:
    parts = "1 log" if len(long) == 1 else f"{len(long)} logs"
    detail = f"{'; '.join(why)}: cut there into {parts}, each named by its rows"
    short = [piece for piece in pieces if piece not in long]
    if short:
        lost = sum(log.time[b - 1] - log.time[a] for a, b in short)
        rows = _listed([f"{first + a}-{first + b}" for a, b in short])
        detail += f". Left out, as shorter than {LOGS.shortest_part_s:g} s: rows {rows}, {lost:.3g} s in all"
    return Note(rule, detail, "", None)


def _nothing_left(log: Log, step: NDArray[np.float64], nominal: float, first: int) -> Fault:
    at = int(np.argmax(step))
    late = int((step > LOGS.longest_gap * nominal).sum())
    detail = (
        f"{late} gaps in time leave no stretch of {LOGS.shortest_part_s:g} s; the longest gap lasts {step[at]:.6g} s "
        f"where {nominal:.6g} s is usual"
    )
    return Fault(detail, "time_gap", "Record again without losing samples.", log.name, first + at + 2, "t")


Array = NDArray[np.float64]


def with_beside(log: Log, parts: Sequence[Log]) -> Log:
    """The log with what the parts of its recording that lie right before and after it hold.

    parts: those of its recording that its filters may see, on one clock; in any order, with or without itself.
    """
    line = sorted([log, *(each for each in parts if each is not log)], key=lambda each: float(each.time[0]))
    own = next(k for k, each in enumerate(line) if each is log)
    after = own
    while after + 1 < len(line) and _follows(line[after], line[after + 1]):
        after += 1
    first = own
    while first > 0 and _follows(line[first - 1], line[first]):
        first -= 1
    if first == after:
        return log
    before = {name: _joined(line[first:own], name) for name in log.channels}
    beyond = {name: _joined(line[own + 1 : after + 1], name) for name in log.channels}
    return replace(log, beside=Beside(before, beyond))


def widened(log: Log) -> tuple[Log, slice]:
    """The log with what is beside it as one, and where it lies there; without it as it is."""
    if log.beside is None:
        return log, slice(0, log.samples)
    before, after = log.beside.before, log.beside.after
    channels = {name: np.concatenate([before[name], own, after[name]]) for name, own in log.channels.items()}
    first, step = len(next(iter(before.values()))), 1.0 / log.rate_hz
    samples = len(next(iter(channels.values())))
    earlier = log.time[0] - step * np.arange(first, 0, -1)
    later = log.time[-1] + step * np.arange(1, samples - first - log.samples + 1)
    time = np.concatenate([earlier, log.time, later])
    return replace(log, time=time, channels=channels, beside=None), slice(first, first + log.samples)


def _follows(one: Log, other: Log) -> bool:
    """Whether the other begins one step after the end of the one, at its rate and with its channels."""
    step = 1.0 / one.rate_hz
    late = float(other.time[0] - one.time[-1]) - step
    same_rate = abs(other.rate_hz * step - 1.0) < LOGS.joined / max(other.samples, 1)
    return abs(late) < LOGS.joined * step and same_rate and other.channels.keys() == one.channels.keys()


def _joined(parts: Sequence[Log], name: str) -> Array:
    return np.concatenate([np.zeros(0), *(each.channels[name] for each in parts)])


BoolArray = NDArray[np.bool_]


def around(marked: BoolArray, reach: int) -> BoolArray:
    """(T, K) whether any sample of the same column is marked no more than `reach` samples before or after."""
    samples = len(marked)
    count = np.zeros((samples + 1, *marked.shape[1:]), dtype=np.int32)
    np.cumsum(marked, axis=0, out=count[1:])
    at = np.arange(samples)
    behind, first = np.minimum(at + reach + 1, samples), np.maximum(at - reach, 0)
    return np.asarray(count[behind] > count[first])
