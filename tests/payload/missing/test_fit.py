"""One more effect beside a fitted body, by projection, is what fitting both anew gives."""

import numpy as np
import pytest
from tests.payload.conftest import GRAVITY, STD, case

from exogauge.criteria.criteria import Criteria
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.fit import Named, Problem, fit, left_with
from exogauge.payload.missing.hanging import hung, second_body, spring
from exogauge.payload.missing.sensor_effects import crosstalk, delay, zero_drift
from exogauge.payload.missing.stretch import moving_stretch, still_stretch


@pytest.fixture(scope="module")
def problem():
    known = case(1)
    gravity, body = known.static.gravity, np.append(known.static.moments[0][:4], np.zeros(6))
    motion = known.motion()
    moved = moving_stretch("excitation", motion, known.excitation[1], gravity, -1, body, STD)
    moved = moved.using(np.arange(len(motion.time)) % 7 > 0)
    return Problem([still_stretch(known.holds(), gravity, -1), moved], Frame(gravity, -1, body), True, Criteria())


@pytest.mark.parametrize(("effect", "shape"), [
    (crosstalk(3, 1), ()), (zero_drift(), (0.0,)), (delay(), (0.004,)), (spring("xy"), (5.0, 0.4)),
    (second_body(), (0.2, -0.1, 0.1, 4.0, 0.2)),
])  # fmt: skip
@pytest.mark.slow
def test_what_is_left_with_one_more_is_what_is_left_of_all_fitted_together(problem, effect, shape):
    base = fit(problem, [])
    beside = left_with(problem, [], base, effect, shape)
    together = fit(problem, [Named(effect, shape)])
    assert np.sum(beside**2) == pytest.approx(together.rss, rel=1e-9)


def test_what_hangs_on_stiff_springs_is_fixed(problem):
    stretch = problem.stretches[1]
    p = np.array([0.2, -0.1, 0.1])
    soft, stiff = (np.abs(hung(stretch, p, (frequency, 1.0), "xyz")).max() for frequency in (5.0, 500.0))
    assert stiff < 1e-3 * soft


def test_at_rest_what_gives_way_sags_by_its_weight_over_its_stiffness(problem):
    """Across the springs' axes the moment is that of the weight at the place it sags to."""
    stretch = problem.stretches[0]
    p, frequency = np.array([0.2, -0.1, 0.1]), 4.0
    b = stretch.motion.rotation.transpose(0, 2, 1) @ -problem.frame.gravity
    sag = -b * np.array([1.0, 1.0, 0.0]) / (2 * np.pi * frequency) ** 2
    expected = np.hstack([np.zeros((len(b), 3)), np.cross(sag, b)])
    np.testing.assert_allclose(hung(stretch, p, (frequency, 0.3), "xy"), expected, atol=1e-12)


def test_gravity_of_the_fixture_is_that_of_the_generator():
    assert np.linalg.norm(case(1).static.gravity) == pytest.approx(np.linalg.norm(GRAVITY))


def test_gravity_is_turned_across_itself_on_a_wall_too(problem):
    stretch = problem.stretches[1]
    for gravity in (GRAVITY, np.array([9.81, 0.0, 0.0]), np.array([0.0, -9.81, 0.0])):
        turned = Frame(gravity, -1, problem.frame.body).tilting(stretch)
        pushed = np.linalg.norm(turned[:, :3], axis=1).mean(axis=0)
        assert pushed == pytest.approx(9.81 * problem.frame.body[0], rel=1e-9)


def test_as_many_numbers_count_as_are_fitted(problem):
    """Stiffness follows from frequency and mass: of a spring two numbers are fitted and three are told."""
    assert [each.fitted for each in (spring("xy"), second_body(), delay(), crosstalk(3, 1))] == [2, 6, 1, 1]
    for effect, shape in ((spring("xy"), (5.0, 0.4)), (crosstalk(3, 1), ())):
        named = [Named(effect, shape)]
        unknowns = fit(problem, named).x.size - fit(problem, []).x.size + len(shape)
        assert effect.fitted == unknowns
