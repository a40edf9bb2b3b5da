"""The rows of a robot's equations in their order, and what each of them is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.intp]


class RowType(Enum):
    """BASE: force or moment on the base of a floating robot. AXIS: of an actuator axis in steady motion. AT_REST: the
    same axis at rest, where friction is known less well. SENSOR: what holds the bodies beyond a sensor that carries
    some."""

    BASE = "base"
    AXIS = "axis"
    AT_REST = "axis at rest"
    SENSOR = "sensor"


@final
@dataclass(frozen=True)
class Row:
    """place: the actuator axis, or the sensor among `Robot.cuts`. component: 0..5, force then moment."""

    type: RowType
    place: int = 0
    component: int = 0


@final
@dataclass(frozen=True)
class RowLayout:
    """A row's number is its place in `rows`. Rows of one type are neighbours, by place, then by component."""

    rows: tuple[Row, ...]

    @classmethod
    def of(cls, floating: bool, axes: int, sensors: int) -> RowLayout:
        return cls(
            (
                *(Row(RowType.BASE, 0, component) for component in range(6 if floating else 0)),
                *(Row(RowType.AXIS, axis) for axis in range(axes)),
                *(Row(RowType.AT_REST, axis) for axis in range(axes)),
                *(Row(RowType.SENSOR, sensor, component) for sensor in range(sensors) for component in range(6)),
            )
        )

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def told(self) -> RowLayout:
        """Without the rows at rest, which ask for what those of their axis do: every sample has each of these."""
        return RowLayout(tuple(row for row in self.rows if row.type != RowType.AT_REST))

    @cached_property
    def _numbers(self) -> Mapping[Row, int]:
        return {row: number for number, row in enumerate(self.rows)}

    def numbers(self, *types: RowType) -> tuple[int, ...]:
        return tuple(number for number, row in enumerate(self.rows) if row.type in types)

    def axis(self, axis: int) -> int:
        return self._numbers[Row(RowType.AXIS, axis)]

    def resting(self, axis: int) -> int:
        return self._numbers[Row(RowType.AT_REST, axis)]

    def sensor(self, sensor: int) -> range:
        """Its six."""
        first = self._numbers[Row(RowType.SENSOR, sensor)]
        return range(first, first + 6)

    def moving(self, number: int) -> int:
        """Of a row at rest, that of its axis in steady motion; of any other, itself."""
        row = self.rows[number]
        return self.axis(row.place) if row.type == RowType.AT_REST else number

    def in_told(self, numbers: Sequence[int]) -> IntArray:
        """(n,) where these rows stand in `told`, those at rest with their axis."""
        return np.array([self.told._numbers[self.rows[self.moving(number)]] for number in numbers], dtype=np.intp)

    @cached_property
    def base(self) -> slice:
        return self._part(RowType.BASE)

    @cached_property
    def axes(self) -> slice:
        return self._part(RowType.AXIS)

    @cached_property
    def at_rest(self) -> slice:
        return self._part(RowType.AT_REST)

    @cached_property
    def sensors(self) -> slice:
        return self._part(RowType.SENSOR)

    def _part(self, asked: RowType) -> slice:
        numbers = self.numbers(asked)
        return slice(numbers[0], numbers[-1] + 1) if numbers else slice(0)
