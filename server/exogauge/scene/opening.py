"""The child process that draws one log of a stored study: it reads what was uploaded, and leaves one packed scene.

Run by `drawing` as `python -I -m exogauge.scene.opening` in a temporary folder of its own.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import serve

SCENE = "log.scene"


def recording(folder: str, log: str, series: str | None, results: str) -> dict[str, Any]:
    """folder: the study's files. series: the log's series file, if it has one. results: results.json."""
    import json

    from exogauge.scene.mesh_files import mesh_opener
    from exogauge.scene.recording import record
    from exogauge.scene.take import take
    from exogauge.studies.bundle import Bundle
    from exogauge.studies.recorded_motion import read_logged

    logged = read_logged(Bundle(Path(folder), "study.yaml"), log)
    found = take(logged, None if series is None else Path(series), json.loads(Path(results).read_bytes()))
    Path(SCENE).write_bytes(record(found, log, mesh_opener(Path(folder))))
    return {}


if __name__ == "__main__":
    sys.exit(serve({"recording": recording}))
