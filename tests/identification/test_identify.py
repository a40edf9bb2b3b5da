import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from exogauge.effects.catalogue import missing_effects
from exogauge.errors import BadLog, BadStudy, NotIdentifiable
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.remarks import About
from exogauge.search.baseline import lay_ground
from exogauge.side_by_side import CORES

JOINTS = ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r")


def by_name(result):
    return {parameter.name: parameter for parameter in result.parameters}


def truth_of(truth, parameter):
    """The true value of a standard, joint or base parameter, from its name alone."""
    if parameter.combination:
        return sum(c * true_standard(truth, name) for name, c in parameter.combination.items())
    return true_standard(truth, parameter.name)


def true_standard(truth, name):
    kind, subject = name[:-1].split("[")
    if kind in truth.xi:
        return truth.xi[kind][[j.name for j in truth.robot.joints].index(subject)]
    element = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz").index(kind)
    return truth.phi[truth.robot.tree.bodies.index(subject), element]


def fit(truth, make_log, noise, settings=None, fitted=(1, 2), held_out=(9,)):
    recordings = [Recording(make_log(truth, seed, noise=noise), False) for seed in fitted]
    recordings += [Recording(make_log(truth, seed, noise=noise), True) for seed in held_out]
    return identify(truth.robot, recordings, settings or Settings(cutoff_hz=8.0))


@pytest.mark.slow
def test_of_a_joint_that_is_left_undecided_no_parameter_counts_and_all_others_stay(make_truth, make_log):
    found = fit(make_truth(True), make_log, noise=1.0)
    then = found.with_undecided(["j1"])
    own = {name for name in by_name(found) if name.endswith("[j1]")}
    decided, left = ({n for n, each in by_name(one).items() if each.identifiable} for one in (found, then))
    assert decided & own
    assert left == decided - own
    assert set(then.unidentifiable) == set(found.unidentifiable) | own
    assert found.with_undecided([]).unidentifiable == found.unidentifiable
    then = found.with_undecided([], ["k_d", "tau_c"])
    friction = {name for name in decided if name.startswith(("k_d[", "tau_c["))}
    assert friction
    assert {n for n, each in by_name(then).items() if each.identifiable} == decided - friction


@pytest.mark.slow
@pytest.mark.parametrize("floating", [True, False])
def test_known_truth_comes_back_without_noise(make_truth, make_log, floating):
    truth = make_truth(floating, actuation="current" if floating else "torque")
    # without noise and nearly without a prior, float64 sums of squares cannot tell a null direction from rounding
    settings = Settings(cutoff_hz=8.0, prior_strength=1e-6, solver="rows")
    result = fit(truth, make_log, noise=0.0, settings=settings)
    # on a fixed base the first rotor and the first link's inertia about that axis always turn together
    together = () if floating else ("J_r[j1]", "base[Izz[link1]]")
    off = [
        parameter.value - truth_of(truth, parameter) for parameter in result.parameters if parameter.name in together
    ]
    assert abs(sum(off)) < 2e-3
    for parameter in result.parameters:
        if parameter.name in together:
            continue
        if parameter.combination or parameter.name.split("[")[0] in JOINTS:
            true = truth_of(truth, parameter)
            share = 0.06 if parameter.name.startswith("tau_s") else 0.02  # stops are few, and filtered
            allowed = max(share * abs(true), 0.02, 2.5 * min(parameter.std, 0.02))
            assert abs(parameter.value - true) < allowed, parameter.name


@pytest.mark.slow
def test_most_intervals_hold_the_truth(make_truth, make_log):
    truth = make_truth(floating=True, joints=3, seed=3)
    result = fit(truth, make_log, noise=1.0)
    decided = [p for p in result.parameters if p.identifiable]
    inside = [abs(p.value - truth_of(truth, p)) < 1.96 * p.std for p in decided]
    assert len(decided) > 30
    assert np.mean(inside) > 0.85


@pytest.mark.slow
def test_held_out_error_shrinks_to_the_noise(make_truth, make_log):
    truth = make_truth(floating=True, seed=4)
    result = fit(truth, make_log, noise=1.0)
    for one in result.validation:
        if one.held_out and one.channel.startswith("base"):
            assert one.rmse_identified < 1.2 * one.noise_floor
            assert one.rmse_identified < 0.5 * one.rmse_prior


def test_coupled_axes_get_their_own_friction(make_truth, make_log):
    C = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.7, 1.0]])
    truth = make_truth(floating=False, actuation="torque", seed=5, coupling=C)
    values = by_name(fit(truth, make_log, noise=0.1, settings=Settings(cutoff_hz=8.0)))
    for joint, k_d in zip(("j1", "j2", "j3"), truth.xi["k_d"], strict=True):
        assert values[f"k_d[{joint}]"].value == pytest.approx(k_d, rel=0.05)


@pytest.mark.slow
def test_the_sign_of_static_friction_is_found_from_the_residual(make_truth, make_log):
    truth = make_truth(floating=True, seed=6)
    values = by_name(fit(truth, make_log, noise=0.5))
    for joint, tau_s in zip(("j1", "j2", "j3"), truth.xi["tau_s"], strict=True):
        assert values[f"tau_s[{joint}]"].value == pytest.approx(tau_s, rel=0.1)


@pytest.mark.slow
def test_friction_that_held_less_in_one_log_is_told_as_a_lower_bound(make_truth, make_log):
    """The second joint is held by a third of what it could: [Evaluator] (8) does not hold there."""
    truth = make_truth(floating=True, seed=6)
    less = replace(truth, xi={**truth.xi, "tau_s": truth.xi["tau_s"] * [1.0, 0.3, 1.0]})

    def tau_s(*truths):
        recordings = [Recording(make_log(each, 1 + k, noise=3.0), False) for k, each in enumerate(truths)]
        found = identify(truth.robot, recordings, Settings(cutoff_hz=8.0))
        doubted = [name for each in found.remarks if each.about == About.STICKS_UNEQUALLY for name in each.names]
        return by_name(found)["tau_s[j2]"], doubted

    same, doubted = tau_s(truth, truth)
    assert same.identifiable
    assert same.value == pytest.approx(truth.xi["tau_s"][1], rel=0.1)
    assert "j2" not in doubted
    varying, doubted = tau_s(truth, less)
    assert not varying.identifiable
    assert varying.value < 0.9 * truth.xi["tau_s"][1]
    assert "j2" in doubted


def test_currents_alone_on_a_fixed_robot_do_not_fix_the_scale(make_truth, make_log):
    result = fit(make_truth(floating=False), make_log, noise=0.5)
    assert not any(p.identifiable for p in result.parameters)
    assert About.FACTOR_OPEN in [each.about for each in result.remarks]


@pytest.mark.slow
def test_accurate_mode_agrees_with_the_statistics(make_truth, make_log):
    truth = make_truth(floating=True, seed=7)
    fast = fit(truth, make_log, 1.0, Settings(cutoff_hz=8.0, prior_strength=1.0), fitted=(1,), held_out=())
    exact = fit(
        truth, make_log, 1.0, Settings(cutoff_hz=8.0, prior_strength=1.0, solver="rows"), fitted=(1,), held_out=()
    )
    for a, b in zip(fast.parameters, exact.parameters, strict=True):
        assert abs(a.value - b.value) < 1e-5 * a.std + 1e-12, a.name


@pytest.mark.slow
def test_every_link_is_possible_when_asked_for(make_truth, make_log):
    truth = make_truth(floating=True, seed=8)
    result = fit(truth, make_log, 3.0, Settings(cutoff_hz=8.0, consistency="physical"), fitted=(1,))
    assert all(result.consistent_links)
    held_out = [one for one in result.validation if one.held_out and one.channel == "base.mx"]
    assert held_out[0].rmse_identified < 0.7 * held_out[0].rmse_prior


@pytest.mark.slow
def test_the_printed_prior_also_beats_the_maker(make_truth, make_log):
    truth = make_truth(floating=True, seed=9)
    result = fit(truth, make_log, 1.0, Settings(cutoff_hz=8.0, prior="as_printed"))
    for one in result.validation:
        if one.held_out and one.channel.startswith("base"):
            assert one.rmse_identified < 0.6 * one.rmse_prior


def test_a_missing_channel_is_named(make_truth, make_log):
    truth = make_truth(floating=True)
    log = make_log(truth, 1, seconds=5.0)
    channels = {name: values for name, values in log.channels.items() if name != "gyro.y"}
    with pytest.raises(BadLog, match=r"gyro\.y"):
        identify(truth.robot, [Recording(type(log)(log.name, log.time, channels), False)], Settings(cutoff_hz=8.0))


def test_nothing_to_fit_is_refused(make_truth, make_log):
    truth = make_truth(floating=True)
    with pytest.raises(BadStudy, match="no log to identify from"):
        identify(truth.robot, [Recording(make_log(truth, 1, seconds=5.0), True)], Settings())


def test_a_log_too_slow_for_the_others_is_refused(make_truth, make_log):
    truth = make_truth(floating=True)
    fast, slow = make_log(truth, 1, seconds=8.0), make_log(truth, 2, seconds=40.0)
    channels = {name: values[::20] for name, values in slow.channels.items()}
    recordings = [Recording(fast, False), Recording(type(fast)("slow", slow.time[::20], channels), True)]
    with pytest.raises(BadLog, match="too slow"):
        identify(truth.robot, recordings, Settings(cutoff_hz=8.0))


def test_a_held_out_log_may_be_slower_than_the_fitted_one(make_truth, make_log):
    truth = make_truth(floating=True, seed=10)
    fast, slow = make_log(truth, 1, noise=1.0), make_log(truth, 2, noise=1.0)
    channels = {name: values[::4] for name, values in slow.channels.items()}
    recordings = [Recording(fast, False), Recording(type(fast)("slow", slow.time[::4], channels), True)]
    result = identify(truth.robot, recordings, Settings(cutoff_hz=8.0))
    held_out = {one.channel: one for one in result.validation if one.held_out}
    assert held_out["base.mx"].rmse_identified < 0.5 * held_out["base.mx"].rmse_prior


def test_logs_without_steady_motion_are_refused_in_words(make_truth, make_log):
    truth = make_truth(floating=False, actuation="torque")
    log = make_log(truth, 1)
    still = Log(log.name, log.time, {name: np.full_like(values, values[0]) for name, values in log.channels.items()})
    with pytest.raises(NotIdentifiable, match="no joint moves steadily"):
        identify(truth.robot, [Recording(still, False)], Settings(cutoff_hz=8.0))


@pytest.mark.slow
def test_no_bit_depends_on_how_many_processors_there_are(make_truth, make_log, monkeypatch):
    truth = make_truth(True)
    logs = [make_log(truth, seed, seconds=12.0, noise=1.0) for seed in (1, 2, 3, 9)]
    recordings = [Recording(log, held_out) for log, held_out in zip(logs, (False, False, False, True), strict=True)]
    told = []
    for count in ("1", "3"):
        monkeypatch.setenv(CORES, count)
        found = identify(truth.robot, recordings, Settings())
        ground = lay_ground(found.model, recordings, missing_effects(), lambda *_: None)
        numbers = [[each.value, each.std] for each in found.parameters]
        fits = [[each.rmse_identified, each.noise_floor] for each in found.validation]
        scores = [[each.evidence, each.gain, *each.step] for each in ground.scores]
        series = [channels for each in found.predictions for channels in vars(each.channels()).values()]
        told.append([*numbers, *fits, *scores, *({name: x.tolist() for name, x in each.items()} for each in series)])
    assert told[0] == told[1]


@pytest.mark.slow
def test_channels_of_a_prediction_are_computed_alike_whenever_they_are_asked_for_and_kept_by_nobody(
    make_truth, make_log
):
    truth = make_truth(True)
    recordings = [Recording(make_log(truth, seed, seconds=12.0, noise=1.0), seed == 3) for seed in (1, 2, 3)]
    found = identify(truth.robot, recordings, Settings())
    for prediction in found.predictions:
        told, again = prediction.channels(), prediction.channels()
        assert set(told.measured) == set(told.predicted) == set(told.predicted_prior) == set(prediction.units)
        for part, same in zip(vars(told).values(), vars(again).values(), strict=True):
            np.testing.assert_equal(dict(part), dict(same))
        held = [weakref.ref(values) for values in told.predicted.values()]
        assert held
        del told, again, part, same
        gc.collect()
        assert [ref() for ref in held] == [None] * len(held)
