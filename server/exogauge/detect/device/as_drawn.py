"""A curve whose shape the data do not decide is told as it is drawn, without numbers that nobody could use.

Size and shape of one curve may trade against each other so far that each alone is open, while their curve is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.effects.effect import Quantity
from exogauge.effects.order import LOG, SINCE
from exogauge.findings.result import Finding
from exogauge.identification.model import Effect

PLACES = (LOG, SINCE)  # in the order of the logs: no number of a curve


def as_drawn(finding: Finding, effect: Effect, judging: Judging) -> Finding:
    """Without the shapes whose std exceeds their value, and without coefficients that may as well be zero beside them.

    A shape that may be negative, such as the angle at which a spring rests, is a place: zero is as good as any other.
    """
    shapes = [one.name for one in effect.shapes if not one.choice and one.low >= 0.0 and one.name not in PLACES]
    own: Sequence[Quantity] = effect.coefficients
    sizes = [one.name for one in own if one.name in finding.parameters]
    open_shapes = [name for name in shapes if name in finding.parameters and _std_over_value(finding, name) > 1.0]
    open_sizes = [name for name in sizes if judging.significant * _std_over_value(finding, name) > 1.0]
    if not open_shapes and not (shapes and sizes and open_sizes == sizes):
        return finding
    dropped = (*open_sizes, *open_shapes)
    kept = {name: each for name, each in finding.parameters.items() if name not in dropped}
    return replace(finding, parameters=kept, as_drawn=dropped)


def _std_over_value(finding: Finding, name: str) -> float:
    found: Estimate = finding.parameters[name]
    return float(found.std / max(abs(found.value), 1e-300))
