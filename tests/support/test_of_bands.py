"""What is measured with a device on and is not its bands': told, and taken for no support."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from tests.support.conftest import XI

from exogauge.remarks import About, Remark
from exogauge.support.evaluate import estimate_support
from exogauge.support.notes import in_doubt
from exogauge.support.settings import PlainLog, WornLog

pytestmark = pytest.mark.slow

CARRIED = 6.0  # kg in front of the chest


@pytest.fixture(scope="module")
def plain(biped, wander):
    return [
        PlainLog(biped.record(wander(seed), f"plain{seed}", noise=1.0, seed=seed).log, "walk", True) for seed in (3, 4)
    ]


@pytest.fixture(scope="module")
def laden(biped):
    """The same robot with something heavy before its chest."""
    phi, chest = biped.phi.copy(), biped.robot.tree.bodies.index("chest")
    ball, place = pin.Inertia.FromSphere(CARRIED, 0.05), pin.SE3(np.eye(3), np.array([0.35, 0.0, 0.1]))
    phi[chest] += place.act(ball).toDynamicParameters()
    return biped.with_truth(phi, np.column_stack([biped.xi[name] for name in XI]))


def runs(robot, wander, device, seeds=(5, 6)):
    return [WornLog(robot.record(wander(n), f"worn{n}", device.bands, noise=1.0, seed=n).log, "walk", device)
            for n in seeds]  # fmt: skip


def told(biped, plain, worn):
    support, _ = estimate_support(biped.known(), plain, worn)
    return {name for each in support.remarks if each.about == About.NOT_OF_BANDS for name in each.names}


def test_bands_as_they_are_described_are_believed(biped, plain, suit, wander):
    assert told(biped, plain, runs(biped, wander, suit)) == set()


def test_so_are_bands_that_run_a_little_beside(biped, plain, suit, wander):
    rng = np.random.default_rng(1)
    beside = replace(suit, bands=tuple(
        replace(band, via_points=tuple(replace(via, xyz=tuple(np.add(via.xyz, 0.005 * rng.standard_normal(3))))
                                       for via in band.via_points))
        for band in suit.bands
    ))  # fmt: skip
    worn = [replace(each, device=beside) for each in runs(biped, wander, suit)]
    assert told(biped, plain, worn) == set()


def test_what_the_robot_carries_in_its_runs_with_the_device_is_not_taken_for_the_device(
    biped, laden, plain, suit, wander
):
    assert told(biped, plain, runs(laden, wander, suit)) == {"worn5", "worn6"}


def test_of_one_run_alone_it_is_named(biped, laden, plain, suit, wander):
    worn = [*runs(biped, wander, suit, (5, 6)), *runs(laden, wander, suit, (7,))]
    assert told(biped, plain, worn) == {"worn7"}


def test_nor_is_what_bands_give_that_run_elsewhere(biped, plain, suit, wander):
    """Described in front of the trunk they shorten where those behind it pull: no spring is found at all."""
    front = replace(suit, bands=tuple(
        replace(band, stiffness=None, natural_length=None, via_points=tuple(
            replace(via, xyz=(-via.xyz[0], *via.xyz[1:])) for via in band.via_points))
        for band in suit.bands
    ))  # fmt: skip
    worn = [replace(each, device=front) for each in runs(biped, wander, suit)]
    assert told(biped, plain, worn) == {"worn5", "worn6"}


@pytest.mark.parametrize(
    ("about", "undecided"),
    [(About.NOT_OF_BANDS, {"one"}), (About.LABELS_EXCHANGED, {"one", "other"}), (About.STIFFNESS_OPEN, set())],
)
def test_another_device_stays_decided_unless_its_partners_are_in_doubt_too(about, undecided):
    assert in_doubt([Remark(about, ("log",), beside=("one",))], {"one", "other"}) == undecided
