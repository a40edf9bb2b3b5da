"""`exogauge motion`: captured motion of a person, on local files."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exogauge.cli.endings import Commands, refuse_no_place
from exogauge.cli.motion_service import add_server, list_plans, send_capture, send_excite, send_retarget

if TYPE_CHECKING:
    from exogauge.motion.contract import RetargetEntry
    from exogauge.motion.plan.judge import Judged
    from exogauge.motion.plan.spline import Trajectory
    from exogauge.motion.plan.written import Written
    from exogauge.robots.moving.robot import MotionRobot

ROWS = "between the rows"
OPTIONS = {"begin": "--from [s]", "end": "--to [s]", "margin_m": "--margin [m]", "rate_hz": "--rate [Hz]"}


def add_commands(commands: Commands) -> None:
    """`motion` and its steps."""
    motion = commands.add_parser("motion", help="captured motion of a person")
    steps = motion.add_subparsers(dest="step", required=True, metavar="STEP")
    read = steps.add_parser("import", help="read a file of markers or of a skeleton, and say what it is")
    _add_capture(read, "C3D, TRC, TSV, CSV, MVNX, MOT, STO, BVH or AMC")
    read.add_argument("--fill", action="store_true", help="close gaps: short ones by splines, others by rigid segments")
    read.add_argument("--json", action="store_true", help="as JSON")
    read.add_argument("--out", type=Path, metavar="FILE.npz", help="write the motion there: metres, z up, seconds")
    add_server(read)
    read.set_defaults(command=import_motion)

    fit = steps.add_parser("fit", help="fit a body to markers or to a skeleton: trunk, hip, knee angles over time")
    _add_capture(fit, "C3D, TRC, TSV, CSV, MVNX, BVH or AMC")
    fit.add_argument("--static", type=Path, metavar="FILE", help="the same person and markers, standing straight")
    fit.add_argument("--json", action="store_true", help="as JSON")
    fit.add_argument("--out", type=Path, metavar="FILE.mot", help="write the angles there, as OpenSim's tables are")
    fit.set_defaults(command=fit_motion)

    robot = steps.add_parser("robot", help="write a robot.yaml for planning motions: of a known robot, or a draft")
    robot.add_argument("urdf", type=Path, help="of Talos, JVRC-1 or ergoCub; of another robot it is looked at")
    robot.add_argument("--preset", metavar="NAME", help="talos, jvrc1 or ergocub, where its links do not tell")
    robot.add_argument("--out", type=Path, metavar="robot.yaml", help="beside the URDF where none is given")
    robot.set_defaults(command=write_robot)

    plan = steps.add_parser("retarget", help="make of a captured motion one that a robot on two feet can do")
    _add_capture(plan, "C3D, TRC, TSV, CSV, MVNX, BVH or AMC")
    plan.add_argument("--static", type=Path, metavar="FILE", help="of markers: the same person, standing straight")
    plan.add_argument("--robot", type=Path, required=True, metavar="robot.yaml", help="with soles, human_map and home")
    plan.add_argument("--from", dest="begin", type=float, default=0.0, metavar="S", help="where the motion begins")
    plan.add_argument("--to", dest="end", type=float, metavar="S", help="where it ends")
    plan.add_argument("--slow", type=float, default=1.0, metavar="FACTOR", help="take that many times the time")
    plan.add_argument("--mirror", action="store_true", help="left and right exchanged")
    plan.add_argument("--repeat", type=int, default=1, metavar="N", help="N times, one after the other")
    plan.add_argument("--share", type=float, default=1.0, metavar="S", help="that share of the trunk's angle")
    plan.add_argument("--without", action="append", choices=("arms", "pelvis"), default=[],
                      help="ask nothing of the arms; let the pelvis stay")  # fmt: skip
    margin = "by which the centre of pressure keeps inside the soles (default: 0.02)"
    plan.add_argument("--margin", type=float, metavar="M", help=margin)
    less = "where it cannot be had: how much slower, or which share of the trunk's angle can"
    plan.add_argument("--what-would-do", action=argparse.BooleanOptionalAction, default=True, help=less)
    _add_export(plan)
    add_server(plan)
    plan.set_defaults(command=retarget_motion)

    export = steps.add_parser("export", help="judge a file of joint angles at a rate, and write it in another format")
    export.add_argument("file", type=Path, help="a table with t [s] and q.<joint> [rad or m]")
    export.add_argument("--robot", type=Path, required=True, metavar="robot.yaml", help="with soles and home")
    _add_export(export)
    export.set_defaults(command=export_motion)

    check = steps.add_parser("check", help="judge a file of joint angles: every bound, balance, still feet")
    check.add_argument("file", type=Path, help="a table with t [s] and q.<joint> [rad or m]")
    check.add_argument("--robot", type=Path, required=True, metavar="robot.yaml", help="fixed, or with soles and home")
    check.add_argument(
        "--rate", type=float, metavar="HZ", help="of the samples that are judged, 200 where none is given"
    )
    check.add_argument("--json", action="store_true", help="as JSON")
    check.set_defaults(command=check_motion)

    excite = steps.add_parser("excite", help="plan a motion from which a robot is identified well, within every bound")
    excite.add_argument("--robot", type=Path, required=True, metavar="robot.yaml", help="fixed, or with soles and home")
    excite.add_argument("--seconds", type=float, default=10.0, metavar="S", help="of the motion itself")
    before = excite.add_mutually_exclusive_group()
    before.add_argument("--study", type=Path, metavar="study.yaml", help="whose logs are known already")
    before.add_argument(
        "--from", dest="result", type=Path, metavar="results.json", help="what it says is known already"
    )
    excite.add_argument("--seed", type=int, default=0, help="of the random motions that the search begins from")
    excite.add_argument("--json", action="store_true", help="as JSON")
    beside = "write t and q.<joint> there, at 200 Hz; and FILE.json: plan.json of the service"
    excite.add_argument("--out", type=Path, metavar="FILE.csv", help=beside)
    add_server(excite)
    excite.set_defaults(command=excite_robot)

    listed = steps.add_parser("list", help="plans that a service holds, newest first")
    add_server(listed, needed=True)
    listed.set_defaults(command=list_plans)


def _add_export(step: argparse.ArgumentParser) -> None:
    step.add_argument("--format", default="csv", metavar="FORMAT",
                      help="csv, hrpsys, mc_rtc, ros2-yaml, ros2-mcap, mujoco, mot")  # fmt: skip
    step.add_argument("--rate", type=float, metavar="HZ", help="of the samples, 200 where none is given; judged at it")
    step.add_argument("--despite", action="store_true", help="write the motion although it breaks a bound")
    step.add_argument("--json", action="store_true", help="as JSON")
    beside = "write the motion there, and beside it FILE.json: ranges, top speeds, margins, hashes"
    step.add_argument("--out", type=Path, metavar="FILE", help=beside)


def _add_capture(step: argparse.ArgumentParser, formats: str) -> None:
    step.add_argument("file", type=Path, help=formats)
    step.add_argument("--skeleton", type=Path, metavar="FILE.asf", help="the bones of an AMC")
    step.add_argument("--up", metavar="AXIS", help="x, y, z or -x, -y, -z, where the file is silent or wrong")
    step.add_argument("--unit", metavar="UNIT", help="m, cm, mm, in or cmu, where the file is silent or wrong")
    step.add_argument("--subject", metavar="PREFIX", help="which one of several people")
    step.add_argument("--name", metavar="OWN=KNOWN", action="append", default=[],
                      help="what a label or bone is called elsewhere; once for each")  # fmt: skip
    step.add_argument("--angle", metavar="UNIT", help="deg or rad, where the file is silent or wrong")


def _stated(args: argparse.Namespace) -> dict[str, Any]:
    """What is said in place of the file. Raises BadMotion."""
    from exogauge.errors import BadMotion, Fault

    pairs = [each.partition("=") for each in args.name]
    for own, _, known in pairs:
        if not (own and known):
            raise BadMotion(Fault("this names nothing", "bad_name", "OWN=KNOWN, as --name Brust=Spine2", None, None,
                                  "--name", own or known))  # fmt: skip
    names = {own: known for own, _, known in pairs}
    return {"up": args.up, "unit": args.unit, "angle": args.angle, "subject": args.subject, "names": names}


def fit_motion(args: argparse.Namespace) -> int:
    """The body, and how well it fits."""
    from exogauge.motion.files import open_motion
    from exogauge.motion.fit.fit import fit_human
    from exogauge.motion.fit.told import angle_table, summarise

    refuse_no_place(args.out)
    motion = open_motion(args.file, skeleton=args.skeleton, **_stated(args))
    static = None if args.static is None else open_motion(args.static, **_stated(args))
    fit = fit_human(motion, static)
    if args.out is not None:
        args.out.write_bytes(angle_table(fit))
    _print(summarise(fit), args.json)
    return 0


def write_robot(args: argparse.Namespace) -> int:
    """robot.yaml beside its URDF; what of it is not the maker's is said."""
    import yaml

    from exogauge.errors import BadRobot, Fault
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.motion.robot_presets import known, preset_of, robot_file_of

    out = args.out or args.urdf.with_name("robot.yaml")
    if args.urdf.is_dir():
        raise BadRobot(Fault("is a folder", "a_folder", "Name the URDF in it", args.urdf.name))
    if not args.urdf.is_file():
        raise BadRobot(Fault("there is no such file", "no_file", "Look at its name", args.urdf.name))
    if out.resolve().parent != args.urdf.resolve().parent:
        raise BadRobot(Fault("robot.yaml and its URDF stand side by side", "no_file", "Copy the URDF there first",
                             args.urdf.name))  # fmt: skip
    if out.exists():
        raise BadRobot(Fault("there is such a file", "exists", "Name another one with --out", out.name))
    urdf = args.urdf.read_bytes()
    preset = preset_of(urdf, args.urdf.name, args.preset) if args.preset or known(urdf, args.urdf.name) else None
    if preset is None:
        return _draft_robot(args.urdf, urdf, out)
    content = yaml.safe_dump(robot_file_of(preset, urdf, args.urdf.name), sort_keys=False, default_flow_style=None)
    head = (f"# Preset {preset.name}. Soles and shapes: {preset.source}. Limits of acceleration and jerk: usual ones,\n"
            "# not the maker's. Look at them before a robot moves.\n")  # fmt: skip
    out.write_text(head + content)
    robot = load_motion_robot(out, beside=True)
    _print({"robot": robot.name, "mass": f"{robot.mass:.1f} kg", "soles and shapes": preset.source,
            "acceleration, jerk": "usual ones, not the maker's", "written": out.name}, False)  # fmt: skip
    return 0


def _draft_robot(file: Path, urdf: bytes, out: Path) -> int:
    """1 where something is lacking."""
    import yaml

    from exogauge.criteria.motion_plan import USUAL
    from exogauge.motion.plan.outcome import may_touch, unseen
    from exogauge.motion.robot_draft import arms_aside, draft_of
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.robots.moving.touching import Pairs

    def write() -> None:
        head = ["# Drafted by looking at the URDF. Check what is marked ?; fill in what is marked !.", *told]
        out.write_text("\n".join(head) + "\n" + yaml.safe_dump(content, sort_keys=False, default_flow_style=None))

    content, told = draft_of(urdf, file.name, file.parent)
    write()
    lacks = any(each.startswith("# !") for each in told)
    robot = None if lacks else load_motion_robot(out, beside=True)
    if robot is not None and (aside := arms_aside(robot, USUAL.clearance_m)):
        content["home"] |= aside
        told.append(f"# ? home: {', '.join(aside)} take forearms and hands off the body, where they lay against it")
        write()
        robot = load_motion_robot(out, beside=True)
    print("\n".join(told))
    if robot is not None:
        near = Pairs(robot, USUAL.clearance_m).left_out
        said = {"robot": robot.name, "mass": f"{robot.mass:.1f} kg"}
        said |= may_touch(robot, near, f": nearer than {1e3 * USUAL.clearance_m:g} mm at home, and so never looked at; "
                                       "move `home` where that is not meant")  # fmt: skip
        _print(said | unseen(robot), False)
    _print({"written": out.name}, False)
    return 1 if lacks else 0


def check_motion(args: argparse.Namespace) -> int:
    """1 where a bound is broken."""
    from exogauge.motion.plan.judge import judge
    from exogauge.motion.plan.outcome import margins
    from exogauge.motion.plan.written import read_written
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.robots.moving.standing import standing

    rate = _rate(args)
    robot = load_motion_robot(args.robot, beside=True)
    written = read_written(robot, args.file)
    judged = judge(robot, written, standing(robot), rate=rate, planned=written)
    said = {"robot": robot.name, "motion": args.file.name, "seconds": round(written.duration, 3)}
    _print(said | _unlike(written) | margins(robot, judged), args.json)
    return 1 if judged.broken else 0


def _unlike(written: Written) -> dict[str, str]:
    """Where the table and the robot do not have the same joints."""
    said = {"held at home": written.held, "no joint of it": written.beside}
    return {key: ", ".join(names) for key, names in said.items() if names}


def excite_robot(args: argparse.Namespace) -> int:
    """1 where no motion keeps within every bound; then nothing is written."""
    refuse_no_place(args.out)
    if args.server:
        return send_excite(args)
    from exogauge.motion.compute import EXCITED_HZ, excitation_document, write_document
    from exogauge.motion.excite.plan import motion_table, plan_excitation

    def tell(start: int, count: int, cost: float, largest: float) -> None:
        if count % 20 == 0:
            print(f"search {start}, motion {count}: mean ln of the standard deviations {cost:.3f}, nearest bound "
                  f"{100 * largest:.0f} %", file=sys.stderr)  # fmt: skip

    plan = plan_excitation(args.robot, args.seconds, study=args.study, result=args.result, seed=args.seed, report=tell,
                           beside=True, say=lambda share, words: print(words, file=sys.stderr))  # fmt: skip
    document, _, _ = excitation_document(plan)
    said = dict(document["told"])
    if args.out is not None and not document["broken"]:
        args.out.write_bytes(motion_table(plan, EXCITED_HZ))
        write_document(args.out.with_suffix(".json"), document)
        said["written"] = args.out.name
    _print(said, args.json)
    return 1 if document["broken"] else 0


def _print(said: Mapping[str, object], as_json: bool) -> None:
    print(json.dumps(said, indent=2) if as_json else "\n".join(f"{key:24} {value}" for key, value in said.items()))


def retarget_motion(args: argparse.Namespace) -> int:
    """1 where a bound is broken; then nothing is written, unless `--despite`."""
    from exogauge.criteria.motion_plan import USUAL
    from exogauge.motion.contacts import with_contacts
    from exogauge.motion.files import open_motion
    from exogauge.motion.plan.outcome import frame_by_frame_words, summarise
    from exogauge.motion.plan.solve import Round
    from exogauge.motion.retargeting import person_in, retargeted
    from exogauge.motion.robot_file import load_motion_robot

    def tell(now: Round) -> None:
        print(f"part {now.part + 1} of {now.parts}, round {now.number}: step {now.step:.2g}, feet off by "
              f"{now.strays:.2g}, bounds exceeded by {now.excess:.2g}", file=sys.stderr)  # fmt: skip

    _refuse_what_cannot_be_written(args)
    wanted = wanted_of(args)
    if args.server:
        return send_retarget(args, wanted.model_dump(exclude_unset=True))
    robot = load_motion_robot(args.robot, beside=True)
    motion = with_contacts(open_motion(args.file, skeleton=args.skeleton, **_stated(args)))
    static = None if args.static is None else open_motion(args.static, **_stated(args))
    found = retargeted(robot, person_in(motion, static), wanted, tell, lambda what, value, nodes, holds: print(
        f"{what} {value:.2f}, {nodes} nodes: {'holds' if holds else 'does not hold'}", file=sys.stderr))  # fmt: skip
    said = summarise(robot, found.person, found.asked, found.missed, found.planned, found.judged)
    if found.alone is not None:
        said["frame by frame"] = frame_by_frame_words(found.alone[1])
    if (could := found.could) is not None:
        said["would do"] = (
            (f"{could.slower:.2f} times the time (--slow {could.slower * wanted.slow:g})" if could.slower
             else f"not {USUAL.slowest:g} times the time")
            + (f", or {100 * could.share:.0f} % of the trunk's angle (--share {could.share * wanted.share:g})"
               if could.share is not None else ", nor with the trunk still")
        )  # fmt: skip
    return _written(args, robot, found.planned.spline, found.judged, said)


def wanted_of(args: argparse.Namespace) -> RetargetEntry:
    """Raises BadMotion with the option that is wrong."""
    given = {"begin": args.begin, "slow": args.slow, "repeat": args.repeat, "mirror": args.mirror, "share": args.share,
             "without": args.without, "what_would_do": args.what_would_do}  # fmt: skip
    given |= {} if args.end is None else {"end": args.end}
    given |= {} if args.margin is None else {"margin_m": args.margin}
    return _entry(given | ({} if args.rate is None else {"rate_hz": args.rate}))


def _rate(args: argparse.Namespace) -> float | None:
    """[Hz], as a plan may have it. Raises BadMotion."""
    return None if args.rate is None else _entry({"rate_hz": args.rate}).rate_hz


def _entry(given: Mapping[str, object]) -> RetargetEntry:
    """Raises BadMotion."""
    from pydantic import ValidationError

    from exogauge.errors import BadMotion, Fault
    from exogauge.motion.contract import RetargetEntry

    try:
        return RetargetEntry.model_validate(given)
    except ValidationError as wrong:
        raise BadMotion([
            Fault(each["msg"].removeprefix("Value error, "), each["type"],
                  column=OPTIONS.get(key := ".".join(map(str, each["loc"])), f"--{key}") if each["loc"] else None,
                  value=str(each["input"])[:200] if each["loc"] else None) for each in wrong.errors()
        ]) from wrong  # fmt: skip


def export_motion(args: argparse.Namespace) -> int:
    """1 where a bound is broken; then nothing is written, unless `--despite`."""
    from exogauge.motion.plan.judge import judge
    from exogauge.motion.plan.outcome import margins
    from exogauge.motion.plan.written import read_written, swing
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.robots.moving.standing import standing

    _refuse_what_cannot_be_written(args)
    rate = _rate(args)
    robot = load_motion_robot(args.robot, beside=True)
    motion = read_written(robot, args.file)
    judged = judge(robot, motion, standing(robot), rate=rate, planned=motion)
    said = {"robot": robot.name, "motion": args.file.name} | _unlike(motion) | margins(robot, judged)
    if (beyond := swing(robot, motion, judged.time, judged.q)) is not None:
        said[ROWS] = beyond
    return _written(args, robot, motion, judged, said)


def _refuse_what_cannot_be_written(args: argparse.Namespace) -> None:
    """Before a motion is planned. Raises BadInput."""
    from exogauge.errors import BadMotion, Fault
    from exogauge.motion.plan.export import FORMATS

    refuse_no_place(args.out)
    if args.format not in FORMATS:
        raise BadMotion(Fault("there is no such format", "unknown_format", f"One of {', '.join(FORMATS)}", None, None,
                              "--format", args.format))  # fmt: skip


def _written(
    args: argparse.Namespace, robot: MotionRobot, motion: Trajectory, judged: Judged, said: Mapping[str, object]
) -> int:
    from exogauge.motion.plan.export import exported, sheet

    if args.out is not None and (args.despite or not judged.broken):
        files = {args.out.stem + end: data for end, data in exported(robot, motion, judged, args.format).items()}
        sources = {path.name: path.read_bytes() for path in (args.file, args.robot)}
        told = sheet(robot, judged, args.format, files, sources)
        told |= {"between_the_rows": said[ROWS]} if ROWS in said else {}
        files[args.out.name + ".json"] = (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()
        for name, data in files.items():
            (args.out.parent / name).write_bytes(data)
        said = {**said, "written": ", ".join(files)}
    _print(said, args.json)
    return 1 if judged.broken else 0


def import_motion(args: argparse.Namespace) -> int:
    """What the file is; with --out the motion itself."""
    if args.server:
        return send_capture(args)
    from exogauge.motion.contacts import with_contacts
    from exogauge.motion.files import open_motion
    from exogauge.motion.gaps import fill_gaps
    from exogauge.motion.summary import summarise, write_arrays

    refuse_no_place(args.out)
    motion = open_motion(args.file, skeleton=args.skeleton, **_stated(args))
    if args.fill:
        motion = fill_gaps(motion)
    motion = with_contacts(motion)
    said = summarise(motion)
    if args.out is not None:
        write_arrays(motion, args.out)
    _print(said, args.json)
    return 0
