"""Commands between labs: publish what was found, and take it back."""

from __future__ import annotations

import argparse
import os

from exogauge.cli.accounts import HERE
from exogauge.cli.endings import Commands

LICENCES = ("CC-BY-4.0", "CC0-1.0", "CC-BY-SA-4.0", "CC-BY-NC-4.0", "CC-BY-NC-SA-4.0", "ODbL-1.0")


def add_commands(commands: Commands) -> None:
    """At a service."""
    publish = commands.add_parser("publish", help="a study's results as a snapshot that anybody may read and cite")
    publish.add_argument("study", help="id of the study")
    publish.add_argument("--title", required=True)
    said = "`Family, Given; ORCID; affiliation`, the last two where there are any; as often as needed"
    publish.add_argument("--creator", action="append", required=True, metavar="WHO", help=said)
    publish.add_argument("--abstract", default="", help="what it is")
    publish.add_argument("--keyword", action="append", default=[], metavar="WORD")
    publish.add_argument("--licence", choices=LICENCES, default=LICENCES[0])
    publish.add_argument("--doi", help="that a registrar has reserved for it")
    publish.add_argument("--inputs", action="store_true", help="robot, logs and device too")
    publish.add_argument("--follows", metavar="ID", help="an earlier publication, of which it is the next version")
    at_server(publish)
    publish.set_defaults(command=publish_study)

    revoke = commands.add_parser("revoke", help="take a publication back: its files go, its record stays")
    revoke.add_argument("publication", help="its id, or the last part of its address")
    revoke.add_argument("--reason", required=True, help="told at its address")
    at_server(revoke)
    revoke.set_defaults(command=revoke_publication)


def at_server(command: argparse.ArgumentParser) -> None:
    here = os.environ.get("EXOGAUGE_URL", HERE)
    command.add_argument("--server", metavar="URL", default=here, help=f"address of the service (default {here})")


def publish_study(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    creators = [creator(text) for text in options.creator]
    about = {"description": options.abstract, "keywords": options.keyword, "licence": options.licence}
    with Client(options.server) as client:
        found = client.publish(
            options.study, options.title, creators, inputs=options.inputs, follows=options.follows,
            **about, **({"doi": options.doi} if options.doi else {}),
        )  # fmt: skip
    print(f"{found.url}\nversion {found.version}, id {found.id}, {len(found.files)} files, {found.content_hash}")
    return 0


def revoke_publication(options: argparse.Namespace) -> int:
    from exogauge.client import Client

    with Client(options.server) as client:
        known = {each.key: each.id for each in client.publications()}
        found = client.revoke(known.get(options.publication, options.publication), options.reason)
    print(f"{found.url} is revoked since {found.revoked_at}")
    return 0


def creator(text: str) -> dict[str, str | None]:
    """Of `Family, Given; ORCID; affiliation`."""
    name, *rest = (part.strip() for part in text.split(";"))
    orcid = next((part for part in rest if part.replace("-", "")[:15].isdigit()), None)
    return {"name": name, "orcid": orcid, "affiliation": next((part for part in rest if part and part != orcid), None)}
