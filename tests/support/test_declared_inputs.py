"""What declared uncertainties do: against logs that are spoilt that way and identified anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import scipy
from tests.support.conftest import BODIES, JOINTS, ORDER, urdf

from exogauge.criteria.identifying import DECLARED as DEFAULT_DOUBTS
from exogauge.devices.routing import Routing
from exogauge.identification.disturbances import common_columns
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.robots.description import Declared
from exogauge.robots.urdf import load_tree
from exogauge.support.balance import balance, of_this_log, slopes
from exogauge.support.band_doubt import contributions
from exogauge.support.band_fit import best_start, fit_device, starts
from exogauge.support.band_inputs import nuisance_torques
from exogauge.support.band_model import Belief, Setting, fit, shared
from exogauge.support.band_rows import WearLogs, band_wires, rows_with, stretches, stretches_and_taut
from exogauge.support.inputs import Doubts, Inputs, sloped_samples, variance_of_mean
from exogauge.support.repeatability import Plain, repeatability
from exogauge.support.same_motion import Posture
from exogauge.support.settings import SupportSettings

SETTINGS = Settings(cutoff_hz=20.0, prior_strength=1.0, consistency="free")
DECLARED = Declared(
    ft_gain=0.01, ft_gain_common=0.01, ft_tilt=0.005, ft_zero_force=2.0, ft_zero_moment=0.2, kt_drift=0.01,
    viscous_drift=0.1, coulomb_drift=0.05, imu_tilt=0.009, ft_place=0.001, encoder_zero=0.002, clock=0.001,
)  # fmt: skip
EVERY = np.arange(6)
FORCES = [f"f{axis}" for axis in "xyz"] + [f"m{axis}" for axis in "xyz"]
Spoil = Callable[[Log], Log]


STARTED = {"log1": 100.0, "log2": 900.0, "later": 1800.0}


def identified(robot, logs, started=None):
    settings = replace(SETTINGS, started=started or {})
    return identify(robot, [Recording(log, held_out=False) for log in logs], settings).model


@pytest.fixture(scope="module")
def robot(biped):
    return replace(biped.robot, declared=DECLARED)


@pytest.fixture(scope="module")
def logs(biped, wander):
    return [biped.record(wander(seed), f"log{seed}", noise=1.0, seed=seed).log for seed in (1, 2)]


@pytest.fixture(scope="module")
def model(robot, logs):
    return identified(robot, logs)


@pytest.fixture(scope="module")
def spoilt(biped, robot, logs):
    """(name of an input, its size) -> how logs are spoilt by it, and the model that these make."""

    @cache  # what parameters and supporting torque are asked of is the same
    def made(name, size):
        spoil = CASES[name](biped, size)
        return spoil, identified(robot, [spoil(log) for log in logs])

    return made


def changed(log: Log, channels: dict) -> Log:
    return replace(log, channels={**log.channels, **channels})


def more_force(sensors, share) -> Spoil:
    def spoil(log):
        names = [f"ft.{sensor}.{each}" for sensor in sensors for each in FORCES]
        return changed(log, {name: (1.0 + share) * log.channels[name] for name in names})

    return spoil


def askew(sensor, axis, angle) -> Spoil:
    """A foot's sensor stands turned by the angle, so that it reads w + δ × w of what acts on it."""

    def spoil(log):
        channels = {}
        for kind in "fm":
            acts = log.stack([f"ft.{sensor}.{kind}{each}" for each in "xyz"])
            reads = acts + np.cross(angle * np.eye(3)["xyz".index(axis)], acts)
            channels |= {f"ft.{sensor}.{kind}{each}": reads[:, k] for k, each in enumerate("xyz")}
        return changed(log, channels)

    return spoil


def tilted(biped, axis, angle) -> Spoil:
    """The IMU stands turned by the angle, so that f = read + δ × read in the base."""

    def spoil(log):
        R, channels = biped.robot.T_base_imu.rotation, {}
        back = R.T @ (np.eye(3) - pin.skew(angle * np.eye(3)[axis])) @ R
        for kind in ("acc", "gyro"):
            read = log.stack([f"{kind}.{each}" for each in "xyz"]) @ back.T
            channels |= {f"{kind}.{each}": read[:, k] for k, each in enumerate("xyz")}
        return changed(log, channels)

    return spoil


def beside(sensor, axis, size) -> Spoil:
    """A foot's sensor sits beside its frame, so that its moments are about another place."""

    def spoil(log):
        force = log.stack([f"ft.{sensor}.f{each}" for each in "xyz"])
        more = np.cross(force, size * np.eye(3)["xyz".index(axis)])
        return changed(log, {f"ft.{sensor}.m{each}": log.channels[f"ft.{sensor}.m{each}"] + more[:, k]
                             for k, each in enumerate("xyz")})  # fmt: skip

    return spoil


def late(channels, seconds) -> Spoil:
    """Channels that are told so much later than they were measured."""

    def spoil(log):
        t = log.time - log.time[0]
        spoilt = {name: scipy.interpolate.CubicSpline(t, log.channels[name]) for name in channels}
        return changed(log, {name: each(t - seconds) for name, each in spoilt.items()})

    return spoil


def zeroed_elsewhere(joint, angle) -> Spoil:
    """An encoder that reads so much less than the angle is."""
    return lambda log: changed(log, {f"q.{joint}": log.channels[f"q.{joint}"] - angle})


BASE = [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
CASES = {
    "ft_gain_common": lambda biped, size: more_force([each.name for each in biped.robot.contacts], size),
    "ft_gain.l_foot": lambda biped, size: more_force(["l_foot"], size),
    "ft_gain.r_foot": lambda biped, size: more_force(["r_foot"], size),
    **{
        f"ft_tilt.{sensor}.{axis}": lambda biped, size, sensor=sensor, axis=axis: askew(sensor, axis, size)
        for sensor in ("l_foot", "r_foot")
        for axis in "xyz"
    },
    **{
        f"ft_place.{sensor}.{axis}": lambda biped, size, sensor=sensor, axis=axis: beside(sensor, axis, size)
        for sensor in ("l_foot", "r_foot")
        for axis in "xyz"
    },
    **{
        f"clock.{sensor}": lambda biped, size, sensor=sensor: late([f"ft.{sensor}.{each}" for each in FORCES], size)
        for sensor in ("l_foot", "r_foot")
    },
    "clock.imu": lambda biped, size: late(BASE, size),
    **{f"encoder_zero.{joint}": lambda biped, size, joint=joint: zeroed_elsewhere(joint, size) for joint in ORDER},
    "imu_tilt.x": lambda biped, size: tilted(biped, 0, size),
    "imu_tilt.y": lambda biped, size: tilted(biped, 1, size),
}


FIRST_OF_KIND = {
    "ft_gain_common", "ft_gain.l_foot", "ft_tilt.l_foot.x", "ft_place.l_foot.y", "clock.l_foot", "clock.imu",
    "imu_tilt.x", "encoder_zero.l_hip", "encoder_zero.torso_pitch",
}  # fmt: skip
EACH = [pytest.param(name, marks=() if name in FIRST_OF_KIND else pytest.mark.thorough) for name in CASES]


def astray(model, found, expected):
    """How far off the worst is, as a share of the largest, each against its own doubt from the logs alone."""
    size = np.sqrt(np.diag(model.covariance))
    live = size > 0.0
    return np.max(np.abs((found - expected)[live] / size[live])) / np.max(np.abs(expected[live] / size[live]))


def test_every_common_input_is_tried(model):
    assert set(model.inputs.names) == set(CASES)


@pytest.mark.slow
@pytest.mark.parametrize("name", EACH)
def test_an_input_moves_the_parameters_as_far_as_logs_that_are_spoilt_by_it(model, spoilt, name):
    step = 1e-4  # more would be seen in the residuals, and rows be weighed anew
    up, down = (spoilt(name, size)[1] for size in (step, -step))
    moved = (up.solution.unbounded.x - down.solution.unbounded.x) / (2.0 * step)
    assert astray(model, moved, model.inputs.moved[:, model.inputs.names.index(name)]) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", EACH)
def test_an_input_moves_the_supporting_torque_as_far_as_logs_that_are_spoilt_by_it(
    biped, model, spoilt, suit, wander, name
):
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    step = 1e-3 if name == "clock.imu" else 1e-4  # a tenth of a millisecond drowns in the noise of accelerations
    found = []
    for size in (step, -step):
        spoil, again = spoilt(name, size)
        found.append(balance(again, again.prepare(spoil(worn)), EVERY).torque[samples])
    prepared, change = model.prepare(worn), (found[0] - found[1]) / (2.0 * step)
    column = model.equations.size + model.inputs.names.index(name)
    expected = np.stack([slope[:, column] for _, slope in slopes(model, prepared, samples, EVERY)], axis=1)
    steady = balance(model, prepared, EVERY).steady[samples]
    # The zero of a joint beyond which none follows is what its link weighs elsewhere: all but a hundredth of it goes.
    equations, phi = model.equations, model.solution.solved.x[: model.equations.base_size]
    taken_off = common_columns(equations, prepared, samples, model.cutoff_hz, phi)[:, model.inputs.names.index(name)]
    directly = np.abs(taken_off[:, equations.layout.told.axes]).max()
    assert np.abs(change - expected)[steady].max() < max(0.1 * np.abs(expected).max(), 0.01 * directly)


@pytest.mark.slow
@pytest.mark.parametrize("joint", [name for name in ORDER if name.startswith("torso")])
def test_where_a_urdf_puts_a_joint_is_taken_up_by_what_its_links_weigh(biped, robot, logs, suit, wander, joint):
    """So that no place of a joint has to be declared: of the moment that its weight has on that way, little is left."""
    parent, child, xyz, axis = JOINTS[joint]
    moved = {**JOINTS, joint: (parent, child, tuple(each + 0.001 for each in xyz), axis)}
    elsewhere = replace(robot, tree=load_tree(urdf(moved), joints=ORDER, base_link="pelvis", floating=True))
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    models = [identified(each, logs) for each in (robot, elsewhere)]
    torques = [balance(each, each.prepare(worn), EVERY) for each in models]
    steady, change = torques[0].steady[samples], (torques[1].torque - torques[0].torque)[samples]
    weight = 9.81 * sum(BODIES[link][0] for link in ("waist", "chest") if link in (child, "chest"))
    assert np.abs(change)[steady].max() < 0.07 * 0.001 * weight


@pytest.mark.slow
def test_zeros_and_motors_of_one_log_move_the_parameters_as_far_as_is_said(biped, robot, logs):
    """Friction drifts by the same rule, and is held by the torque that it makes (below)."""
    log, squares = logs[0], {"ft_zero": 0.0, "kt_drift": 0.0}
    model = identified(robot, [log])
    for sensor in biped.robot.contacts:
        for each in FORCES:
            std, name = (
                DECLARED.ft_zero_force if each[0] == "f" else DECLARED.ft_zero_moment,
                f"ft.{sensor.name}.{each}",
            )
            again = identified(robot, [changed(log, {name: log.channels[name] + 0.02 * std})])
            squares["ft_zero"] += ((again.solution.unbounded.x - model.solution.unbounded.x) / 0.02) ** 2
    for joint in biped.robot.joints:
        name, step = f"i.{joint.name}", 0.1
        again = identified(robot, [changed(log, {name: log.channels[name] / (1.0 + step * DECLARED.kt_drift)})])
        squares["kt_drift"] += ((again.solution.unbounded.x - model.solution.unbounded.x) / step) ** 2
    for name, square in squares.items():
        assert astray(model, np.sqrt(square), np.sqrt(np.diag(model.inputs.by_log[name]))) < 0.15


def moved(robot, model, spoilt, step):
    """(P,) of x per unit of what spoils the logs that `model` is of."""
    return (identified(robot, spoilt).solution.unbounded.x - model.solution.unbounded.x) / step


def gone(log):
    """(R,) how far the courses have gone by the middle of a log, as 0013 and 0026 have it."""
    now, end = STARTED[log.name] + float(log.time.mean()), STARTED["later"]
    warming, first = np.array(DEFAULT_DOUBTS.warming_s), STARTED["log1"]
    return np.expm1(-(now - first) / warming) / np.expm1(-(end - first) / warming)


@pytest.mark.slow
def test_through_a_known_session_motors_drift_by_its_courses(biped, robot, logs, model):
    """One share less in the first log and as much more in the second, of each motor: k_T is what it was between."""
    assert logs[0].time[-1] == logs[1].time[-1]
    square, step = 0.0, 0.05
    for joint in biped.robot.joints:
        name = f"i.{joint.name}"
        spoilt = [
            changed(log, {name: log.channels[name] / (1.0 + sign * step * DECLARED.kt_drift)})
            for sign, log in zip((-1.0, 1.0), logs, strict=True)
        ]
        square = square + moved(robot, model, spoilt, step) ** 2
    half = 0.5 * (gone(logs[1]) - gone(logs[0]))
    expected = np.sqrt(square * np.mean(half**2))
    known = identified(robot, logs, STARTED)
    assert astray(known, expected, np.sqrt(np.diag(known.inputs.by_log["kt_drift"]))) < 0.1


@pytest.mark.parametrize("name", ["kt_drift", "viscous_drift", "coulomb_drift"])
def test_what_one_fitted_log_of_a_known_session_was_recorded_with_is_what_drifts_are_counted_from(robot, logs, name):
    alone = identified(robot, logs[:1], {"log1": 0.0, "later": 900.0})
    assert name not in alone.inputs.by_log
    assert name in identified(robot, logs[:1]).inputs.by_log


@pytest.mark.slow
def test_zeros_that_were_taken_once_are_none_as_the_session_begins(biped, robot, logs, model):
    taken = replace(robot, declared=replace(DECLARED, zeros_taken="session"))
    square, step, courses = 0.0, 0.02, [gone(log) for log in logs]
    for sensor in biped.robot.contacts:
        for each in FORCES:
            size = DECLARED.ft_zero_force if each[0] == "f" else DECLARED.ft_zero_moment
            name, by_log = f"ft.{sensor.name}.{each}", list[np.ndarray]()
            for k, log in enumerate(logs):
                spoilt = [*logs]
                spoilt[k] = changed(log, {name: log.channels[name] + step * size})
                by_log.append(moved(robot, model, spoilt, step))
            square = square + np.mean(np.tensordot(courses, by_log, (0, 0)) ** 2, axis=0)
    known = identified(taken, logs, STARTED)
    assert astray(known, np.sqrt(square), np.sqrt(np.diag(known.inputs.by_log["ft_zero"]))) < 0.15


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "declared"), [("k_d", "viscous_drift"), ("tau_c", "coulomb_drift")])
def test_a_motor_that_rubs_more_in_the_log_with_the_device_takes_from_the_support(
    biped, model, suit, wander, friction, declared
):
    more = getattr(DECLARED, declared)
    rubs = replace(biped, xi=biped.xi | {friction: biped.xi[friction] * (1.0 + more)})
    usual, other = (each.record(wander(5), "worn", bands=suit.bands).log for each in (biped, rubs))
    known = replace(model, identified=replace(model.identified, xi=biped.known().identified.xi))
    prepared, samples = known.prepare(usual), np.arange(100, 700, 20)
    before, after = (balance(known, known.prepare(log), EVERY) for log in (usual, other))
    expected = of_this_log(known, prepared, samples, EVERY)[declared]
    for joint in biped.torso:
        steady = before.steady[samples, joint]
        change = (after.torque - before.torque)[samples, joint][steady]
        assert np.abs(change).max() > 0.02
        np.testing.assert_allclose(change, expected[steady, joint, joint], rtol=0.05, atol=0.01)


def test_a_motor_that_drifts_in_the_log_with_the_device_is_taken_for_support(biped, model, suit, wander):
    worn = biped.record(wander(5), "worn", bands=suit.bands).log
    joint = biped.robot.joints[biped.torso[0]].name
    spoilt = changed(worn, {f"i.{joint}": worn.channels[f"i.{joint}"] / (1.0 + DECLARED.kt_drift)})
    prepared, samples = model.prepare(worn), np.arange(100, 700, 20)
    change = balance(model, model.prepare(spoilt), EVERY).torque - balance(model, prepared, EVERY).torque
    expected = of_this_log(model, prepared, samples, EVERY)["kt_drift"][:, biped.torso[0], biped.torso[0]]
    np.testing.assert_allclose(change[samples, biped.torso[0]], expected, rtol=0.02, atol=1e-3)


def test_a_zero_in_the_log_with_the_device_is_taken_for_support_of_the_leg_above(biped, model, suit, wander):
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    name = "ft.r_foot.fx"
    spoilt = changed(worn, {name: worn.channels[name] + DECLARED.ft_zero_force})
    prepared = model.prepare(worn)
    change = balance(model, model.prepare(spoilt), EVERY).torque - balance(model, prepared, EVERY).torque
    place = [sensor.name for sensor in biped.robot.contacts].index("r_foot")
    expected = of_this_log(model, prepared, samples, EVERY)["ft_zero"][:, :, 6 * place]
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(change[samples], expected, atol=1e-6)


def test_parameters_are_doubted_by_what_is_declared_beside_what_the_logs_scatter(biped, robot, logs, model):
    alone = identified(biped.robot, logs)
    more = model.inputs.alike + sum(model.inputs.by_log.values())
    np.testing.assert_allclose(model.covariance, alone.covariance + more, rtol=1e-6, atol=1e-12)


def test_a_gain_of_all_sensors_moves_everything_in_proportion(biped, robot, logs, model):
    """Linearity: what forces read too much of, masses and k_T are too large by, as far as the logs decide them."""
    moved = model.inputs.moved[:, model.inputs.names.index("ft_gain_common")]
    gains = model.solution.gains.columns
    np.testing.assert_allclose(moved[gains], model.solution.unbounded.x[gains], rtol=0.02)


NAMES = ["torso_pitch", "torso_yaw"]


def problem(biped, bands, evidences):
    columns = np.array([biped.robot.tree.joints.index(name) for name in NAMES])
    logs = rows_with(evidences, "B", columns, NAMES, biped.known().cutoff_hz)
    wires = band_wires(logs, Routing(biped.robot.tree, bands))
    setting = Setting(logs, wires, logs.used / 0.09, float(logs.used.sum()), Belief(np.zeros(3), np.zeros((3, 3))))
    return setting, fit(setting, best_start(setting, starts(shared(bands), wires, ())))


def in_nothing(model, logs, doubts=None):
    """What is found on two runs of one motion without a device. doubts: what is known of it, where that is asked."""
    names = [joint.name for joint in model.robot.joints]
    runs = [Plain(balance(model, model.prepare(log), EVERY), Posture(log, names), "wander") for log in logs]
    return repeatability(runs, np.ones(len(EVERY)), SupportSettings(), doubts)


@pytest.mark.slow
@pytest.mark.parametrize(("taken", "p"), [(None, DEFAULT_DOUBTS.partner_alike), ("log", 0.0)])
def test_what_is_declared_does_not_count_again_where_logs_without_the_device_show_it(biped, wander, taken, p):
    """Zeros of both feet drawn as declared, alike in two runs as partners' are, or not at all where they were taken
    anew before each log: means in steady motion scatter as much as is taken off them, and samples too."""
    nothing_else = replace(
        DECLARED, ft_gain=0.0, ft_gain_common=0.0, kt_drift=0.0, viscous_drift=0.0, coulomb_drift=0.0
    )
    stated = replace(nothing_else, zeros_taken=taken)
    model = replace(biped, robot=replace(biped.robot, declared=stated)).known()
    rng, draws = np.random.default_rng(0), 40
    clean = [biped.record(wander(1, base_seed=k), f"run{k}").log for k in range(2)]
    names = [f"ft.{sensor.name}.{each}" for sensor in biped.robot.contacts for each in FORCES]
    size = np.tile(np.repeat([DECLARED.ft_zero_force, DECLARED.ft_zero_moment], 3), len(biped.robot.contacts))
    scattered, left = {"a": [], "b": [], "paired": []}, {"a": [], "b": [], "paired": []}
    samples = {True: [], False: []}
    for _ in range(draws):
        zeros = (np.sqrt(p) * rng.normal(size=len(names)) + np.sqrt(1.0 - p) * rng.normal(size=(2, len(names)))) * size
        runs = [
            changed(log, {name: log.channels[name] + zero for name, zero in zip(names, each, strict=True)})
            for log, each in zip(clean, zeros, strict=True)
        ]
        for squares, doubts in ((scattered, None), (left, Doubts(model, EVERY))):
            for approach, found in in_nothing(model, runs, doubts).by_approach.items():
                squares[approach].append(found.mean**2)
                samples[doubts is None].append((found.steady if doubts is None else found.beyond["steady"]) ** 2)
    legs = biped.places(*(f"{side}_{joint}" for side in "lr" for joint in ("hip", "knee")))
    for approach, squares in scattered.items():
        of_legs = np.mean(squares, axis=0)[legs]
        share = np.mean(left[approach], axis=0)[legs] / of_legs
        assert of_legs.min() > 0.01
        # of a normal number's square .22 lie beyond its own variance where it is more than two standard deviations
        assert share.max() < 0.45
    own = balance(model, model.prepare(clean[0]), EVERY)
    sloped = sloped_samples(own.prepared)
    doubts = Doubts(model, EVERY)
    taken_off = doubts.of_means(doubts.inputs(own.prepared, sloped), sloped, own.steady & ~own.left_out[:, None])[legs]
    there = np.mean(scattered["b"], axis=0)[legs]
    assert np.all((0.6 * taken_off < there) & (there < 1.6 * taken_off))  # nor is more taken off than there is
    of_samples, beyond = (np.mean(samples[bare], axis=0)[legs] for bare in (True, False))
    assert np.all(beyond < 0.45 * of_samples)


@pytest.mark.slow
def test_what_nobody_declared_stays_where_logs_without_the_device_show_it(biped, model, wander):
    """Friction that the model does not know, one way only, at the left knee."""
    knee = biped.places("l_knee")[0]
    unknown = 5.0 * np.eye(len(EVERY))[knee]
    runs = [
        biped.record(wander(1, base_seed=k), f"run{k}", extra=lambda speed: np.zeros_like(speed) + unknown).log
        for k in range(2)
    ]
    for doubts in (None, Doubts(model, EVERY)):
        assert in_nothing(model, runs, doubts).b.mean[knee] == pytest.approx(5.0, rel=0.05)


@pytest.fixture(scope="module")
def worn(suit, make_evidence, wander):
    return [make_evidence(suit, wander(seed), 0.3, seed=seed) for seed in (1, 2)]


@pytest.mark.parametrize("anew", [False, True])
def test_what_drifts_through_a_session_hardly_averages_out_over_its_logs(biped, suit, worn, anew):
    """One motion in one log, and twice: errors of each log alone are half of the variance, those alike all."""
    drift = np.zeros((len(worn[0].sloped), len(NAMES), 1), dtype=np.float32)
    drift[:, 0, 0] = np.sin(np.linspace(0.0, 9.0, len(drift)))
    inputs = replace(worn[0].inputs_b, own={"ft_zero": drift}, anew=frozenset({"ft_zero"} if anew else ()))
    drifting = replace(worn[0], inputs_b=inputs)
    one, two = (contributions(*problem(biped, suit.bands, [drifting] * times), {})["ft_zero"] for times in (1, 2))
    share = 0.5 if anew else DEFAULT_DOUBTS.alike + 0.5 * (1.0 - DEFAULT_DOUBTS.alike)
    np.testing.assert_allclose(two, share * one, rtol=1e-5, atol=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("anew", [False, True])
def test_of_what_is_anew_in_each_log_means_over_logs_average_out_more(biped, model, anew):
    inputs = Inputs(
        np.zeros((4, model.equations.size + len(model.inputs.names)), dtype=np.float32),
        own={"ft_zero": np.full((4, 2), 1.5, dtype=np.float32)},
        anew=frozenset({"ft_zero"} if anew else ()),
    )
    found = variance_of_mean(model, [(inputs, np.full(4, 0.25))] * 3)["ft_zero"]
    alike = 0.0 if anew else DEFAULT_DOUBTS.alike
    assert found == pytest.approx(2 * 1.5**2 * (alike + (1.0 - alike) / 3.0), rel=1e-6)


def drawn_bands(bands, rng, std):
    """With via points drawn about where they are described."""
    return tuple(
        replace(band, via_points=tuple(
            replace(point, xyz=tuple(np.array(point.xyz) + std * rng.normal(size=3))) for point in band.via_points
        ))
        for band in bands
    )  # fmt: skip


def test_what_is_fitted_beside_the_bands_moves_the_torque_as_via_points_and_lengths_do(biped, suit, worn):
    """Via points drawn as declared, and bands as long as they were put on: RMS over draws of what that adds to the
    torque, against the same of the columns."""
    bands = tuple(replace(band, point_std=0.002, donning_std=0.001) for band in suit.bands)
    setting, fitted = problem(biped, bands, worn)
    added, rng, squares = nuisance_torques(setting, fitted), np.random.default_rng(0), []
    k, l_0 = zip(*(fitted.wear.spring(b) for b in range(2)), strict=True)

    def torque(moved):
        wires = band_wires(setting.logs, Routing(biped.robot.tree, moved))
        pulls = np.array(k) * stretches(wires, np.array(l_0))
        return sum(wire.jacobian * pulls[:, [b]] for b, wire in enumerate(wires))

    as_described = torque(bands)
    for _ in range(60):
        moved = drawn_bands(bands, rng, 0.002)
        longer = 0.001 * rng.normal(size=(2, len(worn)))
        _, taut = stretches_and_taut(setting.wires, l_0)
        one = sum(wire.jacobian * (k[b] * taut[:, b] * longer[b, setting.logs.log])[:, None]
                  for b, wire in enumerate(setting.wires))  # fmt: skip
        squares.append((torque(moved) - as_described + one) ** 2)
    used = setting.logs.used
    drawn, found = (
        np.sqrt(np.mean(np.where(used, each, 0.0), axis=0))
        for each in (np.mean(squares, axis=0), np.sum(added.times(np.eye(added.values.shape[2])) ** 2, axis=2))
    )
    np.testing.assert_allclose(found, drawn, rtol=0.2)


@pytest.mark.slow
def test_springs_of_bands_that_sit_otherwise_than_described_are_found_better_and_doubted_as_much(biped, suit, worn):
    """With little noise: what a fit that knows of no doubt errs by is where the via points are."""
    rng, std, noise = np.random.default_rng(3), 0.005, 0.05
    nothing, sigma = np.zeros((biped.known().equations.size,) * 2), np.full(len(NAMES), noise)
    beside, only = (tuple(replace(band, point_std=each, donning_std=0.0) for band in suit.bands) for each in (std, 0.0))
    setting, _ = problem(biped, beside, worn)
    true = [band.stiffness for band in suit.bands]
    errors, deviations = [], []
    for _ in range(16):
        wires = band_wires(setting.logs, Routing(biped.robot.tree, drawn_bands(beside, rng, std)))
        pulls = np.array(true) * stretches(wires, np.array([band.natural_length for band in suit.bands]))
        torque = -sum(wire.jacobian * pulls[:, [b]] for b, wire in enumerate(wires))
        torque = torque + noise * rng.normal(size=torque.shape)
        spans = setting.logs.spans
        parts = [replace(each, torque=torque[span]) for each, span in zip(setting.logs.logs, spans, strict=True)]
        logs = WearLogs(parts, setting.logs.joints, setting.logs.names)
        found = []
        for bands in (beside, only):
            described = band_wires(logs, Routing(biped.robot.tree, bands))
            seen, _ = fit_device(replace(suit, bands=bands), logs, described, None, nothing, sigma)
            found.append(seen)
        errors.append([seen.fitted.wear.springs[0] - true[0] for seen in found])
        deviations.append(errors[-1][0] / np.sqrt(found[0].covariance(found[0].fitted)[0, 0]))
    better, worse = np.sqrt(np.mean(np.square(errors), axis=0))
    assert better < 0.9 * worse
    assert 0.6 < np.sqrt(np.mean(np.square(deviations))) < 1.4


@pytest.mark.slow
def test_via_points_and_donning_move_the_bands_as_far_as_they_do_when_they_are_moved(biped, suit, worn):
    bands = tuple(replace(band, point_std=0.002, donning_std=0.001) for band in suit.bands)
    setting, fitted = problem(biped, bands, worn)
    found = contributions(setting, fitted, {})
    square = np.zeros(3)
    for b, band in enumerate(bands):
        for p, point in enumerate(band.via_points):
            for axis in range(3):
                xyz = tuple(x + 0.002 * (axis == k) for k, x in enumerate(point.xyz))
                points = (*band.via_points[:p], replace(point, xyz=xyz), *band.via_points[p + 1 :])
                moved = tuple(replace(band, via_points=points) if k == b else one for k, one in enumerate(bands))
                square += (problem(biped, moved, worn)[1].wear.theta - fitted.wear.theta) ** 2
    np.testing.assert_allclose(np.sqrt(np.diag(found["via_points"])), np.sqrt(square), rtol=0.15)
    square, step = np.zeros(3), 1e-5  # more, and samples enter or leave the stretch
    for b in range(2):
        k, l_0 = fitted.wear.spring(b)
        longer = np.subtract(*stretches([setting.wires[b]] * 2, np.array([l_0 - step, l_0])).T)
        for log in range(2):
            in_one = np.where(setting.logs.log == log, k * longer, 0.0)
            pulled = setting.logs.torque.copy()
            setting.logs.torque -= setting.wires[b].jacobian * in_one[:, None]
            square += ((fit(setting, fitted.wear).wear.theta - fitted.wear.theta) * (0.001 / step)) ** 2
            setting.logs.torque = pulled
    np.testing.assert_allclose(np.sqrt(np.diag(found["donning"])), np.sqrt(square), rtol=0.15)
