"""What is computed from a log is kept by the log itself, within a bound."""

import numpy as np

from exogauge.identification.per_log import PerLog
from exogauge.logs.model import Log
from exogauge.robots.motion import Motion


def log(name="one", samples=100):
    return Log(name, np.arange(samples) / 100.0, {})


def test_a_log_of_the_same_name_and_length_has_values_of_its_own():
    kept, first, second = PerLog(), log(), log()
    assert kept.of(first, "load", lambda: np.ones(3)).sum() == 3.0
    assert kept.of(second, "load", lambda: np.zeros(3)).sum() == 0.0
    assert kept.of(first, "load", lambda: np.zeros(3)).sum() == 3.0


def test_what_was_computed_is_not_computed_again_and_is_the_same_object():
    kept, one, calls = PerLog(), log(), []

    def compute():
        calls.append(1)
        return np.ones(4)

    assert kept.of(one, "load", compute) is kept.of(one, "load", compute)
    kept.of(one, "slope", compute)
    assert len(calls) == 2


def test_the_longest_unused_go_and_no_more_is_kept_than_there_is_room_for():
    kept, logs = PerLog(most_bytes=3 * 800), [log(str(k)) for k in range(4)]
    for each in logs[:3]:
        kept.of(each, "load", lambda: np.zeros(100))
    kept.of(logs[0], "load", lambda: np.ones(100))  # used again
    kept.of(logs[3], "load", lambda: np.zeros(100))
    assert len(kept) == 3
    assert kept.of(logs[0], "load", lambda: np.ones(100)).sum() == 0.0
    assert kept.of(logs[1], "load", lambda: np.ones(100)).sum() == 100.0
    kept.of(logs[2], "long", lambda: np.zeros(1000))
    assert len(kept) == 0


def test_arrays_count_once_however_deep_they_lie_and_the_log_does_not():
    one, shared = log(samples=10_000), np.zeros((100, 1))
    motion = Motion(shared, shared, shared, *np.zeros((3, 100, 3)))
    room = 8 * (100 + 3 * 300)
    for bytes_, kept in ((room, 1), (room - 1, 0)):
        cache = PerLog(bytes_)
        cache.of(one, "both", lambda: (one, motion, shared))
        assert len(cache) == kept
