"""Whether what begins with one of the logs holds from there on, or is another in each log.

The step from one log to the next is fitted to whatever changes over the session. Beside it, and with it in the model,
each log is given a size of its own, which is fitted to every second block of it and judged on those between. What they
explain beyond the step is what no step holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import SINCE, present
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.model import AddedEffect, RobotModel
from exogauge.identification.settings import Recording
from exogauge.search.final_numbers import coefficients
from exogauge.search.site_rows import SiteRows, collect_rows
from exogauge.search.sums import sureness

Array = NDArray[np.float64]


def another_in_each_log(model: RobotModel, added: AddedEffect, recordings: Sequence[Recording]) -> Objection | None:
    """model: with all that was named, `added` among it."""
    shapes = added.effect.shapes
    if not any(each.name == SINCE for each in shapes):
        return None
    always = tuple(0.0 if one.name == SINCE else value for one, value in zip(shapes, added.shape, strict=True))
    order, size, judging = model.order, coefficients(model, added), model.criteria.judging
    grams, sizes, gains = list[Array](), list[Array](), list[float]()
    for rows in collect_rows(model, recordings, [added.site])[added.site]:
        halves = _blocks(model, rows, rows.columns(added.effect, always), judging.block_s)
        if not all(halves):
            continue
        sums = [[np.sum(parts, axis=0) for parts in zip(*half, strict=True)] for half in halves]
        own = [np.linalg.lstsq(G, b, rcond=None)[0] for G, b in sums]
        gains += [
            2.0 * float(b @ d) - float(d @ G @ d) for half, d in zip(halves, own[::-1], strict=True) for G, b in half
        ]
        grams.append(sums[0][0] + sums[1][0])
        sizes.append(size * present(shapes, added.shape, order.get(rows.log, -1)))
    if not gains:
        return None
    pulled = [G @ s for G, s in zip(grams, sizes, strict=True)]
    usual = np.linalg.lstsq(np.sum(grams, axis=0), np.sum(pulled, axis=0), rcond=None)[0]
    step = sum(float((s - usual) @ G @ (s - usual)) for G, s in zip(grams, sizes, strict=True))
    beyond = sum(gains)
    if beyond <= judging.of_its_law * (step + beyond) or sureness(np.array(gains)) < judging.sure:
        return None
    return Objection(Why.ANOTHER_IN_EACH_LOG, step / (step + beyond))


def _blocks(
    model: RobotModel, rows: SiteRows, columns: Mapping[int, Array], block_s: float
) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array]]]:
    """Even blocks and odd ones of the log's time: weighted normal matrix (C, C) and right-hand side (C,) of each."""
    found = dict[int, tuple[Array, Array]]()
    for kind, own in rows.rows.items():
        number = np.floor(rows.time[own.samples] / block_s).astype(np.intp)
        for block in np.unique(number):
            inside = number == block
            c, weight = columns[kind][inside], float(model.solution.weights[kind])
            G, b = weight * (c.T @ c), weight * (c.T @ own.e[inside])
            before = found.get(int(block))
            found[int(block)] = (before[0] + G, before[1] + b) if before else (G, b)
    even, odd = ([pair for block, pair in sorted(found.items()) if block % 2 == half] for half in (0, 1))
    return even, odd
