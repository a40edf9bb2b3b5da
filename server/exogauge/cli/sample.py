"""`exogauge sample`: a synthetic study or payload, its truth beside it."""

from __future__ import annotations

import argparse
from pathlib import Path

from exogauge.cli.endings import Commands, refuse_what_is_there
from exogauge.errors import BadInput, Fault
from exogauge.synthetic import disturbances


def add_commands(commands: Commands) -> None:
    """`sample`."""
    sample = commands.add_parser(
        "sample", help="write a complete synthetic study, as a laboratory would record it", epilog=disturbances.table(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    sample.add_argument("out", type=Path, metavar="OUT", help="a new folder, or an empty one")
    sample.add_argument("--seed", type=int, required=True, metavar="N")
    sample.add_argument(
        "--hidden", action="append", metavar="EFFECT@PLACE",
        help="an effect the a-priori model lacks, once for each; with a suit the default is stribeck@torso_pitch; "
        "`none` hides nothing",
    )  # fmt: skip
    sample.add_argument(
        "--suit", choices=("none", "normal", "modified", "both"), default="both",
        help="what is worn in the logs with a device; none: logs to identify and validate only (default: both)",
    )  # fmt: skip
    add_realism(sample)
    sample.add_argument(
        "--with", dest="added", action="append", metavar="NAME[=SIZE]", default=[],
        help="add one of the disturbances below, or change its size: feet_gain=3%%, via_points=5mm; again for another",
    )  # fmt: skip
    sample.add_argument(
        "--without", dest="left_out", action="append", metavar="NAME", default=[], help="leave one of them out"
    )
    sample.add_argument(
        "--motion", dest="motions", action="append", type=Path, metavar="FILE.csv", default=[],
        help="a planned motion, t and q.<joint>, played in place of bends and twists; again for another",
    )  # fmt: skip
    sample.add_argument("--payload", action="store_true", help="a payload behind a wrist sensor instead of a study")
    sample.add_argument("--force", action="store_true", help="write into a folder that holds something already")
    sample.set_defaults(command=write_sample)


def add_realism(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--realism", choices=tuple(disturbances.REALISM), default=disturbances.DEFAULT,
        help="lab: with all that is marked `lab` in docs/sample.md; ideal: motions repeat, sensors have noise alone "
        "(default: lab)",
    )  # fmt: skip


def write_sample(options: argparse.Namespace) -> int:
    from exogauge import synthetic
    from exogauge.terminal import bar

    refuse_what_is_there(options.out, options.force)
    if options.payload and options.motions:
        raise BadInput(Fault("a payload plays no motion from a file", "payload_played", column="motion"))
    if options.payload and (options.added or options.left_out):
        detail = "disturbances are those of a study; a payload's are given with --hidden"
        raise BadInput(Fault(detail, "payload_disturbed", column="with"))
    if options.payload:
        synthetic.write_payload_sample(options.out, options.seed, options.hidden)
        print(options.out / "payload.yaml")
        return 0
    with bar("sample") as progress:
        synthetic.write_sample(
            options.out, options.seed, options.hidden, options.suit, progress, processes=synthetic.processors(),
            realism=options.realism, added=options.added, left_out=options.left_out,
            motions=options.motions,
        )  # fmt: skip
    print(options.out / "study.yaml")
    return 0
