"""A joint of which position and effort may both be turned: what is fitted there may be of the mirror image."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tests.plausibility.long_arm import JOINTS, K_T, long_arm, record

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow


def identified(place: Path, rub: float, checked: bool = False, every: int = 1) -> dict[str, Any]:
    """The wrist turned in all logs, which hold torques. checked: robot.yaml says of every joint that somebody has
    looked. every: of how many samples one is kept."""
    long_arm(place)
    robot, looked = place / "robot.yaml", "sign_checked: true, " if checked else ""
    robot.write_text(re.sub(r"actuation: current, prior: {.*}}", f"{looked}actuation: torque}}", robot.read_text()))
    lines = []
    for seed, role in ((1, "identification"), (2, "identification"), (3, "validation")):
        columns = record(seed, rub=rub)
        columns |= {f"tau.{name}": k_T * columns.pop(f"i.{name}") for name, k_T in zip(JOINTS, K_T, strict=True)}
        columns |= {name: -columns[name] for name in ("q.wrist", "tau.wrist")}
        pq.write_table(
            pa.table({name: np.asarray(each)[::every] for name, each in columns.items()}), place / f"{seed}.parquet"
        )
        lines.append(f"  - {{file: {seed}.parquet, role: {role}}}\n")
    (place / "study.yaml").write_text(
        f"version: 1\nname: arm\nrobot: robot.yaml\nlogs:\n{''.join(lines)}steps: [identify]\n"
    )
    evaluate(place / "study.yaml", place / "out", lambda *_: None)
    return json.loads((place / "out" / "results.json").read_text())


def test_a_joint_of_unsure_sign_has_no_decided_parameter_until_somebody_has_looked(tmp_path: Path) -> None:
    found, stated = identified(tmp_path / "as_told", rub=8.0), identified(tmp_path / "looked", rub=8.0, checked=True)
    unsure = {each["channel"][2:] for each in found["doctor"] if each["rule"] == "sign_unsure"}
    assert "wrist" in unsure
    assert not [each for each in stated["doctor"] if each["rule"] == "sign_unsure"]
    of_the_wrist = [
        {
            each["name"]: each["identifiable"]
            for each in one["identification"]["parameters"]
            if "[wrist]" in each["name"]
        }
        for one in (found, stated)
    ]
    assert not any(of_the_wrist[0].values())
    assert of_the_wrist[1]["tau_c[wrist]"]
    assert "tau_c[wrist]" in found["identification"]["unidentifiable"]


def test_of_logs_that_are_slowly_sampled_no_friction_is_decided(tmp_path: Path) -> None:
    """It turns round between the samples: k_d was too large and tau_c too small at every joint."""
    found = identified(tmp_path, rub=8.0, checked=True, every=10)
    assert "slowly_sampled" in {each["rule"] for each in found["doctor"]}
    decided = {each["name"] for each in found["identification"]["parameters"] if each["identifiable"]}
    assert decided
    assert not [name for name in decided if name.startswith(("k_d[", "tau_c[", "tau_s[", "J_r["))]
