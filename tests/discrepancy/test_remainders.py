"""A second effect that is too small beside the one that was named gets no name, and is not left in the residual."""

import numpy as np
import pytest

from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow


def much(m):
    return 0.35 * np.abs(m.load) * np.sign(m.v)


def much_and_a_little(m):
    """Friction that grows with the load, and a little that differs by direction."""
    return much(m) + 0.25 * np.abs(m.v)


@pytest.fixture(scope="module")
def found(search, study, on_joint):
    return search(study(on_joint(1, much_and_a_little))).discrepancy


def test_only_what_is_large_gets_a_name(found):
    assert [(each.effect, each.place.name) for each in found.findings] == [("load_coulomb", "j2")]


def test_the_rest_is_in_the_model_and_told(found):
    (finding,) = found.findings
    assert [each.what for each in finding.refined] == ["remainder"]
    assert "What is left beside it looks like" in finding_sentence(finding)
    assert found.chain[-1].step.identifier == "remainder of load_coulomb@j2"
    assert finding.held_out.rmse_after < 1.2 * finding.held_out.noise_floor
    assert found.chain[-1].rmse < 0.8 * found.chain[-2].rmse
    assert found.unexplained == ()


def test_where_nothing_is_left_nothing_is_added(search, study, on_joint):
    alone = search(study(on_joint(1, much))).discrepancy
    assert [(each.step.what, each.step.effect) for each in alone.chain] == [("robot", ""), ("effect", "load_coulomb")]
    assert alone.findings[0].refined == ()
