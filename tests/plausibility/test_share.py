"""How often the doctor names the right joint: flips, exchanged columns, other units, dead channels, at random."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.fuzz.small_robots import JOINTS, simulated_logs, write_study
from tests.plausibility.test_examine import as_log

from exogauge.plausibility.examine import examine_against_robot
from exogauge.studies.robot_file import load_robot

pytestmark = pytest.mark.slow

DRAWN = 28  # 14 on each robot, two of each kind
KINDS = ("flip q", "flip i", "exchange q", "exchange i", "degrees", "unit", "dead")


def slip(kind: str, joint: str, other: str, factor: float, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    q, i = f"q.{joint}", f"i.{joint}"
    changed = {
        "flip q": {q: -columns[q]},
        "flip i": {i: -columns[i]},
        "exchange q": {q: columns[f"q.{other}"], f"q.{other}": columns[q]},
        "exchange i": {i: columns[f"i.{other}"], f"i.{other}": columns[i]},
        "degrees": {q: np.degrees(columns[q])},
        "unit": {i: factor * columns[i]},
        "dead": {i: 0.0 * columns[i]},
    }
    return columns | changed[kind]


def test_nineteen_of_twenty_slips_are_named_at_the_right_joint(tmp_path: Path) -> None:
    rng, right, wrong = np.random.default_rng(5), 0, []
    for floating in (False, True):
        folder = tmp_path / str(floating)
        write_study(folder, floating, {})
        robot, logs = load_robot(folder), list(simulated_logs(floating).values())
        for number in range(DRAWN // 2):
            joint, other = rng.choice(JOINTS, 2, replace=False)
            kind, factor = KINDS[number % len(KINDS)], float(rng.choice([1000.0, 100.0, 0.01, 0.001]))
            made = [as_log(k, slip(kind, joint, other, factor, each)) for k, each in enumerate(logs)]
            named = {finding.channel.partition(".")[2] for _, finding in examine_against_robot(robot, made)}
            meant = {joint, other} if kind.startswith("exchange") else {joint}
            right += bool(named) and named <= meant
            wrong += [] if named and named <= meant else [(floating, kind, joint, other, factor, named)]
    assert right >= 0.95 * DRAWN, wrong
