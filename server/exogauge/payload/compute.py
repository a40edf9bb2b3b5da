"""What the service computes of a payload: identification and plans, as `compute(folder, out, progress, settings)`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from exogauge.payload.contract import SettingsEntry
from exogauge.payload.evaluate import evaluate
from exogauge.payload.intake import Payload, open_payload
from exogauge.payload.planning.plan import open_plan, plan_excitation, plan_postures, write_plan
from exogauge.payload.report import write_report
from exogauge.payload.results import results, write_results
from exogauge.progress import Doing, Stage
from exogauge.studies.words.progress_words import phrase

PLAN = "plan.json"
Progress = Callable[[float, str], None]
Report = Callable[[float, str, Stage], None]


def identify(folder: Path, out: Path, report: Report, settings: Mapping[str, Any]) -> None:
    """results.json and its schema, report.html and the one-page summary. settings: override those of payload.yaml."""

    read = 0.1  # of a job: by then the logs are in memory

    def progress(share: float, stage: Stage, doing: Doing, of: str = "") -> None:
        report(read + (0.95 - read) * share, phrase(doing, of), stage)

    report(0.0, phrase(Doing.READING_LOGS), Stage.READING)
    payload = with_settings(open_payload(folder), settings)
    evaluation = evaluate(payload, progress)
    report(0.95, phrase(Doing.WRITING_RESULTS), Stage.WRITING)
    write_results(evaluation, out)
    write_report(results(evaluation), out)


def plan(folder: Path, out: Path, progress: Progress, settings: Mapping[str, Any]) -> None:
    """plan.json, and postures.csv or excitation.csv. settings: `what` is planned."""
    progress(0.0, "reading the robot")
    asked = open_plan(folder)
    make = plan_postures if settings["what"] == "postures" else plan_excitation
    _, told = write_plan(make(asked, progress), out)
    told.rename(out / PLAN)


def with_settings(payload: Payload, settings: Mapping[str, Any]) -> Payload:
    merged = SettingsEntry.model_validate({**payload.file.settings.model_dump(), **settings})
    return replace(payload, file=payload.file.model_copy(update={"settings": merged}))
