"""One log as the robot would have stored it: the contract's columns, every sensor with its own error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.sensors import Sensing, encoder, noisy
from exogauge.synthetic.simulation import Recording

Array = NDArray[np.float64]

LABEL = {"exogauge": "SYNTHETIC: simulated with MuJoCo, measured on no robot"}


def write_log(
    path: Path, recording: Recording, rng: np.random.Generator, seed: int, sensing: Sensing | None = None
) -> None:
    """Contract columns; angles and time as float64, what carries sensor noise as float32. sensing: what is wrong."""
    time, angle = recording.time, encoder(recording.q)
    acc, gyro, wrenches = recording.acc, recording.gyro, recording.wrench
    if sensing is not None:
        time, angle = sensing.stamps(time), encoder(recording.q, sensing.encoder_step)
        acc, gyro = sensing.inertial(acc), sensing.inertial(gyro)
        wrenches = sensing.wrench(wrenches, recording.time)
    columns = {"t": pa.array(time)}
    columns |= {f"q.{name}": pa.array(a) for name, a in zip(JOINT_NAMES, angle.T, strict=True)}

    def add(names: Sequence[str], values: Array, kind: str) -> None:
        logged = noisy(values, kind, rng).astype(np.float32)
        columns.update({name: pa.array(column) for name, column in zip(names, logged.T, strict=True)})

    add([f"i.{name}" for name in JOINT_NAMES], recording.current, "i")
    add([f"acc.{axis}" for axis in "xyz"], acc, "acc")
    add([f"gyro.{axis}" for axis in "xyz"], gyro, "gyro")
    for foot, wrench in zip(FEET, np.moveaxis(wrenches, 1, 0), strict=True):
        add([f"ft.{foot}.f{axis}" for axis in "xyz"], wrench[:, :3], "force")
        add([f"ft.{foot}.m{axis}" for axis in "xyz"], wrench[:, 3:], "moment")
    label = {**LABEL, "seed": str(seed)}
    pq.write_table(pa.table(columns).replace_schema_metadata(label), path, compression="zstd")


def write_torque(path: Path, recording: Recording) -> None:
    """The true supporting torque [N·m] at the log's samples, of the joints that the bands act on; for scoring only."""
    columns = {"t": pa.array(recording.time)}
    for name, torque in zip(JOINT_NAMES, recording.band_torque.T, strict=True):
        if torque.any():
            columns[name] = pa.array(torque.astype(np.float32))
    pq.write_table(pa.table(columns).replace_schema_metadata(LABEL), path, compression="zstd")
