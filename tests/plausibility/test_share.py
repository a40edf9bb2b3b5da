"""How often the doctor names the right joint: flips, exchanged columns, other units, dead channels, at random."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest
from tests.fuzz.small_robots import JOINTS, LOGS, simulate, write_study
from tests.plausibility.test_examine import as_log

from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

pytestmark = pytest.mark.slow

KINDS = ("flip q", "flip i", "exchange q", "exchange i", "degrees", "unit", "dead")
FEW = 4 * len(KINDS)  # in `make test`: two of each kind on each robot
DRAWN = max(int(os.environ.get("EXOGAUGE_TEST_STUDIES", FEW)), FEW)
RECORDED = 4 * len(KINDS)  # slips per motion; `make fuzz` records others, and draws others every time
SEED = 5 if DRAWN == FEW else int(np.random.SeedSequence().generate_state(1)[0])

Columns = dict[str, np.ndarray]


def slip(kind: str, joint: str, other: str, factor: float, columns: Columns) -> Columns:
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


def recorded(floating: bool, motion: int) -> list[Columns]:
    """The logs of one motion; the first is that of every test on the small robots."""
    return [simulate(floating, seed + 10 * motion, seconds) for seed, seconds, _ in LOGS.values()]


def named(robot: Robot, logs: list[Columns]) -> set[str]:
    found = examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)])
    return {finding.channel.partition(".")[2] for _, finding in found}


@pytest.fixture(scope="module", params=[False, True], ids=["arm", "floating"])
def drawn(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """wrong: slips that were not named, or named elsewhere. alarms: what is said of logs as they are. right: others."""
    rng = np.random.default_rng([SEED, request.param])
    folder = tmp_path_factory.mktemp("robot")
    write_study(folder, request.param, {})
    robot = load_robot(folder)
    found: dict[str, list[Any]] = {"right": [], "wrong": [], "alarms": []}
    for number in range(DRAWN // 2):
        if number % RECORDED == 0:
            logs = recorded(request.param, number // RECORDED if DRAWN == FEW else int(rng.integers(1, 10**6)))
            found["alarms"] += named(robot, logs)
        joint, other = rng.choice(JOINTS, 2, replace=False)
        kind, factor = KINDS[number % len(KINDS)], float(rng.choice([1000.0, 100.0, 0.01, 0.001]))
        told = named(robot, [slip(kind, joint, other, factor, each) for each in logs])
        meant = {joint, other} if kind.startswith("exchange") else {joint}
        found["right" if told and told <= meant else "wrong"].append((kind, joint, other, factor, told))
    return found


def test_nineteen_of_twenty_slips_are_named_at_the_right_joint(drawn: dict[str, list[Any]]) -> None:
    assert len(drawn["right"]) + len(drawn["wrong"]) == DRAWN // 2
    assert len(drawn["right"]) >= 0.95 * (DRAWN // 2), (SEED, drawn["wrong"])


def test_of_logs_as_they_are_nothing_is_said(drawn: dict[str, list[Any]]) -> None:
    assert drawn["alarms"] == [], SEED
