"""One study on local files: open, examine, identify, write. Nothing half-written ever looks whole."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from exogauge.errors import BadInput, PhysicallyImpossible
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress
from exogauge.robots.export import export_urdf
from exogauge.studies.examine_logs import examine_logs
from exogauge.studies.open import Study, open_study, read_recordings
from exogauge.studies.report import render_report
from exogauge.studies.results import Evaluation, parameter_table, results, to_json, validation_table
from exogauge.studies.series import write_series

RESULT, REPORT, SERIES, URDF = "results.json", "report.html", "series", "identified.urdf"
PARAMETERS, VALIDATION = "parameters.csv", "validation.csv"


def evaluate(path: Path, out: Path, progress: Progress, settings: Mapping[str, Any] | None = None) -> None:
    """Evaluate the study at `path` (study.yaml, folder or zip) into the folder `out`.

    settings: override those of study.yaml. progress may raise `Cancelled`. results.json is removed first and written
    last: where it stands, everything beside it belongs to it.
    """
    progress(0.0, "opening the study")
    with open_study(path, settings) as study:
        progress(0.02, "reading the logs")
        recordings = read_recordings(study)
        progress(0.10, "examining the logs")
        findings = examine_logs(study.robot, recordings)

        def inner(fraction: float, phrase: str) -> None:
            progress(0.15 + 0.70 * fraction, phrase)

        found = identify(study.robot, recordings, study.settings, inner)
        progress(0.87, "writing the results")
        write(study, found, findings, out)
    progress(1.0, "done")


def write(study: Study, found: Identification, findings: Sequence[Mapping[str, Any]], out: Path) -> None:
    """All result files, made in a folder beside their final place and moved there at the end."""
    out.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=out))
    try:
        (temporary / SERIES).mkdir()
        for prediction in found.predictions:
            write_series(prediction, temporary / SERIES / f"{prediction.log}.parquet")
        (temporary / PARAMETERS).write_bytes(parameter_table(found))
        (temporary / VALIDATION).write_bytes(validation_table(found))
        files = {"report": REPORT, "parameters": PARAMETERS, "validation": VALIDATION}
        files |= {f"series.{prediction.log}": f"{SERIES}/{prediction.log}.parquet" for prediction in found.predictions}
        urdf, warnings = identified_urdf(study, found)
        if urdf is not None:
            (temporary / URDF).write_bytes(urdf)
            files["urdf"] = URDF
        evaluation = Evaluation(
            study.name, study.robot, study.settings, study.steps, study.bundle.inputs, findings, found, warnings, files
        )
        (temporary / REPORT).write_text(render_report(evaluation), encoding="utf-8")
        (temporary / RESULT).write_bytes(to_json(results(evaluation)))
        _publish(temporary, out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def identified_urdf(study: Study, found: Identification) -> tuple[bytes | None, list[str]]:
    """The URDF with identified inertias, or why there is none."""
    try:
        return export_urdf(study.urdf, study.robot.tree, found.phi), []
    except PhysicallyImpossible as refused:
        links = ", ".join(refused.links)
        advice = "Ask for physical consistency in the settings to get one."
        return None, [
            f"No URDF with identified inertias was written, because no body can have those of {links}. {advice}"
        ]
    except BadInput as refused:
        return None, [f"No URDF with identified inertias was written: {refused}"]


def _publish(temporary: Path, out: Path) -> None:
    """Withdraw the old result, move the new files into place, results.json last."""
    for name in (RESULT, REPORT, URDF, PARAMETERS, VALIDATION):
        (out / name).unlink(missing_ok=True)
    shutil.rmtree(out / SERIES, ignore_errors=True)
    for path in sorted(temporary.iterdir(), key=lambda path: path.name == RESULT):
        os.replace(path, out / path.name)
