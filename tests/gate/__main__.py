"""`python -m tests.gate BASE`: which numbers of results.json differ between a base and this tree.

BASE is a revision or the folder of another tree. Each tree evaluates with its own code, on this environment's packages.
Exit code 1: a name or a verdict differs, or a number moved by more than --rtol.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.gate.cases import cases, recorded_answers
from tests.gate.difference import difference
from tests.gate.evaluation import answers
from tests.gate.report import is_same, report
from tests.gate.trees import HERE, trees

# Sums in another order differ by some 1e-16 times the condition of what is solved, which is below 1e6.
RTOL = 1e-9


def main() -> int:
    options = _options()
    with trees(options.base) as (base, this):
        chosen = cases(options.only, options.kept, this, options.blind)
        before = {}
        if options.blind_results:
            before = recorded_answers(options.blind_results, [case.name for case in chosen])
        jobs = [(base, case) for case in chosen if case.name not in before] + [(this, case) for case in chosen]
        found = answers(jobs, options.kept, options.processes)
    differences = {}
    for case in chosen:
        after = found[this.name, case.name]
        if case.name in before:
            differences[case.name] = difference(before[case.name], {"discrepancy": after.get("discrepancy")})
        else:
            differences[case.name] = difference(found[base.name, case.name], after)
    print(report(differences, options.rtol))
    return 0 if is_same(differences, options.rtol) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.gate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("base", help="a revision, or the folder of a tree")
    parser.add_argument("--only", default="sample,real,blind", help="such as sample,blind:0:10,real or real:icub")
    parser.add_argument("--rtol", type=float, default=RTOL, help="largest relative change of a number (%(default)g)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--kept", type=Path, default=HERE / "exogauge-data/gate", help="folder for studies and answers")
    parser.add_argument("--blind", type=Path, help="folder of blind cases made before, in place of fresh ones")
    parser.add_argument(
        "--blind-results", type=Path, metavar="FOLDER",
        help="what `exogauge blind run` wrote of these cases stands for the base (`discrepancy` alone)",
    )  # fmt: skip
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
