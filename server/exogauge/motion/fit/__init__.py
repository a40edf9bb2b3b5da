"""A human body fitted to captured motion: its proportions, where its markers sit, and its angles over time."""

from exogauge.motion.fit.fit import fit_human
from exogauge.motion.fit.result import HumanFit

__all__ = ["HumanFit", "fit_human"]
