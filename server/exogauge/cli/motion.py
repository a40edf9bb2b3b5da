"""`exogauge motion`: captured motion of a person, on local files."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from exogauge.cli.endings import Commands


def add_commands(commands: Commands) -> None:
    """`motion` and its steps."""
    motion = commands.add_parser("motion", help="captured motion of a person")
    steps = motion.add_subparsers(dest="step", required=True, metavar="STEP")
    read = steps.add_parser("import", help="read a file of markers or of a skeleton, and say what it is")
    read.add_argument("file", type=Path, help="C3D, TRC, MOT, STO, BVH or AMC")
    read.add_argument("--skeleton", type=Path, metavar="FILE.asf", help="the bones of an AMC")
    read.add_argument("--up", metavar="AXIS", help="x, y, z or -x, -y, -z, where the file is silent or wrong")
    read.add_argument("--unit", metavar="UNIT", help="m, cm, mm or in, where the file is silent or wrong")
    read.add_argument("--subject", metavar="PREFIX", help="which one of several people")
    read.add_argument("--fill", action="store_true", help="close gaps: short ones by splines, others by rigid segments")
    read.add_argument("--json", action="store_true", help="as JSON")
    read.add_argument("--out", type=Path, metavar="FILE.npz", help="write the motion there: metres, z up, seconds")
    read.set_defaults(command=import_motion)


def import_motion(args: argparse.Namespace) -> int:
    """What the file is; with --out the motion itself."""
    from exogauge.motion.contacts import with_contacts
    from exogauge.motion.files import open_motion
    from exogauge.motion.gaps import fill_gaps
    from exogauge.motion.summary import summarise, write_arrays

    motion = open_motion(args.file, skeleton=args.skeleton, up=args.up, unit=args.unit, subject=args.subject)
    if args.fill:
        motion = fill_gaps(motion)
    motion = with_contacts(motion)
    said = summarise(motion)
    if args.out is not None:
        write_arrays(motion, args.out)
    print(json.dumps(said, indent=2) if args.json else "\n".join(f"{key:14} {value}" for key, value in said.items()))
    return 0
