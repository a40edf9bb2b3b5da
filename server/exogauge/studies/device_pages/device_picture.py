"""A drawing of a robot as a stick figure with a device's bands on it: front and side view, for light and dark."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Device
from exogauge.devices.posture import Posture
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.studies.device_pages.link_table import base_link

Array = NDArray[np.float64]

HEIGHT, WIDEST, MARGIN, TOP, LINE = 620.0, 560.0, 48.0, 46.0, 18.0  # [px]
LETTER = 8.0  # [px] of a label, capitals too
COLOURS = ("#2f7ed8", "#d9480f", "#2b9348", "#a64ac9", "#a67c00", "#0b8f9c")
STYLE = """
text { font: 12px system-ui, sans-serif; fill: #22262c }
.page { fill: #ffffff } .muted { fill: #69707c } .title { font-weight: 600; font-size: 14px }
.bone { stroke: #a4abb6; stroke-width: 4; stroke-linecap: round } .joint { fill: #69707c }
.scale { stroke: #69707c; stroke-width: 2 } .tie { stroke-width: 1.2; stroke-dasharray: 2 3 }
.band { fill: none; stroke-width: 2.5; stroke-linejoin: round }
.link { paint-order: stroke; stroke: #ffffff; stroke-width: 3px }
.number { font-size: 10px; font-weight: 600; fill: #ffffff; text-anchor: middle }
@media (prefers-color-scheme: dark) {
  text { fill: #e6e8eb } .page { fill: #15181d } .muted { fill: #9aa2af }
  .bone { stroke: #596170 } .joint { fill: #9aa2af } .scale { stroke: #9aa2af } .link { stroke: #15181d }
  .number { fill: #ffffff }
}"""


@final
@dataclass(frozen=True)
class _View:
    """One panel. across: what counts to the right, in the base link's axes; scale: [px/m].

    edge: of the panel [px]; left: of the figure [px], at low_m [m]; top_m: the highest place [m].
    two_sided: names of links stand outside, on both sides.
    """

    title: str
    across: Array
    scale: float
    edge: float
    left: float
    low_m: float
    top_m: float
    two_sided: bool

    def at(self, place: Array) -> tuple[float, float]:
        right, down = (float(place @ self.across) - self.low_m, self.top_m - float(place[2]))
        return self.left + right * self.scale, TOP + MARGIN / 2 + down * self.scale

    @property
    def middle(self) -> float:
        return self.left - self.low_m * self.scale


def draw_device(robot: Robot, device: Device | None) -> str:
    """An SVG, all joints at zero; without a device, the robot with the name of every link that moves.

    Forward is +x of the base link, left +y, up +z.
    """
    posture = Posture(robot.tree)
    figure = list(bones(robot.tree, posture))
    bands = () if device is None else device.bands
    routes = [np.array([posture.place(point) for point in band.via_points]) for band in bands]
    links = [point.link for band in bands for point in band.via_points]
    links = links or list(dict.fromkeys([base_link(robot.tree), *robot.tree.bodies]))
    labels = {link: np.asarray(posture.pose(link).translation) for link in links}
    longest = LETTER * max(map(len, labels))
    views, width, foot = _views(np.vstack([*(np.array(bone) for bone in figure), *routes]), longest)
    name = robot.name if device is None else f"{device.name} on {robot.name}"
    lines = [f'<text class="title" x="16" y="24">{escape(name)}</text>']
    for view in views:
        lines += _figure(view, figure)
        if view.two_sided or bands:
            lines += _labels(view, labels)
        for k, (band, places) in enumerate(zip(bands, routes, strict=True)):
            origins = [labels[point.link] for point in band.via_points]
            lines += _band(view, COLOURS[k % len(COLOURS)], places, origins)
    lines += _scale_bar(views[0], foot)
    for k, band in enumerate(bands):
        y, colour = foot + LINE * (k + 2), COLOURS[k % len(COLOURS)]
        lines.append(f'<line class="band" x1="16" x2="40" y1="{y - 4:.0f}" y2="{y - 4:.0f}" stroke="{colour}"/>')
        passes = " – ".join(f"{j} {point.link}" for j, point in enumerate(band.via_points, start=1))
        told = f'{escape(band.name)}<tspan class="muted">: {escape(passes)}</tspan>'
        lines.append(f'<text x="48" y="{y:.0f}">{told}</text>')
        width = max(width, 64.0 + LETTER * (len(band.name) + len(passes)))
    height = foot + LINE * (len(bands) + 2.5)
    size = f'viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}"'
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
            f"<title>{escape(name)}</title>",
            f"<style>{STYLE}</style>",
            '<rect class="page" width="100%" height="100%"/>',
            *lines,
            "</svg>\n",
        ]
    )


def bones(tree: RigidTree, posture: Posture) -> Iterator[tuple[Array, Array]]:
    """From every body's origin to its parent's; a last body goes on to its farthest frame, so that it has a length."""
    origins = [np.asarray(posture.pose(body).translation) for body in tree.bodies]
    for n, up in enumerate(tree.parent):
        if up >= 0 or not tree.floating:
            yield (origins[up] if up >= 0 else np.zeros(3)), origins[n]
    for n in set(range(len(tree.bodies))) - set(tree.parent.tolist()):
        ends = [posture.pose(name).translation for name, (body, _) in tree.frames.items() if body == n]
        yield origins[n], np.asarray(max(ends, key=lambda end: float(np.linalg.norm(end - origins[n]))))


def _views(seen: Array, label: float) -> tuple[list[_View], float, float]:
    """Both panels in one scale, the picture's width, and where the legend begins [px]. label: room to the right."""
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = np.maximum(high - low, 0.1)
    scale = float(min(HEIGHT / extent[2], WIDEST / max(extent[0], extent[1])))
    room = max(MARGIN, label + 16.0)
    front = _View(
        title="front: the robot's left is on the right",
        across=np.array([0.0, 1.0, 0.0]),
        scale=scale,
        edge=0.0,
        left=room,
        low_m=float(low[1]),
        top_m=float(high[2]),
        two_sided=True,
    )
    edge = float(extent[1]) * scale + 2 * room
    side = replace(
        front,
        title="side: forward is to the right",
        across=np.array([1.0, 0.0, 0.0]),
        edge=edge,
        left=edge + MARGIN,
        low_m=float(low[0]),
        two_sided=False,
    )
    width = edge + max(float(extent[0]) * scale + MARGIN + room, 250.0)
    return [front, side], width, TOP + MARGIN + LINE + float(extent[2]) * scale


def _figure(view: _View, bones: Sequence[tuple[Array, Array]]) -> Iterator[str]:
    yield f'<text class="muted" x="{view.edge + 16:.0f}" y="{TOP:.0f}">{escape(view.title)}</text>'
    ends = [(view.at(start), view.at(end)) for start, end in bones]
    for (x1, y1), (x2, y2) in ends:
        yield f'<line class="bone" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
    for x, y in dict.fromkeys(start for start, _ in ends):
        yield f'<circle class="joint" cx="{x:.1f}" cy="{y:.1f}" r="3"/>'


def _band(view: _View, colour: str, places: Array, origins: Sequence[Array]) -> Iterator[str]:
    """Dotted: from each via point to the origin of the link in whose frame it is written."""
    points = [view.at(place) for place in places]
    for (x, y), (x0, y0) in zip(points, map(view.at, origins), strict=True):
        yield f'<line class="tie" stroke="{colour}" x1="{x:.1f}" y1="{y:.1f}" x2="{x0:.1f}" y2="{y0:.1f}"/>'
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    yield f'<polyline class="band" stroke="{colour}" points="{path}"/>'
    for number, (x, y) in enumerate(points, start=1):
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="{colour}"/>'
        yield f'<text class="number" x="{x:.1f}" y="{y + 3.5:.1f}">{number}</text>'


def _labels(view: _View, origins: dict[str, Array]) -> Iterator[str]:
    """Names of links beside their origins, lines apart; in the front view those of the right side stand on the left."""
    taken: list[tuple[bool, float, float]] = []
    for link, (x, at_y) in sorted(((k, view.at(v)) for k, v in origins.items()), key=lambda item: item[1][1]):
        y = at_y + 4.0
        leftward = view.two_sided and x < view.middle - 1.0
        while any(side == leftward and abs(x - x2) < 140.0 and abs(y - y2) < 13.0 for side, x2, y2 in taken):
            y += 13.0
        taken.append((leftward, x, y))
        anchor, beside = ("end", x - 10.0) if leftward else ("start", x + 10.0)
        place = f'x="{beside:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
        yield f'<text class="muted link" {place}>{escape(link)}</text>'


def _scale_bar(view: _View, y: float) -> Iterator[str]:
    metres = 0.5 if view.scale * 0.5 < 200.0 else 0.1
    yield f'<line class="scale" x1="16" x2="{16 + metres * view.scale:.1f}" y1="{y:.1f}" y2="{y:.1f}"/>'
    yield f'<text class="muted" x="{24 + metres * view.scale:.1f}" y="{y + 4:.1f}">{metres:g} m</text>'
