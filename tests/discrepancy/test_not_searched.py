"""Where nothing is searched for, numbers beside what the model lacks are as doubtful as what they took up of it."""

import numpy as np
import pytest

from exogauge.detect.not_searched import not_searched
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.remarks import About
from exogauge.studies.words.remark_words import sentence

SETTINGS = Settings(cutoff_hz=8.0)
TRUE = {"k_d[j2]": 0.7, "tau_c[j2]": 1.2, "tau_o[j2]": -0.3}  # of the arm in conftest


def grows_with_load(motion):
    """Coulomb friction of the second joint, by a tenth of the torque that is passed on."""
    torque = np.zeros_like(motion.q)
    torque[:, 1] = 0.1 * np.abs(motion.load[:, 1]) * np.sign(motion.v[:, 1])
    return torque


@pytest.fixture(scope="module")
def found(robot, record):
    """(hidden) -> identified as it is, and as it is told."""

    def of(*hidden):
        recordings = [Recording(record(seed, *hidden, seconds=15.0), held_out=seed == 3) for seed in (1, 2, 3)]
        before = identify(robot, recordings, SETTINGS)
        return before, not_searched(before, recordings, SETTINGS)

    return of


@pytest.mark.slow
def test_friction_that_grows_with_the_load_makes_the_others_doubtful_and_is_told(found):
    one, other = found(grows_with_load)
    before, after = ({each.name: each for each in found.parameters} for found in (one, other))
    assert abs(before["tau_c[j2]"].value - 1.2) > 4.0 * before["tau_c[j2]"].std
    for name, true in TRUE.items():
        assert abs(after[name].value - true) < 1.96 * after[name].std, name
        assert after[name].parts["unexplained"] > 0.0
    assert after["tau_c[j3]"].std == pytest.approx(before["tau_c[j3]"].std, rel=0.2)
    (remark,) = [each for each in other.remarks if each.about == About.LEFT_WITHOUT_SEARCH]
    assert remark.names == ("tau.j2",)
    assert remark.each[0][0] > 1.5
    assert "tau.j2" in sentence(remark)
    assert "`discrepancy`" in sentence(remark)


def test_where_the_model_lacks_nothing_all_stays_as_it_was(found):
    before, after = found()
    assert after is before
