"""What a sensor inside the robot, its base or its IMU does wrong is named first, where it is; else nothing is.

The logs are made without our code, and every hidden form is another one than the catalogue's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.signal import butter, sosfiltfilt
from tests.sensor_arm import GRAVITY, Reading, describe, record, truth, wrist

from exogauge.detect.pipeline import Found, find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree

pytestmark = pytest.mark.slow

SETTINGS = Settings(cutoff_hz=8.0)
SEEDS = (1, 2, 3)  # of the logs; the last one is held out
LONG = 25.0  # [s]
Search = Callable[..., Found]


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> Search:
    """(what the wrist's sensor does, gravity in the base's frame, which way it reads, logs) -> what the search says."""

    def run(
        spoiled: Reading | None = None,
        gravity: np.ndarray = GRAVITY,
        sees: str = "payload_on_sensor",
        seeds: tuple[int, ...] = SEEDS,
    ) -> Found:
        sensors = [wrist(sees)]
        robot = describe(tmp_path_factory.mktemp("arm"), sensors)
        spoil: Mapping[str, Reading] = {} if spoiled is None else {"wrist": spoiled}
        return searched(robot, [record(seed, sensors, LONG, gravity, spoil) for seed in seeds])

    return run


def searched(robot: Robot, logs: list[Log]) -> Found:
    recordings = [Recording(log, k == len(logs) - 1) for k, log in enumerate(logs)]
    return find_missing_effects(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS)


def named(found: Found) -> list[tuple[str, str, str, str]]:
    findings = found.discrepancy.findings
    return [(each.effect, each.place.kind, each.place.name, each.place.part) for each in findings]


def on(component: int, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Reading:
    """(t, all components) -> what this component reads too much."""
    return lambda t, w: w + change(t, w)[:, None] * (np.arange(6) == component)


def softening_gain(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    """A spring that gets stiffer under load: 9 % too much near zero, 7 % at 15 N."""
    return 0.09 * w[:, 1] / np.sqrt(1.0 + (w[:, 1] / 20.0) ** 2)


def bent_leak(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Of the force along z into that along x, more of a pull than of a push."""
    return 0.06 * w[:, 2] + 0.0006 * w[:, 2] ** 2


def hyperbola(t: np.ndarray, _w: np.ndarray) -> np.ndarray:
    """Warming up by a power of time, not by an exponential."""
    return 0.24 * (1.0 - 1.0 / (1.0 + t / 7.0) ** 1.3)


def one_way(found: Found, name: str) -> float:
    return found.discrepancy.findings[0].parameters[name].value


@pytest.mark.parametrize("sees", ["payload_on_sensor", "sensor_on_payload"])
def test_a_wrong_gain_of_one_axis_is_named_there(search: Search, sees: str) -> None:
    found = search(on(1, softening_gain), sees=sees)
    assert named(found)[0] == ("ft_gain", "sensor", "wrist", "fy")
    assert one_way(found, "gain") == pytest.approx(0.08, abs=0.012)
    finding = found.discrepancy.findings[0]
    assert (finding.held_out.channel, finding.held_out.unit) == ("ft.wrist.fy", "N")
    shown = finding.evidence
    assert (shown.coordinate, shown.unit) == ("reading", "N")
    far = np.abs(shown.at) > 0.5 * np.abs(shown.at).max()
    assert np.all(np.sign(shown.model[far]) == np.sign(shown.at[far]))  # it reads too much, in the log's own sign
    assert np.abs(shown.after).max() < 0.5 * np.abs(shown.before).max()


def test_a_leak_from_one_axis_into_another_is_named_where_it_arrives(search: Search) -> None:
    found = search(on(0, bent_leak))
    assert named(found)[0] == ("ft_crosstalk", "sensor", "wrist", "fx")
    assert found.discrepancy.findings[0].parameters["other"].value == 2.0
    assert one_way(found, "leak") == pytest.approx(0.06, abs=0.015)


def test_a_zero_that_drifts_is_named_at_its_axis(search: Search) -> None:
    found = search(on(4, hyperbola), seeds=(1, 2, 3, 4, 5))
    assert named(found)[0] == ("ft_drift", "sensor", "wrist", "my")
    held_out = found.discrepancy.findings[0].held_out
    assert held_out.unit == "N·m"
    assert held_out.rmse_after < 1.15 * held_out.noise_floor


def test_a_base_that_stands_askew_is_named_with_its_angles(search: Search) -> None:
    """Turned as a whole, not to first order."""
    tilt = np.array([0.02, -0.03, 0.0])
    found = search(gravity=pin.exp3(tilt).T @ GRAVITY)
    assert named(found)[0] == ("base_tilt", "base", "base", "")
    worst = max(found.discrepancy.located, key=lambda each: each.rmse / each.noise_floor)
    assert found.discrepancy.findings[0].held_out.channel == worst.channel
    told = found.discrepancy.findings[0].parameters
    size = np.hypot(told["about_x"].value, told["about_y"].value)
    assert size == pytest.approx(np.hypot(*tilt[:2]), rel=0.1)


def test_what_is_identified_on_a_base_askew_is_as_true_as_on_one_that_stands(tmp_path: Path) -> None:
    """A turn that is taken to first order makes gravity longer by 1/cos: the tool was 27 standard deviations light."""
    sensors, tilt = [wrist()], np.array([0.1, -0.06, 0.0])
    robot = describe(tmp_path, sensors)
    found = searched(robot, [record(seed, sensors, LONG, pin.exp3(tilt).T @ GRAVITY) for seed in SEEDS])
    assert named(found) == [("base_tilt", "base", "base", "")]
    known = truth(robot, sensors)
    friction = [each for each in found.identification.parameters if each.name.startswith(("k_d[", "tau_c["))]
    far = [abs(each.value - known[each.name]) / each.std for each in friction]
    assert len(far) == 8
    assert sum(each < 1.96 for each in far) >= 7
    assert max(far) < 3.0
    told = found.discrepancy.findings[0].parameters
    for axis, angle in zip("xy", tilt[:2], strict=True):
        assert told[f"about_{axis}"].value == pytest.approx(-angle, rel=0.01)
    tool = next(each for each in found.identification.parameters if each.name == "m[tool]")
    assert tool.value == pytest.approx(known["m[tool]"], abs=3.0 * tool.std)


def zeroed_elsewhere(log: Log, joint: str, angle: float) -> Log:
    """The joint stands further by that angle than is read."""
    channel = f"q.{joint}"
    return replace(log, channels=log.channels | {channel: log.channels[channel] - angle})


@pytest.mark.parametrize(("joint", "angle"), [("j2", 0.05), ("j3", -0.03)])
def test_an_encoder_that_was_zeroed_elsewhere_is_named_with_its_angle(tmp_path: Path, joint: str, angle: float) -> None:
    """Masses and friction beside it are as true as if it were right; it was told as a spring of the next joint."""
    sensors = [wrist()]
    robot = describe(tmp_path, sensors)
    found = searched(robot, [zeroed_elsewhere(record(seed, sensors, LONG), joint, angle) for seed in SEEDS])
    assert named(found) == [("encoder_zero", "joint", joint, "")]
    told = found.discrepancy.findings[0].parameters["encoder_offset"]
    assert told.value == pytest.approx(angle, abs=3.0 * told.std)
    assert told.std < 0.002
    known = truth(robot, sensors)
    friction = [each for each in found.identification.parameters if each.name.startswith(("k_d[", "tau_c["))]
    assert max(abs(each.value - known[each.name]) / each.std for each in friction) < 3.0


def beside_the_axis(log: Log, joint: str, off: float) -> Log:
    """Read off a disc whose lines' centre is `off` of its radius beside the axis: by the triangle, no sine."""
    channel = f"q.{joint}"
    true = log.channels[channel]
    return replace(log, channels=log.channels | {channel: true - np.arcsin(off * np.sin(true + 0.7))})


@pytest.mark.parametrize(("joint", "off"), [("j2", 0.03), ("j3", 0.04)])
def test_a_disc_beside_its_axis_is_named_and_no_spring(tmp_path: Path, joint: str, off: float) -> None:
    """It was `unexplained`, or a zero: the rate and the acceleration that it reads wrongly were not looked at."""
    sensors = [wrist()]
    robot = describe(tmp_path, sensors)
    found = searched(robot, [beside_the_axis(record(seed, sensors, LONG), joint, off) for seed in SEEDS])
    assert named(found) == [("encoder_eccentricity", "joint", joint, "")]
    (finding,) = found.discrepancy.findings
    once = [finding.parameters[f"once_{each}"] for each in ("sin", "cos")]
    for told, true in zip(once, (off * np.cos(0.7), off * np.sin(0.7)), strict=True):
        assert told.value == pytest.approx(true, abs=max(3.0 * told.std, 0.05 * off))
    assert finding.held_out.rmse_after < 1.15 * finding.held_out.noise_floor


def test_a_spring_at_a_joint_is_no_eccentric_encoder(tmp_path: Path) -> None:
    """Wound about where it is slack, stiffer the further: it pulls with the angle, and never with the speed."""
    sensors = [wrist()]
    robot = describe(tmp_path, sensors)

    def pulled(log: Log) -> Log:
        away = log.channels["q.j2"] - 0.2
        return replace(log, channels=log.channels | {"tau.j2": log.channels["tau.j2"] + 4.0 * away + 0.5 * away**3})

    found = searched(robot, [pulled(record(seed, sensors, LONG)) for seed in SEEDS])
    assert "encoder_eccentricity" not in [name for name, *_ in named(found)]


@pytest.mark.parametrize("sees", ["payload_on_sensor", "sensor_on_payload"])
def test_nothing_is_named_where_nothing_is_wrong(search: Search, sees: str) -> None:
    found = search(sees=sees)
    assert named(found) == []
    assert found.discrepancy.verdict == "none"


def test_a_gain_that_all_axes_share_is_a_mass_and_no_fault_of_the_sensor(search: Search) -> None:
    """No data of these channels can tell one from the other."""
    assert not [each for each in named(search(lambda _t, w: 1.05 * w)) if each[1] in ("sensor", "base")]


@pytest.fixture(scope="module")
def trunk() -> Robot:
    """A body on a force plate that sways, with two joints; its IMU sits at the base link's origin."""
    tree = load_tree(BODY.encode(), joints=["a", "b"], base_link="base", floating=True, cut_frames=("plate",))
    joints = tuple(Joint(name, "torque") for name in ("a", "b"))
    plate = WrenchSensor("plate", "plate", "contact", 1.0)
    return Robot("trunk", tree, joints, pin.SE3.Identity(), (plate,), np.eye(2), inertial_std={"": 0.3})


LINK = (
    '<link name="{0}"><inertial><origin xyz="{1}"/><mass value="{2}"/>'
    '<inertia ixx="{3}" ixy="0" ixz="0" iyy="{4}" iyz="0" izz="{5}"/></inertial></link>'
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4}"/>'
    '<axis xyz="{5}"/><limit lower="-3" upper="3" effort="100" velocity="10"/></joint>'
)
BODY = "".join([
    '<robot name="trunk"><link name="plate"/>',
    LINK.format("base", "0.02 0.01 0.1", 12.0, 0.3, 0.25, 0.2),
    LINK.format("upper", "0.03 -0.02 0.2", 8.0, 0.2, 0.22, 0.08),
    LINK.format("arm", "0.02 0.04 0.25", 3.0, 0.08, 0.07, 0.02),
    JOINT.format("foot", "fixed", "base", "plate", "0 0 -0.4", "0 0 1"),
    JOINT.format("a", "revolute", "base", "upper", "0 0 0.3", "0 1 0"),
    JOINT.format("b", "revolute", "upper", "arm", "0.05 0.1 0.3", "1 0 0"), "</robot>",
])  # fmt: skip


def swaying(seed: int, late_s: float = 0.0) -> Log:
    """late_s: by how much the IMU's readings are stamped too late; shifted as a whole, not to first order."""
    rng, rate = np.random.default_rng(seed), 200.0
    t = np.arange(0.0, LONG, 1.0 / rate)
    ramp = np.clip(np.minimum(t, t[-1] - t) / 1.5, 0.0, 1.0)
    speed = ramp**3 * (10.0 - 15.0 * ramp + 6.0 * ramp**2)
    surge = np.where(t < 0.5 * LONG, 20.0, -20.0) * (ramp * (1.0 - ramp)) ** 2
    clock = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / rate])

    def waves(width: int, size: float, fastest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        omega, phase = 2.0 * np.pi * rng.uniform(0.1, fastest, (5, width)), rng.uniform(0.0, 6.28, (5, width))
        amplitude, angle = size * rng.uniform(0.5, 1.0, (5, width)), clock[:, None, None] * omega + phase
        rates, bends = np.sum(amplitude * omega * np.cos(angle), 1), -np.sum(amplitude * omega**2 * np.sin(angle), 1)
        return (
            np.sum(amplitude * np.sin(angle), 1),
            rates * speed[:, None],
            bends * speed[:, None] ** 2 + rates * surge[:, None],
        )

    q, dq, ddq = waves(2, 0.25, 0.7)
    tilt, turning, _ = waves(3, 0.05, 1.0)
    _, _, push = waves(3, 0.02, 1.2)
    model = pin.buildModelFromXML(BODY, pin.JointModelFreeFlyer())
    for body in range(1, model.njoints):
        own = model.inertias[body]
        model.inertias[body] = pin.Inertia(1.1 * own.mass, own.lever + 0.01, 1.15 * own.inertia)
    data, R = model.createData(), [pin.exp3(each) for each in tilt]
    gyro = np.array([pin.Jexp3(angle) @ rate_ for angle, rate_ in zip(tilt, turning, strict=True)])
    gyro_dot = np.gradient(gyro, t, axis=0, edge_order=2)
    acc = np.array([r.T @ (p - GRAVITY) for r, p in zip(R, push, strict=True)])
    model.gravity.linear = np.zeros(3)
    frame = model.getFrameId("plate")
    tau, plate = np.empty((len(t), 2)), np.empty((len(t), 6))
    for k in range(len(t)):
        full = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], q[k]])
        forces = pin.rnea(
            model,
            data,
            full,
            np.concatenate([np.zeros(3), gyro[k], dq[k]]),
            np.concatenate([acc[k], gyro_dot[k], ddq[k]]),
        )
        plate[k], tau[k] = model.frames[frame].placement.actInv(pin.Force(forces[:6])).vector, forces[6:]
    tau = tau + 0.6 * dq + 0.8 * np.sign(dq)

    def noisy(values: np.ndarray, std: float) -> np.ndarray:
        return values + std * rng.normal(size=values.shape)

    def stamped(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(t - late_s, t, column) for column in values.T], axis=1)

    channels = {f"{kind}.{joint}": values[:, j] for kind, values in (("q", noisy(q, 1e-5)), ("tau", noisy(tau, 0.05)))
                for j, joint in enumerate("ab")}  # fmt: skip
    for kind, values, std in (("acc", acc, 0.02), ("gyro", gyro, 0.002)):
        channels |= {
            f"{kind}.{axis}": column for axis, column in zip("xyz", noisy(stamped(values), std).T, strict=True)
        }
    wrench = plate + rng.normal(size=plate.shape) * np.repeat([0.3, 0.03], 3)
    names = ("fx", "fy", "fz", "mx", "my", "mz")
    return Log(f"log{seed}", t, channels | {f"ft.plate.{name}": wrench[:, k] for k, name in enumerate(names)})


def test_an_imu_that_is_stamped_late_is_named_with_its_delay(trunk: Robot) -> None:
    found = searched(trunk, [swaying(seed, 0.02) for seed in SEEDS])
    assert named(found)[0] == ("imu_delay", "base", "base", "")
    assert one_way(found, "delay") == pytest.approx(0.02, abs=0.002)


def mounted_askew(log: Log, turn: np.ndarray) -> Log:
    """The IMU is turned by `turn` against the base and nobody knows: a whole rotation, not to first order."""
    R = pin.exp3(turn)
    read = {
        f"{kind}.{axis}": column
        for kind in ("acc", "gyro")
        for axis, column in zip("xyz", R.T @ log.stack([f"{kind}.{each}" for each in "xyz"]).T, strict=True)
    }
    return replace(log, channels=log.channels | read)


@pytest.mark.parametrize("turn", [[0.0, 0.01, 0.0], [-0.05, 0.04, 0.06]])
def test_an_imu_that_is_mounted_askew_is_named_with_its_angles(trunk: Robot, turn: list[float]) -> None:
    found = searched(trunk, [mounted_askew(swaying(seed), np.array(turn)) for seed in SEEDS])
    assert named(found) == [("base_tilt", "base", "base", "")]
    told = found.discrepancy.findings[0].parameters
    for axis, value in zip("xyz", turn, strict=True):
        angle = told[f"about_{axis}"]
        assert angle.value == pytest.approx(value, abs=max(3.0 * angle.std, 0.0015))
    assert told["about_x"].std < 0.002


def test_an_imu_that_is_in_time_is_not_blamed(trunk: Robot) -> None:
    assert named(searched(trunk, [swaying(seed) for seed in SEEDS])) == []


def test_logs_that_were_low_passed_are_seen_with_a_sensor_inside_the_robot_too(tmp_path: Path) -> None:
    sensors, sections = [wrist("payload_on_sensor")], butter(4, 3.0, fs=200.0, output="sos")
    robot = describe(tmp_path, sensors)
    logs = []
    for seed in SEEDS:
        log = record(seed, sensors, LONG)
        channels = {
            name: sosfiltfilt(sections, values - values[0]) + values[0] for name, values in log.channels.items()
        }
        logs.append(replace(log, channels=channels))
    found = searched(robot, logs)
    assert named(found)[0] == ("band_limited_log", "log", "all", "")
    assert all(each.log.stored for each in found.recordings)
