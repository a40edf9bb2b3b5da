"""The command line: each command is a few lines that call what does the work, imported when it is needed."""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from exogauge import __version__
from exogauge.blas_threads import one_thread
from exogauge.errors import ExogaugeError

if TYPE_CHECKING:
    from exogauge.client import Client, Job, Payload

INCOMPLETE, BAD_INPUT = 1, 2
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
SHOWN_FINDINGS = 5  # channels of one sort, unless it is an error


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. 0: done. 1: not all of it. 2: input or installation not usable, and the message says why."""
    os.environ.update(one_thread(os.environ))  # before NumPy is there: processors are for logs (`side_by_side`)
    options = parser().parse_args(arguments)
    level = logging.INFO if options.verbose else logging.WARNING
    logging.basicConfig(level=level, format="%(asctime)s %(levelname)s %(name)s: %(message)s", force=True)
    try:
        code: int = options.command(options)
    except ExogaugeError as error:
        print(f"exogauge {options.name}: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # whoever read along has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return code


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


class InOrder(argparse.Action):
    """Options whose order among each other counts: (option, text) after (option, text)."""

    def __call__(
        self, parser: object, namespace: argparse.Namespace, values: object, option: str | None = None
    ) -> None:
        given = getattr(namespace, self.dest)
        setattr(namespace, self.dest, [*given, (self.option_strings[0].lstrip("-"), values)])


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(
        prog="exogauge", description="Say with numbers what an assistive wear does to a body."
    )
    top.add_argument("--version", action="version", version=f"exogauge {__version__}")
    top.add_argument("-v", "--verbose", action="store_true", help="log what happens to stderr")
    commands = top.add_subparsers(dest="name", required=True, metavar="COMMAND")
    _add_study_commands(commands)
    _add_synthetic_commands(commands)
    _add_service_commands(commands)
    return top


def _add_study_commands(commands: Commands) -> None:
    """On local files."""
    run = commands.add_parser("run", help="evaluate a study on local files, without a server")
    run.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it")
    run.add_argument("--out", type=Path, required=True, metavar="DIR", help="where results.json and the rest go")
    run.set_defaults(command=run_study)

    doctor = commands.add_parser("doctor", help="examine a study's logs before they are believed")
    doctor.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it")
    doctor.add_argument("--all", action="store_true", help="every finding, also where there are many of one sort")
    doctor.set_defaults(command=examine_logs)

    payload = commands.add_parser("payload", help="what hangs on a wrist force/torque sensor")
    steps = payload.add_subparsers(dest="step", required=True, metavar="STEP")
    identify = steps.add_parser("run", help="identify it, and tell what is left of the wrench")
    identify.add_argument("payload", type=Path, help="payload.yaml, or its folder")
    identify.add_argument("--out", type=Path, required=True, metavar="DIR", help="where results.json goes")
    _add_server(identify)
    identify.set_defaults(command=run_payload)
    out = steps.add_parser("export", help="what was identified, for a robot's model or controller")
    out.add_argument("results", help="results.json of a payload, or its folder; with --server the payload's id")
    out.add_argument("--format", required=True, metavar="FORMAT", help="json, csv, urdf, sdf, mjcf, ur, kuka or abb")
    pose = "pose of the sensor in the flange [m, °, about the flange's fixed axes] (default: all in the sensor's frame)"
    out.add_argument("--flange", type=float, nargs=6, metavar=("X", "Y", "Z", "ROLL", "PITCH", "YAW"), help=pose)
    out.add_argument("--out", type=Path, metavar="FILE", help="write it there, and not to the screen")
    _add_server(out)
    out.set_defaults(command=export_payload)
    listed = steps.add_parser("list", help="payloads that a service holds, newest first")
    _add_server(listed, needed=True)
    listed.set_defaults(command=list_payloads)
    look = steps.add_parser("doctor", help="examine its logs before they are believed")
    look.add_argument("payload", type=Path, help="payload.yaml, or its folder")
    look.set_defaults(command=examine_payload)
    live = steps.add_parser("live", help="identify and compensate it sample by sample: from a log, or lines on stdin")
    live.add_argument("payload", type=Path, help="payload.yaml, or its folder: what is known when the stream begins")
    live.add_argument("--log", type=Path, metavar="FILE", help="read as if it were live; without it: lines on stdin")
    live.add_argument("--rate", type=float, default=250.0, metavar="HZ", help="of the samples (default: 250)")
    live.add_argument("--out", type=Path, metavar="FILE.csv", help="write the contact wrench of every sample there")
    live.add_argument("--json", action="store_true", help="every message as a line of JSON")
    live.set_defaults(command=follow_payload)
    for what, help_text in (
        ("postures", "plan the postures that tell most of it"),
        ("excite", "plan the motion that tells most of its inertia"),
    ):
        planned = steps.add_parser(what, help=help_text)
        planned.add_argument("payload", type=Path, help="payload.yaml with `plan`, or its folder")
        planned.add_argument("--out", type=Path, required=True, metavar="DIR", help="where the CSV and the JSON go")
        _add_server(planned)
        planned.set_defaults(command=plan_payload)

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


def _add_server(step: argparse.ArgumentParser, *, needed: bool = False) -> None:
    step.add_argument("--server", metavar="URL", required=needed, help="let the service at this address do it")


def _add_synthetic_commands(commands: Commands) -> None:
    """What is simulated."""
    sample = commands.add_parser("sample", help="write a complete synthetic study")
    sample.add_argument("out", type=Path, metavar="OUT")
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
    sample.add_argument("--payload", action="store_true", help="a payload behind a wrist sensor instead of a study")
    sample.set_defaults(command=write_sample)

    blind = commands.add_parser("blind", help="studies with hidden effects: how often is what is named right?")
    steps = blind.add_subparsers(dest="step", required=True, metavar="STEP")
    make = steps.add_parser("make", help="write the cases and, sealed, what is hidden in them")
    make.add_argument("out", type=Path, metavar="OUT", help="a new folder")
    make.add_argument("--seed", type=int, required=True, metavar="N")
    make.add_argument("--cases", type=int, required=True, metavar="K")
    make.add_argument("--robot", choices=("arm6", "torso8", "both"), default="both", help="(default: both)")
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


def _add_service_commands(commands: Commands) -> None:
    """Server, workers, database, demonstration."""
    serve = commands.add_parser("serve", help="the service: API, page and workers, on this machine only by default")
    serve.add_argument("--host", help="address to listen on (EXOGAUGE_HOST)")
    serve.add_argument("--port", type=int, help="port; 0 takes a free one (EXOGAUGE_PORT)")
    serve.add_argument("--workers", type=int, help="worker processes; 0: none here (EXOGAUGE_WORKERS)")
    serve.add_argument("--data-dir", type=Path, help="where everything is kept (EXOGAUGE_DATA_DIR)")
    serve.add_argument("--with-parent", action="store_true", help="stop when stdin ends")
    serve.set_defaults(command=start_server)

    work = commands.add_parser("work", help="one more worker for the same database and blobs")
    work.add_argument("--with-parent", action="store_true", help="stop when stdin ends")
    work.set_defaults(command=start_worker)

    migrate = commands.add_parser("migrate", help="bring the database to this version; back it up before")
    migrate.set_defaults(command=upgrade_database)

    demo = commands.add_parser("demo", help="evaluate the sample study through the service, and print the result")
    demo.set_defaults(command=show_demo)


def run_study(options: argparse.Namespace) -> int:
    """2 when the data hold no answer for a step behind the identification, 1 when such a step failed unexpectedly."""
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
    from exogauge.studies.words.notices import by_sort, named
    from exogauge.terminal import text_table

    with open_study(options.study) as study:
        logs = admit(study)
        sorts = by_sort(examined(study.robot, logs.recordings, logs.worn))
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
    print(f"{sum(len(sort.each) for sort in sorts)} findings of {len(sorts)} sorts, {errors} of them errors")
    return 1 if errors else 0


def run_payload(options: argparse.Namespace) -> int:
    from exogauge.payload.evaluate import evaluate
    from exogauge.payload.intake import open_payload
    from exogauge.payload.report import write_report
    from exogauge.payload.results import results, summary, write_results

    if options.server:
        return send_payload(options, lambda client, payload: client.identify_payload(payload))
    evaluation = evaluate(open_payload(options.payload))
    path, found = write_results(evaluation, options.out), results(evaluation)
    print(summary(found))
    print(write_report(found, options.out))
    print(path)
    return 0


def examine_payload(options: argparse.Namespace) -> int:
    """1 when a log has an error."""
    from exogauge.payload.doctor import examine
    from exogauge.payload.intake import open_payload
    from exogauge.terminal import text_table

    found = examine(open_payload(options.payload))
    rows = [[log, each.severity, each.channel, each.rule, f"{each.detail}. {each.advice}"] for log, each in found]
    print(text_table(("log", "", "channel", "rule", ""), rows, widest=110) if rows else "nothing to find fault with")
    return 1 if any(each.severity == "error" for _, each in found) else 0


def export_payload(options: argparse.Namespace) -> int:
    from exogauge.payload.exports.formats import export, read_results, results_from

    if options.server:
        from exogauge.client import Client

        with Client(options.server) as client:
            found = results_from(json.dumps(client.payload_results(options.results)).encode(), "results.json")
    else:
        found = read_results(Path(options.results))
    text = export(found, options.format, options.flange)
    if options.out is None:
        print(text, end="")
    else:
        options.out.write_text(text, encoding="utf-8")
        print(options.out)
    return 0


def list_payloads(options: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.terminal import text_table

    with Client(options.server) as client:
        rows = [[each.id, each.name, each.version, len(each.summary.get("logs", ()))] for each in client.payloads()]
    print(text_table(("id", "name", "version", "logs"), rows) if rows else "none")
    return 0


def send_payload(options: argparse.Namespace, ask: Callable[[Client, Payload], Job]) -> int:
    """Hand it in, wait, and fetch what was made."""
    from exogauge.client import Client

    with Client(options.server) as client:
        payload = client.upload_payload(options.payload)
        job = client.wait(ask(client, payload))
        written = client.download(job, options.out)
    print(f"payload {payload.id}, version {payload.version}")
    for path in written:
        print(path)
    return 0


def log_beside(options: argparse.Namespace) -> Path:
    """The log as it is named, or as payload.yaml's folder has it."""
    from exogauge.errors import BadInput, Fault

    folder = options.payload if options.payload.is_dir() else options.payload.parent
    for each in (options.log, folder / options.log, folder / "logs" / options.log):
        if each.is_file():
            return Path(each)
    raise BadInput(
        Fault("there is no such file", "no_file", "Name it from here, or from payload.yaml.", str(options.log))
    )


def follow_payload(options: argparse.Namespace) -> int:
    """1 when a sample was refused."""
    import json
    from contextlib import ExitStack

    from exogauge.payload.live_lines import Stream, from_lines, from_log
    from exogauge.payload.live_start import open_start
    from exogauge.payload.live_text import lines, written

    stream = Stream(*open_start(options.payload), options.rate)
    messages = from_lines(sys.stdin, stream) if options.log is None else from_log(log_beside(options), stream)
    with ExitStack() as opened:
        if options.out is not None:
            messages = written(messages, opened.enter_context(options.out.open("w", encoding="utf-8")))
        for line in (json.dumps(each) for each in messages) if options.json else lines(messages):
            print(line, flush=True)
    return 1 if stream.arrivals.counts.refused else 0


def plan_payload(options: argparse.Namespace) -> int:
    from exogauge.payload.planning.plan import open_plan, plan_excitation, plan_postures, summary, write_plan
    from exogauge.terminal import bar

    if options.server:
        what = "postures" if options.step == "postures" else "excitation"
        return send_payload(options, lambda client, payload: client.plan_payload(payload, what))
    asked = open_plan(options.payload)
    with bar(options.step) as progress:
        plan = (plan_postures if options.step == "postures" else plan_excitation)(asked, progress)
    print(summary(plan.found))
    for path in write_plan(plan, options.out):
        print(path)
    return 0


def draft_mapping(options: argparse.Namespace) -> int:
    from exogauge.studies.import_log.mapping_draft import draft
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


def write_sample(options: argparse.Namespace) -> int:
    from exogauge import synthetic
    from exogauge.terminal import bar

    if options.payload:
        synthetic.write_payload_sample(options.out, options.seed, options.hidden)
        print(options.out / "payload.yaml")
        return 0
    with bar("sample") as progress:
        synthetic.write_sample(
            options.out, options.seed, options.hidden, options.suit, progress, processes=synthetic.processors()
        )
    print(options.out / "study.yaml")
    return 0


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

    from exogauge.blind.score import score
    from exogauge.blind.score_text import score_text

    found = score(options.out)
    print(score_text(found))
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 0


def start_server(options: argparse.Namespace) -> int:
    from exogauge.serving import serve
    from exogauge.settings import Settings

    given = {key: getattr(options, key) for key in ("host", "port", "workers", "data_dir")}
    for key, value in given.items():
        if value is not None:  # by the environment, so that the workers see it too
            os.environ[f"EXOGAUGE_{key.upper()}"] = str(value)
    serve(Settings(), with_parent=options.with_parent)
    return 0


def start_worker(options: argparse.Namespace) -> int:
    from exogauge.jobs.worker import work
    from exogauge.settings import Settings

    work(Settings(), with_parent=options.with_parent)
    return 0


def upgrade_database(_: argparse.Namespace) -> int:
    from exogauge.serving import upgrade
    from exogauge.settings import Settings

    print(f"the database is at revision {upgrade(Settings())}")
    return 0


def show_demo(_: argparse.Namespace) -> int:
    from exogauge.demo import demo
    from exogauge.settings import Settings

    demo(Settings())
    return 0


if __name__ == "__main__":
    sys.exit(main())
