"""Bands pull as their energy asks; what is hidden in them is what it says."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.blind.generator.dynamics import carrier, joint_torques
from exogauge.blind.generator.hidden.band import (
    BandHysteresis,
    BandLength,
    BandRelaxation,
    BandSlip,
    BandSoftening,
    BandStiffness,
    BandViaFriction,
    BandViscous,
    held_by_threads,
    together,
)
from exogauge.blind.generator.hidden.kinds import ELSEWHERE, IN_BANDS
from exogauge.blind.generator.placed import HowLarge, Placed, pull
from exogauge.blind.generator.places import poses, wire
from exogauge.blind.generator.wear import FURTHEST, LENGTH_STD, STIFFNESS_STD, Band


def _points(scene, band: Band):
    names = scene.robot.tree.names
    for link, xyz in band.wire.points:
        on, offset = carrier(scene.links, link)
        yield (names.index(on) if on in names else -1), offset + xyz


@pytest.mark.slow
def test_joints_give_what_the_bands_energy_changes_by(torso8) -> None:
    """Against -dU/dq by finite differences, U = k (l - l_0)² / 2 where the band is taut."""
    wear, tree = torso8.wear, torso8.robot.tree
    q = torso8.motion.q[wear.worn][1, ::250]
    step = 1e-6
    for band in (*wear.bands, *wear.spare):
        points = list(_points(torso8, band))

        def energy(q: np.ndarray, band=band, points=points) -> np.ndarray:
            length = wire(poses(tree, q), points)[0].sum(axis=1)
            return 0.5 * band.stiffness * np.maximum(length - band.natural_length, 0.0) ** 2

        pull = band.pull(band.tension)[1, ::250]
        assert np.abs(pull).max() > 0.3
        for joint in range(8):
            nudge = step * np.eye(8)[joint]
            np.testing.assert_allclose(
                pull[:, joint], (energy(q + nudge) - energy(q - nudge)) / (2 * step), atol=1e-4, err_msg=band.wire.name
            )


@pytest.mark.slow
def test_motors_hold_the_bands_in_worn_logs_only(torso8) -> None:
    pull = torso8.wear.pull()
    assert np.all(pull[~torso8.wear.worn] == 0.0)
    robot = torso8.robot
    log = int(np.flatnonzero(torso8.wear.worn)[0])
    motion = torso8.motion
    bodies = joint_torques(robot.tree, robot.phi, motion.q[log], motion.dq[log], motion.ddq[log])
    for j, run in enumerate(torso8.runs):
        np.testing.assert_allclose(run.load[log], bodies[:, j] + pull[log, :, j], atol=1e-9)


def test_logs_of_one_motion_are_the_same_motion(torso8) -> None:
    for motion in ("reach", "sway"):
        same = [n for n, log in enumerate(torso8.logs) if log.motion == motion]
        assert {torso8.logs[n].worn for n in same} == {True, False}
        for n in same[1:]:
            np.testing.assert_array_equal(torso8.motion.q[n], torso8.motion.q[same[0]])


def test_bands_are_nearly_what_their_maker_states(torso8) -> None:
    for band in torso8.wear.bands:
        assert abs(band.stiffness / band.stated[0] - 1.0) <= FURTHEST * STIFFNESS_STD
        assert abs(band.natural_length / band.stated[1] - 1.0) <= FURTHEST * LENGTH_STD
    groups = {band.wire.group: set() for band in torso8.wear.bands}
    for band in torso8.wear.bands:
        groups[band.wire.group].add((band.stiffness, band.stated[0]))
    assert all(len(values) == 1 for values in groups.values()), "bands of a group share their stiffness"


@pytest.mark.parametrize("name", sorted(IN_BANDS))
def test_no_band_ever_pushes(torso8, name: str) -> None:
    """Tension beside the band's own is never less than minus that, on joints where one band pulls alone."""
    kind = ELSEWHERE[name]
    for where in kind.places(torso8):
        effect = kind.draw(np.random.default_rng(2), torso8, where)
        change = effect.change(torso8, effect.limits(torso8)[1])
        assert change.torque is not None
        assert np.abs(change.torque).max() > 0.01
        assert np.all(change.torque[~torso8.wear.worn] == 0.0)
        if name in ("extra_band", "band_via_friction"):  # beside the bands; not one tension
            continue
        band = next(each for each in torso8.wear.bands if each.wire.name == where["band"])
        total = change.torque[torso8.wear.worn] + band.pull(band.tension)
        tension = np.sum(total * band.slope, axis=2) / np.sum(band.slope**2, axis=2)
        assert tension.min() > -1e-9
        np.testing.assert_allclose(band.pull(tension), total, atol=1e-9)


def test_a_band_that_lets_go_for_two_reasons_does_not_push_either(torso8) -> None:
    (band, *_), worn = torso8.wear.bands, torso8.wear.worn
    both = [
        kind.draw(np.random.default_rng(2), torso8, {"band": band.wire.name}) for kind in (BandRelaxation, BandViscous)
    ]
    pulls = [each.change(torso8, 4.0 * each.limits(torso8)[1]).pull for each in both]
    assert np.any(sum(each.tension for each in pulls) < -band.tension)
    total = together(torso8, pulls)[worn] + band.pull(band.tension)
    tension = np.sum(total * band.slope, axis=2) / np.sum(band.slope**2, axis=2)
    assert tension.min() > -1e-9
    np.testing.assert_allclose(band.pull(tension), total, atol=1e-9)


def test_what_one_band_does_alone_is_what_it_does_among_others(torso8) -> None:
    for name in sorted(IN_BANDS):
        kind = ELSEWHERE[name]
        change = kind.draw(np.random.default_rng(2), torso8, where := kind.places(torso8)[0]).change(torso8, 0.3)
        np.testing.assert_allclose(together(torso8, [change.pull]), change.torque, atol=1e-9, err_msg=f"{name} {where}")


@pytest.mark.parametrize("turned", [False, True])
def test_a_stiffer_and_longer_band_is_one_spring(torso8, turned: bool) -> None:
    """Whichever of the two is drawn first: k (l - l_0) with the new k and the new l_0."""
    name = torso8.wear.bands[0].wire.name
    band = next(each for each in torso8.wear.bands if each.wire.name == name)
    found = HowLarge("", 1.0, 1.0, 1.0)
    hidden = [
        Placed(BandStiffness(name, 1.0), None, {"band": name}, 0.5, found),
        Placed(BandLength(name, 1.0), None, {"band": name}, 0.04, found),
    ]
    asked = pull(torso8, hidden[::-1] if turned else hidden)
    k, l_0 = 1.5 * band.stated[0], 1.04 * band.stated[1]
    expected = band.pull(k * np.maximum(band.length - l_0, 0.0) - band.tension)
    np.testing.assert_allclose(asked[torso8.wear.worn], expected, atol=1e-9)


def test_a_slipped_anchor_stays_where_it_is(torso8) -> None:
    band = torso8.wear.bands[0]
    slip = BandSlip(band.wire.name, 1, 10.0, 0.2)
    worn = slip.change(torso8, 0.01).torque[torso8.wear.worn]
    before, after = torso8.motion.time < 10.0, torso8.motion.time > 10.2
    assert np.all(worn[0] == 0.0)
    assert np.all(worn[1][before] == 0.0)
    longer = band.stiffness * (np.maximum(band.length - band.natural_length - 0.01, 0.0) - band.stretch)
    np.testing.assert_allclose(worn[1][after], band.pull(longer)[1][after], atol=1e-12)
    np.testing.assert_allclose(worn[2], band.pull(longer)[2], atol=1e-12)


def test_what_drags_in_a_band_takes_work(torso8) -> None:
    """Over the worn logs a rubbing, a creeping and a viscous band take energy from the joints."""
    name, dq = torso8.wear.bands[0].wire.name, torso8.motion.dq
    for effect, size in (
        (BandViscous(name, 0.7, 0.1), 3.0),
        (BandRelaxation(name, 0.8, 4.0, 0.4), 0.4),
        (BandViaFriction(name, 1e-3, 1.4, 0.3, 3.0), 0.3),
        (BandHysteresis(name, (1e-3, 3e-3)), 0.3),
    ):
        work = np.sum(effect.change(torso8, size).torque * dq, axis=(1, 2))[torso8.wear.worn] / 200.0
        assert work.min() > 0.05, effect


def test_a_creeping_band_is_a_stiffer_one_when_it_is_quick_and_itself_when_it_waits(torso8) -> None:
    band = torso8.wear.bands[0]
    slow = BandRelaxation(band.wire.name, 1e4, 1.0, 0.5).change(torso8, 0.3).torque[torso8.wear.worn]
    since = band.stretch - band.stretch[:, :1]
    expected = np.maximum(0.3 * band.stiffness * since, -band.tension)
    np.testing.assert_allclose(slow, band.pull(expected), atol=0.02 * np.abs(slow).max())
    quick = BandRelaxation(band.wire.name, 1e-3, 1.0, 0.5).change(torso8, 0.3).torque[torso8.wear.worn]
    assert np.abs(quick).max() < 0.02 * np.abs(slow).max()


def test_threads_that_rub_do_not_ask_how_fast_the_band_is_stretched(torso8) -> None:
    """The same lengths at half the speed: the same forces. After a way of one direction all threads give way."""
    effect = BandHysteresis(torso8.wear.bands[0].wire.name, (5e-4, 2e-3))
    length = torso8.wear.bands[0].length[:, ::4]
    slow = np.repeat(length, 2, axis=1)
    ways = np.array(effect.ways)
    np.testing.assert_array_equal(held_by_threads(slow, ways), np.repeat(held_by_threads(length, ways), 2, axis=1))
    there_and_back = np.concatenate([np.linspace(0.0, 0.01, 50), np.linspace(0.01, 0.0, 50)])[None]
    held = held_by_threads(there_and_back, ways)[0]
    assert held[49] == 1.0
    assert held[-1] == -1.0


def test_a_band_that_softens_still_pulls_more_the_further_it_is_stretched(torso8) -> None:
    band = torso8.wear.bands[0]
    effect = BandSoftening(band.wire.name, 1.2)
    size = effect.limits(torso8)[1]
    total = (band.tension + effect.change(torso8, size).pull.tension).ravel()
    along = np.argsort(band.stretch.ravel())
    assert np.diff(total[along]).min() > -1e-9
    assert total.max() == pytest.approx((1.0 - size) * band.tension.max())
