"""A picture of how often stated intervals hold: the share inside, by the share that is claimed, one panel per kind."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from tests.calibration.kinds import Told

CLAIMED = np.linspace(0.05, 0.95, 19)
SIDE, APART, ACROSS = 120, 46, 4
STYLE = """
  .paper { fill: #ffffff } .frame { fill: #f3f5f8; stroke: #8792a2 }
  text { font: 12px system-ui, sans-serif; fill: #1d2430 }
  .small { font-size: 11px; fill: #4a5565 } .even { stroke: #8792a2; stroke-dasharray: 4 4 }
  .found { stroke: #1f5fb0; stroke-width: 2; fill: none } .chance { fill: #5b86c4; opacity: .25 }
  @media (prefers-color-scheme: dark) {
    .paper { fill: #14181f } .frame { fill: #222935; stroke: #7b8799 } text { fill: #e8ecf2 } .small { fill: #b4becc }
    .even { stroke: #98a3b3 } .found { stroke: #7fb0f0 }
  }
"""


def calibration(numbers: Sequence[Told], said: str) -> str:
    """An SVG. The band: where 19 of 20 shares of as many independent numbers would lie if every claim were true."""
    kinds = sorted({each.kind for each in numbers if each.told})
    rows = -(-len(kinds) // ACROSS)
    width, height = 30 + ACROSS * (SIDE + APART), 46 + rows * (SIDE + APART + 14)
    parts = [
        _panel(kind, [each for each in numbers if each.kind == kind and each.told],
               36 + (k % ACROSS) * (SIDE + APART), 54 + (k // ACROSS) * (SIDE + APART + 14))
        for k, kind in enumerate(kinds)
    ]  # fmt: skip
    title = f"Share of the truths inside, by the share that an interval claims: {said}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'role="img">\n<title>{escape(title)}</title>\n<style>{STYLE}</style>\n'
        f'<rect width="{width}" height="{height}" class="paper"/>\n<text x="16" y="24">{escape(title)}</text>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )


def _panel(kind: str, own: Sequence[Told], left: float, top: float) -> str:
    def at(claimed: float, share: float) -> str:
        return f"{left + SIDE * claimed:.1f},{top + SIDE * (1.0 - min(max(share, 0.0), 1.0)):.1f}"

    half = 1.96 * np.sqrt(CLAIMED * (1.0 - CLAIMED) / len(own))
    shares = [float(np.mean([each.inside_of_normal(float(level)) for each in own])) for level in CLAIMED]
    upper = [at(c, c + h) for c, h in zip(CLAIMED, half, strict=True)]
    lower = [at(c, c - h) for c, h in zip(CLAIMED, half, strict=True)]
    line = " ".join(at(c, share) for c, share in zip(CLAIMED, shares, strict=True))
    return (
        f'<rect x="{left}" y="{top}" width="{SIDE}" height="{SIDE}" class="frame"/>'
        f'<polygon points="{" ".join([*upper, *lower[::-1]])}" class="chance"/>'
        f'<line x1="{left}" y1="{top + SIDE}" x2="{left + SIDE}" y2="{top}" class="even"/>'
        f'<polyline points="{line}" class="found"/>'
        f'<text x="{left}" y="{top - 6}">{escape(kind)}</text>'
        f'<text x="{left}" y="{top + SIDE + 14}" class="small">0</text>'
        f'<text x="{left + SIDE}" y="{top + SIDE + 14}" class="small" text-anchor="end">1, of {len(own)}</text>'
    )
