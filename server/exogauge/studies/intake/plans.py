"""Motions that a study's logs may be of: those that it names, and those that the service lays beside it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from exogauge.errors import BadInput
from exogauge.logs.followed import PlannedSeries
from exogauge.sandbox import LogRequest, parse_log
from exogauge.studies.intake.contract import PLANS_BESIDE, PLANS_LISTED
from exogauge.studies.intake.open import Study

FEET = "stands."  # columns that say which feet stand: joints alone tell which plan a log is of


@final
@dataclass(frozen=True)
class StudyPlan:
    """series: as planned. file: as study.yaml names it, None of one that the service has; plan_id: its id there.
    source: the file's bytes, sha256: of them."""

    series: PlannedSeries
    file: str | None
    plan_id: str | None
    sha256: str
    source: bytes


def read_plans(study: Study) -> list[StudyPlan]:
    """Those that the study names come first; of files with the same content one. Raises BadLog of one that is named and
    cannot be read; one of the service's that cannot is passed over."""
    root, found = study.bundle.root, list[StudyPlan]()
    for file in dict.fromkeys(study.file.plans):
        _add(found, study.bundle.path(file), Path(file).stem, file, None)
    listed = root / PLANS_BESIDE / PLANS_LISTED
    of_service: dict[str, tuple[str, str]] = json.loads(listed.read_bytes()) if listed.is_file() else {}
    for file, (plan_id, name) in of_service.items():
        try:
            _add(found, root / PLANS_BESIDE / Path(file).name, name, None, plan_id)
        except (BadInput, OSError):
            continue
    return found


def _add(found: list[StudyPlan], path: Path, name: str, file: str | None, plan_id: str | None) -> None:
    source = path.read_bytes()
    digest = hashlib.sha256(source).hexdigest()
    for k, same in enumerate(found):
        if same.sha256 == digest:
            if same.plan_id is None:
                found[k] = StudyPlan(same.series, same.file, plan_id, digest, source)
            return
    log = parse_log(LogRequest(name, {file or path.name: path}, left_out=FEET))
    q = {channel.removeprefix("q."): values for channel, values in log.channels.items() if channel.startswith("q.")}
    found.append(StudyPlan(PlannedSeries(name, log.time - log.time[0], q), file, plan_id, digest, source))


def named(plans: Sequence[StudyPlan]) -> list[str]:
    """Names, told apart where two are the same."""
    names = [plan.series.name for plan in plans]
    return [name if names.count(name) == 1 else f"{name} ({plan.sha256[:8]})"
            for name, plan in zip(names, plans, strict=True)]  # fmt: skip
