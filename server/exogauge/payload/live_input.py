"""Rows of numbers as they arrive, in the columns and units of payload.yaml, to what the engine takes; what is refused
and what is counted on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.criteria.payload_live import USUAL, Streaming
from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.logs.channels import shorten
from exogauge.payload.contract import PayloadFile
from exogauge.payload.intake import Stream, check_angles, check_rotation, factor_of, from_quaternion
from exogauge.payload.prepare import into_sensor
from exogauge.payload.sensor_motion import Chain

Array = NDArray[np.float64]


@final
class Columns:
    """What a row holds: time, pose, position where there is one, wrench; names and units are those of payload.yaml."""

    def __init__(self, file: PayloadFile, chain: Chain | None) -> None:
        pose, sensor = file.pose, file.sensor
        self.file, self._chain = file, chain
        self.pose = [*(pose.joints.values() if pose.joints else pose.rotation or pose.quaternion or ())]
        self.position = [] if pose.joints else [*(pose.position or ())]
        self.names = (file.time.column, *self.pose, *self.position, *sensor.wrench)
        unit = pose.angle_unit if pose.joints else None
        name = "payload.yaml"
        self._factors = np.concatenate([
            [factor_of(file.time.unit, "time", name)],
            np.full(len(self.pose), factor_of(unit, "angle", name) if unit else 1.0),
            np.full(len(self.position), factor_of(pose.position_unit, "length", name)),
            np.repeat([factor_of(sensor.force_unit, "force", name), factor_of(sensor.moment_unit, "torque", name)], 3),
        ])  # fmt: skip

    def read(self, rows: Array) -> tuple[Array, Array, Array]:
        """rows: (n, columns). Time (n,) [s], pose (n, K), wrench (n, 6) in {S}, all SI. Raises BadStudy: row counts
        from 1."""
        if rows.ndim != 2 or rows.shape[1] != len(self.names):
            found = rows.shape[1] if rows.ndim == 2 else 0
            advice = f"In this order: {', '.join(self.names)}."
            detail = f"a sample has {len(self.names)} numbers"
            raise BadStudy(Fault(detail, "wrong_width", advice, "stream", value=str(found)))
        bad = np.argwhere(~(np.abs(rows) <= LOGS.largest))
        if len(bad):
            row, column = (int(k) for k in bad[0])
            detail = "not a finite number, or beyond any reading"
            advice = "Leave the sample out: it counts as missing."
            value = str(rows[row, column])
            raise BadStudy(Fault(detail, "not_finite", advice, "stream", row + 1, shorten(self.names[column]), value))
        si = rows * self._factors
        pose = Stream(si[:, 0], si[:, 1 : 1 + len(self.pose)], "stream")
        if self._chain is not None:
            check_angles(pose, self.pose)
        elif self.file.pose.rotation is not None:
            check_rotation(pose, self.pose[0])
        else:
            pose = from_quaternion(pose, self.file.pose.quaternion_order or "xyzw")
        position = si[:, 1 + len(self.pose) : -6]
        wrench = si[:, -6:]
        if self.file.sensor.axes == "base":
            wrench = into_sensor(self._rotation(pose.values), wrench)
        return si[:, 0], np.column_stack([pose.values, position]), wrench

    def _rotation(self, pose: Array) -> Array:
        if self._chain is None:
            return pose.reshape(-1, 3, 3)
        return self._chain.rotations(pose)

    def read_some(self, rows: Array) -> tuple[NDArray[np.bool_], tuple[Array, Array, Array] | None, list[Fault]]:
        """Which rows can be read, what they say, and what is wrong with the first of the others."""
        try:
            return np.ones(len(rows), dtype=bool), self.read(rows) if len(rows) else None, []
        except BadInput as error:
            if rows.ndim != 2 or rows.shape[1] != len(self.names):
                raise
            faults = list(error.faults)
        good = np.array([self._readable(row[None]) for row in rows])
        return good, self.read(rows[good]) if good.any() else None, faults

    def _readable(self, row: Array) -> bool:
        try:
            self.read(row)
        except BadInput:
            return False
        return True


@final
@dataclass
class Counts:
    """received: rows that came, whatever became of them. taken: by the engine. missing: numbers that were left out and
    have not come. doubled: came before. out_of_order: come after a later one, by number or by time. late: taken, more
    than 0.1 s behind the quickest. refused: no readable sample."""

    received: int = 0
    taken: int = 0
    missing: int = 0
    doubled: int = 0
    out_of_order: int = 0
    late: int = 0
    refused: int = 0

    def plain(self) -> Mapping[str, int]:
        return asdict(self)


@final
class Arrivals:
    """Which samples are taken: each later than all before, by number and by time. The rest is counted."""

    def __init__(self, last: int | None = None, time: float = -np.inf, criteria: Streaming = USUAL) -> None:
        """last, time: number and time [s] of the last sample of a stream that goes on; None: any number begins."""
        self.counts, self._criteria = Counts(), criteria
        self.last, self.time = last, time
        self._missing = set[int]()
        self._quickest = np.inf

    def admit(self, numbers: NDArray[np.int64], time: Array, clock: float | None = None) -> NDArray[np.bool_]:
        """(n,) which are taken. time: (n,) [s] of the sender. clock: [s] now, here; None where nobody waits."""
        remembered = 10_000  # numbers of samples that have not come
        keep = np.zeros(len(numbers), dtype=bool)
        counts = self.counts
        for k, (number, t) in enumerate(zip(numbers.tolist(), time.tolist(), strict=True)):
            if self.last is not None and number <= self.last:
                if number in self._missing:
                    self._missing.discard(number)
                    counts.missing, counts.out_of_order = counts.missing - 1, counts.out_of_order + 1
                else:
                    counts.doubled += 1
                continue
            if self.last is not None and number > self.last + 1:
                counts.missing += number - self.last - 1
                first = max(self.last + 1, number - remembered)
                self._missing.update(range(first, number))
                if len(self._missing) > remembered:
                    self._missing = set(sorted(self._missing)[-remembered:])
            self.last = number
            if t <= self.time:
                counts.out_of_order += 1
                continue
            self.time = t
            keep[k] = True
            if clock is not None:
                self._quickest = min(self._quickest, clock - t)
                counts.late += clock - t > self._quickest + self._criteria.late_s
        counts.taken += int(keep.sum())
        return keep
