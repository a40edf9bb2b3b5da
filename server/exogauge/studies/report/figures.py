"""Drawings of the report as inline SVG; colours are CSS variables, so one drawing serves light, dark and paper.

Like Figs 9-11 of [Evaluator]: measured thick and grey, identified model thin and solid, a-priori model thin and dotted.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from exogauge.identification.result import Channels, Prediction

Array = NDArray[np.float64]

BUCKETS = 500
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
        axis.grid(axis="y")
        factors, scores = [list(column) for column in zip(*ordered, strict=True)]
        axis.plot(factors, scores, color=COLOURS["--identified"], linewidth=1.3, marker="o", markersize=3.5)
        if factors[0] <= chosen <= factors[-1]:
            axis.axvline(chosen, color=COLOURS["--prior"], linewidth=1.0, linestyle=(0, (1, 2)))
        axis.set_xlabel("factor on the prior's weight")
        axis.set_ylabel("held-out error, weighted")
        axis.yaxis.set_major_locator(MaxNLocator(4))
        return svg_text(figure, key)


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
