"""What a process writes belongs to the code that it loaded, whatever lies on the disk by then."""

from __future__ import annotations

import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import exogauge
from exogauge.studies.report.summary_page import summary_page
from exogauge.studies.report.write import render_report
from exogauge.studies.results.document import Evaluation, results

PACKAGE = Path(exogauge.__file__).parent
RUN = """
import pickle, sys
from pathlib import Path
copy, folder = Path(sys.argv[1]), Path(sys.argv[2])
sys.path.insert(0, str(copy))
import exogauge.studies.evaluate
from exogauge.studies.report.summary_page import summary_page
from exogauge.studies.report.write import render_report
from exogauge.studies.results.document import results
assert Path(exogauge.__file__).is_relative_to(copy)
evaluation = pickle.loads((folder / "evaluation").read_bytes())
for path in (copy / "exogauge").rglob("*"):
    if path.is_file() and path.suffix not in (".py", ".pyc"):
        path.write_text("{{ what_only_newer_code_knows }}")
(folder / "report.html").write_text(render_report(evaluation), encoding="utf-8")
(folder / "summary.html").write_bytes(summary_page(results(evaluation)).html)
"""


@pytest.mark.slow
def test_an_upgrade_beneath_a_running_job_leaves_its_reports_as_they_were(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    """Every data file of the package is replaced after the code was loaded, and before anything was rendered."""
    shutil.copytree(PACKAGE, tmp_path / "exogauge", ignore=shutil.ignore_patterns("*.nb?", "*.pyc.*", "_packaged"))
    (tmp_path / "evaluation").write_bytes(pickle.dumps(evaluation))
    subprocess.run([sys.executable, "-c", RUN, str(tmp_path), str(tmp_path)], check=True, timeout=120)
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == render_report(evaluation)
    assert (tmp_path / "summary.html").read_bytes() == summary_page(results(evaluation)).html
