"""What runs on several processors gives what one gives: in order, once, and with its failures."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from exogauge.side_by_side import CORES, cores, each


@pytest.fixture(params=[1, 2, 5])
def count(request, monkeypatch):
    monkeypatch.setenv(CORES, str(request.param))
    return request.param


def test_results_come_in_the_order_of_the_items(count):
    def slow(number):
        time.sleep(0.02 if number % 3 == 0 else 0.0)
        return number**2

    assert list(each(slow, range(20))) == [number**2 for number in range(20)]
    assert list(each(slow, [])) == []


def test_as_many_run_at_once_as_there_are_cores_and_no_more_wait_than_that(count):
    lock, running, most, taken = threading.Lock(), 0, 0, 0

    def items():
        nonlocal taken
        for number in range(12):
            taken += 1
            yield number

    def work(_number):
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.02)
        with lock:
            running -= 1

    for done, _ in enumerate(each(work, items()), 1):
        assert taken <= done + count
    assert most == count


def test_within_itself_it_is_map(count):
    names = list(each(lambda _: {*each(lambda _: threading.current_thread().name, range(4))}, range(6)))
    assert all(len(own) == 1 for own in names)


def test_the_first_that_fails_raises_in_its_turn(count):
    begun = []

    def work(number):
        begun.append(number)
        if number >= 3:
            raise ValueError(str(number))
        return number

    found = []
    with pytest.raises(ValueError, match="3"):
        found.extend(each(work, range(50)))
    assert max(begun) <= 3 + count


def test_what_numpy_was_told_holds_there_too(count):
    with np.errstate(divide="ignore"):
        assert np.isinf(list(each(lambda x: np.divide(1.0, x), np.zeros(3)))).all()


def test_who_says_nothing_gets_the_cores_there_are(monkeypatch):
    monkeypatch.delenv(CORES, raising=False)
    assert cores() == len(os.sched_getaffinity(0))
    monkeypatch.setenv(CORES, "0")
    assert cores() == 1


def test_the_command_line_keeps_linear_algebra_to_one_thread():
    code = "import os; from exogauge.cli import main; main(['--version'])"
    tail = "\nfinally:\n    print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules)"
    asked = "import os, sys\ntry:\n    " + code.partition("; ")[2] + tail
    environment = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    said = subprocess.run([sys.executable, "-c", asked], capture_output=True, env=environment, check=False)
    assert said.stdout.split()[-2:] == [b"1", b"False"]
