"""The child's last moment: what it answered stands, whatever a library would do while the interpreter is taken down."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

from exogauge.sandbox.limits import Limits
from exogauge.sandbox.protocol import ANSWER

ABORTS_WHEN_TAKEN_DOWN = """
import atexit, os
from exogauge.sandbox.answering import serve
atexit.register(os.abort)
serve({"double": lambda number: {"twice": 2 * number}})
"""


def test_a_library_that_aborts_at_the_very_end_takes_no_answer_away(tmp_path: Path) -> None:
    request = {"task": "double", "options": {"number": 21}, "limits": dataclasses.asdict(Limits())}
    child = subprocess.run(
        [sys.executable, "-c", ABORTS_WHEN_TAKEN_DOWN], input=json.dumps(request).encode(), cwd=tmp_path, check=False
    )
    assert child.returncode == 0
    assert json.loads((tmp_path / ANSWER).read_text()) == {"result": {"twice": 42}}
