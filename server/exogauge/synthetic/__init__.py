"""Synthetic studies from MuJoCo. Imports nothing of the code that evaluates them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

from exogauge.errors import BadInput, Fault, Unavailable
from exogauge.synthetic.disturbances import DEFAULT, chosen


def write_sample(
    out: Path,
    seed: int,
    hidden: Sequence[str] | None = None,
    suit: str = "both",
    progress: Callable[[float, str], None] | None = None,
    processes: int = 1,
    realism: str = DEFAULT,
    added: Sequence[str] = (),
    left_out: Sequence[str] = (),
    motions: Sequence[Path] = (),
) -> None:
    """Write a whole synthetic study folder into `out`, truth.json included; see `study.write_study`.

    realism, added, left_out: what the laboratory does to it, in the words of `disturbances.chosen`. motions: tables of
    planned motions, played in place of bends and twists.
    """
    if find_spec("mujoco") is None:
        raise Unavailable("making a sample needs MuJoCo, which is not installed: pip install 'exogauge[sample]'")
    from exogauge.synthetic.played import read_motions
    from exogauge.synthetic.study import write_study

    disturbed, played = chosen(realism, added, left_out), read_motions(motions)
    write_study(out, seed, hidden, suit, progress, processes=processes, disturbed=disturbed, played=played)


def refuse_fall(motion: Path, seed: int, realism: str = DEFAULT) -> None:
    """Raises BadMotion (`fell_over`) where the robot of `write_sample` would fall in a run of a planned motion."""
    if find_spec("mujoco") is None:
        raise Unavailable("making a sample needs MuJoCo, which is not installed: pip install 'exogauge[sample]'")
    from exogauge.synthetic.played import read_motions
    from exogauge.synthetic.study import rehearse

    rehearse(seed, "both", chosen(realism), read_motions([motion]))


def write_sample_robot(folder: Path) -> None:
    """robot.yaml and robot.urdf of the sample's robot, for planning motions before there is a sample."""
    import yaml

    from exogauge.synthetic.urdf import robot_file, robot_urdf

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(robot_urdf(), encoding="utf-8")
    (folder / "robot.yaml").write_text(yaml.safe_dump(dict(robot_file()), sort_keys=False), encoding="utf-8")


def write_payload_sample(out: Path, seed: int, hidden: Sequence[str] | None = None) -> None:
    """Write a synthetic payload recording into `out`, truth.json included; see `payload.write_payload`."""
    if find_spec("mujoco") is None:
        raise Unavailable("making a sample needs MuJoCo, which is not installed: pip install 'exogauge[sample]'")
    if seed < 0:
        raise BadInput(Fault("the seed must be 0 or more", "seed_negative", column="seed", value=str(seed)))
    from exogauge.synthetic.payload import write_payload

    write_payload(out, seed, hidden)


def processors() -> int:
    """How many processors this process may use: a good number of `processes`."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
