"""Commands that keep an installation whole: check, gc, backup, restore."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from exogauge.cli.at_service import at_server
from exogauge.cli.endings import Commands

if TYPE_CHECKING:  # imported where used: most commands need no database
    from exogauge.storage.retention import Retired

NOT_SOUND = 1  # what the command ends with
KINDS = {
    "study": "studies", "robot": "robots", "device": "devices", "log": "logs", "payload": "payloads",
    "motion": "motions", "plan": "plans",
}  # fmt: skip


def add_commands(commands: Commands) -> None:
    """Check, sweep, back up, restore."""
    check = commands.add_parser("check", help="read every blob and every reference, and say what is missing or damaged")
    check.add_argument("--json", action="store_true", help="as JSON")
    check.set_defaults(command=check_all)

    gc = commands.add_parser("gc", help="remove what nothing needs: the service does it every hour")
    gc.add_argument("--json", action="store_true", help="as JSON")
    gc.add_argument(
        "--stopped", action="store_true", help="no server and no worker runs: nothing is on its way, wait for nothing"
    )
    gc.add_argument(
        "--dry-run", action="store_true", help="say which closed labs go, and what because it is old; remove nothing"
    )
    gc.set_defaults(command=sweep_all)

    audit = commands.add_parser(
        "audit", help="old entries of the audit into a file; and, if said so, out of the database"
    )
    audit.add_argument("folder", type=Path, help="where the file goes; none is written over")
    audit.add_argument(
        "--older-than", type=float, metavar="DAYS", help="EXOGAUGE_AUDIT_KEPT_DAYS, where it is not named"
    )
    audit.add_argument("--remove", action="store_true", help="from the database too, once the file is written")
    audit.set_defaults(command=archive_old_audit)

    backup = commands.add_parser("backup", help="rows and blobs into a folder, beside a service that runs")
    backup.add_argument("folder", type=Path, help="new, or with an older backup: only new blobs are copied then")
    backup.set_defaults(command=back_up_all)

    restore = commands.add_parser("restore", help="a backup into an empty database, of either kind, and its blobs")
    restore.add_argument("folder", type=Path)
    restore.set_defaults(command=restore_all)

    delete = commands.add_parser("delete", help="delete something that a service keeps, with all that hangs on it")
    delete.add_argument("kind", choices=sorted(KINDS))
    delete.add_argument("id")
    at_server(delete)
    delete.set_defaults(command=delete_one)


def back_up_all(options: argparse.Namespace) -> int:
    from exogauge.jobs.leases import new_worker_id
    from exogauge.settings import Settings
    from exogauge.storage.store import open_installation
    from exogauge.terminal import bar
    from exogauge.upkeep.backup import back_up

    installation = open_installation(Settings(), migrating=True)
    with bar("blobs", shown=sys.stderr.isatty()) as say:
        told = lambda done, of: say(done / of, f"{done} of {of}", "copying")  # noqa: E731
        done = back_up(installation, options.folder, new_worker_id(), told)
    installation.close()
    print(f"{done.rows} rows, {done.blobs} blobs, {done.bytes / 1e6:.1f} MB, {done.copied} of them new")
    return 0


def restore_all(options: argparse.Namespace) -> int:
    from exogauge.jobs.engine import migrate_engine
    from exogauge.settings import Settings
    from exogauge.storage.checking import check
    from exogauge.storage.store import open_installation
    from exogauge.terminal import bar
    from exogauge.upkeep.backup import restore

    settings = Settings()
    installation = open_installation(settings)
    with bar("blobs", shown=sys.stderr.isatty()) as say:
        told = lambda done, of: say(done / of, f"{done} of {of}", "copying")  # noqa: E731
        done = restore(options.folder, settings, installation.blobs, told)
    migrate_engine(settings.database_url)
    found = check(installation, None)
    installation.close()
    print(f"{done.rows} rows, {done.blobs} blobs, {done.bytes / 1e6:.1f} MB")
    print(
        "every blob and every reference is sound" if found.sound else "NOT SOUND: `exogauge check` says what is missing"
    )
    return 0 if found.sound else NOT_SOUND


def archive_old_audit(options: argparse.Namespace) -> int:
    from exogauge.settings import Settings
    from exogauge.storage.migrate import at_newest_or_raise, current
    from exogauge.upkeep.old_audit import archive_audit

    settings = Settings()
    at_newest_or_raise(current(settings.database_url))
    days = settings.audit_kept_days if options.older_than is None else options.older_than
    done = archive_audit(settings.database_url, options.folder, timedelta(days=days), remove=options.remove)
    if done.file is None:
        print(f"no entry is from before {done.before:%Y-%m-%d %H:%M} UTC")
        return 0
    print(f"{done.count} entries of {len(done.entries)} labs from before {done.before:%Y-%m-%d %H:%M} UTC: {done.file}")
    print(f"SHA-256 {done.sha256}")
    print(
        "removed from the database; each lab's audit says so" if done.removed else "they stay in the database: --remove"
    )
    return 0


def delete_one(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        client.delete_by_id(KINDS[options.kind], options.id)
    print(f"{options.kind} {options.id} is deleted")
    return 0


def check_all(options: argparse.Namespace) -> int:
    from exogauge.settings import Settings
    from exogauge.storage.checking import check
    from exogauge.storage.migrate import at_newest_or_raise, current
    from exogauge.storage.store import open_installation

    settings = Settings()
    at_newest_or_raise(current(settings.database_url))
    installation = open_installation(settings)
    found = check(installation, settings)
    installation.close()
    if options.json:
        print(json.dumps(found.as_json(), indent=2))
        return 0 if found.sound else NOT_SOUND
    print(f"{found.blobs} blobs, {found.bytes / 1e6:.1f} MB, {found.references} references")
    rows = {
        "corrupt": "blobs are not what their name says",
        "missing": "references to a blob that is not there",
        "sizes": "rows tell another size than the blob has",
        "broken": "faults of the database",
        "orphans": "blobs that nothing names (gc removes them)",
        "left_over": "files that a killed process left (gc removes them)",
    }
    for name, words in rows.items():
        listed = getattr(found, name)
        print(f"{len(listed):6d} {words}")
        if name not in ("orphans", "left_over"):
            for each in listed[:20]:
                print(f"         {each}")
    if not found.sound:
        print("The store is not sound: restore what is missing from a backup (docs/operations.md).")
    return 0 if found.sound else NOT_SOUND


def sweep_all(options: argparse.Namespace) -> int:
    from exogauge.settings import Settings
    from exogauge.storage.closing import remove_due
    from exogauge.storage.held_files import YOUNG_S
    from exogauge.storage.migrate import at_newest_or_raise, current
    from exogauge.storage.orphans import WAIT
    from exogauge.storage.retention import Ages, no_labs, retire
    from exogauge.storage.store import open_installation
    from exogauge.storage.sweeping import sweep_installation, sweep_machine, waiting

    settings = Settings()
    at_newest_or_raise(current(settings.database_url))
    installation = open_installation(settings)
    closed = remove_due(installation, timedelta(days=settings.lab_kept_days), dry=options.dry_run)
    aged = retire(installation, Ages.of(settings), dry=options.dry_run)
    with installation.reading() as session:
        unknown = no_labs(session, settings.studies_kept_days, settings.lab)
    for lab in unknown:
        print(f"EXOGAUGE_STUDIES_KEPT_DAYS names a lab that is not there: {lab}", file=sys.stderr)
    if options.dry_run:
        found = {"orphans_waiting": waiting(installation), "closed": closed, "aged": aged.as_json()}
        print(json.dumps(found) if options.json else told_as_gone(closed, aged, "would go"))
        installation.close()
        return 0
    swept = sweep_installation(installation, timedelta(0) if options.stopped else WAIT)
    swept += sweep_machine(installation, settings, 0.0 if options.stopped else YOUNG_S)
    installation.close()
    if options.json:
        print(json.dumps({**asdict(swept), "closed": closed, "aged": aged.as_json()}))
        return 0
    print(
        f"removed: {swept.blobs} blobs, {swept.incoming} half written, {swept.uploads} uploads, {swept.scratch} folders"
    )
    print(f"         {swept.live} of live streams, {swept.shelves} pictures; {swept.orphans_waiting} blobs wait")
    print(told_as_gone(closed, aged, "went"))
    return 0


def told_as_gone(closed: Mapping[str, int], aged: Retired, how: str) -> str:
    """Closed labs, and what age alone removes, in words."""
    return (
        f"{closed['labs']} closed labs with {closed['rows']} rows {how}\n"
        f"by age {how}: {aged.studies} studies ({aged.studies_needed} more are needed), {aged.logs} unused logs, "
        f"logs of {aged.job_logs} jobs, {aged.deliveries} deliveries, {aged.keys} keys of requests"
    )
