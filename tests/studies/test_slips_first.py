"""A slip of a mapping is told first: what else looks wrong because of it is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.api.conftest import ROBOT, URDF
from tests.client.worn_arm import write_worn_study
from tests.fuzz.small_robots import simulate, write_study

from exogauge.errors import BadStudy
from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.open import open_study
from exogauge.studies.intake.robot_file import load_robot
from exogauge.studies.results.examine_logs import examine_logs


def test_positions_in_degrees_are_all_that_is_wrong_though_one_log_stays_within_its_limits(tmp_path: Path) -> None:
    """There its own signals do not show it, and what joints should bear is wrong."""
    write_study(tmp_path, False, {})
    logs = []
    for seed, size in ((1, 1.5), (2, 0.02)):
        columns = simulate(False, seed, 20.0, size)
        time = columns.pop("t")
        in_degrees = {name: np.degrees(values) if name == "q.j2" else values for name, values in columns.items()}
        logs.append(Log(f"log_{seed}", time, in_degrees))
    found = examine_logs(load_robot(tmp_path), [Recording(each, False) for each in logs])
    assert {(each["rule"], each["channel"]) for each in found if each["severity"] == "error"} == {("degrees", "q.j2")}


@pytest.mark.slow
@pytest.mark.parametrize("in_degrees", [True, False])
def test_motions_that_differ_in_degrees_are_told_as_degrees_first(tmp_path: Path, in_degrees: bool) -> None:
    folder = write_worn_study(tmp_path, ROBOT, URDF, same_motion=False)
    for path in (folder / "logs").iterdir() if in_degrees else ():
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        table[:, 1] = np.degrees(table[:, 1])
        np.savetxt(path, table, "%.6f", delimiter=",", header="t,q.elbow,tau.elbow", comments="")
    with open_study(folder) as study, pytest.raises(BadStudy) as refused:
        admit(study)
    told = [(fault.rule, fault.column) for fault in refused.value.faults]
    assert told == [*[("degrees", "q.elbow")] * in_degrees, ("motions_differ", "q.elbow")]
