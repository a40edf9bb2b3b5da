"""A joint's friction beside a named effect is known no better than the effect's shape lets it be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.identify import identify
from exogauge.identification.model import AddedEffect, Extension
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import AxisSite
from exogauge.identification.solution import solve
from exogauge.search.doubt import inverse_of_rest
from exogauge.search.final_numbers import with_doubt_of_shapes

SETTINGS = Settings(cutoff_hz=8.0)
TAU_B, V_S = 1.5, 0.25  # wide: it reaches to where viscous friction is learnt


def stribeck(motion):
    v = motion.v[:, 1]
    torque = np.zeros_like(motion.q)
    torque[:, 1] = TAU_B * np.sign(v) * np.exp(-((np.abs(v) / V_S) ** 2))
    return torque


def test_friction_beside_an_effect_moves_with_its_shape_as_its_deviation_says(robot, record):
    """Independent of the formula: identified once more with the shape moved, x moves by dx/dshape."""
    recordings = [
        Recording(record(1, stribeck, seconds=15.0), False),
        Recording(record(9, stribeck, seconds=8.0), True),
    ]
    first = identify(robot, recordings, SETTINGS)
    effect, scale = shaped_effects()["stribeck"], first.model.sizes.velocity[1]

    def with_shape(v_s):
        added = AddedEffect(effect, AxisSite(1), (v_s / scale, 2.0))
        extension = Extension(first.model, (added,), {})
        return identify(robot, recordings, SETTINGS, extension=extension), added

    found, added = with_shape(V_S)
    doubted = with_doubt_of_shapes(found, [added], recordings)
    value, std, wider = ({each.name: getattr(each, what) for each in one.parameters}
                         for one, what in ((found, "value"), (found, "std"), (doubted, "std")))  # fmt: skip
    moved = {each.name: each.value for each in with_shape(1.05 * V_S)[0].parameters}
    names = ["k_d[j2]", "tau_c[j2]"]
    grown = np.array([np.sqrt(wider[name] ** 2 - std[name] ** 2) for name in names])
    slope = np.array([moved[name] - value[name] for name in names])
    assert np.all(grown > 0.0)
    # both are dx/dshape times a deviation; of the two shapes v_s rules, so their ratio is about that of the slopes
    assert grown[0] / grown[1] == pytest.approx(abs(slope[0] / slope[1]), rel=0.5)
    for name, truth in zip(names, (0.7, 1.2), strict=True):  # of the arm in conftest
        assert abs(value[name] - truth) < 4.0 * wider[name]
    assert wider["k_d[j1]"] == pytest.approx(std["k_d[j1]"], rel=0.05), "another joint's friction is not in doubt"
    assert np.all(np.diag(doubted.model.covariance) >= np.diag(found.model.covariance) - 1e-12)


@pytest.mark.parametrize("passes", [1, 4])
def test_shapes_leave_a_scale_that_currents_leave_open_as_it_was_stated(weighed, record, passes):
    """One factor of all torques: no row tells it, whichever iteration's rows they are, and so no shape moves it."""
    k_T, known = (6.0, 5.0, 3.0), weighed(("current",) * 3)
    joints = tuple(replace(joint, prior_std={"k_T": 0.06 * joint.prior["k_T"]}) for joint in known.joints)
    robot = replace(known, joints=joints, inertial_std={"": 0.3})

    def recorded(seed):
        log = record(seed, lambda motion: TAU_B * np.sign(motion.v) * np.exp(-((np.abs(motion.v) / V_S) ** 2)), 20.0)
        channels = dict(log.channels)
        for joint, k in zip(joints, k_T, strict=True):
            channels[f"i.{joint.name}"] = channels.pop(f"tau.{joint.name}") / k
        return Recording(replace(log, channels=channels), False)

    recordings = [recorded(seed) for seed in (1, 2)]
    first = identify(robot, recordings, SETTINGS)
    sizes, effect = first.model.sizes.velocity, shaped_effects()["stribeck"]
    added = [AddedEffect(effect, AxisSite(axis), (V_S / sizes[axis], 2.0)) for axis in range(3)]
    found = identify(robot, recordings, SETTINGS, extension=Extension(first.model, tuple(added), {}))
    prepared = [found.model.prepare(each.log) for each in recordings]
    solution = solve(found.model.equations, prepared, found.model.solution.prior, SETTINGS, passes=passes)
    found = replace(found, model=replace(found.model, solution=solution))
    doubted = {each.name: each.std for each in with_doubt_of_shapes(found, added, recordings).parameters}
    for each in found.parameters:
        if each.name.startswith("k_T"):
            assert each.std < each.prior_std
            assert doubted[each.name] < 1.01 * each.std


def test_what_is_swallowed_is_in_great_doubt_and_not_in_none():
    """Three columns of which the last is hardly more than the sum of the others, with what is fitted beside them; the
    part that this takes is off by a millionth."""
    rng = np.random.default_rng(4)
    beside, columns = rng.normal(size=(5000, 4)), rng.normal(size=(5000, 3)) * [1.0, 30.0, 0.02]
    columns[:, 2] = (columns[:, 0] + columns[:, 1] / 30.0) * 0.02 + 1e-7 * rng.normal(size=5000)
    columns += beside @ rng.normal(size=(4, 3)) * [1.0, 30.0, 0.02]
    squares, cross = columns.T @ columns, beside.T @ columns
    taken = cross.T @ np.linalg.solve(beside.T @ beside, cross)
    for off in (0.0, 1e-6, -1e-6):
        std = np.sqrt(np.diag(inverse_of_rest(squares, (1.0 + off) * taken)))
        alone = 1.0 / np.sqrt(np.diag(squares - taken))
        assert np.all(std > 50.0 * alone)
    apart = squares[:2, :2] - taken[:2, :2]
    np.testing.assert_allclose(inverse_of_rest(squares[:2, :2], taken[:2, :2]), np.linalg.inv(apart), rtol=1e-9)
    silent = inverse_of_rest(np.diag([4.0, 0.0]), np.zeros((2, 2)))
    np.testing.assert_allclose(silent, np.diag([0.25, 0.0]))
