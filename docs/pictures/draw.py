"""Draws the pictures of the documents beside this file: `python docs/pictures/draw.py`."""

from __future__ import annotations

from html import escape
from pathlib import Path

STYLE = """
  .paper { fill: #ffffff } .box { fill: #f3f5f8; stroke: #8792a2 } .soft { fill: #e4eefb; stroke: #5b86c4 }
  .mark { fill: #fdeed8; stroke: #c77d1e } text { font: 14px system-ui, sans-serif; fill: #1d2430 }
  .name { font-weight: 600 } .small { font-size: 12.5px; fill: #4a5565 } .note { font-size: 12.5px; fill: #8a5200 }
  .line { stroke: #66707f; stroke-width: 1.4; fill: none } .fine { stroke: #c77d1e; stroke-width: 1.2; fill: none }
  .tip { fill: #66707f } .dash { stroke: #66707f; stroke-width: 1.2; stroke-dasharray: 6 5 }
  @media (prefers-color-scheme: dark) {
    .paper { fill: #14181f } .box { fill: #222935; stroke: #7b8799 } .soft { fill: #1d3352; stroke: #6d9be0 }
    .mark { fill: #46300f; stroke: #e0a04a } text { fill: #e8ecf2 } .small { fill: #b4becc } .note { fill: #f0bb70 }
    .line, .dash { stroke: #98a3b3 } .tip { fill: #98a3b3 } .fine { stroke: #e0a04a }
  }
"""


def text(x: float, y: float, words: str, kind: str = "", anchor: str = "start") -> str:
    return f'<text x="{x}" y="{y}" class="{kind}" text-anchor="{anchor}">{escape(words)}</text>'


def box(x: float, y: float, width: float, name: str, *lines: str, kind: str = "box", height: float = 0.0) -> str:
    """A box with its name and lines of small words, all in the middle. The height follows the lines."""
    height = height or 34 + 18 * len(lines)
    top = y + (height - 18 * len(lines)) / 2 + 5
    words = [text(x + width / 2, top, name, "name", "middle")]
    words += [text(x + width / 2, top + 18 * k, line, "small", "middle") for k, line in enumerate(lines, 1)]
    return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" class="{kind}"/>' + "".join(words)


def arrow(*points: tuple[float, float]) -> str:
    path = " ".join(f"{x},{y}" for x, y in points)
    return f'<polyline points="{path}" class="line" marker-end="url(#tip)"/>'


def note(x: float, y: float, to: float, *lines: str) -> str:
    """Words in the margin at x, with a line to the left end `to`."""
    words = "".join(text(x, y + 4 + 16 * k, line, "note") for k, line in enumerate(lines))
    return f'<polyline points="{x - 6},{y} {to},{y}" class="fine"/>' + words


def picture(name: str, width: int, height: int, title: str, *parts: str) -> None:
    tip = (
        '<marker id="tip" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto">'
        '<path d="M0,0 L9,4 L0,8 z" class="tip"/></marker>'
    )
    size = f'viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    drawn = "\n".join(parts)
    page = (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n<defs>{tip}</defs>\n"
        f'<rect width="{width}" height="{height}" class="paper"/>\n{drawn}\n</svg>\n'
    )
    Path(__file__).with_name(f"{name}.svg").write_text(page, encoding="utf-8")


def house() -> None:
    floors = [
        ("cli · api · client · scene", "commands, HTTP, Python client, 3D view", "box"),
        ("jobs", "queue, workers, progress", "box"),
        ("studies", "intake → evaluate → results → report", "box"),
        ("storage · sandbox · settings", "database, files, a fenced child for uploads", "box"),
        ("detect", "detectors in their order", "soft"),
        ("experiment", "the motion that would tell two causes apart", "soft"),
        ("search", "which effect is missing", "soft"),
        ("findings", "what was found, as data", "soft"),
        ("support · plausibility", "supporting torque; the doctor", "soft"),
        ("identification", "rows, weights, prior, solution, std", "soft"),
        ("effects · devices", "why a torque is what it is; bands of a device", "soft"),
        ("robots", "kinematics and regressor of a URDF", "soft"),
        ("estimation", "statistics of linear rows", "soft"),
        ("logs", "tables, clocks, filters, noise", "soft"),
        ("criteria", "numbers that decide, and why", "soft"),
    ]
    parts, notes = [], []
    for k, (name, words, kind) in enumerate(floors):
        y = 16 + 46 * k + (34 if k > 3 else 0)
        parts.append(f'<rect x="20" y="{y}" width="560" height="40" rx="6" class="{kind}"/>')
        parts += [text(36, y + 25, name, "name"), text(284, y + 25, words, "small")]
        if name == "studies":
            notes.append(note(620, y + 14, 580, "a new report section:", "studies/report/"))
        if name == "detect":
            notes.append(note(620, y + 14, 580, "a new detector:", "detect/, named in pipeline.py"))
        if name.startswith("effects"):
            notes.append(
                note(620, y + 14, 580, "a new law of a band, effect of a joint or sensor:", "one file in effects/")
            )
        if name == "logs":
            notes.append(note(620, y + 14, 580, "a new log format:", "a *_table.py in logs/"))
    y = 16 + 46 * 4 + 8
    parts.append(f'<line x1="20" x2="580" y1="{y + 6}" y2="{y + 6}" class="dash"/>')
    parts.append(text(620, y - 8, "above: the shell", "small"))
    parts.append(text(620, y + 9, "below: numerics, arrays in, values out", "small"))
    picture(
        "house", 890, 16 + 46 * 15 + 44, "The packages of exogauge: each imports only what is below it", *parts, *notes
    )


def walk() -> None:
    column, x = 250, (20, 320, 620)
    parts = [
        text(x[0] + 125, 22, "a log", "small", "middle"),
        text(x[1] + 125, 22, "the robot", "small", "middle"),
        text(x[2] + 125, 22, "the device", "small", "middle"),
        box(x[0], 36, column, "read", "columns, units, signs, names", "logs/, studies/intake"),
        box(x[0], 136, column, "even clock, doctor", "gaps cut, faults told before", "anything is believed"),
        box(x[0], 236, column, "prepare", "low-pass, differentiate;", "steady motion and rest told apart"),
        box(x[0], 336, column, "rows", "[A | y] per base axis, joint,", "sensor component", kind="soft"),
        box(x[1], 336, column, "statistics", "a few MB, however long the log", kind="soft", height=70),
        box(
            x[1],
            236,
            column,
            "solve",
            "prior, weights, possible bodies;",
            "four passes: friction needs its sign",
            kind="soft",
        ),
        box(x[1], 136, column, "identification", "every value with its std;", "errors on held-out logs", kind="soft"),
        box(x[1], 36, column, "search", "what is missing is named, added,", "and all is identified again", kind="mark"),
        box(
            x[2],
            36,
            column,
            "supporting torque",
            "A: without minus with the device",
            "B: model minus measurement",
            kind="soft",
        ),
        box(x[2], 136, column, "bands", "stiffness, natural length, std", kind="soft", height=70),
        box(x[2], 236, column, "search on bands", "what a band does beyond a spring", kind="mark", height=70),
        box(x[2], 336, column, "results.json", "report, summary, tables,", "series, URDF"),
    ]
    down = [arrow((x[0] + 125, 36 + 100 * k + 70), (x[0] + 125, 136 + 100 * k)) for k in range(3)]
    across = [arrow((x[0] + 250, 371), (x[1], 371)), arrow((x[1] + 250, 71), (x[2], 71))]
    up = [arrow((x[1] + 125, 336 - 100 * k), (x[1] + 125, 306 - 100 * k)) for k in range(3)]
    again = [
        arrow((x[1], 61), (x[1] - 18, 61), (x[1] - 18, 261), (x[1], 261)),
        text(x[1] - 24, 120, "again", "small", "end"),
    ]
    last = [arrow((x[2] + 125, 36 + 100 * k + 70), (x[2] + 125, 136 + 100 * k)) for k in range(3)]
    picture("walk-of-a-log", 890, 426, "From a log to the results", *parts, *down, *across, *up, *again, *last)


def search() -> None:
    x, y, wide = (20, 320, 620), (20, 120, 220, 330), 250
    parts = [
        box(x[0], y[0], wide, "baseline", "all parameters and the prior,", "as identified"),
        box(x[1], y[0], wide, "candidates", "effect × place × shape,", "some thousands"),
        box(x[2], y[0], wide, "score", "gain beside the whole baseline,", "on fitted logs"),
        box(x[2], y[1], wide, "refine", "the shapes of the dozen best"),
        box(x[1], y[1], wide, "judge", "do held-out logs surely gain?"),
        box(x[0], y[1], wide, "add", "identify the robot again", kind="soft"),
        box(x[1], y[2], wide, "nothing qualifies", "any more"),
        box(
            x[0],
            y[3],
            wide,
            "prune and correct",
            "drop what is not needed; shapes",
            "once more; curves of their own",
            kind="soft",
        ),
        box(x[1], y[3], wide, "findings", "effect, place, numbers ± std,", "what else it may be", kind="mark"),
        box(x[2], y[3], wide, "experiment", "the motion that would tell", "what these logs cannot"),
    ]
    ways = [
        arrow((270, 55), (320, 55)), arrow((570, 55), (620, 55)), arrow((745, 90), (745, 120)),
        arrow((620, 146), (570, 146)), arrow((320, 146), (270, 146)), arrow((145, 120), (145, 90)),
        arrow((445, 172), (445, 220)), arrow((320, 246), (145, 246), (145, 330)),
        arrow((270, 365), (320, 365)), arrow((570, 365), (620, 365)),
        text(295, 138, "yes", "small", "middle"), text(455, 202, "no", "small"), text(155, 110, "again", "small"),
        text(620, 240, '"Unexplained" is an answer, too: what', "small"),
        text(620, 257, "is left is told with its place.", "small"),
    ]  # fmt: skip
    picture("search", 890, 420, "How a missing effect is found", *parts, *ways)


if __name__ == "__main__":
    house()
    walk()
    search()
