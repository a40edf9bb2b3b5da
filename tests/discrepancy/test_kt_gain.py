"""A motor gain that differs from the stated one is absorbed; what gives it away is what the maker says of the rest."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.detect.nominal.contradicted import contradicted
from exogauge.detect.nominal.detector import name_contradiction
from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.search.baseline import lay_ground

pytestmark = pytest.mark.slow

JOINTS, K_T = ("j1", "j2", "j3"), (6.0, 5.0, 3.0)  # `weighed` states these, within
DOUBT, MASS_DOUBT = 0.02, 0.03
SETTINGS = Settings(cutoff_hz=8.0)


@pytest.fixture(scope="module")
def evaluated(weighed, record):
    """(actuation, what every motor truly gives over what is stated or logged, noise seed) -> recordings, and the
    robot identified from them."""

    def run(actuation, ratio, seed=0, phi=None):
        robot = weighed(actuation)
        if phi is not None:
            robot = replace(robot, tree=replace(robot.tree, phi=robot.tree.phi * phi))
        recordings = []
        for number in (1, 2, 9):
            log = record(number, noise_seed=100 * seed + number)
            channels = dict(log.channels)
            for joint, how, k, more in zip(JOINTS, actuation, K_T, ratio, strict=True):
                tau = channels.pop(f"tau.{joint}") / more
                channels[f"tau.{joint}" if how == "torque" else f"i.{joint}"] = tau if how == "torque" else tau / k
            recordings.append(Recording(replace(log, channels=channels), number == 9))
        return recordings, identify(robot, recordings, SETTINGS)

    return run


@pytest.fixture(scope="module")
def findings(evaluated):
    """The same -> what contradicts the maker in the model as it is."""

    def run(*how):
        recordings, found = evaluated(*how)
        odd = contradicted(found.model, [each.log for each in recordings if not each.held_out])
        return [
            name_contradiction(rank, found, recordings, SETTINGS, each) for rank, each in enumerate(odd.one_by_one, 1)
        ]

    return run


@pytest.mark.parametrize("share", [-0.15, 0.12])
def test_a_gain_off_by_more_than_its_doubt_is_named_with_its_size(findings, share):
    (finding,) = findings(("torque", "current", "current"), (1.0, 1.0 + share, 1.0))
    assert (finding.effect, finding.place.kind, finding.place.name) == ("kt_gain", "joint", "j2")
    ratio, gain = finding.parameters["ratio"], finding.parameters["gain"]
    assert abs(ratio.value - (1.0 + share)) < 3.0 * ratio.std
    assert abs(gain.value - 5.0 * (1.0 + share)) < 3.0 * gain.std
    assert (finding.parameters["stated"].value, gain.unit) == (5.0, "N·m/A")
    assert finding.held_out.channel == "tau.j2"
    assert finding.held_out.rmse_after < 0.5 * finding.held_out.rmse_before


def test_a_logged_torque_that_is_not_what_the_motor_gives_is_named(findings):
    (finding,) = findings(("torque",) * 3, (1.0, 1.15, 1.0))
    assert (finding.effect, finding.place.name) == ("kt_gain", "j2")
    ratio = finding.parameters["ratio"]
    assert abs(ratio.value - 1.15) < 3.0 * ratio.std
    assert finding.parameters["gain"].unit == "1"
    assert finding.held_out.channel == "tau.j2"
    assert finding.held_out.rmse_after < 0.9 * finding.held_out.rmse_before


@pytest.mark.parametrize(("joint", "ratio"), [("j2", (1.0, 0.85, 1.0)), ("j3", (1.0, 1.0, 1.2))])
def test_a_logged_torque_that_others_contradict_is_part_of_the_model_that_is_handed_on(evaluated, joint, ratio):
    """What the links of one joint weigh, the torque of the next one says too."""
    recordings, found = evaluated(("torque",) * 3, ratio)
    answer = find_missing_effects(found, recordings, missing_effects(), SETTINGS)
    (finding,) = answer.discrepancy.findings
    assert (finding.effect, finding.place.name) == ("kt_gain", joint)
    share = finding.parameters["share"]
    assert abs(share.value - (1.0 - 1.0 / ratio[JOINTS.index(joint)])) < 3.0 * share.std
    assert [each.effect.name for each in answer.identification.model.extension.effects] == ["kt_gain"]
    assert finding.score > 0.5


def test_torques_that_are_logged_right_are_not_blamed(evaluated):
    recordings, found = evaluated(("torque",) * 3, (1.0, 1.0, 1.0))
    assert find_missing_effects(found, recordings, missing_effects(), SETTINGS).discrepancy.findings == ()


def test_where_currents_are_logged_the_torque_constant_of_the_model_is_all_that_is_asked_about(evaluated):
    """Beside it a second factor of the same torque explains nothing but rounding and turns."""
    recordings, found = evaluated(("torque", "current", "current"), (1.0, 1.0, 1.0))
    ground = lay_ground(found.model, recordings, missing_effects(), lambda *_: None)
    tried = {site.axis for site, candidates in ground.candidates.items()
             if any(each.effect.name == "kt_gain" for each in candidates)}  # fmt: skip
    assert tried == {0}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("actuation", [("torque", "current", "current"), ("torque",) * 3])
def test_gains_and_links_within_their_doubts_are_no_finding(findings, actuation, seed):
    rng = np.random.default_rng(seed)
    ratio = 1.0 + DOUBT * rng.standard_normal(3) * (np.array(actuation) == "current")
    assert findings(actuation, ratio, seed, 1.0 + MASS_DOUBT * rng.standard_normal((3, 1))) == []


def test_without_a_known_scale_no_gain_is_named(findings):
    named = findings(("current",) * 3, (1.0, 1.3, 1.0))
    assert [each for each in named if each.effect == "kt_gain"] == []


@pytest.mark.parametrize("factor", [0.8, 1.3])
def test_a_common_factor_is_never_named_at_one_joint(findings, factor):
    named = findings(("torque",) * 3, (factor,) * 3)
    assert [each for each in named if each.effect == "kt_gain"] == []
