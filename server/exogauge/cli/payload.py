"""`exogauge payload`: what hangs on a wrist force/torque sensor, on local files or by a service."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exogauge.cli.endings import Commands, refuse_what_is_there

if TYPE_CHECKING:
    from exogauge.client import Client, Job, Payload


def add_commands(commands: Commands) -> None:
    """`payload` and its steps."""
    payload = commands.add_parser("payload", help="what hangs on a wrist force/torque sensor")
    steps = payload.add_subparsers(dest="step", required=True, metavar="STEP")
    identify = steps.add_parser("run", help="identify it, and tell what is left of the wrench")
    identify.add_argument("payload", type=Path, help="payload.yaml, or its folder")
    identify.add_argument("--out", type=Path, required=True, metavar="DIR", help="where results.json goes")
    identify.add_argument("--force", action="store_true", help="write into a folder that holds something already")
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
    table = steps.add_parser("tables", help="what three methods say and leave, before and after the secondary zero")
    table.add_argument("results", type=Path, help="results.json of a payload, or its folder")
    table.add_argument("--out", type=Path, metavar="FILE.csv", help="what is left, a row per log, method and quantity")
    table.set_defaults(command=show_payload_tables)
    listed = steps.add_parser("list", help="payloads that a service holds, newest first")
    _add_server(listed, needed=True)
    listed.set_defaults(command=list_payloads)
    look = steps.add_parser("doctor", help="examine its logs before they are believed")
    look.add_argument("payload", type=Path, help="payload.yaml, or its folder")
    _add_server(look)
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
        planned.add_argument("--force", action="store_true", help="write into a folder that holds something already")
        _add_server(planned)
        planned.set_defaults(command=plan_payload)


def _add_server(step: argparse.ArgumentParser, *, needed: bool = False) -> None:
    step.add_argument("--server", metavar="URL", required=needed, help="let the service at this address do it")


def run_payload(options: argparse.Namespace) -> int:
    from exogauge.payload.evaluate import evaluate
    from exogauge.payload.intake import open_payload
    from exogauge.payload.report import write_report
    from exogauge.payload.results import results, summary, write_results

    refuse_what_is_there(options.out, options.force)
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
    from exogauge.terminal import text_table

    found = _service_findings(options) if options.server else _own_findings(options.payload)
    keys = ("log", "severity", "channel", "rule")
    rows = [[*(each[key] for key in keys), f"{each['detail']}. {each['advice']}"] for each in found]
    print(text_table(("log", "", "channel", "rule", ""), rows, widest=110) if rows else "nothing to find fault with")
    return 1 if any(each["severity"] == "error" for each in found) else 0


def _own_findings(path: Path) -> list[dict[str, Any]]:
    from exogauge.payload.doctor import examine
    from exogauge.payload.intake import open_payload

    return [{"log": log, **vars(each)} for log, each in examine(open_payload(path))]


def _service_findings(options: argparse.Namespace) -> list[dict[str, Any]]:
    from exogauge.client import Client

    with Client(options.server) as client:
        payload = client.upload_payload(options.payload)
    print(f"payload {payload.id}, version {payload.version}")
    return list(payload.summary.get("findings", ()))


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


def show_payload_tables(options: argparse.Namespace) -> int:
    from exogauge.payload.exports.formats import read_results
    from exogauge.payload.tables import as_csv, as_text

    found = read_results(options.results)
    print(as_text(found))
    if options.out is not None:
        options.out.write_bytes(as_csv(found))
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
    """1 when a sample was refused, or so few came that nothing was told."""
    import json
    from contextlib import ExitStack

    from exogauge.payload.live_lines import Stream, from_lines, from_log, lines, written
    from exogauge.payload.live_start import open_start

    stream = Stream(*open_start(options.payload), options.rate)
    messages = from_lines(sys.stdin, stream) if options.log is None else from_log(log_beside(options), stream)
    with ExitStack() as opened:
        if options.out is not None:
            messages = written(messages, opened.enter_context(options.out.open("w", encoding="utf-8")))
        for line in (json.dumps(each) for each in messages) if options.json else lines(messages):
            print(line, flush=True)
    return 1 if stream.arrivals.counts.refused or not stream.live.told else 0


def plan_payload(options: argparse.Namespace) -> int:
    from exogauge.payload.planning.plan import open_plan, plan_excitation, plan_postures, summary, write_plan
    from exogauge.terminal import bar

    refuse_what_is_there(options.out, options.force)
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
