"""A study whose angles begin anew after a turn says what the same study says without."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.whole_service import small_study

from exogauge.studies.intake.open import open_study, read_recordings
from exogauge.studies.results.examine_logs import examine_logs


def written(folder: Path, anew: bool) -> Path:
    for path, content in small_study("turns").items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
    for log in (folder / "logs").iterdir() if anew else ():
        head, *rows = log.read_text().splitlines()
        place, table = head.split(",").index("q.elbow"), np.loadtxt(rows, delimiter=",")
        table[:, place] %= 2.0 * np.pi
        np.savetxt(log, table, delimiter=",", header=head, comments="", fmt="%.17g")
    return folder


@pytest.mark.slow
def test_angles_that_begin_anew_are_read_as_one_course_and_told(tmp_path: Path) -> None:
    found = {}
    for anew in (False, True):
        with open_study(written(tmp_path / str(anew), anew)) as study:
            recordings = read_recordings(study)
            found[anew] = recordings, examine_logs(study.robot, recordings)
    for one, other in zip(found[False][0], found[True][0], strict=True):
        np.testing.assert_allclose(other.log.channels["q.elbow"], one.log.channels["q.elbow"], atol=1e-12)
    told = [each for each in found[True][1] if each["rule"] == "turns_continued"]
    assert {each["log"] for each in told} == {each.log.name for each in found[True][0]}
    assert all(each["severity"] == "warning" and "q.elbow" in each["detail"] for each in told)
    assert not [each for each in found[False][1] if each["rule"].startswith("turn")]
