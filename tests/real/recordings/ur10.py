"""UR10: an exciting trajectory, 27.5 s at 125 Hz, in a rosbag2; low-passed below 2 Hz before it was stored."""

from __future__ import annotations

import sqlite3
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from tests.real.recordings.placing import write_fixed_arm

RECORDING = "ur10_rosbag2"
BAG = "ur10_exciting_trajectory.db3"
FILES = (BAG,)
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
STUDY = """version: 1
name: UR10
robot: robot.yaml
logs:
  - {{file: log.parquet, rows: {fitted}, role: identification, name: train}}
  - {{file: log.parquet, rows: {held_out}, role: validation, name: held_out}}
steps: [identify, discrepancy]
"""
FORWARD, REVERSE = ("[0, 2064]", "[2064, 3441]"), ("[1377, 3441]", "[0, 1377]")


def write(folder: Path) -> None:
    """forward.yaml and reverse.yaml: either part is fitted, the other held out."""
    write_fixed_arm(folder, "ur_description/urdf/ur10_robot.urdf", JOINTS)
    pq.write_table(pa.table(joint_states(folder / BAG)), folder / "log.parquet")
    for name, (fitted, held_out) in {"forward": FORWARD, "reverse": REVERSE}.items():
        (folder / f"{name}.yaml").write_text(STUDY.format(fitted=fitted, held_out=held_out))


class Message:
    """A serialised ROS 2 message, little endian: every value starts at a multiple of its size."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data[4:], 0  # four bytes say how it is serialised

    def take(self, form: str) -> tuple[Any, ...]:
        one = struct.calcsize(form[-1])
        self.at += -self.at % one
        values = struct.unpack_from(f"<{form}", self.data, self.at)
        self.at += one * len(values)
        return values

    def text(self) -> str:
        (length,) = self.take("I")
        self.at += length
        return self.data[self.at - length : self.at - 1].decode()

    def numbers(self) -> tuple[float, ...]:
        (length,) = self.take("I")
        return self.take(f"{length}d")


def joint_states(bag: Path) -> dict[str, np.ndarray]:
    """t [s] and, per joint, q [rad] and tau [N·m], each (T,)."""
    rows = []
    connection = sqlite3.connect(bag)
    for (data,) in connection.execute("select data from messages order by id"):
        message = Message(data)
        seconds, nanoseconds = *message.take("i"), *message.take("I")
        message.text()
        names = [message.text() for _ in range(message.take("I")[0])]
        position, _velocity, effort = message.numbers(), message.numbers(), message.numbers()
        assert tuple(names) == JOINTS
        rows.append([seconds + 1e-9 * nanoseconds, *position, *effort])
    connection.close()
    table = np.array(rows)
    columns = {"t": table[:, 0] - table[0, 0]}
    for k, joint in enumerate(JOINTS):
        columns |= {f"q.{joint}": table[:, 1 + k], f"tau.{joint}": table[:, 7 + k]}
    return columns
