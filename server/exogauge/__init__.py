"""exogauge: say with numbers what an assistive wear does to a body."""

__version__ = "0.1.0"
