"""One plain study written, evaluated by the product's own command and scored."""

from __future__ import annotations

import json
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

from tests.plain.score import facts
from tests.plain.study_files import plan, write_study

from exogauge.cli import main


def one(seed: int, keep: str) -> dict[str, Any]:
    """Facts of one study; `error` where it ended without results."""
    what, started = plan(seed), time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(keep or scratch) / what.name
        if not (folder / "truth.json").exists():
            write_study(folder, what)
        study, out = folder, Path(keep or scratch) / f"{what.name}-result"
        try:
            code = main(["run", str(study / "study.yaml"), "--out", str(out)])
            found = facts(
                json.loads((out / "results.json").read_bytes()), json.loads((folder / "truth.json").read_bytes())
            )
            found["error"] = "" if code == 0 else f"exit code {code}"
        except (Exception, SystemExit):
            found = {"error": traceback.format_exc(limit=-3)}
    return {"name": what.name, "seconds": time.perf_counter() - started, **found}
