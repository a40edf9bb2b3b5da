"""Two drawings: the chain of errors down to the noise floor, and the residual over what an effect depends on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.ticker import MaxNLocator, NullLocator

from exogauge.findings.result import Evidence, Link
from exogauge.studies.report.figures import COLOURS, STYLE, Array, draw_line, sheet, svg_text
from exogauge.studies.words.discrepancy_sentences import chain_unit
from exogauge.studies.words.names import channel, step_words
from exogauge.studies.words.rounding import significant

FLOOR = "noise floor"
ROW = 0.5  # [inch] height of a bar with its label
BAR = 0.36  # of a row
CUT = 4.0  # a first bar longer than this times the next is cut, or nothing could be told of the others
BREAK = (0.90, 0.915)  # where a cut bar has its gap
ROOM = 1.25  # of the longest bar: for the number behind it
MARGIN = 0.085  # of the width: room for numbers of six characters and their unit
FAINT = 0.22  # opacity of the spread
DOUBT = 2.0  # standard errors drawn
MARKED = 40  # most points that are drawn as such
CROWDED = 0.15  # median distance from zero, as a share of the largest, below which the axis is stretched about zero


def draw_chain(chain: Sequence[Link], key: str) -> str:
    """One bar per model: grey what noise explains, coloured what is above it. key: see figures."""
    floor = chain[-1].noise_floor
    end = _end([*(link.rmse for link in chain), floor])
    with matplotlib.rc_context({**STYLE, "text.parse_math": False}):
        figure = sheet(9.0, ROW * (len(chain) + 1), 1, top=0.05)
        figure.subplots_adjust(left=0.002, bottom=0.0)
        axis = figure.subplots()
        for row, link in enumerate(chain):
            first = row == 0 and len(chain) > 1
            _bar(axis, row, link.rmse, link.noise_floor, "--prior" if first else "--identified", end, link.unit)
            _words(axis, row, step_words(link.step), _worst(link))
        _bar(axis, len(chain), floor, floor, "--measured", end, chain[-1].unit)
        _words(axis, len(chain), FLOOR, "what the sensors’ own noise leaves of a perfect model")
        axis.set_xlim(0.0, ROOM * end)
        axis.set_ylim(len(chain) + 0.5, -0.5)
        axis.set_axis_off()
        return svg_text(figure, key)


def is_cut(chain: Sequence[Link]) -> bool:
    """Whether the first bar is longer than drawn."""
    return bool(chain[0].rmse > _end([*(link.rmse for link in chain), chain[-1].noise_floor]))


def _end(lengths: Sequence[float]) -> float:
    """Longest length drawn: that of the longest bar, unless the first is far longer than the others."""
    finite = [length for length in lengths if np.isfinite(length)] or [1.0]
    others = max(finite[1:], default=finite[0])
    return min(finite[0], CUT * others) if finite[0] > others > 0.0 else max(others, 1e-12)


def _bar(axis: Any, row: int, rmse: float, floor: float, colour: str, end: float, unit: str) -> None:
    """With a tick at its floor and the number behind it."""
    middle, noise, stop = row + 0.16, min(rmse, floor), min(rmse, end)
    parts = [(0.0, noise, "--measured"), (noise, stop, colour)]
    if rmse > end:
        parts[1:] = [(noise, BREAK[0] * end, colour), (BREAK[1] * end, end, colour)]
    for start, stop, shade in parts:
        if stop > start:
            axis.barh(middle, stop - start, BAR, start, color=COLOURS[shade], linewidth=0)
    axis.plot([floor, floor], [middle - 0.5 * BAR, middle + 0.75 * BAR], color=COLOURS["--ink"], linewidth=1.3)
    place = (max(min(rmse, end), floor), middle)
    text = f"{significant(rmse)} {chain_unit(unit)}"
    axis.annotate(text, place, (6, 0), textcoords="offset points", va="center", fontweight="bold")


def _words(axis: Any, row: int, step: str, note: str) -> None:
    transform, height = axis.get_yaxis_transform(), row - 0.1
    axis.text(0.0, height, step, transform=transform, va="bottom", fontsize=9.5, color=COLOURS["--ink"])
    axis.text(1.0, height, note, transform=transform, va="bottom", ha="right", fontsize=8.5, color=COLOURS["--muted"])


def _worst(link: Link) -> str:
    if not link.worst:
        return ""
    if link.worst_rmse <= link.worst_floor:
        return "every channel at its floor or below"
    unit = link.worst_unit
    numbers = f"{significant(link.worst_rmse)} over {significant(link.worst_floor)}"
    return f"furthest above its floor: {channel(link.worst)}, {numbers}{'' if unit == link.unit else f' {unit}'}"


def draw_evidence(evidence: Evidence, words: Mapping[str, str], key: str, unit: str = "N·m") -> str:
    """Mean residual before (thick, grey) and after (thin), the effect's own part (dashed), two standard errors.

    words: coordinate -> what the axis says of it. unit: of the residual.
    """
    with matplotlib.rc_context({**STYLE, "text.parse_math": False}):
        figure = sheet(9.0, 2.3, 1, top=0.12)
        figure.subplots_adjust(left=MARGIN)
        axis = figure.subplots()
        axis.grid(axis="y")
        axis.axhline(0.0, color=COLOURS["--muted"], linewidth=0.6)
        doubt = DOUBT * np.nan_to_num(evidence.spread)
        for values, colour in ((evidence.before, "--measured"), (evidence.after, "--identified")):
            low, high = values - doubt, values + doubt
            axis.fill_between(evidence.at, low, high, color=COLOURS[colour], alpha=FAINT, linewidth=0)
            draw_line(axis, evidence.at, values, colour)
            if evidence.at.size <= MARKED:
                size = 4.5 if colour == "--measured" else 2.6
                axis.plot(evidence.at, values, "o", markersize=size, color=COLOURS[colour], markeredgewidth=0)
        axis.plot(evidence.at, evidence.model, color=COLOURS["--ink"], linewidth=1.6, linestyle=(0, (3.0, 1.6)))
        over = f" [{evidence.unit}]" if evidence.unit else ""
        axis.set_xlabel(f"{words.get(evidence.coordinate, evidence.coordinate.replace('_', ' '))}{over}")
        _stretch(axis, evidence.at)
        axis.set_ylabel(f"[{unit}]")
        axis.yaxis.set_major_locator(MaxNLocator(5))
        axis.margins(x=0.01)
        return svg_text(figure, key)


def _stretch(axis: Any, at: Array) -> None:
    """Where most bins lie close to zero, so does what they show: the axis is logarithmic away from it."""
    size = np.abs(at[np.isfinite(at)])
    largest = size.max(initial=0.0)
    if size.size < 5 or largest <= 0.0 or np.median(size) > CROWDED * largest:
        return
    inner = 10.0 ** np.floor(np.log10(max(np.quantile(size, 0.25), 1e-4 * largest)))
    axis.set_xlabel(f"{axis.get_xlabel()}, stretched about zero")
    axis.set_xscale("symlog", linthresh=inner, linscale=0.6)
    decades = inner * 10.0 ** np.arange(np.floor(np.log10(largest / inner)) + 1.0)
    low, high = axis.get_xlim()
    ticks = [tick for tick in (*-decades[::-1], 0.0, *decades) if low <= tick <= high]
    axis.set_xticks(ticks, [significant(tick, 1) for tick in ticks])
    axis.xaxis.set_minor_locator(NullLocator())
