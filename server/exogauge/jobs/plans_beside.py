"""The lab's planned motions, laid beside a study whose logs may be of them."""

from __future__ import annotations

import json
from pathlib import Path

from exogauge.errors import NotFound
from exogauge.storage.blobs import copy_out
from exogauge.storage.bundles import PLANNED
from exogauge.storage.store import Store
from exogauge.studies.intake.contract import PLANS_BESIDE, PLANS_LISTED

MOST = 50  # judgement: the newest; each is compared with every log


def lay_plans(store: Store, folder: Path) -> None:
    """The tables below `folder/.plans`, with a list of what they are."""
    listed = {}
    for plan in store.plans.page(None, MOST, state="succeeded").items:
        try:
            table = store.results.artifact(store.results.newest("plan", plan.id).job_id, PLANNED)
        except NotFound:
            continue
        file = f"{plan.id}.csv"
        copy_out(store.blobs, table.sha256, folder / PLANS_BESIDE / file)
        listed[file] = [plan.id, plan.name]
    if listed:
        (folder / PLANS_BESIDE / PLANS_LISTED).write_text(json.dumps(listed), encoding="utf-8")
