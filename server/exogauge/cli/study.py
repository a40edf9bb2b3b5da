"""Commands on the files of a study: evaluate and examine it, its mapping, its device, another device."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from exogauge.cli import at_service
from exogauge.cli.endings import BAD_INPUT, INCOMPLETE, Commands, refuse_no_folder

SHOWN_FINDINGS = 5  # channels of one sort, unless it is an error
CHANGES = {
    "set": "A.stiffness=300 (N/m), A_left.natural_length=0.6 (m), A.pretension=0.02 (m stretched with all joints at "
    "zero), A.law=NAME,KEY=VALUE; or a via point: A_left.3=chest:0.1,0,0.2, its link or its place alone too",
    "scale": "A.stiffness=2, A_left.natural_length=0.95",
    "move": "A_left.3=0,0,0.01 (m, in its link's frame), A_left.natural_length=-0.02",
    "add": "A_left.3=chest:0.1,0,0.2: a new via point number 3",
    "remove": "A_left.3 (a via point), A_left (a band), A (a group)",
    "copy": "A_left=A_left_2: one band more like it",
    "mirror": "A_left=A_right: its like on the other side",
}
WHAT_IF = """What another device would do over a recorded motion: torque of each joint, before and after.

A change names a band, a group, or '*' for all, then a dot and what is changed. Changes are made in the order in
which they are written, each as often as needed. Via points count from 0. Numbers are SI."""


def add_commands(commands: Commands) -> None:
    """On local files."""
    run = commands.add_parser("run", help="evaluate a study: on local files, or with --server by a service")
    run.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it; at a service its id does, too")
    run.add_argument("--out", type=Path, metavar="DIR", help="where results.json and the rest go")
    at_service.add_run_there(run)
    run.set_defaults(command=run_study)

    doctor = commands.add_parser("doctor", help="examine a study's logs before they are believed")
    doctor.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it")
    doctor.add_argument("--all", action="store_true", help="every finding, also where there are many of one sort")
    doctor.set_defaults(command=examine_logs)

    robot = commands.add_parser("robot", help="draft a robot.yaml for a URDF, by looking at it")
    robot.add_argument("urdf", type=Path, metavar="URDF")
    robot.add_argument("--actuation", choices=("current", "torque"), default="current", help="what drives log")
    robot.add_argument("--out", type=Path, metavar="ROBOT.yaml", help="write it there, and not to the screen")
    robot.set_defaults(command=draft_robot)

    mapping = commands.add_parser("mapping", help="draft a mapping.yaml for foreign log files, by looking at them")
    mapping.add_argument("files", type=Path, nargs="+", metavar="FILE", help="the files of one log")
    mapping.add_argument("--robot", type=Path, metavar="FILE", help="robot.yaml, or nothing but a URDF")
    mapping.add_argument("--out", type=Path, metavar="MAPPING.yaml", help="write it there, and not to the screen")
    mapping.set_defaults(command=draft_mapping)

    device = commands.add_parser(
        "device", help="check a device file on its robot: where bands run, which way they pull"
    )
    device.add_argument("device", type=Path, nargs="?", metavar="DEVICE.yaml", help="without it: the robot's links")
    device.add_argument("--robot", type=Path, metavar="FILE", help="robot.yaml, or nothing but a URDF")
    device.add_argument("--study", type=Path, help="study.yaml, its folder, or a zip of it, in place of --robot")
    device.add_argument("--log", type=Path, metavar="FILE", help="lengths and moment arms over this log too")
    device.add_argument("--picture", type=Path, metavar="FILE.svg", help="draw the bands on the robot, front and side")
    place = "a place seen from the base link [m], all joints at zero, as a via point of LINK"
    device.add_argument("--place", nargs=4, action="append", metavar=("LINK", "X", "Y", "Z"), default=[], help=place)
    device.set_defaults(command=check_device)

    over = commands.add_parser("take-over", help="write what a result named of a device's bands into its device file")
    over.add_argument("results", type=Path, help="results.json of a study that wore it, or its folder")
    over.add_argument("device", type=Path, metavar="DEVICE.yaml", help="the file that the study named")
    over.add_argument("--out", type=Path, metavar="FILE", help="write it there, and not to the screen")
    over.set_defaults(command=take_over)

    what_if = commands.add_parser(
        "whatif", help="what another device would do over a recorded motion", description=WHAT_IF,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    what_if.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it")
    what_if.add_argument("--log", required=True, metavar="NAME_OR_FILE", help="a log of the study, or any other file")
    what_if.add_argument("--device", metavar="FILE", help="the device to start from (default: what the log wears)")
    for option, text in CHANGES.items():
        what_if.add_argument(f"--{option}", action=InOrder, dest="changes", metavar="CHANGE", help=text)
    what_if.add_argument("--changes", action=InOrder, dest="changes", metavar="FILE", help="the same as YAML")
    aim = "a joint that the device is for (default: the one with the largest torque)"
    what_if.add_argument("--main", action="append", default=[], metavar="JOINT", help=aim)
    what_if.add_argument("--save", type=Path, metavar="FILE", help="write the changed device as device.yaml")
    what_if.add_argument("--json", action="store_true", help="the answer as JSON")
    what_if.set_defaults(command=ask_what_if, changes=[])


class InOrder(argparse.Action):
    """Options whose order among each other counts: (option, text) after (option, text)."""

    def __call__(
        self, parser: object, namespace: argparse.Namespace, values: object, option: str | None = None
    ) -> None:
        given = getattr(namespace, self.dest)
        setattr(namespace, self.dest, [*given, (self.option_strings[0].lstrip("-"), values)])


def run_study(options: argparse.Namespace) -> int:
    """2 when the data hold no answer for a step behind the identification, 1 when such a step failed unexpectedly."""
    refuse_no_folder(options.out)
    if options.server:
        return at_service.run_there(options)
    at_service.refuse_what_needs_one(options)
    from exogauge.studies.evaluate import evaluate
    from exogauge.terminal import bar

    with bar("run") as progress:
        failed = evaluate(options.study, options.out, progress)
    print(f"{options.out / 'report.html'}\n{options.out / 'results.json'}")
    for each in failed:
        print(f"exogauge run: {each.sentence}", file=sys.stderr)
    return 0 if not failed else BAD_INPUT if all(each.expected for each in failed) else INCOMPLETE


def examine_logs(options: argparse.Namespace) -> int:
    """1 when a log has an error."""
    from exogauge.studies.intake.admit import admit
    from exogauge.studies.intake.open import open_study
    from exogauge.studies.results.examine_logs import examine_logs as examined
    from exogauge.studies.words.names import counted
    from exogauge.studies.words.notices import by_sort
    from exogauge.studies.words.remark_words import named
    from exogauge.terminal import text_table

    with open_study(options.study) as study:
        logs = admit(study)
        sorts = by_sort(examined(study.robot, logs.recordings, logs.worn))
        noticed = [f"NOTE {each.code}: {each.short}" for each in study.notices]
    print("\n".join(noticed), end="\n" if noticed else "")
    columns = ("channel", "logs", "detail")
    for sort in sorts:
        places = sort.places
        if not (sort.first or options.all):
            print(f"{sort.severity.upper()} {sort.rule}: {named([place.channel for place in places])}")
            continue
        most = len(places) if options.all or sort.severity == "error" else SHOWN_FINDINGS
        advice = f". {sort.advice[0].upper()}{sort.advice[1:]}" if sort.advice else ""
        print(f"{sort.severity.upper()} {sort.rule}: {len(places)}{advice}")
        rows = [[each.channel, named(each.logs), each.finding.get("detail")] for each in places[:most]]
        print(text_table(columns, rows, widest=110))
        print(f"… and {len(places) - most} more channels\n" if len(places) > most else "")
    if any(not sort.first for sort in sorts) and not options.all:
        print("--all lists every channel of every sort")
    errors = sum(len(sort.each) for sort in sorts if sort.severity == "error")
    found = counted(sum(len(sort.each) for sort in sorts), "finding")
    print(f"{found} of {counted(len(sorts), 'sort')}, {counted(errors, 'error')}")
    return 1 if errors else 0


def draft_robot(options: argparse.Namespace) -> int:
    """Beside its URDF, which it names; never over a file that is there."""
    from exogauge.errors import BadRobot, Fault
    from exogauge.studies.import_log.robot_draft import draft_robot as drafted
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.robot_file import MAX_URDF_BYTES

    folder = options.urdf.resolve().parent
    text = drafted(
        Bundle(folder, "").read(options.urdf.name, limit=MAX_URDF_BYTES), options.urdf.name, options.actuation
    )
    if options.out is None:
        print(text, end="")
        return 0
    if options.out.resolve().parent != folder or options.out.exists():
        advice = "Name a new file beside the URDF with --out"
        raise BadRobot(Fault("robot.yaml stands beside its URDF, and none is written over", "no_place", advice,
                             str(options.out)))  # fmt: skip
    options.out.write_text(text, encoding="utf-8")
    print(options.out)
    return 0


def draft_mapping(options: argparse.Namespace) -> int:
    from exogauge.studies.import_log.log_preview import draft
    from exogauge.studies.intake.device_on_robot import read_wearer

    robot = None if options.robot is None else read_wearer(options.robot, None)
    text = draft(options.files, robot)
    if options.out is None:
        print(text, end="")
    else:
        options.out.write_text(text, encoding="utf-8")
        print(options.out)
    return 0


def take_over(options: argparse.Namespace) -> int:
    import json

    from exogauge.errors import BadInput
    from exogauge.studies.intake.contract import DeviceFile
    from exogauge.studies.intake.yaml_file import read_yaml
    from exogauge.studies.results.taken_over import taken_over_of

    file = options.results / "results.json" if options.results.is_dir() else options.results
    results = json.loads(file.read_bytes())
    _, content, faults = read_yaml(options.device.read_bytes(), DeviceFile, file=options.device.name)
    if faults:
        raise BadInput(faults)
    taken = taken_over_of(results, content)
    text = taken.text(f"{file}, study {results['name']!r}")
    if options.out is None:
        print(text, end="")
    else:
        options.out.write_text(text, encoding="utf-8")
        print("\n".join([str(options.out), *taken.said, *(f"Not taken over: {each}" for each in taken.left)]))
    return 0


def check_device(options: argparse.Namespace) -> int:
    from exogauge.studies.device_pages.device_picture import draw_device
    from exogauge.studies.device_pages.device_text import device_text
    from exogauge.studies.device_pages.link_table import link_table, via_point_at
    from exogauge.studies.intake.device_on_robot import check_device_file, read_wearer

    if options.device is None:
        robot, device = read_wearer(options.robot, options.study), None
        print("\n".join(via_point_at(robot, link, xyz) for link, *xyz in options.place) or link_table(robot))
    else:
        check = check_device_file(options.device, options.robot, options.study, options.log)
        robot, device = check.robot, check.device
        print(device_text(check))
    if options.picture is not None:
        options.picture.parent.mkdir(parents=True, exist_ok=True)
        options.picture.write_text(draw_device(robot, device), encoding="utf-8")
        print(f"\n{options.picture}")
    return 0


def ask_what_if(options: argparse.Namespace) -> int:
    from exogauge.studies.device_pages import what_if

    asked = what_if.ask(options.study, options.log, options.device, options.changes, options.main)
    print(what_if.to_json(asked.answer()).decode() if options.json else asked.text(), end="" if options.json else "\n")
    if options.save is not None:
        for path in asked.save(options.save):
            print(path, file=sys.stderr)
    return 0
