"""What a maker means by a doubted link, against links drawn one by one."""

import numpy as np
import pytest

from exogauge.detect.nominal.nominal_values import LettingGo, as_stated

RHO = 0.25  # of a maker who says nothing


def drawn(rng, phi):
    """(10,) of a link of another density, another centre and another inertia about it."""
    m, c = phi[0], phi[1:4] / phi[0]
    about_centre = inertia(phi) - m * (c @ c * np.eye(3) - np.outer(c, c))
    g = np.sqrt(np.trace(about_centre) / (2.0 * m))
    heavier = 1.0 + RHO * rng.standard_normal()
    centre = c + RHO * g * rng.standard_normal(3)
    more = m * g**2 * RHO * rng.standard_normal((3, 3)) * np.where(np.eye(3), 1.0, 0.5)
    more = np.triu(more) + np.triu(more, 1).T
    total = heavier * about_centre + more + heavier * m * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return np.array([heavier * m, *(heavier * m * centre), *total[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])


def inertia(phi):
    xx, xy, yy, xz, yz, zz = phi[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.slow
def test_doubts_are_those_of_links_with_other_masses_centres_and_inertias(study, identified):
    model = identified(study(seconds=8.0)).model
    own, stated = model.solution.prior, as_stated(model)
    rng = np.random.default_rng(3)
    for body, phi in enumerate(model.robot.tree.phi):
        part = slice(10 * body, 10 * body + 10)
        links = np.array([drawn(rng, phi) for _ in range(20_000)]) - phi
        seen = own.seen[:, part]
        shown = np.abs(seen).sum(axis=1) > 0.0
        expected = np.std(links @ seen[shown].T, axis=0)
        got = np.sqrt(np.diag((stated.seen[:, part] * stated.std[part] ** 2) @ stated.seen[:, part].T))[shown]
        np.testing.assert_allclose(got, expected, rtol=0.15, err_msg=model.robot.tree.bodies[body])


def test_the_makers_numbers_themselves_stay_what_they_are(study, identified):
    model = identified(study(seconds=8.0)).model
    np.testing.assert_allclose(as_stated(model).seen_mean, model.solution.prior.seen_mean, atol=1e-12)


def test_what_is_left_of_rounding_alone_says_nothing():
    """Two columns that the data know, and one of which nothing is left: its square is below zero by rounding."""
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    S, told = (Q * [9.0, 4.0, -1.5]) @ Q.T, (Q * [9.0, 4.0, 0.0]) @ Q.T
    g = Q[:, :2] @ [2.0, -1.0]
    let = LettingGo(S, g + 5.0 * Q[:, 2]).let(np.arange(3))
    inner = np.eye(3) + told
    np.testing.assert_allclose(let.change, np.linalg.solve(inner, g), rtol=1e-12)
    np.testing.assert_allclose(let.std, np.sqrt(np.diag(np.linalg.inv(inner))), rtol=1e-12)
    assert let.evidence == pytest.approx(g @ np.linalg.solve(inner, g) - np.linalg.slogdet(inner)[1])
