"""The child process: one request on standard input, one answer in `answer.json`, then the end.

Run as `python -I -m exogauge.sandbox.child` in a temporary folder of its own. What it imports, it imports for its
task alone, after its limits are set.
"""

from __future__ import annotations

import errno
import json
import sys
import traceback
from pathlib import Path
from typing import Any

from exogauge.sandbox.protocol import ANSWER, LOG, URDF


def main() -> int:
    request = json.load(sys.stdin)
    from exogauge.sandbox.limits import Limits

    Limits(**request["limits"]).apply()
    Path(ANSWER).write_text(json.dumps(answer(request)))
    return 0


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """The result, the faults of the input, or the name of what stopped the child (traced on standard error)."""
    from exogauge.errors import BadInput

    try:
        task = {"log": _log, "robot": _robot}[request["task"]]
        return {"result": task(request)}
    except BadInput as bad:
        return {"error": type(bad).__name__, "faults": [vars(fault) for fault in bad.faults]}
    except MemoryError:
        return {"error": "MemoryError"}
    except ImportError as problem:
        traceback.print_exc()
        return {"error": "MemoryError" if "failed to map" in str(problem) else "Unforeseen"}
    except OSError as problem:
        traceback.print_exc()
        return {"error": {errno.EFBIG: "FileTooLarge", errno.ENOSPC: "NoSpace"}.get(problem.errno or 0, "Unforeseen")}
    except Exception:  # the child's last door: nothing may leave it but an answer
        traceback.print_exc()
        return {"error": "Unforeseen"}


def _log(request: dict[str, Any]) -> dict[str, Any]:
    import numpy as np
    import pyarrow as pa

    from exogauge.logs.canonical import write_log
    from exogauge.logs.mapping import read_mapped
    from exogauge.logs.mapping_rules import LogMapping
    from exogauge.logs.reading import read_log

    pa.set_cpu_count(1)
    paths = {name: Path(path) for name, path in request["paths"].items()}
    rows = None if request["rows"] is None else (int(request["rows"][0]), int(request["rows"][1]))
    if request["mapping"] is None:
        ((file, path),) = paths.items()
        log = read_log(path, request["name"], rows, file=file, allow_gaps=request["allow_gaps"])
    else:
        matrix = request["motor_from_joint"]
        log = read_mapped(
            paths,
            LogMapping.from_plain(request["mapping"]),
            joints=request["joints"],
            motor_from_joint=None if matrix is None else np.array(matrix, dtype=np.float64),
            name=request["name"],
            rows=rows,
            allow_gaps=request["allow_gaps"],
        )
    write_log(log, Path(LOG))
    return {
        "channels": list(log.channels),
        "samples": log.samples,
        "rate_hz": log.rate_hz,
        "t0": float(log.time[0]),
        "t1": float(log.time[-1]),
    }


def _robot(request: dict[str, Any]) -> dict[str, Any]:
    from exogauge.robots.urdf import load_tree
    from exogauge.robots.urdf_check import check_urdf

    urdf, file = Path(URDF).read_bytes(), request["file"]
    check_urdf(urdf, file)
    if request["joints"] is None:
        return {"bodies": [], "joints": [], "mass": None}
    tree = load_tree(
        urdf,
        joints=request["joints"],
        base_link=request["base_link"],
        floating=request["floating"],
        cut_frames=request["cut_frames"],
        file=file,
    )
    return {"bodies": list(tree.bodies), "joints": list(tree.joints), "mass": tree.mass}


if __name__ == "__main__":
    sys.exit(main())
