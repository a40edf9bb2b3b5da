"""An effect whose curve is another than the formula's is bent until it fits; one that follows the formula is not."""

import numpy as np
import pytest

from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow

MU, MORE = 0.10, 0.012  # of the load, and of its square [1/(N·m)]


def by_the_square(m):
    """Friction that grows faster than the load: gears that bend."""
    return (MU * np.abs(m.load) + MORE * m.load**2) * np.sign(m.v)


def in_proportion(m):
    return (MU + 5.0 * MORE) * np.abs(m.load) * np.sign(m.v)


def named(found):
    return [(each.effect, each.place.name) for each in found.discrepancy.findings]


@pytest.fixture(scope="module")
def bent(search, study, on_joint):
    return search(study(on_joint(1, by_the_square)))


@pytest.fixture(scope="module")
def straight(search, study, on_joint):
    return search(study(on_joint(1, in_proportion)))


def test_the_effect_keeps_its_name_and_the_error_falls_to_what_it_is_with_the_formulas_own_curve(bent, straight):
    assert named(bent) == named(straight) == [("load_coulomb", "j2")]
    one, other = (each.discrepancy.findings[0].held_out for each in (bent, straight))
    assert one.rmse_after < 1.1 * other.rmse_after
    before_the_bend, with_it = bent.discrepancy.chain[1:]
    assert before_the_bend.rmse > 1.2 * with_it.rmse


def test_the_bend_is_told_and_stands_in_the_chain_and_the_lineage(bent):
    (finding,) = bent.discrepancy.findings
    assert [each.what for each in finding.refined] == ["own_curve"]
    assert "Its curve is not quite that of the formula" in finding_sentence(finding)
    assert [each.step.identifier for each in bent.discrepancy.chain][1:] == [
        "load_coulomb@j2", "own curve of load_coulomb@j2",
    ]  # fmt: skip
    assert [each.rmse for each in bent.discrepancy.chain] == sorted(
        (each.rmse for each in bent.discrepancy.chain), reverse=True
    )
    assert bent.discrepancy.lineage[-1].parent == bent.discrepancy.lineage[-2].version


def test_the_curve_that_is_handed_on_is_the_true_one(bent):
    values = {each.name: each.value for each in bent.identification.parameters}
    effects = bent.identification.model.extension.effects
    own = next(each.effect for each in effects if each.effect.name == "load_coulomb_curve")
    load = np.linspace(5.0, 12.0, 8)
    said = values["load_coulomb.mu[j2]"] * load
    for coefficient, term in zip(own.coefficients, own.terms, strict=True):
        said += values[f"load_coulomb_curve.{coefficient.name}[j2]"] * load * (load / own.sizes[0]) ** (1 + term)
    true = MU * load + MORE * load**2
    np.testing.assert_allclose(said - said.mean(), true - true.mean(), atol=0.1 * np.ptp(true))


def test_what_follows_the_formula_is_not_bent(straight):
    assert len(straight.discrepancy.chain) == 2
    assert straight.discrepancy.findings[0].refined == ()
