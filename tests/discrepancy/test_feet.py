"""What a contact sensor has wrong: a body that sways on two plates, made by pinocchio without our code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from tests.discrepancy.test_sensor_effects import BODY, SEEDS, named, searched, swaying

from exogauge.effects.catalogue import sensor_effects, whole_sensor_effects
from exogauge.findings.verdict import Why
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import SensorSite
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree
from exogauge.studies.words.reason_sentences import reason_words

pytestmark = pytest.mark.slow

AXES = ("fx", "fy", "fz", "mx", "my", "mz")
FEET = {"left": 0.1, "right": -0.1}  # [m] along y from the plate
Wrong = Callable[[np.ndarray, np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def robot() -> Robot:
    feet = "".join(
        f'<link name="{name}"/><joint name="to_{name}" type="fixed"><parent link="base"/><child link="{name}"/>'
        f'<origin xyz="0 {y} -0.4"/></joint>'
        for name, y in FEET.items()
    )
    text = BODY.replace("</robot>", f"{feet}</robot>")
    tree = load_tree(text.encode(), joints=["a", "b"], base_link="base", floating=True, cut_frames=tuple(FEET))
    sensors = tuple(WrenchSensor(name, name, "contact", 1.0) for name in FEET)
    joints = tuple(Joint(name, "torque") for name in ("a", "b"))
    return Robot("trunk", tree, joints, pin.SE3.Identity(), sensors, np.eye(2), inertial_std={"": 0.3})


def on_two_plates(seed: int, wrong: dict[str, Wrong] | None = None) -> Log:
    """The wrench of one plate, parted: the weight wanders from one to the other, and they push against each other."""
    whole, rng = swaying(seed), np.random.default_rng(100 + seed)
    t = whole.time
    w = whole.stack([f"ft.plate.{axis}" for axis in AXES])
    waves = np.sin(2.0 * np.pi * np.outer(t, [0.07, 0.19, 0.31]) + rng.uniform(0.0, 6.0, 3))
    share = (0.5 + 0.12 * waves.sum(axis=1))[:, None]
    y_left, y_right = (np.array([0.0, y, 0.0]) for y in FEET.values())
    left_force = share * w[:, :3] + 8.0 * waves[:, ::-1] + 0.3 * rng.standard_normal((len(t), 3))
    left_moment = share * (w[:, 3:] - np.cross(y_left, w[:, :3])) + 0.03 * rng.standard_normal((len(t), 3))
    right_force = w[:, :3] - left_force
    right_moment = w[:, 3:] - left_moment - np.cross(y_left, left_force) - np.cross(y_right, right_force)
    channels = {name: values for name, values in whole.channels.items() if not name.startswith("ft.")}
    for name, force, moment in (("left", left_force, left_moment), ("right", right_force, right_moment)):
        read = np.hstack([force, moment])
        if wrong and name in wrong:
            read = wrong[name](t, read)
        channels |= {f"ft.{name}.{axis}": column for axis, column in zip(AXES, read.T, strict=True)}
    return Log(whole.name, t, channels)


def search(robot: Robot, wrong: dict[str, Wrong] | None = None) -> list[tuple[str, str, str, str]]:
    return named(searched(robot, [on_two_plates(seed, wrong) for seed in SEEDS]))


def softening_gain(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    """8 % too much, and less of it under load."""
    out = w.copy()
    out[:, 2] += 0.08 * w[:, 2] * (1.0 - 0.1 * np.abs(w[:, 2]) / np.abs(w[:, 2]).max())
    return out


def hyperbola(t: np.ndarray, w: np.ndarray) -> np.ndarray:
    out = w.copy()
    out[:, 1] += 6.0 * t / (t + 10.0)
    return out


def askew(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    R = pin.exp3(np.array([0.02, -0.015, 0.0]))
    return np.hstack([w[:, :3] @ R.T, w[:, 3:] @ R.T])


def never_zeroed(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    return w + np.array([5.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_nothing_is_named_where_nothing_is_wrong(robot: Robot) -> None:
    assert search(robot) == []


@pytest.mark.parametrize(
    ("wrong", "effect", "part"),
    [(softening_gain, "ft_gain", "fz"), (hyperbola, "ft_drift", "fy"), (askew, "ft_tilt", ""),
     (never_zeroed, "ft_zero", "fx")],
)  # fmt: skip
def test_what_one_foot_has_wrong_is_named_there(robot: Robot, wrong: Wrong, effect: str, part: str) -> None:
    assert search(robot, {"left": wrong})[:1] == [(effect, "sensor", "left", part)]


def test_both_feet_turned_alike_are_the_base_and_no_foot(robot: Robot) -> None:
    found = search(robot, {"left": askew, "right": askew})
    assert found[:1] == [("base_tilt", "base", "base", "")]


@pytest.mark.parametrize("component", [0, 2, 4])
def test_what_an_effect_takes_off_the_rows_is_what_a_changed_reading_does_to_them(robot: Robot, component: int) -> None:
    """Of the log itself, read anew with the fault in it; a component's gain, and a tilt of all."""
    log = on_two_plates(SEEDS[0])
    found = identify(robot, [Recording(log, held_out=False)], Settings())
    model, step = found.model, 1e-4
    read = log.stack([f"ft.left.{axis}" for axis in AXES])
    cases = [
        (SensorSite(0, component, contact=True), sensor_effects()["ft_gain"], 0, step * read * np.eye(6)[component])
    ]
    turn = np.hstack([np.cross([0.0, 1.0, 0.0], read[:, :3]), np.cross([0.0, 1.0, 0.0], read[:, 3:])])
    cases.append((SensorSite(0, None, contact=True), whole_sensor_effects()["ft_tilt"], 1, step * turn))
    prepared = model.prepare(log)
    before = model.equations.outside(prepared)
    for site, effect, coefficient, more in cases:
        channels = log.channels | {f"ft.left.{axis}": read[:, k] + more[:, k] for k, axis in enumerate(AXES)}
        changed = model.prepare(replace(log, name="changed", channels=channels))
        after = model.equations.outside(changed)
        columns = prepared.low_pass.apply(site.see(model, prepared).columns(effect, ())[:, coefficient])
        own = model.equations.layout.in_told(site.kinds(model.equations))
        np.testing.assert_allclose(columns, -(after - before)[:, own] / step, atol=1e-6 * np.abs(columns).max())


def test_a_foot_of_which_a_component_was_never_measured_is_not_blamed(robot: Robot) -> None:
    log = on_two_plates(SEEDS[0])
    log = replace(log, channels=log.channels | {"ft.left.mx": np.zeros(log.samples)})
    model = identify(robot, [Recording(log, held_out=False)], Settings()).model
    prepared = model.prepare(log)
    for foot, blamed in ((0, False), (1, True)):
        columns = SensorSite(foot, 2, contact=True).see(model, prepared).columns(sensor_effects()["ft_gain"], ())
        assert columns.any() == blamed


def shunted(_t: np.ndarray, w: np.ndarray) -> np.ndarray:
    """A cover 0.1 m in front bears a share of the weight past the sensor while that stands in front of its usual place:
    nothing that the catalogue holds."""
    out, along = w.copy(), -w[:, 4] / w[:, 2]
    borne = 3.0 * w[:, 2] * np.maximum(along - np.median(along), 0.0)
    out[:, 2] -= borne
    out[:, 4] += 0.1 * borne
    return out


def test_what_no_catalogue_holds_is_unexplained_where_it_is(robot: Robot) -> None:
    found = searched(robot, [on_two_plates(seed, {"left": shunted}) for seed in SEEDS]).discrepancy
    assert found.findings == ()
    assert found.verdict == "unexplained"
    assert found.unexplained[0].channel.startswith("base.")
    assert any(each.objection.why is Why.PARTIAL for each in found.rejected), (
        "the nearest names are told with their share"
    )


def in_amperes(log: Log, alike: float) -> Log:
    """Currents of motors that give 5 N·m/A; both feet read `alike` times what they feel."""
    channels = dict(log.channels)
    for joint in "ab":
        channels[f"i.{joint}"] = channels.pop(f"tau.{joint}") / 5.0
    return replace(log, channels={name: (alike if name.startswith("ft.") else 1.0) * c for name, c in channels.items()})


@pytest.mark.parametrize("alike", [1.0, 0.85])
def test_a_gain_that_both_feet_share_is_undecided_and_blames_nobody(robot: Robot, alike: float) -> None:
    joints = tuple(Joint(name, "current", prior={"k_T": 5.0}, prior_std={"k_T": 0.1}) for name in "ab")
    described = replace(robot, joints=joints, inertial_std={"": 0.1})
    found = searched(described, [in_amperes(on_two_plates(seed), alike) for seed in SEEDS])
    assert named(found) == []
    told = found.discrepancy
    if alike == 1.0:
        assert told.verdict == "none"
        return
    (caveat,) = told.cannot
    assert told.verdict == "undecided"
    assert (caveat.why, caveat.of) == ("feet_alike", "left, right")
    assert caveat.value == pytest.approx(alike - 1.0, abs=max(3.0 * caveat.needed, 0.03))
    assert "weigh the robot" in reason_words(caveat)
