"""Synthetic studies from MuJoCo. Imports nothing of the code that evaluates them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

from exogauge.errors import Unavailable


def write_sample(
    out: Path,
    seed: int,
    hidden: Sequence[str] = (),
    suit: str = "none",
    progress: Callable[[float, str], None] | None = None,
) -> None:
    """Write a whole synthetic study folder into `out`, truth.json included; see `study.write_study`."""
    if find_spec("mujoco") is None:
        raise Unavailable("making a sample needs MuJoCo, which is not installed: pip install 'exogauge[sample]'")
    from exogauge.synthetic.study import write_study

    write_study(out, seed, hidden, suit, progress)
