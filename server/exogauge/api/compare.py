"""Jobs side by side: supporting torque, stiffness, identification, verdicts, and the settings that differ."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal, final
from uuid import UUID

from fastapi import Query, Response
from pydantic import BaseModel

from exogauge.api.dependencies import ReaderDep
from exogauge.api.results import content_of
from exogauge.api.routing import Router
from exogauge.storage.store import Store
from exogauge.studies.results.comparison import as_csv, as_latex, compare, verdict

router = Router(tags=["compare"])
MOST_JOBS = 20
FORMATS = {"csv": "text/csv; charset=utf-8", "latex": "application/x-latex; charset=utf-8"}
TABLES: dict[int | str, dict[str, Any]] = {
    200: {"content": {kind: {"schema": {"type": "string"}} for kind in ("text/csv", "application/x-latex")}}
}


@final
class EffectOut(BaseModel):
    """where: `{"joint": "torso_pitch"}`, `{"sensor": "wrist", "axis": "fx"}`, `{"base": true}`. title: in words."""

    effect: str
    where: dict[str, str | bool]
    title: str | None
    score: float | None


@final
class ComparedJob(BaseModel):
    """verdict: of the search for missing effects; null where it was not made. effects: those it named."""

    id: str
    study_id: str
    name: str
    robot: str
    kind: str
    created_at: datetime
    code_version: str
    verdict: Literal["effects", "unexplained", "undecided", "none"] | None
    effects: list[EffectOut]


@final
class Number(BaseModel):
    value: float | None
    std: float | None
    unit: str


@final
class SupportCell(BaseModel):
    """rmse: against the band model. spread: of the mean between trials. motion_equality: of approach A."""

    unit: str
    main: bool
    rmse: float | None
    rmse_steady: float | None
    peak: Number | None
    mean: Number | None
    integral: Number | None
    spread: float | None
    motion_equality: str | None


@final
class SupportRow(BaseModel):
    """cells: in the order of the jobs; null where a job has none."""

    device: str
    motion: str
    joint: str
    approach: str
    cells: list[SupportCell | None]


@final
class StiffnessCell(BaseModel):
    group: str | None
    stiffness_n_per_m: Number
    natural_length_m: Number
    truth_n_per_m: float | None
    error_percent: float | None
    identifiable: bool


@final
class StiffnessRow(BaseModel):
    device: str
    approach: str
    band: str
    cells: list[StiffnessCell | None]


@final
class IdentificationCell(BaseModel):
    rmse_prior: float | None
    rmse_identified: float | None
    noise_floor: float | None
    held_out: bool


@final
class IdentificationRow(BaseModel):
    """kind: base_moment, trunk_torque, joint_torque, joint_force."""

    kind: str
    unit: str
    cells: list[IdentificationCell | None]


@final
class DifferingSetting(BaseModel):
    """name: `settings.…`, `software.…`, `inputs.<file>` (its SHA-256), `steps.…`, `robot`. values: in the order of the
    jobs, null where one says nothing."""

    name: str
    values: list[Any]


@final
class CompareOut(BaseModel):
    jobs: list[ComparedJob]
    support: list[SupportRow]
    stiffness: list[StiffnessRow]
    identification: list[IdentificationRow]
    settings: list[DifferingSetting]


@router.get("/compare", operation_id="compareStudies", response_model=CompareOut, responses=TABLES)
def compare_studies(
    jobs: Annotated[tuple[UUID, ...], Query(min_length=1, max_length=MOST_JOBS, description="ids, one parameter each")],
    store: ReaderDep,
    form: Annotated[Literal["json", "csv", "latex"], Query(alias="format")] = "json",
    table: Annotated[Literal["support", "stiffness"], Query(description="which one, as CSV or LaTeX")] = "support",
) -> Any:
    """Every number is that of its job's results.json. Rows: device, motion, joint, approach; one cell per job.

    csv: a row per cell, all digits, text safe for spreadsheets. latex: a tabular, rounded by the standard deviations.
    """
    ids = list(dict.fromkeys(map(str, jobs)))
    contents = [content_of(store, key) for key in ids]
    heads = [head(store, key, content) for key, content in zip(ids, contents, strict=True)]
    found = compare(contents)
    if form == "json":
        return CompareOut(jobs=heads, **found)
    write = as_csv if form == "csv" else as_latex
    names = [{"id": each.id, "name": each.name, "verdict": each.verdict} for each in heads]
    suffix = "tex" if form == "latex" else "csv"
    headers = {"Content-Disposition": f'attachment; filename="comparison-{table}.{suffix}"'}
    return Response(write(found, names, table), media_type=FORMATS[form], headers=headers)


def head(store: Store, job_id: str, content: dict[str, Any]) -> ComparedJob:
    job = store.jobs.get(job_id)
    return ComparedJob(
        id=job.id,
        study_id=store.study_of(job).id,
        name=content["name"],
        robot=content["robot"],
        kind=job.kind,
        created_at=job.created_at,
        code_version=job.code_version or "",
        **verdict(content),
    )
