"""What if the device were another: changes in, supporting torque before and after out, in milliseconds.

The first question about a log reads it (a second or so); what is read stays ready in this process. The numerics are
imported with the first question.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import Request

from exogauge.api.dependencies import Id, SettingsDep, StorageDep
from exogauge.api.routing import Router
from exogauge.api.uploads import scratch_folder
from exogauge.api.what_if_shapes import WhatIfOut, WhatIfRequest
from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import StudyRecord
from exogauge.storage.store import Storage
from exogauge.studies.intake.yaml_file import suggestion

if TYPE_CHECKING:
    from exogauge.api.benches import Ready

router = Router(tags=["what-if"])
CREATING = threading.Lock()


@router.post("/studies/{study_id}/whatif", operation_id="whatIf")
def what_if(
    study_id: Id, wanted: WhatIfRequest, request: Request, storage: StorageDep, settings: SettingsDep
) -> WhatIfOut:
    """What the changed device would do over a recorded motion, beside what the present one does.

    At most 5000 samples: a longer log is low-passed as a whole and every n-th sample kept. Each of them is exact, and a
    peak between two of them is missed; a job of kind `whatif` takes them all.
    """
    started = time.perf_counter()
    with storage.reading() as store:
        study = store.studies.get(str(study_id))
        files = store.studies.files(study.id)
    ready = bench_of(request, study, files, wanted, storage, settings)
    opened = time.perf_counter()
    answer = answered(ready, wanted)
    done = time.perf_counter()
    return WhatIfOut(**answer, elapsed_ms=1e3 * (done - opened), opening_ms=1e3 * (opened - started))


def bench_of(
    request: Request,
    study: StudyRecord,
    files: Sequence[PinnedFile],
    wanted: WhatIfRequest,
    storage: Storage,
    settings: Settings,
) -> Ready:
    """The log and its device, kept or read now."""
    from exogauge.api.benches import Benches, open_bench

    refuse_unknown(study, files, wanted)
    with CREATING:
        if not hasattr(request.app.state, "benches"):
            request.app.state.benches = Benches()
    benches: Benches = request.app.state.benches

    def make() -> Ready:
        with scratch_folder(settings) as folder:
            lay_out(study, files, wanted.log, storage, folder)
            return open_bench(folder, wanted.log, wanted.device)

    return benches.get((study.content_hash, wanted.log, wanted.device), make)


def answered(ready: Ready, wanted: WhatIfRequest) -> dict[str, Any]:
    from exogauge.api.benches import BENCH_BYTES, refuse_large
    from exogauge.devices.changes import apply
    from exogauge.devices.what_if import compare
    from exogauge.studies.device_pages.entry_changes import changes_of
    from exogauge.studies.device_pages.what_if import answer, series

    changed = apply(ready.motion.device, changes_of(wanted.changes), ready.motion.tree)
    refuse_large(ready.motion, changed, BENCH_BYTES)
    found = compare(ready.bench, changed, wanted.main)
    return answer(found, ready.motion) | {"series": series(found) if wanted.series else None}


def refuse_unknown(study: StudyRecord, files: Sequence[PinnedFile], wanted: WhatIfRequest) -> None:
    """A log or a device file that the study does not hold: nothing else may reach the reader."""
    names = [str(log["name"]) for log in study.summary.get("logs", [])]
    if wanted.log not in names:
        advice = suggestion(wanted.log, names)
        raise BadStudy(
            Fault("the study has no log of this name", "unknown_log", advice, column="log", value=wanted.log)
        )
    paths = [file.path for file in files]
    if wanted.device is not None and wanted.device not in paths:
        near = suggestion(wanted.device, [path for path in paths if path.endswith((".yaml", ".yml"))])
        raise BadInput(Fault("the study has no such file", "missing_file", near, column="device", value=wanted.device))


def lay_out(study: StudyRecord, files: Sequence[PinnedFile], log: str, storage: Storage, folder: Path) -> None:
    """The study's files without the tables of other logs, which may be large."""
    tables = {str(each["name"]): set(each.get("file", ())) for each in study.summary.get("logs", [])}
    others = set[str]().union(*tables.values()) - tables[log]
    for file in files:
        if file.path not in others:
            copy_out(storage.blobs, file.sha256, folder / file.path)
