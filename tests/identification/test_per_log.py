"""What is computed from a log is kept by the log itself, within a bound."""

import numpy as np

from exogauge.identification.per_log import COMMON_ROOM, PerLog
from exogauge.logs.model import Log
from exogauge.robots.motion import Motion
from exogauge.side_by_side import CORES
from exogauge.side_by_side import each as side_by_side


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
    assert len(kept) == 3, "what is larger than the room takes nobody's place"


def test_who_takes_little_stays_through_passes_over_more_logs_than_there_is_room_for():
    kept, logs, computed = PerLog(most_bytes=6 * 800 + 12 * 80), [log(str(k)) for k in range(12)], []

    def load(of):
        computed.append(of.name)
        return np.zeros(10)

    for _ in range(3):
        for each in logs:
            kept.of(each, "prepared", lambda: np.zeros(100))
            kept.of(each, "load", lambda each=each: load(each))
    assert computed == [each.name for each in logs], "the longest unused alone would have kept none until it is asked"


def test_who_takes_little_goes_too_once_it_is_asked_no_more():
    kept, old, logs = PerLog(most_bytes=3 * 800), log("old"), [log(str(k)) for k in range(60)]
    kept.of(old, "load", lambda: np.zeros(50))
    for each in logs:
        kept.of(each, "prepared", lambda: np.zeros(100))
    assert kept.of(old, "load", lambda: np.ones(50)).sum() == 50.0


def test_arrays_count_once_however_deep_they_lie_and_the_log_does_not():
    one, shared = log(samples=10_000), np.zeros((100, 1))
    motion = Motion(shared, shared, shared, *np.zeros((3, 100, 3)))
    room = 8 * (100 + 3 * 300)
    for bytes_, kept in ((room, 1), (room - 1, 0)):
        cache = PerLog(bytes_)
        cache.of(one, "both", lambda: (one, motion, shared))
        assert len(cache) == kept


def test_all_share_the_common_room_s_bound_and_nothing_else(monkeypatch):
    monkeypatch.setattr(COMMON_ROOM, "_most_bytes", 3 * 800)
    one, own, other = log(), PerLog(), PerLog()
    own.of(one, "load", lambda: np.zeros(100))
    assert other.of(one, "load", lambda: np.ones(100)).sum() == 100.0
    assert (len(own), len(other)) == (1, 1)
    for what in ("slope", "inertia"):
        other.of(one, what, lambda: np.ones(100))
    assert (len(own), len(other)) == (0, 3), "a model that is asked no more has nothing there after a while"


def test_who_is_gone_leaves_room(monkeypatch):
    monkeypatch.setattr(COMMON_ROOM, "_most_bytes", 3 * 800)
    one, own, other = log(), PerLog(), PerLog()
    own.of(one, "load", lambda: np.zeros(100))
    for what in ("load", "slope"):
        other.of(one, what, lambda: np.ones(100))
    del other
    for what in ("slope", "inertia"):
        own.of(one, what, lambda: np.zeros(100))
    assert len(own) == 3


def test_one_number_shown_everywhere_takes_no_room():
    kept = PerLog(most_bytes=100)
    kept.of(log(), "smeared", lambda: np.broadcast_to(0.0, (1000, 30)))
    assert len(kept) == 1


def test_threads_that_share_it_keep_its_bound(monkeypatch):
    monkeypatch.setenv(CORES, "4")
    kept, logs = PerLog(most_bytes=5 * 800), [log(str(k)) for k in range(12)]
    asked = [logs[k] for k in np.random.default_rng(0).integers(0, 12, 400)]
    sums = list(side_by_side(lambda one: kept.of(one, "x", lambda: np.full(100, float(one.name))).sum(), asked))
    assert sums == [100.0 * float(one.name) for one in asked]
    assert len(kept) == 5
