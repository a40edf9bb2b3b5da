"""`python -m tests.plain [--seeds 0:40]`: writes, evaluates and scores plain studies, two at a time."""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tests.plain.evaluation import one
from tests.plain.score import summary


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0:40", help="first:stop")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--keep", default="", help="folder for studies and results")
    parser.add_argument("--json", default="", help="file for all figures")
    options = parser.parse_args()
    first, stop = map(int, options.seeds.split(":"))
    found = []
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for result in pool.map(one, range(first, stop), [options.keep] * (stop - first)):
            found.append(result)
            print(_line(result), flush=True)
            if options.json:  # after each: a run that is interrupted keeps what it has found
                Path(options.json).write_text(json.dumps(found, indent=1))
    print(summary(found))
    return 0 if all(result.get("good") for result in found) else 1


def _line(result: dict[str, Any]) -> str:
    if result["error"] and "floors" not in result:
        return f"{result['name']:44s} {result['error'].splitlines()[-1]}"
    return (
        f"{result['name']:44s} {result['verdict']:12s} floors {result['floors']:.3f} at {result['worst']}, "
        f"cut-off {result['cutoff_hz']:.1f} Hz, {result['seconds']:.0f} s {' '.join(result['named'])} {result['error']}"
    )


if __name__ == "__main__":
    sys.exit(main())
