"""Drawings of the report as inline SVG; colours are CSS variables, so one drawing serves light, dark and paper.

Like Figs 9-11 of [Evaluator]: measured thick and grey, identified model thin and solid, a-priori model thin and dotted.
Like Figs 12 and 13: supporting torque over time, the joint's angle above, one panel per device below; A thin and solid,
B thick and grey, B with the maker's values thin and dotted, the band model thick and dashed.
"""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

from exogauge.identification.result import Channels, Prediction
from exogauge.support.result import Trial

Array = NDArray[np.float64]

BUCKETS = 500
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
COLOURS = {  # drawn with the sentinel, shown with the variable of the page's style sheet
    "--ink": "#010101",
    "--muted": "#020202",
    "--line": "#030303",
    "--measured": "#040404",
    "--identified": "#050505",
    "--prior": "#060606",
    "--soft": "#070707",
}
LINE = {"--measured": (3.2, "-"), "--prior": (1.1, (0, (1.2, 1.4))), "--identified": (1.1, "-")}  # width [pt], dashes
STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "exogauge",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.edgecolor": COLOURS["--line"],
    "axes.labelcolor": COLOURS["--muted"],
    "xtick.color": COLOURS["--line"],
    "ytick.color": COLOURS["--line"],
    "xtick.labelcolor": COLOURS["--muted"],
    "ytick.labelcolor": COLOURS["--muted"],
    "text.color": COLOURS["--ink"],
    "axes.formatter.useoffset": False,  # a label says where its tick is, without a sum to make
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": COLOURS["--line"],
    "grid.linewidth": 0.5,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
}


def draw_series(
    prediction: Prediction, told: Channels, channels: Sequence[str], notes: Mapping[str, str], key: str
) -> str:
    """One panel per channel over time. told: of the prediction. notes: text at a panel's upper right. key: prefix that
    makes ids unique."""
    with matplotlib.rc_context({**STYLE, "text.parse_math": False}):  # names are text, even with a $ in them
        figure = sheet(9.0, 1.15, len(channels))
        axes = figure.subplots(len(channels), 1, sharex=True, squeeze=False)[:, 0]
        for axis, channel in zip(axes, channels, strict=True):
            _panel(axis, prediction, told, channel)
            axis.set_title(label(channel), loc="left", fontsize=9.5, fontweight="bold", color=COLOURS["--ink"], pad=4)
            axis.set_title(notes.get(channel, ""), loc="right", fontsize=8.5, color=COLOURS["--muted"], pad=4)
        axes[-1].set_xlabel("time [s]")
        return svg_text(figure, key)


def draw_curve(points: Sequence[tuple[float, float]], chosen: float, key: str) -> str:
    """Score on held-out blocks against the factor on the prior's weight; the chosen factor is marked."""
    ordered = sorted((factor, score) for factor, score in points if factor > 0 and np.isfinite(score))
    with matplotlib.rc_context(STYLE):
        figure = sheet(5.2, 1.8, 1)
        axis = figure.subplots()
        axis.set_xscale("log")
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(_power_of_ten))
        axis.grid(axis="y")
        factors, scores = [list(column) for column in zip(*ordered, strict=True)]
        axis.plot(factors, scores, color=COLOURS["--identified"], linewidth=1.3, marker="o", markersize=3.5)
        if factors[0] <= chosen <= factors[-1]:
            axis.axvline(chosen, color=COLOURS["--prior"], linewidth=1.0, linestyle=(0, (1, 2)))
        axis.set_xlabel("factor on the prior's weight")
        axis.set_ylabel("held-out error, weighted")
        axis.yaxis.set_major_locator(MaxNLocator(4))
        return svg_text(figure, key)


def _power_of_ten(value: float, place: int | None) -> str:
    """As text: formulas, and ticks between powers, would take most of the drawing's time."""
    return "10" + str(round(math.log10(value))).translate(RAISED)


def sheet(width: float, panel: float, panels: int, top: float = 0.25) -> Figure:
    """Margins are fixed: fitting them to the text would take half of the drawing's time. Lengths in inches."""
    left, right, bottom, gap = 0.68, 0.06, 0.45, 0.4
    height = top + panels * panel + (panels - 1) * gap + bottom
    figure = Figure(figsize=(width, height))
    figure.subplots_adjust(left / width, bottom / height, 1 - right / width, 1 - top / height, 0.0, gap / panel)
    return figure


def _panel(axis: Any, prediction: Prediction, told: Channels, channel: str) -> None:
    lines: tuple[tuple[Mapping[str, Array], str], ...] = (
        (told.measured, "--measured"),
        (told.predicted_prior, "--prior"),
        (told.predicted, "--identified"),
    )
    axis.grid(axis="y")
    for values, colour in lines:
        if channel in values:
            draw_line(axis, prediction.time, values[channel], colour)
    axis.set_ylabel(f"[{prediction.units.get(channel, '')}]")
    axis.yaxis.set_major_locator(MaxNLocator(4))
    axis.margins(x=0.0)


def draw_line(axis: Any, time: Array, values: Array, colour: str, opacity: float = 1.0) -> None:
    """A line in the look that belongs to its colour."""
    width, dashes = LINE[colour]
    look = {"linewidth": width, "linestyle": dashes, "solid_joinstyle": "round", "alpha": opacity}
    axis.plot(*thin_out(time, values), color=COLOURS[colour], **look)


def thin_out(time: Array, values: Array, buckets: int = BUCKETS) -> tuple[Array, Array]:
    """Smallest and largest value of each bucket, in time order: what the eye would see. For drawing only."""
    if time.size <= 2 * buckets:
        return time, values
    span = -(-time.size // buckets)
    starts = np.arange(0, time.size, span)
    padded = np.full(starts.size * span, np.nan)
    padded[: values.size] = values
    blocks = padded.reshape(-1, span)
    low = np.argmin(np.where(np.isfinite(blocks), blocks, np.inf), axis=1)
    high = np.argmax(np.where(np.isfinite(blocks), blocks, -np.inf), axis=1)
    kept = np.unique(np.concatenate([starts + low, starts + high]))
    return time[kept], values[kept]


def label(channel: str) -> str:
    """`base.my` -> `base moment y`, `tau.torso_pitch` -> `torso_pitch`, `ft.wrist.fx` -> `wrist.fx`."""
    kind, _, rest = channel.partition(".")
    if kind == "base":
        return f"base {'force' if rest[:1] == 'f' else 'moment'} {rest[1:]}"
    return rest if kind in ("tau", "ft") else channel


def svg_text(figure: Figure, key: str) -> str:
    """Bare <svg> for embedding: no fixed size, no metadata, no style sheet of its own, ids prefixed with `key`,
    the page's font, and variables in place of the sentinel colours."""
    FigureCanvasSVG(figure)
    sink = io.StringIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")  # the browser has more fonts
        figure.savefig(sink, format="svg", transparent=True, metadata={"Date": None})
    text = sink.getvalue()
    box = re.search(r'viewBox="([-\d. ]+)"', text)
    assert box is not None
    body = text[text.index(">", text.index("<svg")) + 1 :]
    body = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<style.*?</style>", "", body, flags=re.S)
    body = re.sub(r'(\bid="|url\(#)', rf"\g<1>{key}-", body)
    body = body.replace('xlink:href="#', f'href="#{key}-')
    body = re.sub(r'\bd="[^"]*"', _rounded, body)
    body = re.sub(r"font: (?:(\d+) )?([\d.]+)px [^;\"]*", _page_font, body)
    for variable, sentinel in COLOURS.items():
        body = body.replace(sentinel, f"var({variable})")
    body = re.sub(r"\s*\n\s*", "\n", body).strip()
    return f'<svg viewBox="{box.group(1)}" xmlns="http://www.w3.org/2000/svg" aria-hidden="true">{body}'


def _page_font(match: re.Match[str]) -> str:
    weight = f"; font-weight: {match.group(1)}" if match.group(1) else ""
    return f"font-size: {match.group(2)}px{weight}"


def _rounded(path: re.Match[str]) -> str:
    """Coordinates to a hundredth of a point, finer than any screen."""
    return re.sub(r"(\.\d\d)\d+", r"\1", path.group())


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
