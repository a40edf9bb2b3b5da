"""The child's end of `asking`: one request on standard input, one answer in `answer.json`, then the end."""

from __future__ import annotations

import errno
import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

from exogauge.garbage import looked_for_seldom
from exogauge.sandbox.protocol import ANSWER, NO_ROOM

STOPS = {errno.EFBIG: "FileTooLarge"}
Tasks = Mapping[str, Callable[..., dict[str, Any]]]


def serve(tasks: Tasks) -> NoReturn:
    """Answer, and end. What a task imports, it imports itself, after the limits are set.

    The interpreter is not taken down: a thread of Arrow that still reads ahead then aborts the process now and then
    (https://github.com/apache/arrow/issues/34314), and nothing is left to be tidied in a process of one answer.
    """
    looked_for_seldom()
    request = json.load(sys.stdin)
    from exogauge.sandbox.limits import Limits

    Limits(**request["limits"]).apply()
    from exogauge.errors import no_room

    try:
        Path(ANSWER).write_text(json.dumps(answer(tasks[request["task"]], request["options"]), allow_nan=False))
    except OSError as problem:  # a full disk has no room for an answer either
        os._exit(NO_ROOM if no_room(problem) else 1)
    with suppress(OSError):  # what was said on the way is no answer: a full disk may have no room for it
        sys.stderr.flush()
    os._exit(0)


def answer(task: Callable[..., dict[str, Any]], options: Mapping[str, Any]) -> dict[str, Any]:
    """The result, the faults of the input, or the name of what stopped the child (traced on standard error)."""
    from exogauge.errors import BadInput, no_room

    try:
        return {"result": task(**options)}
    except BadInput as bad:
        if no_room(bad):  # behind what its reader took for damage
            return {"error": "NoSpace"}
        return {"error": type(bad).__name__, "faults": [vars(fault) for fault in bad.faults]}
    except MemoryError:
        return {"error": "MemoryError"}
    except ImportError as problem:
        traceback.print_exc()
        return {"error": "MemoryError" if "failed to map" in str(problem) else "Unforeseen"}
    except OSError as problem:
        traceback.print_exc()
        return {"error": "NoSpace" if no_room(problem) else STOPS.get(problem.errno or 0, "Unforeseen")}
    except Exception as problem:  # the child's last door: nothing may leave it but an answer
        traceback.print_exc()
        return {"error": "NoSpace" if no_room(problem) else "Unforeseen"}
