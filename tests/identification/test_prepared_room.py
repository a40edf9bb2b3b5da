"""What a prepared log holds beside the log: numbers that no filter has changed stand in the log or in one byte."""

import numpy as np
import pytest

from exogauge.identification.preparation import drive_on_axes, prepare, wrenches
from exogauge.identification.turns import rest_detection

CUTOFF_HZ = 6.0


@pytest.fixture
def made(make_truth, make_log):
    truth = make_truth(True)
    log = make_log(truth, seed=1)
    return truth.robot, log, prepare(truth.robot, log, CUTOFF_HZ, rest_detection(truth.robot, [log], CUTOFF_HZ))


def test_nothing_is_held_that_the_log_holds_nor_a_sign_in_eight_bytes(made):
    _, log, prepared = made
    floats = {name: each for name, each in vars(prepared).items() if getattr(each, "dtype", None) == np.float64}
    wide = {name: each.reshape(log.samples, -1) for name, each in floats.items() if each.size and any(each.strides)}
    assert {"drive", "direction", "rest", "wrenches"} <= wide.keys()
    for name, each in wide.items():
        assert not np.isin(each, (-1.0, 0.0, 1.0)).all(), name
        for column in each.T:
            assert not any(np.array_equal(abs(column), abs(logged)) for logged in log.channels.values()), name


def test_what_is_as_it_was_stored_is_the_log_s_own(made):
    robot, log, prepared = made
    view = prepared.as_stored(robot)
    assert np.array_equal(view.drive, np.column_stack([log.channels[f"i.{joint.name}"] for joint in robot.joints]))
    assert np.array_equal(view.direction, prepared.raw_direction)
    assert set(np.unique(view.rest)) == {0.0, 1.0}
    assert np.array_equal(view.rest == 1.0, prepared.raw_direction == 0)
    feet = wrenches(robot.contacts, log)
    for number, foot in enumerate(robot.contacts):
        assert np.array_equal(feet[:, number, 2], foot.sign * log.channels[f"ft.{foot.name}.fz"])
    assert np.array_equal(drive_on_axes(robot, log), view.drive)
