"""Studies at a service: hand them in, let them be evaluated, wait, fetch, compare, share.

What is asked for goes to stdout, what happens to stderr. Every command may be given again: the same files are the same
study, an equal request is the same job, what was fetched stays.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import UUID

from exogauge.cli.accounts import HERE
from exogauge.cli.endings import BAD_INPUT, INCOMPLETE, Commands, refuse_no_folder
from exogauge.errors import BadInput, Fault

if TYPE_CHECKING:
    from exogauge.client import Client, Job, Study

KINDS = ("evaluate", "support", "stiffness")
ID = "id of a job, or of a study: its newest evaluation"
ONLY_THERE: Mapping[str, object] = {  # options of `run`, and what they are where nobody asks for them
    "kind": None, "settings": [], "no_wait": False, "timeout": None, "json": False,
}  # fmt: skip


def add_commands(commands: Commands) -> None:
    """At a service."""
    upload = commands.add_parser("upload", help="hand a study in at a service; prints its id")
    upload.add_argument("study", type=Path, help="study.yaml, its folder, or a zip of it")
    upload.set_defaults(command=upload_study)

    listed = commands.add_parser("studies", help="studies that a service holds, newest first")
    listed.add_argument("--search", metavar="WORDS", help="of their names")
    listed.set_defaults(command=list_studies)

    wait = commands.add_parser("wait", help="until jobs have ended; 0 where all succeeded")
    wait.add_argument("jobs", nargs="+", metavar="JOB", help="id of a job")
    wait.add_argument("--timeout", type=float, metavar="S", help="end with 3 after so long; the job goes on")
    wait.set_defaults(command=wait_for_jobs)

    cancel = commands.add_parser("cancel", help="stop a job that waits or runs")
    cancel.add_argument("jobs", nargs="+", metavar="JOB", help="id of a job")
    cancel.set_defaults(command=cancel_jobs)

    results = commands.add_parser("results", help="what a job found: in words, as JSON, or all its files")
    results.add_argument("of", metavar="ID", help=ID)
    results.add_argument("--out", type=Path, metavar="DIR", help="fetch all its files there, and print their names")
    results.set_defaults(command=show_results)

    compare = commands.add_parser("compare", help="jobs side by side")
    compare.add_argument("of", nargs="+", metavar="ID", help=ID)
    compare.add_argument("--table", choices=("support", "stiffness"), default="support", help="which one")
    compare.add_argument("--latex", action="store_true", help="rounded by the standard deviations; default: CSV")
    compare.set_defaults(command=compare_jobs)

    export = commands.add_parser("export", help="samples of a job's series as CSV or Parquet; without a name: which")
    export.add_argument("of", metavar="ID", help=ID)
    export.add_argument("series", nargs="?", metavar="NAME", help="of the series: its log")
    export.add_argument("--out", type=Path, metavar="FILE", help="its ending says which: .csv or .parquet")
    export.add_argument(
        "--channel", action="append", default=[], metavar="NAME", help="default: all; as often as needed"
    )
    export.add_argument("--from", dest="start", type=float, metavar="S", help="begin of the window")
    export.add_argument("--to", dest="end", type=float, metavar="S", help="end of the window")
    export.set_defaults(command=export_series)

    share = commands.add_parser("share", help="let other labs read a study; without a lab: who may")
    share.add_argument("study", metavar="STUDY", help="its id")
    with_whom = share.add_mutually_exclusive_group()
    with_whom.add_argument("--lab", metavar="NAME", help="name of the lab")
    with_whom.add_argument("--all", action="store_true", help="every lab of the installation, those to come too")
    share.add_argument("--end", action="store_true", help="not any more")
    share.set_defaults(command=share_study)

    for each in (upload, listed, wait, cancel, results, compare, export, share):
        at_server(each)
        each.add_argument("--json", action="store_true", help="as JSON")


def at_server(command: argparse.ArgumentParser) -> None:
    here = os.environ.get("EXOGAUGE_URL", HERE)
    said = f"address of the service (default: EXOGAUGE_URL, or {HERE})"
    command.add_argument("--server", metavar="URL", default=here, help=said)


def add_run_there(run: argparse.ArgumentParser) -> None:
    """Options of `run` that a service needs."""
    run.add_argument("--server", metavar="URL", help="let the service at this address do it; --out is optional then")
    run.add_argument("--kind", choices=KINDS, help="how far (default: evaluate, all that the study allows)")
    setting = "in place of the study's own; as often as needed"
    run.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE", help=setting)
    run.add_argument("--no-wait", action="store_true", help="print the job's id, and leave")
    run.add_argument("--timeout", type=float, metavar="S", help="end with 3 after so long; the job goes on")
    run.add_argument("--json", action="store_true", help="the job as JSON")


def refuse_what_needs_one(options: argparse.Namespace) -> None:
    """What only a service does, asked without one."""
    asked = next((name for name, default in ONLY_THERE.items() if getattr(options, name) != default), None)
    if asked is not None:
        name = "--set" if asked == "settings" else f"--{asked.replace('_', '-')}"
        raise BadInput(Fault(f"{name} is for a service", "needs_server", "Name it with --server URL.", column=name))
    if options.out is None:
        raise BadInput(Fault("where results go is not said", "no_out", "Name a folder with --out.", column="--out"))


def run_there(options: argparse.Namespace) -> int:
    """0: it succeeded. 1: a step failed, or the job did, or was cancelled. 2: what was handed in is to blame."""
    from exogauge.client import Client

    with Client(options.server) as client:
        study = client.study(str(options.study)) if is_id(options.study) else client.upload_study(options.study)
        job = client.submit(study, options.kind or KINDS[0], settings_of(options.settings))
        say(f"study {study.id}\njob {job.id}")
        if options.no_wait:
            show(job, options.json, job.id)
            return 0
        ended = waited(client, job, options.timeout)
        if ended.state != "succeeded":
            show(ended, options.json, "")
            return told(ended)
        results = client.results(ended)
        if options.out is not None:
            client.download(ended, options.out)
            show(ended, options.json, f"{options.out / 'report.html'}\n{options.out / 'results.json'}")
        else:
            show(ended, options.json, "" if options.json else in_words(results))
    return told_steps(results)


def upload_study(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        study = client.upload_study(options.study)
    say(f"{study.name}, content {study.content_hash[:12]}")
    show(study, options.json, study.id)
    return 0


def list_studies(options: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.terminal import text_table

    with Client(options.server) as client:
        found = list(client.studies(options.search))
    if options.json:
        print(json.dumps([vars(each) for each in found], indent=1))
        return 0
    rows = [[each.id, each.name, str(each.created_at)[:16], (each.latest_job or {}).get("state", "")] for each in found]
    print(text_table(("id", "name", "handed in", "latest job"), rows) if rows else "none")
    return 0


def wait_for_jobs(options: argparse.Namespace) -> int:
    """The largest of the jobs' endings."""
    from exogauge.client import Client

    with Client(options.server) as client:
        ended = [waited(client, client.job(key), options.timeout) for key in options.jobs]
    if options.json:
        print(json.dumps([vars(each) for each in ended], indent=1))
    else:
        print("\n".join(f"{each.id} {each.state}" for each in ended))
    return max(told(each) for each in ended)


def cancel_jobs(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        stopped = [client.cancel(key) for key in options.jobs]
    if options.json:
        print(json.dumps([vars(each) for each in stopped], indent=1))
    else:
        print("\n".join(f"{each.id} {each.state if each.ended else 'is asked to stop'}" for each in stopped))
    return 0


def show_results(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    refuse_no_folder(options.out)
    with Client(options.server) as client:
        job = client.evaluated(options.of)
        results = client.results(job)
        written = [] if options.out is None else client.download(job, options.out)
    if options.json:
        print(json.dumps(results, indent=1))
    else:
        print("\n".join(map(str, written)) if written else in_words(results))
    return 0


def compare_jobs(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        jobs = [client.evaluated(key) for key in options.of]
        if options.json:
            print(json.dumps(client.compare(jobs), indent=1))
        else:
            print(client.comparison(jobs, "latex" if options.latex else "csv", options.table), end="")
    return 0


def export_series(options: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.terminal import text_table

    with Client(options.server) as client:
        job = client.evaluated(options.of)
        if options.series is None:
            found = client.series(job)
            keys = ("name", "samples", "start", "end", "rate_hz")
            rows = [[each[key] for key in keys] for each in found]
            print(json.dumps(found, indent=1) if options.json else text_table(keys, rows) if rows else "none")
            return 0
        if options.out is None or options.out.suffix not in (".csv", ".parquet"):
            advice = "Name it with --out FILE.csv or --out FILE.parquet."
            raise BadInput(Fault("which file to write is not said", "no_out", advice, column="--out"))
        written = client.export_series(job, options.series, options.out, options.channel, options.start, options.end)
    print(json.dumps({"job": job.id, "file": str(written)}) if options.json else written)
    return 0


def share_study(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        if (options.lab or options.all) and not options.end:
            client.share(options.study, options.lab)
        shares = client.shares(options.study)
        if options.end:
            any_lab = not (options.lab or options.all)
            ended = [each for each in shares if any_lab or each["lab"] == options.lab]
            for each in ended:
                client.end_share(options.study, each["id"])
            shares = [each for each in shares if each not in ended]
    names = [each["lab"] or "every lab" for each in shares]
    print(json.dumps(shares, indent=1) if options.json else "\n".join(names) or "nobody else")
    return 0


def waited(client: Client, job: Job, timeout_s: float | None) -> Job:
    """The job, ended. Raises NotNow after `timeout_s`, ClientProblem where there is no such job."""
    from exogauge.client.problems import ClientProblem

    try:
        return client.wait(job, timeout_s=timeout_s)
    except KeyboardInterrupt:
        say(f"the job goes on: exogauge wait {job.id} --server {client.url}")
        raise
    except ClientProblem as problem:
        now = client.job(job) if not (problem.status or problem.later) else None
        if now is None or not now.ended:
            raise
        return now


def told(job: Job) -> int:
    """Say why a job did not succeed, and end as that asks for."""
    from exogauge.client.problems import problem_of_job

    if job.state == "succeeded":
        return 0
    say(f"exogauge: {job.id}: {problem_of_job(job)}")
    return BAD_INPUT if job.problem is not None and job.problem.get("status", 422) < 500 else INCOMPLETE


def told_steps(results: Mapping[str, Any]) -> int:
    failed = [each for each in results.get("steps", ()) if each.get("status") == "failed"]
    for each in failed:
        say(f"exogauge: the step {each['step']} failed, what was found before it stands: {each['reason']}")
    return INCOMPLETE if failed else 0


def in_words(results: Mapping[str, Any]) -> str:
    """One page, where it is a study's."""
    from exogauge.studies.report.summary_text import summary_text

    return summary_text(results) if "discrepancy" in results else json.dumps(results, indent=1)


def settings_of(given: list[str]) -> dict[str, Any]:
    """Of KEY=VALUE, each value as YAML reads it."""
    import yaml

    settings = dict[str, Any]()
    for each in given:
        key, equals, text = each.partition("=")
        try:
            settings[key.strip()] = yaml.safe_load(text)
        except yaml.YAMLError:
            equals = ""
        if not (equals and key.strip()):
            advice = "Write KEY=VALUE, such as cutoff_hz=8."
            raise BadInput(Fault("this sets nothing", "no_setting", advice, column="--set", value=each))
    return settings


def is_id(path: Path) -> bool:
    """Whether no such file is there, and it is what a service calls a study."""
    try:
        return not path.exists() and str(UUID(str(path))) == str(path)
    except ValueError:
        return False


def show(thing: Study | Job, as_json: bool, words: str) -> None:
    if as_json or words:
        print(json.dumps(vars(thing), indent=1) if as_json else words)


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
