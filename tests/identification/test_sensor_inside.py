"""Force/torque sensors inside the robot: what hangs beyond them and their zeros come back, whatever their sign."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from tests.sensor_arm import COMPONENTS, JOINTS, SENSOR_NOISE, Sensor, describe, record, truth, wrist

from exogauge.effects.payload import EFFECT as PAYLOAD
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification, Parameter
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import LinkSite
from exogauge.remarks import About
from exogauge.robots.cuts import in_sensor, mass_columns
from exogauge.robots.description import Robot
from exogauge.robots.kinematics import Kinematics
from exogauge.robots.regressor import inverse_dynamics
from exogauge.studies.report.report_tables import sensor_table
from exogauge.studies.results.document import sensor_entries, summaries

SETTINGS = Settings(cutoff_hz=8.0)
LONG = 25.0  # [s] of a log
INERTIAL = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
SURE = 3.5  # standard deviations: of 60 numbers, one in forty lies beyond
FOOT = Sensor("foot", "foot_ft", "world_on_robot", np.array([3.0, -2.0, 5.0, 0.2, 0.3, -0.1]))

Identified = tuple[Robot, Identification]
Identify = Callable[..., Identified]


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory) -> Identify:
    """(sensors, seed, sensors that the logs are made with) -> the arm from two logs, and one held out."""

    def make(sensors: Sequence[Sensor], seed: int = 1, made_with: Sequence[Sensor] | None = None) -> Identified:
        robot = describe(tmp_path_factory.mktemp("arm"), sensors)
        logs = [record(100 * seed + k, made_with or sensors, LONG) for k in range(3)]
        return robot, identify(robot, [Recording(log, k == 2) for k, log in enumerate(logs)], SETTINGS)

    return make


@pytest.fixture(scope="module")
def on_wrist(identified: Identify) -> Identified:
    return identified([wrist()])


@pytest.fixture(scope="module")
def without(identified: Identify) -> Identified:
    """The same logs; nobody knows of the sensor."""
    return identified([], made_with=[wrist()])


@pytest.mark.slow
def test_a_load_on_the_tool_takes_off_every_row_what_its_mass_asks_of_it(on_wrist: Identified) -> None:
    robot, found = on_wrist
    tree, equations = robot.tree, found.model.equations
    body = tree.bodies.index("tool")
    prepared = found.model.prepare(record(7, [wrist()], 5.0))
    columns = LinkSite(body).see(found.model, prepared).columns(PAYLOAD, (1.0,))
    kinds = LinkSite(body).kinds(equations)
    assert kinds == (*range(4), *range(8, 14))  # motors and the sensor
    phi = np.zeros((4, *tree.phi.shape))
    phi[range(4), body, range(4)] = 1.0
    torque = np.stack([inverse_dynamics(tree, prepared.motion, each) for each in phi], axis=1)
    assert np.abs(torque[:, :, 1]).max() > 1.0
    np.testing.assert_allclose(columns[:, :, :4], -torque, atol=1e-9)
    sweep = Kinematics(tree).sweep(prepared.motion)
    reading = in_sensor(tree, "wrist_ft", sweep, mass_columns(4 * body + np.arange(4), sweep))
    np.testing.assert_allclose(columns[:, :, 4:], -reading.transpose(2, 1, 0), atol=1e-9)


def named(found: Identification) -> dict[str, Parameter]:
    return {parameter.name: parameter for parameter in found.parameters}


def errors(found: Identification, known: dict[str, float]) -> dict[str, float]:
    """Of every number that the data decide, in its own standard deviations."""
    result = {}
    for each in found.parameters:
        true = known.get(each.name)
        if each.combination:
            true = sum(factor * known[name] for name, factor in each.combination.items())
        if true is not None and each.identifiable and each.std > 0.0 and not each.name.startswith("tau_s"):
            result[each.name] = (each.value - true) / each.std
    return result


def test_all_ten_numbers_of_the_tool_and_six_of_the_zero_come_back(on_wrist: Identified) -> None:
    robot, found = on_wrist
    z, parameters, known = errors(found, truth(robot, [wrist()])), named(found), truth(robot, [wrist()])
    wanted = [f"{name}[tool]" for name in INERTIAL] + [f"zero.{component}[wrist]" for component in COMPONENTS]
    assert z.keys() >= set(wanted)
    assert max(abs(z[name]) for name in wanted) < SURE
    assert parameters["m[tool]"].std < 1e-3 * known["m[tool]"]
    assert abs(parameters["m[tool]"].prior - known["m[tool]"]) > 20.0 * parameters["m[tool]"].std  # the maker was wrong


def test_every_combination_of_bodies_before_and_beyond_comes_back(on_wrist: Identified) -> None:
    robot, found = on_wrist
    z = errors(found, truth(robot, [wrist()]))
    combined = [value for name, value in z.items() if name.startswith("base[")]
    assert len(combined) >= 30
    assert max(map(abs, combined)) < SURE + 0.5
    assert 0.6 < np.sqrt(np.mean(np.square(combined))) < 1.5


def test_the_tool_and_the_link_before_it_are_told_apart(on_wrist: Identified, without: Identified) -> None:
    """Without the sensor they are one body, and its first moment is all that joints show."""
    (robot, found), (plain, less) = on_wrist, without
    assert "tool" in robot.tree.bodies
    assert "tool" not in plain.tree.bodies
    known, parameters = truth(robot, [wrist()]), named(found)
    for name in ("mz[l4]", "mz[tool]"):
        assert parameters[name].identifiable
        assert parameters[name].std < 0.01 * abs(known[name])
        assert parameters[name].value == pytest.approx(known[name], abs=SURE * parameters[name].std)
    whole = named(less)["mz[l4]"]
    assert whole.value == pytest.approx(truth(plain, [])["mz[l4]"], abs=SURE * whole.std)
    assert whole.value > 2.0 * parameters["mz[l4]"].value


def test_joints_alone_say_the_same_of_the_joints(on_wrist: Identified, without: Identified) -> None:
    with_sensor, alone = (named(each[1]) for each in (on_wrist, without))
    for kind in ("k_d", "tau_c", "tau_o"):
        for joint in JOINTS:
            one, other = (each[f"{kind}[{joint}]"] for each in (with_sensor, alone))
            assert abs(one.value - other.value) < SURE * np.hypot(one.std, other.std)
            assert one.std < 1.2 * other.std  # what the sensor adds takes nothing away


@pytest.mark.parametrize("said", ["payload_on_sensor", "sensor_on_payload"])
def test_both_signs_give_the_same_tool_and_the_zero_of_the_log(identified: Identify, said: str) -> None:
    sensor = wrist(said)
    robot, found = identified([sensor], seed=2)
    z = errors(found, truth(robot, [sensor]))
    assert max(abs(z[f"{name}[tool]"]) for name in INERTIAL) < SURE
    assert max(abs(z[f"zero.{component}[wrist]"]) for component in COMPONENTS) < SURE


def test_a_sign_stated_wrongly_is_seen_at_once(identified: Identify) -> None:
    _, found = identified([wrist("sensor_on_payload")], made_with=[wrist("payload_on_sensor")])
    fit = next(each for each in found.validation if each.held_out and each.channel == "ft.wrist.fz")
    assert fit.rmse_prior > 50.0 * fit.noise_floor
    (remark,) = [each for each in found.remarks if each.about == About.NEGATIVE_MASS]
    assert remark.names == ("tool",)
    assert remark.each[0][0] < 0.0
    assert named(found)["m[tool]"].value > 0.0  # a body all the same


def test_a_sign_stated_rightly_is_not_doubted(on_wrist: Identified) -> None:
    assert About.NEGATIVE_MASS not in [each.about for each in on_wrist[1].remarks]


def test_held_out_readings_are_predicted_down_to_their_noise(on_wrist: Identified) -> None:
    _, found = on_wrist
    fits = {each.channel: each for each in found.validation if each.held_out}
    for component, noise in zip(COMPONENTS, SENSOR_NOISE, strict=True):
        fit = fits[f"ft.wrist.{component}"]
        assert fit.unit == ("N" if component[0] == "f" else "N·m")
        assert fit.noise_floor == pytest.approx(noise, rel=0.15)
        assert fit.rmse_identified < 1.1 * fit.noise_floor
        assert fit.rmse_prior > 2.0 * fit.noise_floor


@pytest.mark.slow
def test_a_sensor_under_the_robot_sees_all_of_it(identified: Identify) -> None:
    robot, found = identified([FOOT])
    z, known, parameters = errors(found, truth(robot, [FOOT])), truth(robot, [FOOT]), named(found)
    assert robot.tree.cuts["foot_ft"] == tuple(range(len(robot.tree.bodies)))
    combined = [value for name, value in z.items() if name.startswith("base[")]
    assert len(combined) >= 20
    assert max(map(abs, combined)) < SURE + 0.5
    for component in ("fx", "fy", "mz"):  # across gravity, where no weight can stand in for a zero
        zero = parameters[f"zero.{component}[foot]"]
        assert zero.std < 0.01
        assert zero.value == pytest.approx(known[f"zero.{component}[foot]"], abs=SURE * zero.std)
    assert parameters["zero.fz[foot]"].std > 1.0  # the robot's weight can, and the doubt says so


@pytest.mark.slow
def test_two_sensors_agree_on_what_both_carry(identified: Identify) -> None:
    sensors = [wrist(), FOOT]
    robot, found = identified(sensors)
    z = errors(found, truth(robot, sensors))
    assert robot.tree.cuts["wrist_ft"] == (robot.tree.bodies.index("tool"),)
    combined = [value for name, value in z.items() if name.startswith(("base[", "zero."))]
    assert max(map(abs, combined)) < SURE + 0.5


def test_tables_hold_the_zero_and_what_the_sensor_carries(on_wrist: Identified) -> None:
    robot, found = on_wrist
    (entry,), (column,) = sensor_entries(found, robot), sensor_table(found, robot)
    assert (entry["sensor"], entry["carries"]) == ("wrist", ["tool"])
    assert tuple(entry["zero"]) == tuple(column.zero) == COMPONENTS
    assert entry["zero"]["fx"]["value"] == named(found)["zero.fx[wrist]"].value
    assert [entry["zero"][name]["unit"] for name in ("fx", "mz")] == ["N", "N·m"]
    kinds = {each.kind: each for each in summaries(found, list(JOINTS))}
    assert kinds["sensor_force"].channels == ("ft.wrist.fx", "ft.wrist.fy", "ft.wrist.fz")
    assert kinds["sensor_moment"].unit == "N·m"
    assert kinds["sensor_moment"].rmse_identified < kinds["sensor_moment"].rmse_prior


@pytest.mark.slow
def test_standard_deviations_hold_over_ten_robots_runs(identified: Identify) -> None:
    """Of the tool's ten numbers and the zero's six, over ten seeds."""
    wanted = [f"{name}[tool]" for name in INERTIAL] + [f"zero.{component}[wrist]" for component in COMPONENTS]
    z = []
    for seed in range(10, 20):
        robot, found = identified([wrist()], seed)
        own = errors(found, truth(robot, [wrist()]))
        z.append([own[name] for name in wanted])
    each = np.array(z)
    assert 0.75 < np.sqrt(np.mean(each**2)) < 1.35
    assert np.mean(np.abs(each) < 2.0) > 0.88
    assert np.abs(each).max() < 5.0
