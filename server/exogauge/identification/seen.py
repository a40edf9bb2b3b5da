"""What several sites see of one log: axes that they share are looked at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from exogauge.identification.axis_signals import axis_signals
from exogauge.identification.pair_site import PairSite, seen_of_pair
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import AxisSite, Seen, Site, seen_of_axis

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel


def seen_by(model: RobotModel, prepared: Prepared, sites: Sequence[Site]) -> dict[Site, Seen]:
    """Site -> `Site.see`."""
    single = [site.axis for site in sites if isinstance(site, AxisSite)]
    paired = [axis for site in sites if isinstance(site, PairSite) for axis in (site.axis, site.other)]
    axes = list(dict.fromkeys([*single, *paired]))
    signals = dict(zip(axes, axis_signals(model, prepared, axes), strict=True)) if axes else {}
    found: dict[Site, Seen] = {}
    for site in sites:
        if isinstance(site, AxisSite):
            found[site] = seen_of_axis(signals[site.axis])
        elif isinstance(site, PairSite):
            found[site] = seen_of_pair(signals[site.axis], signals[site.other])
        else:
            found[site] = site.see(model, prepared)
    return found
