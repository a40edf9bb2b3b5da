"""Supporting torque over time, like Figs 12 and 13 of [Evaluator]: the joint's angle above, one panel per device below.

A thin and solid, B thick and grey, B with the maker's values thin and dotted, the band model thick and dashed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from exogauge.studies.report.figures import BUCKETS, COLOURS, STYLE, Array, draw_line, sheet, svg_text, thin_out
from exogauge.support.result import Trial

FAINT = 0.22  # opacity of the uncertainty of B; that of A is lighter, it lies on top
DOUBT = 2.0  # standard deviations drawn
PALE = 0.4  # opacity of A where it does not compare like with like
LEAST_ANGLE = 4.0  # [°] shown: a joint that stands still looks like one
MARGIN = 0.2  # of the torque axis, above and below the lines
LETTER = 0.0085  # of the drawing's width per letter of a phase's name


def draw_support(trials: Sequence[Trial], joint: str, notes: Mapping[str, str], key: str) -> str:
    """trials: one per device, the same motion. notes: device -> text at its panel's upper right. key: see figures."""
    with matplotlib.rc_context({**STYLE, "text.parse_math": False}):
        figure = sheet(9.0, 1.35, 1 + len(trials), top=0.45)
        angle, *torques = figure.subplots(1 + len(trials), 1, sharex=True)
        _angle(angle, trials, joint)
        for axis, trial in zip(torques, trials, strict=True):
            axis.set_ylim(*span(trials, joint))
            _torque(axis, trial, joint)
            _title(axis, trial.device, notes.get(trial.device, ""))
        for axis, trial in zip((angle, *torques), (trials[0], *trials), strict=True):
            _phases(axis, trial, named=axis is angle)
            axis.margins(x=0.0)
            axis.yaxis.set_major_locator(MaxNLocator(4))
        torques[-1].set_xlabel("time from the start of the log [s]")
        return svg_text(figure, key)


def effort_unit(trial: Trial, joint: str) -> str:
    """N of a joint that slides, else N·m."""
    return trial.prediction.units.get(f"tau.{joint}", "N·m")


def _angle(axis: Any, trials: Sequence[Trial], joint: str) -> None:
    slides = effort_unit(trials[0], joint) == "N"
    axis.grid(axis="y")
    for n, trial in enumerate(trials):
        position = trial.q[:, trial.joints.index(joint)]
        position = 1e3 * position if slides else np.rad2deg(position)
        colour = COLOURS["--ink" if n == 0 else "--muted"]
        axis.plot(*thin_out(trial.time - trial.time[0], position), color=colour, linewidth=1.1 if n == 0 else 0.7)
    axis.set_title(
        f"{'position' if slides else 'angle'} of {joint}",
        loc="left",
        fontsize=9.5,
        fontweight="bold",
        color=COLOURS["--ink"],
        pad=17,
    )
    low, high = axis.get_ylim()
    if high - low < LEAST_ANGLE:
        axis.set_ylim(0.5 * (low + high - LEAST_ANGLE), 0.5 * (low + high + LEAST_ANGLE))
    axis.set_ylabel("[mm]" if slides else "[°]")


def _torque(axis: Any, trial: Trial, joint: str) -> None:
    k, time = trial.joints.index(joint), trial.time - trial.time[0]
    for start, stop in runs(trial.rest[:, k]):
        axis.axvspan(time[start], time[stop - 1], color=COLOURS["--soft"], linewidth=0)
    axis.grid(axis="y")
    axis.axhline(0.0, color=COLOURS["--muted"], linewidth=0.6)
    b, doubt = trial.support_b[:, k], DOUBT * trial.support_b_std[:, k]
    _band(axis, time, trial.low_b[:, k] - doubt, trial.high_b[:, k] + doubt, "--measured", FAINT)
    draw_line(axis, time, b, "--measured")
    draw_line(axis, time, trial.support_prior[:, k], "--prior")
    if trial.band_model is not None:
        drawn = thin_out(time, trial.band_model[:, k])
        axis.plot(*drawn, color=COLOURS["--ink"], linewidth=2.0, linestyle=(0, (3.0, 1.6)))
    _draw_a(axis, trial, k)
    if trial.support_paired is not None:
        drawn = thin_out(time, trial.support_paired[:, k])
        axis.plot(*drawn, color=COLOURS["--identified"], linewidth=1.4, linestyle=(0, (4.0, 1.4)))
    axis.set_ylabel(f"[{effort_unit(trial, joint)}]")


def _draw_a(axis: Any, trial: Trial, k: int) -> None:
    """Pale where it does not compare like with like."""
    if trial.support_a is None or trial.support_a_std is None or trial.low_a is None or trial.high_a is None:
        return
    time, doubt = trial.time - trial.time[0], DOUBT * trial.support_a_std[:, k]
    _band(axis, time, trial.low_a[:, k] - doubt, trial.high_a[:, k] + doubt, "--identified", FAINT / 2)
    like, a = trial.compared[:, k], trial.support_a[:, k]
    draw_line(axis, time, np.where(like, np.nan, a), "--identified", opacity=PALE)
    draw_line(axis, time, np.where(like, a, np.nan), "--identified")


def span(trials: Sequence[Trial], joint: str) -> tuple[float, float]:
    """Lower and upper end of the torque axis: all lines with a margin; wide intervals at rest do not squeeze them."""
    lines = [
        values[:, trial.joints.index(joint)]
        for trial in trials
        for values in (trial.support_b, trial.support_paired, trial.support_prior, trial.band_model)
        if values is not None
    ]
    found = np.concatenate([[0.0], *(line[np.isfinite(line)] for line in lines)])
    low, high = float(found.min()), float(found.max())
    margin = MARGIN * (high - low) or 1.0
    return low - margin, high + margin


def _title(axis: Any, title: str, note: str) -> None:
    axis.set_title(title, loc="left", fontsize=9.5, fontweight="bold", color=COLOURS["--ink"], pad=4)
    axis.set_title(note, loc="right", fontsize=8.5, color=COLOURS["--muted"], pad=4)


def _band(axis: Any, time: Array, low: Array, high: Array, colour: str, opacity: float) -> None:
    axis.fill_between(*outline(time, low, high), color=COLOURS[colour], alpha=opacity, linewidth=0)


def _phases(axis: Any, trial: Trial, named: bool) -> None:
    """A thin line where a phase begins; its name above where there is room."""
    time = trial.time - trial.time[0]
    for start, stop in runs(trial.phase):
        if start > 0:
            axis.axvline(time[start], color=COLOURS["--muted"], linewidth=0.5, linestyle=(0, (1.0, 3.0)))
        name = trial.phase_names[trial.phase[start]]
        if named and time[stop - 1] - time[start] > LETTER * len(name) * time[-1]:
            place = 0.5 * (time[start] + time[stop - 1])
            transform = axis.get_xaxis_transform()
            axis.text(place, 1.03, name, transform=transform, ha="center", fontsize=8.0, color=COLOURS["--muted"])


def runs(values: ArrayLike) -> Iterator[tuple[int, int]]:
    """(start, stop) of every stretch of one value; of truth values only the true ones."""
    array = np.asarray(values)
    edges = np.flatnonzero(np.diff(array)) + 1
    for start, stop in zip([0, *edges], [*edges, array.size], strict=True):
        if stop > start and (array.dtype != np.bool_ or array[start]):
            yield int(start), int(stop)


def outline(time: Array, low: Array, high: Array, buckets: int = BUCKETS) -> tuple[Array, Array, Array]:
    """(time, low, high) of a band over time, thinned so that it still holds all of itself; gaps stay gaps."""
    if time.size <= buckets:
        return time, low, high
    starts = np.arange(0, time.size, -(-time.size // buckets))
    return time[starts], np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)
