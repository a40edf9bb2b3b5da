"""A low-pass before storage makes friction look soft; it is seen, its cut-off found, and the model filtered alike."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import bessel, butter, lfilter, sosfilt, sosfiltfilt, sosfreqz

from exogauge.criteria.detecting import StoredFilter
from exogauge.detect.pipeline import find_missing_effects
from exogauge.detect.stored_filter.detector import band_limits
from exogauge.detect.stored_filter.stored_pass import filtered_alike
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.effects.catalogue import shaped_effects
from exogauge.errors import NotIdentifiable
from exogauge.identification.identify import identify
from exogauge.identification.noise_bias import noise_behind_stored
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.filtering import StoredPass
from exogauge.logs.model import Log
from exogauge.logs.stored_band import stored_edge, stored_edges
from exogauge.studies.words.finding_sentences import finding_sentence
from exogauge.support.settings import WornLog

pytestmark = pytest.mark.slow

RATE = 200.0
SETTINGS = Settings(cutoff_hz=20.0)


def changed(recordings, change):
    """change: (name of a channel, (T,)) -> (T,)."""
    return [
        replace(each, log=replace(each.log, channels={name: change(name, x) for name, x in each.log.channels.items()}))
        for each in recordings
    ]


def stored_through(sections, both_ways=True):
    passed = sosfiltfilt if both_ways else sosfilt
    return lambda _name, values: passed(sections, values - values[0]) + values[0]


def limits(robot, recordings):
    def anew(each):
        return identify(robot, each, SETTINGS)

    return band_limits(anew(recordings), recordings, anew)


@pytest.mark.parametrize(("hz", "decimals"), [(2.0, 3), pytest.param(5.0, 12, marks=pytest.mark.thorough)])
def test_the_cut_off_comes_out_within_its_doubt(robot, study, hz, decimals):
    through = stored_through(butter(4, hz, fs=RATE, output="sos"))

    def stored(name, values):
        passed = through(name, values)
        return np.round(passed, decimals) if name.startswith("tau") else passed

    found = limits(robot, changed(study(), stored))
    assert found is not None
    cutoff = found.finding.parameters["cutoff"]
    assert abs(cutoff.value - hz) < 2.0 * cutoff.std
    assert cutoff.std < 0.1 * hz
    assert (found.band.stored.late, abs(found.band.stored.order - 4) < 2) == (False, True)
    assert (found.finding.place.kind, found.finding.place.name) == ("log", "all")
    assert found.finding.held_out.rmse_after < 0.5 * found.finding.held_out.rmse_before


@pytest.mark.parametrize(
    ("sections", "both_ways"),
    [
        pytest.param(butter(8, 3.0, fs=RATE, output="sos"), True, marks=pytest.mark.thorough),
        (bessel(8, 3.0, fs=RATE, output="sos", norm="mag"), True),
        (butter(8, 3.0, fs=RATE, output="sos"), False),
    ],
    ids=["steeper", "bessel", "one way"],
)
def test_a_filter_of_another_shape_is_seen_too(robot, study, sections, both_ways):
    found = limits(robot, changed(study(), stored_through(sections, both_ways)))
    assert found is not None
    assert 2.0 < found.band.cutoff.value < 4.0


@pytest.mark.parametrize(("order", "late"), [pytest.param(2, False, marks=pytest.mark.thorough), (4, True)])
def test_whether_a_filter_made_the_signals_late_and_how_steep_it_was_is_found(robot, study, order, late):
    through = stored_through(butter(order, 3.0, fs=RATE, output="sos"), both_ways=not late)
    found = limits(robot, changed(study(), through))
    assert found is not None
    assert found.band.stored.late is late
    assert abs(found.band.stored.order - order) < 2
    assert ("ms late" in finding_sentence(found.finding)) is late
    assert found.finding.held_out.rmse_after < 0.5 * found.finding.held_out.rmse_before


@pytest.mark.parametrize(("order", "hz"), [(1, 5.0), pytest.param(3, 4.0, marks=pytest.mark.thorough)])
def test_a_gentle_low_pass_of_positions_and_torques_is_seen_by_the_noise_it_takes_along(robot, study, order, hz):
    rng = np.random.default_rng(order)
    through = stored_through(butter(order, hz, fs=RATE, output="sos"), both_ways=False)

    def encoded(name, values):
        return values + 3e-6 * rng.standard_normal(values.shape) if name.startswith("q.") else values

    sampled = changed(study(), encoded)
    assert [stored_edge(each.log) for each in sampled] == [None] * 3
    torques_only = changed(sampled, lambda name, values: values if name.startswith("q.") else through(name, values))
    assert not any(edge and not edge.steep for edge in (stored_edge(each.log) for each in torques_only))
    found = limits(robot, changed(sampled, through))
    assert found is not None
    assert found.finding.place.name == "all"
    assert found.finding.held_out.rmse_after < 0.8 * found.finding.held_out.rmse_before


def test_a_low_pass_behind_which_nothing_can_be_identified_is_none(robot, study):
    """A trial that fails is no reason to give up the evaluation."""
    recordings = changed(study(), stored_through(butter(4, 3.0, fs=RATE, output="sos")))
    first = identify(robot, recordings, SETTINGS)

    def nothing_moves(_recordings):
        raise NotIdentifiable("no joint moves steadily")

    assert band_limits(first, recordings, nothing_moves) is None


@pytest.mark.parametrize("one", [0, 2], ids=["fitted", "held out"])
def test_a_single_low_passed_log_is_named_for_itself(robot, study, one):
    recordings = study()
    recordings[one : one + 1] = changed(
        recordings[one : one + 1], stored_through(butter(4, 3.0, fs=RATE, output="sos"))
    )
    found = limits(robot, recordings)
    assert found is not None
    assert found.band.logs == (recordings[one].log.name,)
    assert found.finding.held_out.log == recordings[one].log.name
    assert abs(found.band.cutoff.value - 3.0) < 3.0 * found.band.cutoff.std
    assert f"in {recordings[one].log.name}, turns included" in finding_sentence(found.finding)


def test_a_log_that_ends_less_clearly_counts_where_its_fellows_end():
    """White noise through a low-pass of order 7 or 4, which falls by some 80 and 46 dB in an octave and a half."""
    rng, t = np.random.default_rng(3), np.arange(0.0, 60.0, 1.0 / RATE)

    def ended(name, order):
        noise = lfilter(*butter(order, 5.0, fs=RATE), rng.standard_normal(len(t)))
        return Log(name, t, {"tau.j1": noise, "q.j1": np.sin(t)})

    clear, less = [ended(f"clear {n}", 7) for n in range(3)], ended("less clear", 4)
    assert all(stored_edge(each).steep for each in clear)
    assert not stored_edge(less).steep
    assert [each.steep for each in stored_edges([*clear, less]).values()] == [True] * 4
    white = Log("white", t, {"tau.j1": rng.standard_normal(len(t)), "q.j1": np.sin(t)})
    assert "white" not in stored_edges([*clear, white])
    assert not stored_edges([clear[0], less, white])["less clear"].steep


def dahl(motion):
    """Four springs that slip, on the second joint, by 1.5 N·m: friction soft at turns, though stored as it is."""
    torque, held = np.zeros_like(motion.q), np.zeros(4)
    reach = np.array([0.01, 0.02, 0.04, 0.08])
    for k in range(1, len(motion.t)):
        held = np.clip(held + motion.q[k, 1] - motion.q[k - 1, 1], -reach, reach)
        torque[k, 1] = 1.5 * np.mean(held / reach)
    return torque


def none(name, values):
    return values


def on_efforts(change):
    return lambda name, values: change(values) if name.startswith("tau") else values


CLEAN = {
    "as it is": ({}, none),
    "hardly any noise": ({"noise": 1e-3}, none),
    "much noise": ({"noise": 1.0}, none),
    "no noise": ({"noise": 0.0}, none),
    "no noise, in steps": ({"noise": 0.0}, on_efforts(lambda x: np.round(x, 2))),
    "no noise, in coarse steps": ({"noise": 0.0}, on_efforts(lambda x: 0.2 * np.round(x / 0.2))),
    "single precision": ({"noise": 0.0}, on_efforts(lambda x: x.astype(np.float32).astype(float))),
    "short": ({"seconds": 8.0}, none),
    "one joint still": ({"still": 1}, none),
    "one joint still, no noise": ({"still": 1, "noise": 0.0}, none),
    "a lag of 10 ms": ({}, on_efforts(lambda x: lfilter([0.4], [1.0, -0.6], x))),
    "a drive's second-order filter": ({}, on_efforts(lambda x: sosfilt(butter(2, 30.0, fs=RATE, output="sos"), x))),
    "the same, slow": ({}, on_efforts(lambda x: sosfilt(butter(2, 10.0, fs=RATE, output="sos"), x))),
    "anti-aliasing": ({"noise": 0.01}, on_efforts(lambda x: sosfilt(butter(8, 60.0, fs=RATE, output="sos"), x))),
    "mean of five": ({}, on_efforts(lambda x: np.convolve(x, np.ones(5) / 5, mode="same"))),
    "every second value twice": ({}, on_efforts(lambda x: np.repeat(x[::2], 2)[: len(x)])),
}


@pytest.mark.parametrize("variant", CLEAN)
def test_logs_that_were_not_low_passed_do_not_end(study, variant):
    how, change = CLEAN[variant]
    assert [stored_edge(each.log) for each in changed(study(**how), change)] == [None] * 3


@pytest.mark.parametrize("noise", [0.05, 0.0])
def test_friction_that_is_soft_at_turns_is_no_filter(study, noise):
    assert [stored_edge(each.log) for each in study(dahl, noise=noise)] == [None] * 3


def test_smooth_motion_without_friction_or_noise_ends_as_well_but_asks_for_no_filter(robot, study):
    smooth = study(lambda motion: motion.load - motion.drive, noise=0.0)
    assert stored_edge(smooth[0].log) is not None
    assert limits(robot, smooth) is None


def test_noise_free_logs_without_a_low_pass_are_left_alone(robot, study):
    assert limits(robot, study(noise=0.0)) is None


def test_without_a_held_out_log_nothing_is_claimed(robot, study):
    recordings = changed(study(), stored_through(butter(4, 3.0, fs=RATE, output="sos")))
    assert limits(robot, [replace(each, held_out=False) for each in recordings]) is None


def floors(found, log):
    return np.array([fit.noise_floor for fit in found.validation if fit.log == log and fit.channel.startswith("tau.")])


def test_the_noise_floor_of_such_a_log_is_what_the_others_noise_leaves_behind_its_low_pass(robot, study):
    """White noise of 0.05 N·m behind a zero-phase low-pass: its power is the mean of the squared gain."""
    recordings, sections = study(noise=0.05), butter(4, 3.0, fs=RATE, output="sos")
    (late,) = changed(recordings[2:], stored_through(sections))
    gain = np.abs(sosfreqz(sections, 4000)[1]) ** 2
    left = 0.05 * np.sqrt(np.mean(gain**2))
    limited = [*recordings[:2], replace(late, log=replace(late.log, stored=StoredPass(3.0)))]
    found = identify(robot, limited, SETTINGS)
    np.testing.assert_allclose(floors(found, late.log.name), left, rtol=0.25)  # encoders add some
    np.testing.assert_allclose(floors(found, recordings[0].log.name), 0.05, rtol=0.15)


def test_what_the_maker_states_of_the_noise_passes_the_low_pass_too(robot, study):
    sections = butter(4, 3.0, fs=RATE, output="sos")
    stored = changed(study(noise=0.05), stored_through(sections))
    limited = [replace(each, log=replace(each.log, stored=StoredPass(3.0))) for each in stored]
    told, unsaid = (identify(one, limited, SETTINGS) for one in (replace(robot, noise={"tau": 0.05}), robot))
    left = 0.05 * np.sqrt(np.mean(np.abs(sosfreqz(sections, 4000)[1]) ** 4))
    for each in limited:
        np.testing.assert_allclose(floors(told, each.log.name), left, rtol=0.2)
        assert np.all(floors(unsaid, each.log.name) < 0.1 * left)


@pytest.mark.parametrize(
    ("noise", "limited", "said"),
    [
        ({}, slice(1, None), "The noise floor is what the noise of the other logs leaves behind that low-pass."),
        pytest.param(
            {"tau": 0.05},
            slice(None),
            "The noise floor is what the noise that robot.yaml states leaves behind",
            marks=pytest.mark.thorough,
        ),
        ({}, slice(None), "There is no noise floor to hold that against"),
    ],
    ids=["others", "stated", "unknown"],
)
def test_what_the_noise_floor_stands_for_is_said(robot, study, noise, limited, said):
    recordings = study()
    recordings[limited] = changed(recordings[limited], stored_through(butter(4, 3.0, fs=RATE, output="sos")))
    found = limits(replace(robot, noise=noise), recordings)
    assert found is not None
    assert said in finding_sentence(found.finding)


@pytest.mark.parametrize(("order", "late"), [(2, True), (3, False)])
def test_noise_that_only_low_passed_logs_hold_is_seen_where_nothing_jumps(robot, study, order, late):
    """The joints of these logs turn round every second or so; one that does not stands for those that creep."""
    rng, stored = np.random.default_rng(order), StoredPass(4.0, order, late)
    sections = butter(order, 4.0, fs=RATE, output="sos")
    slow = changed(study(noise=0.0), lambda name, x: np.linspace(0.0, 1.0, len(x)) if name == "q.j1" else 0.0 * x)
    noisy = changed(slow, lambda name, x: x + 0.05 * rng.normal(size=x.shape) if name.startswith("tau.") else x)
    limited = changed(noisy, stored_through(sections, both_ways=not late))
    model = identify(robot, study(), SETTINGS).model
    for each in limited:
        behind = noise_behind_stored(robot, model.prepare(replace(each.log, stored=stored)))
        assert behind["tau.j1"] == pytest.approx(0.05, rel=0.25)
    turning = changed(study(noise=0.05), stored_through(sections, both_ways=not late))
    behind = noise_behind_stored(robot, model.prepare(replace(turning[0].log, stored=stored)))
    assert all(behind[f"tau.{name}"] is None or behind[f"tau.{name}"] < 0.1 for name in ("j1", "j2", "j3"))


def wear(log):
    band = Band("back", "back", (ViaPoint("lj1", (0.0, 0.0, 0.1)), ViaPoint("lj2", (0.1, 0.0, 0.1))))
    return WornLog(log, "any", Device("suit", (band,)))


def test_a_log_with_a_device_is_filtered_like_the_others_if_its_spectrum_ends_where_theirs_does(study, record):
    through, faster = (stored_through(butter(4, hz, fs=RATE, output="sos")) for hz in (3.0, 8.0))
    limited = [
        replace(each, log=replace(each.log, stored=StoredPass(2.97))) for each in changed(study(), through)
    ]  # as `band_limits` leaves them

    def pulled(motion):
        """A band on the second joint that comes taut at 0.1 rad, by 30 N·m/rad."""
        torque = np.zeros_like(motion.q)
        torque[:, 1] = 30.0 * np.maximum(motion.q[:, 1] - 0.1, 0.0)
        return torque

    worn = record(21, pulled)
    alike, other = (changed([Recording(worn, True)], each)[0].log for each in (through, faster))
    logs = filtered_alike([wear(alike), wear(other), wear(worn)], limited, StoredFilter())
    assert [each.log.stored for each in logs] == [StoredPass(2.97), None, None]
    assert [each.log for each in filtered_alike([wear(alike)], study(), StoredFilter())] == [alike]


@pytest.mark.slow
def test_a_low_passed_log_is_named_first_and_no_friction_with_it(robot, study):
    recordings = changed(study(), stored_through(butter(4, 2.0, fs=RATE, output="sos")))
    found = find_missing_effects(
        identify(robot, recordings, SETTINGS), recordings, tuple(shaped_effects().values()), SETTINGS
    ).discrepancy
    assert [each.effect for each in found.findings] == ["band_limited_log"]
    assert found.chain[1].rmse < found.chain[0].rmse
