"""What a foreign column may be: named where its name and the robot leave one reading, else left open with advice."""

from __future__ import annotations

import math

import pytest
import yaml

from exogauge.studies.import_log.column_guess import guess
from exogauge.studies.import_log.column_words import Advice, JointFacts, Seen, Suggestion, Wearer
from exogauge.studies.import_log.log_preview import proposal
from exogauge.studies.intake.mapping_file import parse_mapping

ROBOT = Wearer(
    (
        JointFacts("torso_pitch", -0.5, 2.0, 6.0),
        JointFacts("torso_yaw", -2.6, 2.6, 6.0),
        JointFacts("l_knee", -0.1, 2.4, 10.0),
    ),
    ("l_foot", "r_foot"),
)
SMALL = (-0.3, 0.4)


def one(name: str, low: float = -1.0, high: float = 1.0, wearer: Wearer = ROBOT, step: float | None = None):
    return guess([Seen(name, low, high, step)], wearer, {})[name]


@pytest.mark.parametrize(
    ("name", "span", "channel", "unit"),
    [
        ("q.l_knee", SMALL, "q.l_knee", "rad"),
        ("torso_pitch_pos_rad", SMALL, "q.torso_pitch", "rad"),
        ("TorsoPitchPosition [deg]", (-20.0, 60.0), "q.torso_pitch", "deg"),
        ("/joint_states/torso_yaw/velocity (rad/s)", SMALL, "dq.torso_yaw", "rad/s"),
        ("l_knee.effort [N·m]", (-40.0, 80.0), "tau.l_knee", "N·m"),
        ("l_knee_current_mA", (-4000.0, 4000.0), "i.l_knee", "mA"),
        ("torso_pitch_angle", (-20.0, 60.0), "q.torso_pitch", "deg"),
        ("l_foot/force/z [N]", (0.0, 700.0), "ft.l_foot.fz", "N"),
        ("r_foot_mx [Nm]", SMALL, "ft.r_foot.mx", "Nm"),
        ("imu/angular_velocity/y (deg/s)", SMALL, "gyro.y", "deg/s"),
        ("temperature_l_knee", (20.0, 45.0), "temp.l_knee", "degC"),
        ("l_knee_deg", (-5.0, 60.0), "q.l_knee", "deg"),
        ("torso_yaw_joint_mA", (-900.0, 900.0), "i.torso_yaw", "mA"),
        ("torso_yaw [N·m]", (-30.0, 30.0), "tau.torso_yaw", "N·m"),
        ("l_knee (rpm)", (-3.0, 3.0), "dq.l_knee", "rpm"),
        ("l_knee_vel_degps", (-90.0, 90.0), "dq.l_knee", "deg/s"),
        ("imu_acc_z_mps2", (9.0, 10.5), "acc.z", "m/s^2"),
        ("LeftKnee_pos [deg]", (-5.0, 60.0), "q.l_knee", "deg"),
        ("l_knee_q_dot [rad/s]", SMALL, "dq.l_knee", "rad/s"),
        ("l_knee_theta_ddot [rad/s^2]", SMALL, "ddq.l_knee", "rad/s^2"),
        ("l_knee_current_q [A]", SMALL, "i.l_knee", "A"),
        ("RightFootForceSensor_fz [N]", (0.0, 700.0), "ft.r_foot.fz", "N"),
        ("RightFootForceSensor_cx [Nm]", SMALL, "ft.r_foot.mx", "Nm"),
    ],
)  # fmt: skip
def test_a_name_that_leaves_one_reading_is_sure(name: str, span: tuple[float, float], channel: str, unit: str) -> None:
    found = one(name, *span)
    assert isinstance(found, Suggestion), found
    assert (found.channel, found.unit, found.sign, found.sure) == (channel, unit, 1, True), found


@pytest.mark.parametrize(
    ("name", "span", "channel", "unit", "said"),
    [
        ("torso_yaw_pos", SMALL, "q.torso_yaw", "rad", "rad is usual"),
        ("torso_yaw_torque", (-30.0, 30.0), "tau.torso_yaw", "Nm", "Nm is usual"),
        ("l_knee_current", (-3000.0, 3000.0), "i.l_knee", "mA", "mA is usual"),
        ("l_knee_motor_pos [rad]", (-100.0, 200.0), "q.l_knee", "rad", "motor's side"),
        ("l_knee_omega", SMALL, "dq.l_knee", "rad/s", "rate of the joint"),
        ("l_foot_fz", (0.0, 700.0), "ft.l_foot.fz", "N", "N is usual"),
        ("gyro_x", (-120.0, 90.0), "gyro.x", "deg/s", "deg/s is usual"),
    ],
)
def test_what_rests_on_habit_is_suggested_and_says_so(
    name: str, span: tuple[float, float], channel: str, unit: str, said: str
) -> None:
    found = one(name, *span)
    assert isinstance(found, Suggestion), found
    assert (found.channel, found.unit, found.sure) == (channel, unit, False)
    assert said in found.why
    assert (found.side == "motor") == ("motor" in name)


def test_a_joint_that_only_fits_its_limits_the_other_way_round_is_suggested_with_its_sign_and_not_sure() -> None:
    for name, span in (
        ("l_knee_pos [rad]", (-2.2, -0.2)),
        ("l_knee_pos", (-2.2, -0.2)),
        ("l_knee_pos", (-126.0, -10.0)),
    ):
        found = one(name, *span)
        assert isinstance(found, Suggestion)
        assert (found.sign, found.sure) == (-1, False)
        assert "sign reversed" in found.why
    assert isinstance(one("l_knee_pos", -500.0, 500.0), Advice)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("x7", "ignore"),
        ("battery_voltage", "ignore"),
        ("l_knee_desired_pos", "commanded"),
        ("l_knee_status", "what of it was measured"),
        ("l_knee_error_deg", "not what was measured"),
        ("wrist_pos", "No joint of the robot"),
        ("head_fz", "which sensor"),
        ("l_knee_pos [A]", "no unit of q"),
        ("q.wrist", "No joint of the robot"),
    ],
)
def test_what_cannot_be_named_gets_advice_and_no_suggestion(name: str, said: str) -> None:
    found = one(name)
    assert isinstance(found, Advice), found
    assert said in found.text


@pytest.mark.parametrize(
    ("name", "first", "step", "unit", "sure"),
    [
        ("t", 0.0, 0.005, "s", True),
        ("t", 0.0, 5.0, "ms", True),
        ("time", 0.0, 5.0, "ms", True),
        ("timestamp", 0.0, 5000.0, "us", True),
        ("stamp", 1.7e18, 5e6, "ns", True),
        ("stamp", 1.7e9, 0.005, "s", True),
        ("Time (ms)", 0.0, 5.0, "ms", True),
        ("ms", 0.0, 5.0, "ms", True),
        ("sec", 0.0, 0.005, "s", True),
        ("time", 0.0, 0.1, "s", False),
        ("time", 0.0, 100.0, "ms", False),
    ],
)
def test_the_unit_of_time_is_told_by_its_name_its_epoch_or_its_step(
    name: str, first: float, step: float, unit: str, sure: bool
) -> None:
    found = one(name, first, first + 1000 * step, step=step)
    assert isinstance(found, Suggestion), found
    assert (found.channel, found.unit) == ("t", unit)
    assert found.sure == sure
    assert isinstance(one("time", 0.0, 5.0, step=None), Advice)


@pytest.mark.parametrize(("size", "unit"), [(9.8, "m/s^2"), (0.99, "g"), (1003.0, "mg"), (9790.0, "mm/s^2")])
def test_gravity_tells_the_unit_of_an_accelerometer(size: float, unit: str) -> None:
    found = guess([Seen("acc_z", -size, size)], ROBOT, {"acc_z": size})["acc_z"]
    assert (found.unit, found.sure) == (unit, True)
    assert isinstance(guess([Seen("acc_z", -3.0, 3.0)], ROBOT, {"acc_z": 3.0})["acc_z"], Advice)


def test_numbered_columns_are_joints_in_order_only_where_there_are_as_many_and_never_surely() -> None:
    names = [f"position[{k}] (rad)" for k in range(3)]
    found = guess([Seen(name, *SMALL) for name in names], ROBOT, {})
    assert [found[name].channel for name in names] == ["q.torso_pitch", "q.torso_yaw", "q.l_knee"]
    assert not any(found[name].sure for name in names)
    fewer = guess([Seen(name, *SMALL) for name in names[:2]], ROBOT, {})
    assert all(isinstance(each, Advice) for each in fewer.values())


@pytest.mark.parametrize(
    "called", ["ax{}.pos_deg", "Axis{} [deg]", "axis_{}_angle_deg", "$AXIS_ACT.A{} [deg]", "$AXIS_ACT[{}] [deg]"]
)
def test_axes_that_are_numbered_are_joints_and_no_accelerometers(called: str) -> None:
    names = [called.format(k + 1) for k in range(3)]
    found = guess([Seen(name, -5.0, 60.0) for name in names], ROBOT, {})
    assert [found[name].channel for name in names] == ["q.torso_pitch", "q.torso_yaw", "q.l_knee"]
    assert not any(found[name].sure for name in names)
    triple = guess([Seen(f"a{axis} [m/s^2]", -10.0, 10.0) for axis in "xyz"], ROBOT, {})
    assert [each.channel for each in triple.values()] == ["acc.x", "acc.y", "acc.z"]


@pytest.mark.parametrize(("name", "sure"), [("clk[ms]", True), ("elapsed [ms]", False)])
def test_a_clock_by_any_other_name_is_told_by_its_unit_where_it_rises(name: str, sure: bool) -> None:
    found = one(name, 7000.0, 32000.0, step=8.0)
    assert (found.channel, found.unit, found.sure) == ("t", "ms", sure)
    assert isinstance(one("latency [ms]", 0.0, 3.0), Advice)


def test_a_wrench_without_a_name_is_the_only_sensors_and_nobodys_where_there_are_two() -> None:
    names = ["Fx_N", "Fy_N", "Fz_N", "Tx_Nm", "Ty_Nm", "Tz_Nm"]
    seen = [Seen(name, -20.0, 20.0) for name in names]
    found = guess(seen, Wearer(ROBOT.joints, ("wrist",)), {})
    assert [found[name].channel for name in names] == [
        f"ft.wrist.{part}" for part in ("fx", "fy", "fz", "mx", "my", "mz")
    ]
    assert {found[name].why for name in names} == {"the robot has one sensor"}
    assert not any(found[name].sure for name in names)
    assert all(isinstance(each, Advice) for each in guess(seen, ROBOT, {}).values())


def test_two_columns_for_one_channel_are_both_left_open() -> None:
    found = guess([Seen("time", 0.0, 5.0, 0.005), Seen("header.stamp", 0.0, 5.0, 0.005)], ROBOT, {})
    assert all(isinstance(each, Advice) and "'time', 'header.stamp'" in each.text for each in found.values())


def test_without_a_robot_a_joint_is_called_as_in_the_column_and_not_surely() -> None:
    found = one("elbow_pos [rad]", wearer=Wearer())
    assert (found.channel, found.sure) == ("q.elbow", False)
    assert "no robot is given" in found.why


def test_a_proposal_is_a_mapping_that_its_own_reader_takes() -> None:
    names = [
        "time",
        "l_knee_pos",
        "acc_x",
        "acc_y",
        "acc_z",
        *(f"l_foot_{a}" for a in ("fx", "fy", "fz", "mx", "my", "mz")),
    ]
    seen = [Seen("time", 0.0, 5.0, 0.005), *(Seen(name, *SMALL) for name in names[1:])]
    found = guess(seen, ROBOT, dict.fromkeys(("acc_x", "acc_y", "acc_z"), 9.81))
    content = proposal("a.csv", {name: each for name, each in found.items() if isinstance(each, Suggestion)})
    (entry,) = content["files"]
    assert list(entry["columns"]) == ["l_knee_pos"]
    assert [each["channel"] for each in entry["vectors"]] == ["acc"]
    assert [each["sensor"] for each in entry["wrenches"]] == ["l_foot"]
    (read,) = parse_mapping(yaml.safe_dump(content).encode(), "mapping.yaml").files
    assert set(read.used) == set(names)
    assert math.isclose(read.clock.delay_s, 0.0)


ARM = Wearer(tuple(JointFacts(name, -3.0, 3.0, 3.0) for name in ("base", "upper", "fore")))


def of_arm(**spans: tuple[float, float]) -> dict[str, Suggestion | Advice]:
    return guess([Seen(name, *span) for name, span in spans.items()], ARM, {})


@pytest.mark.parametrize(
    ("quantity", "large", "small", "unit"),
    [("current_", 900.0, 40.0, "mA"), ("q", 60.0, 2.0, "deg"), ("torque", 9000.0, 30.0, "mNm")],
)
def test_a_quantity_has_one_unit_in_all_its_columns(quantity: str, large: float, small: float, unit: str) -> None:
    """The small ones of a wrist were read in amperes beside milliamperes of the shoulder."""
    spans = {f"{quantity}{k}": (-size, size) for k, size in enumerate((large, small, small))}
    found = of_arm(**spans)
    assert [each.unit for each in found.values() if isinstance(each, Suggestion)] == [unit] * 3
    assert not any(each.sure for each in found.values() if isinstance(each, Suggestion))


def test_a_unit_that_is_named_stays_beside_others() -> None:
    found = of_arm(current_0=(-900.0, 900.0), base_current_A=(-4.0, 4.0), upper_current_mA=(-50.0, 50.0))
    assert [each.unit for each in found.values() if isinstance(each, Suggestion)][-2:] == ["A", "mA"]


def test_six_numbers_of_a_tool_are_no_joints() -> None:
    """`actual_TCP_speed_0` became the speed of the first joint."""
    tool = [f"{name}_{k}" for name in ("actual_TCP_speed", "tool.velocity", "ee_pose.position") for k in range(3)]
    found = guess([Seen(name, -0.3, 0.3) for name in [*tool, "actual_qd_0", "actual_qd_1", "actual_qd_2"]], ARM, {})
    assert all(isinstance(found[name], Advice) for name in tool)
    assert isinstance(found["actual_qd_2"], Suggestion)


@pytest.mark.parametrize(
    ("stem", "channel"),
    [
        ("Achse {} Position [rad]", "q"),
        ("Gelenkwinkel_{} [rad]", "q"),
        ("Drehzahl Achse {} [rad/s]", "dq"),
        ("Istdrehmoment A{} [Nm]", "tau"),
        ("Strom_Achse_{}", "i"),
        ("position axe {} (rad)", "q"),
        ("couple axe {} (N.m)", "tau"),
        ("velocidad articulación {}", "dq"),
        ("coppia giunto {} [Nm]", "tau"),
        ("関節{}角度[rad]", "q"),
        ("関節{}角速度[rad/s]", "dq"),
        ("軸{}トルク[Nm]", "tau"),
        ("关节{}力矩", "tau"),
        ("轴{}电流", "i"),
        ("關節{}角度", "q"),
        ("관절{}_각속도[rad/s]", "dq"),
        ("{}축 토크 [Nm]", "tau"),
    ],
)
def test_a_joint_is_known_in_other_languages(stem: str, channel: str) -> None:
    found = guess([Seen(stem.format(k), *SMALL) for k in (1, 2, 3)], ARM, {})
    assert [each.channel for each in found.values() if isinstance(each, Suggestion)] == [
        f"{channel}.{joint}" for joint in ("base", "upper", "fore")
    ]


@pytest.mark.parametrize("name", ["Zeit [s]", "Zeitstempel", "temps (s)", "temps", "tiempo", "時間[s]", "时间"])
def test_the_time_is_known_in_other_languages(name: str) -> None:
    found = one(name, 0.0, 10.0, step=0.01)
    assert isinstance(found, Suggestion)
    assert (found.channel, found.unit) == ("t", "s")


@pytest.mark.parametrize(
    "stem",
    [
        "Sollposition_{}",
        "Achse {} Sollwert Winkel",
        "consigne couple axe {}",
        "関節{}角度指令",
        "关节{}期望位置",
        "관절{} 목표 위치",
    ],
)
def test_what_is_asked_of_a_joint_was_not_measured_in_other_languages_either(stem: str) -> None:
    found = guess([Seen(stem.format(k), *SMALL) for k in (1, 2, 3)], ARM, {})
    assert all(isinstance(each, Advice) and "commanded" in each.text for each in found.values())


@pytest.mark.parametrize(
    ("name", "told"), [("qfrc_actuator_{}", True), ("qfrc_bias_{}", False), ("qfrc_passive_{}", False)]
)
def test_of_what_mujoco_calls_forces_at_the_joints_the_actuators_alone_are_the_torque(name: str, told: bool) -> None:
    found = guess([Seen(name.format(k), *SMALL) for k in (0, 1, 2)], ARM, {})
    channels = [each.channel for each in found.values() if isinstance(each, Suggestion)]
    assert channels == (["tau.base", "tau.upper", "tau.fore"] if told else [])


@pytest.mark.parametrize("name", ["existence", "motor_temps_3", "kisten_lage_x", "listing"])
def test_a_word_that_holds_another_languages_word_is_not_taken_for_it(name: str) -> None:
    assert isinstance(one(name), Advice)


def test_what_goes_out_beside_what_comes_in_was_not_measured() -> None:
    """Both were claimed for one joint, and so neither was taken."""
    found = guess([Seen(f"q{way}_{k}", *SMALL) for way in ("In", "Out") for k in range(3)], ARM, {})
    assert [each.channel for each in found.values() if isinstance(each, Suggestion)] == ["q.base", "q.upper", "q.fore"]
    assert all(isinstance(found[f"qOut_{k}"], Advice) for k in range(3))
    alone = guess([Seen(f"enc_out_{k}", *SMALL) for k in range(3)], ARM, {})
    assert all(isinstance(each, Suggestion) for each in alone.values())


@pytest.mark.parametrize("stem", ["tau_ext_hat_filtered{}", "ExternalTorque[{}]", "tau_gravity_{}", "torque_ff{}"])
def test_a_part_of_the_torque_that_a_model_tells_is_not_the_measured_one(stem: str) -> None:
    both = [Seen(each.format(k), *SMALL) for each in ("tau_J{}", stem) for k in range(3)]
    found = guess(both, ARM, {})
    assert [name for name, each in found.items() if isinstance(each, Suggestion)] == [f"tau_J{k}" for k in range(3)]


@pytest.mark.parametrize(
    "name",
    [
        "l_knee_position_error", "error.l_knee.pos", "l_knee_torque_limit", "l_knee_pos_std", "l_knee_encoder_counts",
        "l_knee_torque [%]", "l_knee_tau_offset", "bus_current_l_knee", "gyro_bias_x", "l_knee_temperature_gradient",
        "l_knee_tau_friction", "l_knee_model_torque", "l_knee_current_d",
    ],
)  # fmt: skip
def test_what_is_told_beside_a_quantity_is_not_taken_for_it(name: str) -> None:
    found = one(name)
    assert isinstance(found, Advice), found
    assert "`ignore`" in found.text


def test_an_error_beside_a_position_keeps_neither_from_being_told() -> None:
    found = guess([Seen(name, -0.3, 0.4) for name in ("actual.l_knee.pos", "error.l_knee.pos")], ROBOT, {})
    said = found["actual.l_knee.pos"]
    assert isinstance(said, Suggestion)
    assert said.channel == "q.l_knee"


def test_a_letter_before_an_axis_is_a_couple_only_beside_a_sensor() -> None:
    assert isinstance(one("cx"), Advice)
    assert isinstance(one("support_center_cx"), Advice)


@pytest.mark.parametrize("first", [0, 1])
def test_three_numbers_of_an_imu_are_its_axes(first: int) -> None:
    stems = ("imu_state.accelerometer[{}]", "imu_state.gyroscope[{}]")
    columns = [Seen(stem.format(first + k), -9.9, 9.9) for stem in stems for k in range(3)]
    norms = {stems[0].format(first + k): 9.81 for k in range(3)}
    found = [each for each in guess(columns, ARM, norms).values() if isinstance(each, Suggestion)]
    assert [each.channel for each in found] == [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    assert not any(each.sure for each in found)
    four = guess([Seen(f"imu_gyro_{k}", *SMALL) for k in range(4)], ARM, {})
    assert all(isinstance(each, Advice) for each in four.values())


@pytest.mark.parametrize("stem", ["PositionCmptd{}", "tau_J_d_{}", "q_d[{}]", "state.dq_d[{}]", "action.q{}"])
def test_what_was_computed_or_desired_was_not_measured(stem: str) -> None:
    found = guess([Seen(stem.format(k), *SMALL) for k in range(3)], ARM, {})
    assert all(isinstance(each, Advice) and "commanded" in each.text for each in found.values())


def test_of_two_numbers_the_one_counts_that_numbers_the_joints() -> None:
    found = guess([Seen(f"ROB_1 axis {k} position", *SMALL) for k in (1, 2, 3)], ARM, {})
    assert [each.channel for each in found.values() if isinstance(each, Suggestion)] == ["q.base", "q.upper", "q.fore"]


def test_names_that_two_numberings_fit_are_left_open() -> None:
    found = guess([Seen(f"q_{j}_{k}", *SMALL) for j in range(3) for k in range(3)], ARM, {})
    assert all(isinstance(each, Advice) for each in found.values())


def test_a_second_stamp_is_no_second_topic() -> None:
    """Of `rostopic echo -p`: the mapping that was drafted held no file at all."""
    stamps = [Seen(name, 1.7e18, 1.8e18, 1e7) for name in ("%time", "field.header.stamp")]
    other = [Seen("field.header.seq", 0.0, 9.0, 1.0), *(Seen(f"field.position{k}", *SMALL) for k in range(3))]
    found = guess([*stamps, *other], ARM, {})
    assert all(isinstance(found[each.name], Advice) for each in stamps)
    sure = {name: each for name, each in found.items() if isinstance(each, Suggestion)}
    assert len(proposal("log.csv", sure)["files"][0]["columns"]) == 3


def test_a_time_that_does_not_rise_is_told_what_else_would_do() -> None:
    stamps = one("header.stamp.nsecs", 0.0, 9.9e8)
    assert isinstance(stamps, Advice)
    assert "`rate_hz`" in stamps.text
    assert "seconds and nanoseconds" in stamps.text


@pytest.mark.parametrize(
    ("kind", "turns", "slides", "unit"),
    [("q", 60.0, 0.03, "m"), ("q", 60.0, 30.0, "mm"), ("torque", 9000.0, 20.0, "N"), ("qd", 100.0, 0.1, "m/s")],
)
def test_a_joint_that_slides_has_no_unit_of_those_that_turn(kind: str, turns: float, slides: float, unit: str) -> None:
    """A gripper's metres were radians, and would be degrees beside an arm's."""
    gripper = Wearer((JointFacts("arm", -3.0, 3.0, 3.0), JointFacts("finger", -0.04, 0.04, 0.2, sliding=True)))
    found = guess([Seen(f"{kind}0", -turns, turns), Seen(f"{kind}1", -slides, slides)], gripper, {})
    other = found[f"{kind}1"]
    assert isinstance(other, Suggestion)
    assert other.unit == unit
