"""`exogauge blind`: studies with hidden effects, their evaluation, and how often it was right."""

from __future__ import annotations

import argparse
from pathlib import Path

from exogauge.cli.endings import Commands


def add_commands(commands: Commands) -> None:
    """`blind` and its steps."""
    blind = commands.add_parser("blind", help="studies with hidden effects: how often is what is named right?")
    steps = blind.add_subparsers(dest="step", required=True, metavar="STEP")
    make = steps.add_parser("make", help="write the cases and, sealed, what is hidden in them")
    make.add_argument("out", type=Path, metavar="OUT", help="a new folder")
    make.add_argument("--seed", type=int, required=True, metavar="N")
    make.add_argument("--cases", type=int, required=True, metavar="K")
    make.add_argument("--robot", choices=("arm6", "torso8", "both", "humanoid"), default="both", help="(default: both)")
    make.add_argument("--effects", metavar="A,B,…", help="hide one of these in every case")
    make.set_defaults(command=make_blind)
    trial = steps.add_parser("run", help="evaluate every case that has no result of this code yet")
    trial.add_argument("out", type=Path, metavar="OUT", help="what `blind make` has written")
    trial.add_argument("--keep", action="store_true", help="do not repeat results of earlier code")
    trial.set_defaults(command=run_blind)
    score = steps.add_parser("score", help="compare results and answers, if the seal is whole")
    score.add_argument("out", type=Path, metavar="OUT", help="what `blind make` has written")
    score.add_argument("--json", type=Path, metavar="FILE", help="write the score as JSON too")
    score.set_defaults(command=score_blind)


def make_blind(options: argparse.Namespace) -> int:
    from exogauge.blind.generator.make import make
    from exogauge.synthetic import processors
    from exogauge.terminal import bar

    with bar("blind make") as progress:
        effects = [name.strip() for name in (options.effects or "").split(",") if name.strip()]
        make(options.out, options.seed, options.cases, progress, processors(), options.robot, effects)
    print(options.out / "seal.txt")
    return 0


def run_blind(options: argparse.Namespace) -> int:
    """1 when a case failed."""
    from exogauge.blind.run import run
    from exogauge.synthetic import processors
    from exogauge.terminal import bar

    with bar("blind run") as progress:
        failed = run(options.out, progress, processors(), keep=options.keep)
    print(f"{options.out / 'results'}" + (f"\n{len(failed)} cases failed: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


def score_blind(options: argparse.Namespace) -> int:
    import json

    from exogauge.blind.score import score, score_text

    found = score(options.out)
    print(score_text(found))
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 0
