"""Rows of a robot's equations: each has one number, and those at rest are asked what their axis is."""

from __future__ import annotations

import pytest

from exogauge.robots.rows import Row, RowLayout, RowType

LAYOUT = RowLayout.of(floating=True, axes=3, sensors=2)


@pytest.mark.parametrize("layout", [LAYOUT, LAYOUT.told, RowLayout.of(floating=False, axes=2, sensors=1)])
def test_parts_are_all_rows_each_once(layout):
    parts = (layout.base, layout.axes, layout.at_rest, layout.sensors)
    assert sum((layout.rows[part] for part in parts), ()) == layout.rows
    for part, kind in zip(parts, RowType, strict=True):
        assert {row.type for row in layout.rows[part]} <= {kind}


def test_a_row_is_found_by_what_it_is():
    assert LAYOUT.rows[LAYOUT.axis(2)] == Row(RowType.AXIS, 2)
    assert LAYOUT.rows[LAYOUT.resting(1)] == Row(RowType.AT_REST, 1)
    assert [LAYOUT.rows[k] for k in LAYOUT.sensor(1)] == [Row(RowType.SENSOR, 1, k) for k in range(6)]


def test_a_row_at_rest_stands_with_its_axis_among_those_that_every_sample_has():
    told = LAYOUT.told
    numbers = [0, LAYOUT.axis(1), LAYOUT.resting(1), LAYOUT.sensor(0)[5]]
    assert LAYOUT.in_told(numbers).tolist() == [0, told.axis(1), told.axis(1), told.sensor(0)[5]]
    assert [LAYOUT.moving(k) for k in numbers] == [0, LAYOUT.axis(1), LAYOUT.axis(1), LAYOUT.sensor(0)[5]]
