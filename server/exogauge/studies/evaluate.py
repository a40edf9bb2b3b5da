"""One study on local files: open, examine, identify, write. Nothing half-written ever looks whole."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from exogauge.detect.device.finding import with_numbers_beside
from exogauge.detect.device.uncovered_joints import look_beyond
from exogauge.detect.device.workflow import find_band_effects
from exogauge.detect.not_searched import not_searched
from exogauge.detect.pipeline import find_missing_effects
from exogauge.detect.stored_filter.stored_pass import filtered_alike
from exogauge.devices.result import StiffnessResult
from exogauge.effects.catalogue import missing_effects
from exogauge.errors import BadInput, BadLog, BadRobot, PhysicallyImpossible
from exogauge.findings.as_told import by_importance
from exogauge.findings.result import Discrepancy
from exogauge.identification.identify import identify
from exogauge.identification.model import RobotModel
from exogauge.identification.result import Identification, Prediction
from exogauge.logs.followed import followed
from exogauge.logs.model import Log
from exogauge.progress import Doing, Progress, Stage
from exogauge.remarks import About, Remark
from exogauge.resident import give_back
from exogauge.robots.export import export_urdf
from exogauge.robots.moving.robot import MotionRobot
from exogauge.side_by_side import each as side_by_side
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.contract import STEPS, DeviceFile
from exogauge.studies.intake.moving_robot import moving_robot
from exogauge.studies.intake.open import Study, open_study
from exogauge.studies.intake.plans import read_plans
from exogauge.studies.intake.yaml_file import MAX_BYTES, read_yaml
from exogauge.studies.report.summary_page import summary_page
from exogauge.studies.report.write import render_report
from exogauge.studies.results.configuration import study_record
from exogauge.studies.results.discrepancy_results import (
    PLANNED,
    discrepancy_entry,
    file_name,
    motion_table,
    planned_files,
)
from exogauge.studies.results.document import Evaluation, parameter_table, results, to_json, validation_table
from exogauge.studies.results.examine_logs import (
    examine_logs,
    late_and_not_in_the_model,
    refuse_what_made_it_worse,
    suspects,
    told_of_errors,
    unsure_coefficients,
    unsure_joints,
    without_spoiled,
    worn_without_spoiled,
)
from exogauge.studies.results.failed_step import FailedStep, keeping, told
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.plan_results import FOLLOWED, PlansOfStudy, followed_files
from exogauge.studies.results.support_results import before_after, stiffness_entries, stiffness_table, support_table
from exogauge.studies.results.taken_over import TAKEN_OVER, taken_over
from exogauge.studies.series.write import Moved, write_series
from exogauge.studies.words.notices import Notice, notice
from exogauge.studies.words.progress_words import phrase
from exogauge.support.evaluate import (
    Consequences,
    Gathered,
    beside_named,
    conclude_support,
    consequences,
    gather_support,
)
from exogauge.support.notes import in_doubt
from exogauge.support.result import SupportResult, Trial
from exogauge.support.settings import PlainLog, WornLog

RESULT, REPORT, SERIES, URDF = "results.json", "report.html", "series", "identified.urdf"
PAGE_HTML, PAGE_PDF = "summary.html", "summary.pdf"
PARAMETERS, VALIDATION, SUPPORT, STIFFNESS = "parameters.csv", "validation.csv", "support.csv", "stiffness.csv"
NOT_ASKED_FOR = "not asked for"

Report = Callable[[float, str, Stage], None]
"""Called with a share 0…1 of the whole, what is being done in words, and the stage that it belongs to."""


def evaluate(
    path: Path, out: Path, report: Report, settings: Mapping[str, Any] | None = None
) -> tuple[FailedStep, ...]:
    """Evaluate the study at `path` (study.yaml, folder or zip) into the folder `out`: every step its files allow.

    settings: override those of study.yaml. report may raise `Cancelled`. An older result is removed first and
    results.json written last: where it stands, everything beside it belongs to it. A step behind the identification
    that fails keeps what was found before it; those that failed are returned, and told in results.json.
    """
    return _evaluate(path, out, report, settings, STEPS)


def evaluate_support(
    path: Path, out: Path, report: Report, settings: Mapping[str, Any] | None = None
) -> tuple[FailedStep, ...]:
    """As `evaluate`, up to the supporting torque."""
    return _evaluate(path, out, report, settings, ("identify", "support"))


def evaluate_stiffness(
    path: Path, out: Path, report: Report, settings: Mapping[str, Any] | None = None
) -> tuple[FailedStep, ...]:
    """As `evaluate`, up to the stiffness of the bands."""
    return _evaluate(path, out, report, settings, ("identify", "support", "stiffness"))


def _evaluate(
    path: Path, out: Path, report: Report, settings: Mapping[str, Any] | None, asked: Sequence[str]
) -> tuple[FailedStep, ...]:
    withdraw(out)
    reading, writing = _said(report, Stage.READING), _said(report, Stage.WRITING)
    reading(0.0, Doing.OPENING_STUDY)
    with open_study(path, settings) as study:
        steps = tuple(step if step.step in asked else replace(step, skipped=NOT_ASKED_FOR) for step in study.steps)
        doing = {step.step for step in steps if step.skipped is None}
        reading(0.02, Doing.READING_LOGS)
        logs = admit(study, worn="support" in doing, progress=reading)
        reading(0.10, Doing.EXAMINING_LOGS)
        findings = examine_logs(study.robot, logs.recordings, logs.worn, study.settings.criteria)
        plans = _plans_of(study, [*(each.log for each in logs.recordings), *(each.log for each in logs.worn)])
        compared = frozenset(name for name, each in study.motions.items() if each.role == "without_device")
        kept = without_spoiled(study.robot, logs.recordings, findings, compared)
        recordings, spoiled = kept.recordings, kept.spoiled
        plain = logs.as_plain(recordings)
        used_worn = worn_without_spoiled(study.robot, logs.worn, findings)
        worn, kept = used_worn.logs, replace(kept, findings=used_worn.about_used(kept.findings))
        spans = _spans(report, bool(worn), "discrepancy" in doing)
        try:
            found = identify(study.robot, recordings, study.settings, spans[Stage.IDENTIFY])
        except BadLog as error:  # what the doctor suspects comes first: it knows the cause
            raise BadLog([*suspects(kept.findings), *error.faults]) from error
        if not spoiled and "discrepancy" not in doing:  # where it is, what has no name yet looks like a wrong number
            found = not_searched(found, recordings, study.settings)
        doubts, bare = refuse_what_made_it_worse(found, recordings, kept.findings), found.model
        doubts = [*kept.notices, *used_worn.notices, *told_of_errors(study.robot, kept.findings), *doubts]
        give_back()
        failed = list[FailedStep]()
        discrepancy: Discrepancy | None = None
        used = study.settings
        plain_now: Sequence[PlainLog] = plain
        worn_now: Sequence[WornLog] = worn
        if "discrepancy" in doing:
            with keeping(failed, "discrepancy"):
                missing = find_missing_effects(
                    found, recordings, missing_effects(), study.settings, spans[Stage.DISCREPANCY], _moving(study),
                    spoiled=spoiled[0] if spoiled else "",
                )  # fmt: skip
                alike = filtered_alike(worn, missing.recordings, missing.settings.criteria.stored_filter)
                discrepancy, found, used = missing.discrepancy, missing.identification, missing.settings
                plain_now, worn_now = logs.as_plain(missing.recordings), alike
        support, stiffness = None, tuple[StiffnessResult, ...]()
        give_back()
        if logs.worn:
            with keeping(failed, *(step for step in ("support", "stiffness") if step in doing)):
                if not worn:
                    raise used_worn.refused()
                support, stiffness, discrepancy = _with_devices(
                    study, found, bare, (plain, worn), (plain_now, worn_now),
                    discrepancy, bool(spoiled), spans[Stage.SUPPORT], failed,
                )  # fmt: skip
        give_back()
        told_of = found.by_stated_constants().with_undecided(
            unsure_joints(kept.findings), unsure_coefficients(recordings, kept.findings)
        )
        late = late_and_not_in_the_model(recordings, kept.findings, used, discrepancy)
        if nothing := bool(spoiled or late):
            told_of = told_of.with_nothing_decided()
        devices = {each.device for each in stiffness} | {each.device for each in (support.joints if support else ())}
        undecided = devices if nothing else in_doubt(support.remarks if support else (), devices)
        stiffness = tuple(each.with_nothing_decided() if each.device in undecided else each for each in stiffness)
        support = support and support.with_nothing_decided(undecided)
        writing(0.87, Doing.WRITING_RESULTS)
        evaluation = Evaluation(
            name=study.name,
            robot=study.robot,
            settings=used,
            steps=told(steps, failed),
            inputs=study.bundle.inputs,
            findings=findings,
            identification=told_of,
            notices=(*study.notices, *doubts, *late, *(Notice("failed_step", each.sentence) for each in failed)),
            files={},
            support=support,
            stiffness=stiffness if "stiffness" in doing else (),
            discrepancy=discrepancy,
            record=study_record(study, [*(each.log for each in recordings), *(each.log for each in worn)], found),
            support_settings=study.support_settings,
            logs=[*(each.log for each in recordings), *(each.log for each in worn)],
            plans=plans,
        )
        write(study, evaluation, out)
    writing(1.0, Doing.DONE)
    return tuple(failed)


def _plans_of(study: Study, logs: Sequence[Log]) -> PlansOfStudy:
    """Which logs are of which planned motion; of a log that was cut at gaps each stretch is looked at."""
    plans = read_plans(study)
    series = [plan.series for plan in plans]
    found = [followed(log, series, study.settings.criteria.following) for log in logs] if plans else []
    return PlansOfStudy(plans, [each for each in found if each is not None], study.robot.tree.sliding)


def _moving(study: Study) -> MotionRobot | None:
    """The robot as motions are planned for it; None where its file tells something of it that it is not."""
    try:
        path = study.bundle.root / study.file.robot
        return moving_robot(study.robot, study.robot_file, study.urdf, path)
    except BadRobot:
        return None


def _with_devices(
    study: Study,
    found: Identification,
    bare: RobotModel,
    logs_of_bare: tuple[Sequence[PlainLog], Sequence[WornLog]],
    logs: tuple[Sequence[PlainLog], Sequence[WornLog]],
    discrepancy: Discrepancy | None,
    spoiled: bool,
    span: Progress,
    failed: list[FailedStep],
) -> tuple[SupportResult, tuple[StiffnessResult, ...], Discrepancy | None]:
    """Supporting torque, bands, and what is missing with what the bands lack. bare: the model before anything was
    named. What is gathered of the logs on the way is not held while results are written."""
    (plain, worn), twice = logs, found.model is not bare
    begin, untold = _part(0.0, 0.5, span) if twice else span, list[FailedStep]()
    earlier: Consequences | None = None
    with keeping(untold, "discrepancy"):
        if twice:  # first, as what logs say of two models is too much to be held at once
            earlier = consequences(bare, *logs_of_bare, study.support_settings, begin)
            begin = _part(0.5, 1.0, span)
            give_back()
    gathered = gather_support(found.model, plain, worn, study.support_settings, begin)
    support, stiffness = conclude_support(found.model, gathered, worn, study.support_settings, begin)
    failed += untold
    if discrepancy is not None and not untold and not spoiled:
        with keeping(failed, "discrepancy"):
            if earlier is not None:
                difference = before_after(earlier, (support, stiffness))
                discrepancy = replace(discrepancy, before_after=difference)
            discrepancy = _with_wear(study, found, plain, gathered, stiffness, discrepancy, span)
            stiffness = beside_named(found.model, gathered, stiffness, discrepancy.bands)
            discrepancy = with_numbers_beside(discrepancy, stiffness)
    return support, stiffness, discrepancy


def _with_wear(
    study: Study,
    found: Identification,
    plain: Sequence[PlainLog],
    gathered: Gathered,
    stiffness: Sequence[StiffnessResult],
    discrepancy: Discrepancy,
    progress: Progress,
) -> Discrepancy:
    """What the model of the wear lacks, behind what that of the robot lacked."""
    progress(0.99, Doing.LOOKING_FOR_BAND_EFFECTS, "the bands")
    give_back()
    beyond = look_beyond(found.model, gathered, plain, study.support_settings)
    complete = find_band_effects(found.model, gathered, stiffness, discrepancy, beyond)
    return replace(complete, findings=by_importance(complete.findings))


def _spans(report: Report, worn: bool, discrepancy: bool) -> dict[Stage, Progress]:
    """Each step's own progress 0…1 within the whole's, by what it takes of the time."""
    weights = {
        Stage.IDENTIFY: 2.0,
        Stage.DISCREPANCY: 4.0 if discrepancy else 0.0,
        Stage.SUPPORT: 2.0 if worn else 0.0,
    }
    total, start = sum(weights.values()), 0.15
    spans: dict[Stage, Progress] = {}
    for stage, weight in weights.items():
        stop = start + 0.72 * weight / total
        spans[stage] = _part(start, stop, _said(report, stage))
        start = stop
    return spans


def _said(report: Report, stage: Stage) -> Progress:
    """Progress in words, at its stage."""

    def progress(share: float, doing: Doing, of: str = "") -> None:
        report(share, phrase(doing, of), stage)

    return progress


def _part(start: float, stop: float, progress: Progress) -> Progress:
    """The part of a progress from `start` to `stop`."""

    def part(share: float, doing: Doing, of: str = "") -> None:
        progress(start + (stop - start) * share, doing, of)

    return part


def write(study: Study, evaluation: Evaluation, out: Path) -> None:
    """All result files, made in a folder beside their final place and moved there at the end."""
    out.mkdir(parents=True, exist_ok=True)
    found = evaluation.identification
    temporary = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=out))
    try:
        files = {
            "report": REPORT,
            "page": PAGE_HTML,
            "page_pdf": PAGE_PDF,
            "parameters": PARAMETERS,
            "validation": VALIDATION,
        }
        (temporary / PARAMETERS).write_bytes(parameter_table(found))
        (temporary / VALIDATION).write_bytes(validation_table(found))
        if evaluation.support is not None:
            (temporary / SUPPORT).write_bytes(support_table(evaluation.support))
            files["support"] = SUPPORT
        if evaluation.stiffness:
            (temporary / STIFFNESS).write_bytes(stiffness_table(evaluation.stiffness))
            files["stiffness"] = STIFFNESS
        for name, plan in planned_files(evaluation.discrepancy):
            (temporary / file_name(name)).write_bytes(motion_table(plan))
            files[name] = file_name(name)
        for name, table in followed_files(evaluation.plans):
            (temporary / file_name(name)).write_bytes(table)
            files[name] = file_name(name)
        evaluation = replace(evaluation, taken_over=_write_taken_over(study, evaluation, temporary, files))
        files |= _write_all_series(evaluation, temporary)
        urdf, notices = identified_urdf(study, found)
        if any(each.code == About.SPOILED_FIT for each in evaluation.notices):
            urdf, notices = (
                None,
                [Notice("no_urdf", "No URDF with identified inertias was written: the fit is spoiled.")],
            )
        if urdf is not None:
            (temporary / URDF).write_bytes(urdf)
            files["urdf"] = URDF
        evaluation = replace(evaluation, notices=[*evaluation.notices, *notices], files=files)
        (temporary / REPORT).write_text(render_report(evaluation), encoding="utf-8")
        content = results(evaluation)
        page = summary_page(content)
        (temporary / PAGE_HTML).write_bytes(page.html)
        (temporary / PAGE_PDF).write_bytes(page.pdf)
        (temporary / RESULT).write_bytes(to_json(content))
        _publish(temporary, out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _write_taken_over(study: Study, evaluation: Evaluation, folder: Path, files: dict[str, str]) -> dict[int, str]:
    """Device files with what was named of their bands, one for each device of which anything was; rank -> file."""
    found, ranks = finite(discrepancy_entry(evaluation.discrepancy) or {}), dict[int, str]()
    stiffness = finite(stiffness_entries(evaluation.stiffness))
    for number, written in enumerate(study.devices, 1):
        content = read_yaml(study.bundle.read(written, limit=MAX_BYTES), DeviceFile, file=written)[1]
        taken = taken_over(content, found.get("findings", []), stiffness)
        if taken.ranks:
            name = f"taken_over_{number}"
            (folder / f"{name}.yaml").write_text(taken.text(f"the study {evaluation.name!r}"), encoding="utf-8")
            files[name] = f"{name}.yaml"
            ranks |= dict.fromkeys(taken.ranks, files[name])
    return ranks


def _write_all_series(evaluation: Evaluation, folder: Path) -> dict[str, str]:
    """`series.<log>` -> its file. Logs with a device hold their supporting torques too."""
    (folder / SERIES).mkdir()
    every: list[tuple[Prediction, Trial | None]] = [(each, None) for each in evaluation.identification.predictions]
    every += [(trial.prediction, trial) for trial in (evaluation.support.trials if evaluation.support else ())]
    logs, cutoff_hz = {log.name: log for log in evaluation.logs}, evaluation.identification.cutoff_hz

    def written(of: tuple[Prediction, Trial | None]) -> None:
        prediction, trial = of
        log = logs.get(prediction.log)
        moved = None if log is None else Moved(evaluation.robot, log, cutoff_hz)
        write_series(prediction, folder / SERIES / f"{prediction.log}.parquet", trial, moved)

    for _ in side_by_side(written, every):
        pass
    return {f"series.{prediction.log}": f"{SERIES}/{prediction.log}.parquet" for prediction, _ in every}


def identified_urdf(study: Study, found: Identification) -> tuple[bytes | None, list[Notice]]:
    """The URDF with identified inertias, or why there is none."""
    try:
        return export_urdf(study.urdf, study.robot.tree, found.phi), []
    except PhysicallyImpossible as refused:
        return None, [notice(Remark(About.NO_URDF_OF, tuple(refused.links)))]
    except BadInput as refused:
        return None, [Notice("no_urdf", f"No URDF with identified inertias was written: {refused}")]


def _publish(temporary: Path, out: Path) -> None:
    """Withdraw the old result, move the new files into place, results.json last."""
    withdraw(out)
    for path in sorted(temporary.iterdir(), key=lambda path: path.name == RESULT):
        os.replace(path, out / path.name)


def withdraw(out: Path) -> None:
    """What an earlier evaluation has left in `out`, its results.json first."""
    for name in (RESULT, REPORT, PAGE_HTML, PAGE_PDF, URDF, PARAMETERS, VALIDATION, SUPPORT, STIFFNESS):
        (out / name).unlink(missing_ok=True)
    for own in (PLANNED, FOLLOWED, TAKEN_OVER):
        for file in out.glob(own):
            file.unlink()
    shutil.rmtree(out / SERIES, ignore_errors=True)
