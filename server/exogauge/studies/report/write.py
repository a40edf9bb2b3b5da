"""report.html: one file that says what was found, shows it, and says where it came from; no outside requests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from markupsafe import Markup

from exogauge.identification.result import Channels, Identification, Prediction
from exogauge.studies.report.discrepancy_section import discrepancy_view
from exogauge.studies.report.figures import draw_curve, draw_series, label
from exogauge.studies.report.plan_section import plan_rows
from exogauge.studies.report.report_head import kicker, lead, leads, tiles
from exogauge.studies.report.report_tables import (
    base_table,
    doubts_of_parameters,
    figure_channels,
    fit_tables,
    joint_table,
    link_table,
    load_table,
    sensor_table,
    unknowns,
)
from exogauge.studies.report.stiffness_section import device_views
from exogauge.studies.report.summary_page import TEMPLATES
from exogauge.studies.report.support_section import motion_views
from exogauge.studies.results.document import Evaluation, Summary, all_notices, results, summaries
from exogauge.studies.words.notices import by_sort, repeats
from exogauge.studies.words.rounding import significant

MAX_DRAWN_LOGS = 4


@final
@dataclass(frozen=True)
class Drawing:
    """An inline SVG, the words that stand in for it, and the caption's words."""

    svg: Markup
    words: str
    log: str
    held_out: bool


def render_report(evaluation: Evaluation) -> str:
    found = evaluation.identification
    content = results(evaluation)
    joints = [joint.name for joint in evaluation.robot.joints]
    pooled = summaries(found, joints)
    columns, rows = joint_table(found, evaluation.robot)
    held_out = any(fit.held_out for fit in found.validation)
    return TEMPLATES.get_template("report.html.j2").render(
        evaluation=evaluation,
        found=found,
        content=content,
        synthetic=evaluation.synthetic,
        kicker=kicker(evaluation),
        lead=lead(evaluation, pooled),
        leads=leads(evaluation),
        plan_rows=plan_rows(content["plans"]),
        gap=discrepancy_view(evaluation.discrepancy, content),
        support_views=motion_views(evaluation.support) if evaluation.support else [],
        stiffness_views=device_views(evaluation.stiffness),
        tile_rows=tiles(evaluation, pooled),
        held_out=held_out,
        notices=all_notices(evaluation),
        findings=by_sort(content["doctor"]),
        parted=any(fit.rmse_at_rest is not None for fit in found.validation),
        held_out_tables=fit_tables(found, held_out=True),
        fitted_tables=fit_tables(found, held_out=False),
        drawings=_drawings(found, pooled, held_out),
        drawn_logs=MAX_DRAWN_LOGS,
        joint_columns=columns,
        joint_rows=rows,
        sensors=sensor_table(found, evaluation.robot),
        load_rows=load_table(found, evaluation.robot),
        link_rows=link_table(found, evaluation.robot),
        base_rows=base_table(found),
        parameter_doubts=doubts_of_parameters(found),
        unknowns=unknowns(found),
        curve=_curve(found),
        sig=significant,
    )


def _drawings(found: Identification, pooled: Sequence[Summary], held_out: bool) -> list[Drawing]:
    trunk = next((each.channels for each in pooled if each.kind == "trunk_torque"), ())
    logs = {each.log: each for each in found.predictions if each.held_out == held_out}
    firsts = [logs[repeated[0]] for repeated in repeats(logs).values()]
    drawings = []
    for k, prediction in enumerate(firsts[:MAX_DRAWN_LOGS]):
        fits, told = [fit for fit in found.validation if fit.log == prediction.log], prediction.channels()
        notes = {
            fit.channel: f"RMSE {significant(fit.rmse_prior)} → {significant(fit.rmse_identified)} {fit.unit}"
            for fit in fits
        }
        for part, channels in zip("abc", figure_channels(fits, trunk), strict=True):
            present = [channel for channel in channels if channel in told.measured]
            if present:
                drawings.append(_drawing(prediction, told, present, notes, f"f{k}{part}"))
    return drawings


def _drawing(
    prediction: Prediction, told: Channels, channels: Sequence[str], notes: Mapping[str, str], key: str
) -> Drawing:
    shown = "; ".join(f"{label(channel)}: {notes.get(channel, 'no error stated')}" for channel in channels)
    words = f"Measured, identified and a-priori curves over time on log {prediction.log}. {shown}."
    return Drawing(
        Markup(draw_series(prediction, told, channels, notes, key)), words, prediction.log, prediction.held_out
    )


def _curve(found: Identification) -> dict[str, Any] | None:
    points = [(factor, score) for factor, score in found.prior_curve if factor > 0.0]
    if len(points) < 2:
        return None
    best = min(points, key=lambda point: point[1])
    words = (
        f"Held-out error against the prior's factor; the smallest, {significant(best[1])}, at {significant(best[0])}."
    )
    return {"svg": Markup(draw_curve(points, found.prior_strength, "curve")), "words": words, "points": points}
