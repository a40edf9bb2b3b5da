"""A base that turns over feet which stand: its legs' encoders tell what its gyro should, and when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plausibility.standing import RATE, record, standing

from exogauge.criteria.examining import Comparing
from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot, examine_one_by_one, looked_at
from exogauge.studies.results.examine_logs import examine_logs

pytestmark = pytest.mark.slow

SEEDS = (1, 2, 3)


def late(log: Log, milliseconds: float) -> Log:
    """Its IMU."""
    taken = log.time - 1e-3 * milliseconds
    read = {name: np.interp(taken, log.time, each) for name, each in log.channels.items() if name[:3] in ("acc", "gyr")}
    cut = slice(round(RATE), -round(RATE))
    return replace(log, time=log.time[cut], channels={n: each[cut] for n, each in (log.channels | read).items()})


@pytest.mark.parametrize("milliseconds", [-70, 0, 20, 70])
def test_an_imu_that_is_late_in_one_log_is_told_there_alone_with_the_time(milliseconds: int) -> None:
    robot, logs = standing(), [late(record(seed), 0.0) for seed in SEEDS]
    logs[1] = late(record(SEEDS[1]), milliseconds)
    found = list(examine_against_robot(robot, logs))
    told = [(log, each.channel, each.rule) for log, each in found]
    assert told == ([(logs[1].name, "acc", "imu_clock")] if abs(milliseconds) > 30 else [])
    assert [each.value for _, each in found] == pytest.approx([1e-3 * milliseconds] * len(found), abs=0.003)


def test_of_many_logs_one_that_is_late_is_told_which_ever_it_is() -> None:
    """Six are held together; the seventh of those without a device was looked at by nobody."""
    logs = [late(record(seed), 0.0) for seed in range(1, 9)]
    recordings = [Recording(log, held_out=number >= 2) for number, log in enumerate(logs)]
    fitted = {each.log.name for each in recordings if not each.held_out}
    together = looked_at(logs, fitted, Comparing().most_logs)
    (place, *_) = (number for number, log in enumerate(logs) if log not in together)
    recordings[place] = Recording(late(record(place + 1), 60.0), held_out=True)
    found = examine_logs(standing(), recordings)
    told = [(each["log"], each["channel"]) for each in found if each["rule"] == "imu_clock"]
    assert told == [(logs[place].name, "acc")]
    every = examine_logs(
        standing(), [replace(each, log=late(record(k + 1), 60.0)) for k, each in enumerate(recordings)]
    )
    assert [each["log"] for each in every if each["rule"] == "imu_late"] == [each.name for each in logs]


def test_one_that_is_late_in_all_logs_is_a_delay_that_an_effect_can_name() -> None:
    robot, logs = standing(), [late(record(seed), 60.0) for seed in SEEDS]
    told = [(log, each.rule) for log, each in examine_against_robot(robot, logs)]
    assert told == [(each.name, "imu_late") for each in logs]


@pytest.mark.parametrize(("others", "rule"), [(0.06, "imu_late"), (None, "imu_clock"), (0.02, "imu_clock")])
def test_with_a_device_on_it_is_of_another_clock_where_the_other_logs_are_not_as_late(
    others: float | None, rule: str
) -> None:
    ((_, found),) = examine_one_by_one(standing(), [late(record(4), 60.0)], imu_late_s=others)
    assert (found.channel, found.rule) == ("acc", rule)
    assert found.value == pytest.approx(0.06, abs=0.003)


def test_a_gyro_that_tells_another_turn_than_the_legs_is_not_called_late() -> None:
    log = record(5)
    other = {f"gyro.{axis}": record(6).channels[f"gyro.{axis}"] for axis in "xyz"}
    found = examine_against_robot(standing(), [late(replace(log, channels=log.channels | other), 50.0)])
    assert "imu_clock" not in {each.rule for _, each in found}
