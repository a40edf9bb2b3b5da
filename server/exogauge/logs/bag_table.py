"""rosbag2 storage files (SQLite `.db3`, MCAP) through rosbags: joint states, wrenches and IMUs as columns.

A topic's columns are called after it: `/joint_states` gives `joint_states.stamp` [ns] and, per joint,
`joint_states.position.<joint>`, `.velocity.…`, `.effort.…`; a wrench `<topic>.force.x` …, an IMU
`<topic>.linear_acceleration.x` …, `<topic>.angular_velocity.x` …. Each topic has stamps of its own, and
so a clock: those of the header, or where a driver leaves these at zero, those at which the message was recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, final

import numpy as np

from exogauge.errors import BadInput, BadLog, Fault
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_cells
from exogauge.logs.model import Note
from exogauge.logs.tables import RawArray, broken

SQLITE, MCAP = b"SQLite format 3\0", b"\x89MCAP0\r\n"
STAMP = "stamp"
Row = dict[str, float]


@final
class BagTable:
    """Messages name their joints, so `names` takes the whole file to be read; it is read once."""

    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str) -> None:
        self.file = file
        try:
            self._columns = dict(self._read(path))
        except BadInput:
            raise
        except MemoryError:
            raise
        except Exception as problem:  # a hostile file meets a library that decodes whatever it is told
            raise BadLog(broken(problem, file)) from None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._columns)

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        return {
            name: values if name in exact or values.dtype.kind == "f" else values.astype(np.float64)
            for name, values in ((name, self._columns[name]) for name in names)
        }

    def _read(self, path: Path) -> Iterator[tuple[str, RawArray]]:
        from rosbags.rosbag2.storage_mcap import McapReader
        from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_HUMBLE)  # these messages are the same in every distribution
        with path.open("rb") as stream:
            packed = stream.read(len(SQLITE))
        reader = (Sqlite3Reader if packed == SQLITE else McapReader)(path)
        reader.open()
        try:
            wanted = [each for each in reader.connections if each.msgtype in _MESSAGES]
            if not wanted:
                raise BadLog(self._nothing_known(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections})))
            check_cells(sum(each.msgcount for each in wanted), 4, self.file)
            stamps: dict[tuple[str, tuple[str, ...]], list[int]] = {}
            rows: dict[tuple[str, tuple[str, ...]], list[list[float]]] = {}
            for connection, received, data in reader.messages(wanted):
                message: Any = store.deserialize_cdr(data, connection.msgtype)
                said = _MESSAGES[connection.msgtype](message)
                key = (connection.topic, tuple(sorted(said)))  # publishers may share a topic, and order joints anew
                own = int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)
                stamps.setdefault(key, []).append(own or int(received))
                rows.setdefault(key, []).append([said[field] for field in key[1]])
        finally:
            reader.close()
        for number, (key, values) in enumerate(rows.items()):
            again = sum(topic == key[0] for topic, _ in list(rows)[:number])
            topic = key[0].strip("/").replace("/", ".") + (f"_{again + 1}" if again else "")
            yield f"{topic}.{STAMP}", np.array(stamps[key], np.int64)
            table = np.array(values, np.float64)
            order = sorted(range(len(key[1])), key=lambda k, fields=key[1]: _ORDER.index(fields[k].split(".")[0]))  # type: ignore[misc]
            for k in order:
                yield f"{topic}.{key[1][k]}", np.ascontiguousarray(table[:, k])

    def _nothing_known(self, topics: Sequence[str]) -> Fault:
        return Fault(
            "no topic of the bag is a joint state, a wrench or an IMU",
            "no_known_topic",
            "Read are sensor_msgs/JointState, sensor_msgs/Imu and geometry_msgs/WrenchStamped; "
            "export other messages as CSV or Parquet.",
            self.file,
            value=shorten(", ".join(topics), 200) or "no topics",
        )


def _joint_state(message: Any) -> Row:
    found: Row = {}
    for field in ("position", "velocity", "effort"):
        values = getattr(message, field)
        if len(values) == len(message.name):
            found |= {f"{field}.{name}": float(value) for name, value in zip(message.name, values, strict=True)}
    return found


def _wrench(message: Any) -> Row:
    return _vectors(message.wrench, "force", "torque")


def _imu(message: Any) -> Row:
    return _vectors(message, "linear_acceleration", "angular_velocity")


def _vectors(message: Any, *fields: str) -> Row:
    return {f"{field}.{axis}": float(getattr(getattr(message, field), axis)) for field in fields for axis in "xyz"}


_MESSAGES: dict[str, Callable[[Any], Row]] = {
    "sensor_msgs/msg/JointState": _joint_state,
    "geometry_msgs/msg/WrenchStamped": _wrench,
    "sensor_msgs/msg/Imu": _imu,
}
_ORDER = ("position", "velocity", "effort", "force", "torque", "linear_acceleration", "angular_velocity")
