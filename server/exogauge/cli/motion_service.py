"""`exogauge motion … --server`: a service reads, plans and keeps; what it made is fetched."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exogauge.client import Client, Motion, Plan


def add_server(step: argparse.ArgumentParser, *, needed: bool = False) -> None:
    step.add_argument("--server", metavar="URL", required=needed, help="let the service at this address do it")


def send_capture(args: argparse.Namespace) -> int:
    """Hand it in, and say what it is."""
    from exogauge.client import Client

    with Client(args.server) as client:
        motion = uploaded(client, args)
    said = {"motion": f"{motion.id}, version {motion.version}", **motion.summary.get("told", {})}
    show(said, args.json)
    return 0


def send_retarget(args: argparse.Namespace, options: dict[str, Any]) -> int:
    """1 where a bound is broken; then nothing is written, unless `--despite`."""
    from exogauge.client import Client

    with Client(args.server) as client:
        motion, robot = uploaded(client, args), client.upload_robot(args.robot)
        return fetched(client, client.wait_plan(client.plan_motion(motion, robot, **options)), args, args.format)


def send_excite(args: argparse.Namespace) -> int:
    """1 where no motion keeps within every bound; then nothing is written."""
    from exogauge.client import Client

    with Client(args.server) as client:
        robot = client.upload_robot(args.robot)
        study = None if args.study is None else client.upload_study(args.study)
        asked = client.plan_excitation(robot, study, seconds=args.seconds, seed=args.seed)
        return fetched(client, client.wait_plan(asked), args, "csv")


def list_plans(args: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.terminal import text_table

    with Client(args.server) as client:
        rows = [[each.id, each.name, each.kind, (each.latest_job or {}).get("state", "")] for each in client.plans()]
    print(text_table(("id", "name", "kind", "state"), rows) if rows else "none")
    return 0


def uploaded(client: Client, args: argparse.Namespace) -> Motion:
    from exogauge.errors import BadMotion, Fault

    if args.name:
        advice = "Hand it in without --name, and say the names on the page of the motion"
        raise BadMotion(Fault("a service keeps names as a map", "names_as_map", advice, column="--name"))
    said = {"up": args.up, "unit": args.unit, "angle": args.angle, "subject": args.subject}
    return client.upload_motion(args.file, args.skeleton, getattr(args, "static", None), **said)


def fetched(client: Client, plan: Plan, args: argparse.Namespace, form: str) -> int:
    found = plan.found or {}
    said = {"plan": plan.id, **found.get("told", {})}
    broken, despite = bool(found.get("broken")), getattr(args, "despite", False)
    if args.out is not None and (despite or not broken):
        rate = getattr(args, "rate", None) if form != "csv" else None
        target: Path = args.out if form == "csv" else args.out.with_suffix(".zip")
        said["written"] = client.export_plan(plan, form, target, rate, despite=despite).name
    show(said, args.json)
    return 1 if broken else 0


def show(said: dict[str, Any], as_json: bool) -> None:
    print(json.dumps(said, indent=2) if as_json else "\n".join(f"{key:24} {value}" for key, value in said.items()))
