"""Logs that hold the same samples are one recording, however they are named and cut."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.criteria.examining import Examining
from exogauge.logs.model import Log
from exogauge.logs.shared_samples import shared_samples


def recorded(name: str, seed: int, rows: slice = slice(None), **changed: np.ndarray) -> Log:
    rng = np.random.default_rng(seed)
    whole = {"q.a": np.sin(0.01 * np.arange(1000)), "i.a": rng.standard_normal(1000), "i.b": rng.standard_normal(1000)}
    whole |= changed
    values = {channel: each[rows] for channel, each in whole.items()}
    return Log(name, 0.01 * np.arange(values["i.a"].size), values)


def told(logs: list[Log], held_out: list[bool]) -> dict[str, float]:
    return {name: finding.value or 0.0 for name, finding in shared_samples(logs, held_out, Examining())}


def test_a_held_out_log_is_told_if_it_was_fitted_too_whichever_comes_first() -> None:
    assert told([recorded("val", 1), recorded("id", 1)], [True, False]) == {"val": 1.0}


@pytest.mark.parametrize("begin", [600, 613])
def test_rows_of_two_logs_that_overlap_are_told_by_how_much(begin: int) -> None:
    logs = [recorded("first", 1, slice(0, 800)), recorded("second", 1, slice(begin, 1000))]
    assert told(logs, [False, True])["second"] == (800 - begin) / (1000 - begin)


def test_efforts_of_another_recording_are_told_though_positions_are_their_own() -> None:
    assert told([recorded("a", 1), recorded("b", 1, **{"q.a": np.cos(0.01 * np.arange(1000))})], [False, False]) == {
        "b": 1.0
    }


def test_the_same_motion_again_other_sensors_and_a_robot_that_is_off_are_not() -> None:
    off = {"i.a": np.zeros(1000), "i.b": np.zeros(1000)}
    assert told([recorded("a", 1), recorded("b", 2)], [False, True]) == {}
    assert told([recorded("a", 1, **off), recorded("b", 2, **off)], [False, True]) == {}
    assert told([recorded("a", 1), recorded("b", 1, **{"i.c": np.ones(1000)})], [False, True]) == {}
    assert told([recorded("a", 1, slice(0, 40)), recorded("b", 1)], [False, True]) == {}
