"""A joint of which position and effort may both be turned: what is fitted there may be of the mirror image."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tests.plausibility.long_arm import long_arm, record

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow


def identified(place: Path, rub: float) -> dict[str, Any]:
    """The wrist turned in all logs."""
    long_arm(place)
    lines = []
    for seed, role in ((1, "identification"), (2, "identification"), (3, "validation")):
        columns = record(seed, rub=rub)
        columns |= {name: -columns[name] for name in ("q.wrist", "i.wrist")}
        pq.write_table(pa.table({name: np.asarray(each) for name, each in columns.items()}), place / f"{seed}.parquet")
        lines.append(f"  - {{file: {seed}.parquet, role: {role}}}\n")
    (place / "study.yaml").write_text(
        f"version: 1\nname: arm\nrobot: robot.yaml\nlogs:\n{''.join(lines)}steps: [identify]\n"
    )
    evaluate(place / "study.yaml", place / "out", lambda *_: None)
    return json.loads((place / "out" / "results.json").read_text())


def test_where_the_logs_do_not_tell_a_joints_sign_none_of_its_parameters_counts_as_decided(tmp_path: Path) -> None:
    found = identified(tmp_path, rub=8.0)
    unsure = {each["channel"][2:] for each in found["doctor"] if each["rule"] == "sign_unsure"}
    assert "wrist" in unsure
    decided = {each["name"] for each in found["identification"]["parameters"] if each["identifiable"]}
    assert not [name for name in decided if name.endswith(tuple(f"[{joint}]" for joint in unsure))]
    assert "tau_c[wrist]" in found["identification"]["unidentifiable"]
