"""The page offers the units that a mapping knows: `web/src/pages/import/quantities.ts` and `logs/units.py`."""

from __future__ import annotations

from functools import partial

import pytest
from tests.web import page_code

from exogauge.logs.units import units_of

by_the_page = partial(page_code.by_the_page, "pages/import/quantities.ts")
MEASURED = {
    ("t", ""): ("time",),
    ("q", ""): ("angle", "length"),
    ("dq", ""): ("angular velocity", "velocity"),
    ("ddq", ""): ("angular acceleration", "acceleration"),
    ("i", ""): ("current",),
    ("tau", ""): ("torque", "force"),
    ("temp", ""): ("temperature",),
    ("gyro", ""): ("angular velocity",),
    ("acc", ""): ("acceleration",),
    ("ft", "fx"): ("force",),
    ("ft", "mx"): ("torque",),
}


@pytest.mark.slow
def test_every_unit_that_a_mapping_knows_is_offered_and_no_other() -> None:
    offered = by_the_page([("unitsOf", key) for key in MEASURED])
    for (quantity, axis), units, dimensions in zip(MEASURED, offered, MEASURED.values(), strict=True):
        assert set(units) == set(units_of(dimensions)), f"{quantity} {axis}"
