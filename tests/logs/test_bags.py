"""rosbag2 files: written with rosbags itself, read as columns, mapped by what is suggested."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from exogauge.errors import BadLog
from exogauge.logs.mapping import read_mapped
from exogauge.logs.model import Log
from exogauge.logs.open_table import open_table
from exogauge.sandbox import LogRequest, parse_log
from exogauge.studies.import_log.column_words import Wearer
from exogauge.studies.import_log.log_preview import preview
from exogauge.studies.intake.mapping_file import parse_mapping

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES: dict[str, Any] = STORE.types
START = 1_700_000_000_000_000_000
JOINTS = ("shoulder", "elbow")
Write = Callable[..., Path]


def header(ns: int) -> Any:
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=ns // 1_000_000_000, nanosec=ns % 1_000_000_000)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id="")


def state(ns: int, t: float, names: tuple[str, ...] = JOINTS) -> Any:
    order = [JOINTS.index(name) for name in names]
    position, velocity = np.array([np.sin(t), np.cos(t)])[order], np.array([np.cos(t), -np.sin(t)])[order]
    effort = np.array([10.0 + t, 20.0 - t])[order]
    return TYPES["sensor_msgs/msg/JointState"](header(ns), list(names), position, velocity, effort)


def vector(x: float, y: float, z: float) -> Any:
    return TYPES["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)


def wrench(ns: int, t: float) -> Any:
    inner = TYPES["geometry_msgs/msg/Wrench"](force=vector(t, 0.0, -30.0), torque=vector(0.1, 0.2 * t, 0.3))
    return TYPES["geometry_msgs/msg/WrenchStamped"](header(ns), inner)


def imu(ns: int, t: float) -> Any:
    still = TYPES["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    unknown = np.zeros(9)
    turning, lifted = vector(0.0, 0.0, 0.01 * t), vector(0.0, 0.1, 9.81)
    return TYPES["sensor_msgs/msg/Imu"](header(ns), still, unknown, turning, unknown, lifted, unknown)


def messages(rate_hz: float, seconds: float, late_s: float = 0.0) -> Iterator[tuple[int, float]]:
    for k in range(round(rate_hz * seconds)):
        t = late_s + k / rate_hz
        yield START + round(1e9 * t), t


@pytest.fixture(params=["sqlite3", "mcap"])
def write(tmp_path: Path, request: pytest.FixtureRequest) -> Write:
    """topics: name -> [(time of arrival in ns, message)]; the storage file of the bag."""

    def make(**topics: list[tuple[int, Any]]) -> Path:
        with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin[request.param.upper()]) as writer:
            for topic, sent in topics.items():
                kind = sent[0][1].__msgtype__
                connection = writer.add_connection("/" + topic.replace(".", "/"), kind, typestore=STORE)
                for ns, message in sent:
                    writer.write(connection, ns, STORE.serialize_cdr(message, kind))
        (found,) = [*(tmp_path / "bag").glob("*.db3"), *(tmp_path / "bag").glob("*.mcap")]
        return found

    return make


def read(path: Path) -> Log:
    """As a study would, through the mapping that is suggested, in the child that opens uploads."""
    mapping = parse_mapping(yaml.safe_dump(preview(path, path.name, Wearer())["proposal"]).encode(), "mapping.yaml")
    joints = ("shoulder", "elbow")
    here = read_mapped({path.name: path}, mapping, joints=joints, motor_from_joint=None, name="log")
    there = parse_log(LogRequest("log", {path.name: path}, mapping, joints))
    assert all(np.array_equal(here.channels[name], values) for name, values in there.channels.items())
    return here


def test_joint_states_become_channels(write: Write) -> None:
    log = read(write(joint_states=[(ns, state(ns, t)) for ns, t in messages(100.0, 2.0)]))
    t = np.arange(200) / 100.0
    np.testing.assert_allclose(log.time, t, atol=1e-9)
    assert np.array_equal(log.channels["q.shoulder"], np.sin(t))
    np.testing.assert_allclose(log.channels["dq.elbow"], -np.sin(t), atol=1e-12)
    np.testing.assert_allclose(log.channels["tau.elbow"], 20.0 - t, atol=1e-12)


@pytest.mark.slow
def test_topics_of_different_rates_come_on_one_clock(write: Write) -> None:
    path = write(
        joint_states=[(ns, state(ns, t)) for ns, t in messages(100.0, 3.0)],
        **{"wrist.wrench": [(ns, wrench(ns, t)) for ns, t in messages(50.0, 3.0, 0.013)]},
        imu=[(ns, imu(ns, t)) for ns, t in messages(200.0, 3.0, 0.004)],
    )
    log = read(path)
    assert log.rate_hz == pytest.approx(200.0)
    t = log.time
    np.testing.assert_allclose(log.channels["q.shoulder"], np.sin(t), atol=1e-6)
    np.testing.assert_allclose(log.channels["gyro.z"], 0.01 * t, atol=1e-9)
    np.testing.assert_allclose(log.channels["acc.z"], 9.81, atol=1e-9)


def test_a_wrench_is_all_six_of_a_sensor(write: Write) -> None:
    table = open_table(path := write(wrist=[(ns, wrench(ns, t)) for ns, t in messages(50.0, 1.0)]), path.name)
    assert table.names == (
        "wrist.stamp",
        *(f"wrist.force.{axis}" for axis in "xyz"),
        *(f"wrist.torque.{axis}" for axis in "xyz"),
    )


def test_without_a_header_stamp_the_time_of_recording_counts(write: Write) -> None:
    log = read(write(joint_states=[(ns, state(0, t)) for ns, t in messages(100.0, 1.0)]))
    np.testing.assert_allclose(np.diff(log.time), 0.01, atol=1e-9)


def test_joints_in_another_order_in_every_message_keep_their_values(write: Write) -> None:
    sent = [(ns, state(ns, t, JOINTS[:: 1 - 2 * (k % 2)])) for k, (ns, t) in enumerate(messages(100.0, 1.0))]
    np.testing.assert_allclose(read(write(joint_states=sent)).channels["tau.shoulder"], 10.0 + np.arange(100) / 100.0)


def test_a_gripper_that_shares_the_topic_has_columns_of_its_own(write: Write) -> None:
    sent = [
        (ns, state(ns, t, ("shoulder",) if k % 2 else ("elbow",))) for k, (ns, t) in enumerate(messages(100.0, 1.0))
    ]
    names = open_table(path := write(joint_states=sent), path.name).names
    assert {"joint_states.position.elbow", "joint_states_2.position.shoulder", "joint_states_2.stamp"} <= set(names)


def test_a_bag_without_such_topics_says_what_it_holds(write: Write) -> None:
    text = TYPES["std_msgs/msg/String"]
    with pytest.raises(BadLog, match="no topic of the bag") as caught:
        open_table(path := write(chatter=[(START, text(data="hello"))]), path.name)
    assert "/chatter (std_msgs/msg/String)" in (caught.value.faults[0].value or "")


def test_a_damaged_bag_is_a_fault(write: Write) -> None:
    path = write(joint_states=[(ns, state(ns, t)) for ns, t in messages(100.0, 1.0)])
    data = path.read_bytes()
    for broken in (data[: len(data) // 2], data[:2000] + bytes(500) + data[2500:]):
        path.write_bytes(broken)
        with suppress(BadLog):  # and nothing else: what is left may be whole
            open_table(path, path.name)
    path.write_bytes(data[:100])
    with pytest.raises(BadLog):
        open_table(path, path.name)
