"""Commands between labs: publish what was found, take it back, compare one device over labs."""

from __future__ import annotations

import argparse
import json
from typing import Any

from exogauge.cli.at_service import at_server
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

    labs = commands.add_parser(
        "compare-labs", help="one device in all studies that you may see, and whether labs agree"
    )
    labs.add_argument("model", nargs="?", help="as device.yaml says it, or its name; without it: the devices there are")
    labs.add_argument("--size", help="where device.yaml states one")
    labs.add_argument("--json", action="store_true", help="as JSON")
    at_server(labs)
    labs.set_defaults(command=compare_labs)


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


def compare_labs(options: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.terminal import text_table

    with Client(options.server) as client:
        if options.model is None:
            items = client.compared_devices()
            rows = [[each["model"], each["size"] or "", each["labs"], each["studies"]] for each in items]
            shown: object = items
            text = text_table(("device", "size", "labs", "studies"), rows) if rows else "no device was worn yet"
        else:
            found = client.compare_device(options.model, options.size)
            shown, text = found, device_in_words(found)
    print(json.dumps(shown, indent=1) if options.json else text)
    return 0


def device_in_words(found: dict[str, Any]) -> str:
    """Who found what, and whether they agree."""
    from exogauge.terminal import text_table

    studies, quantities = found["studies"], found["quantities"]
    worn = [
        [each["lab"], each["study"], each["robot"], each["specimen"].get("serial") or "not stated", each["seen"]]
        for each in studies
    ]
    bands = [
        [each["lab"], each["study"], band["band"], band["approach"], *(shown(band, what) for what in BAND)]
        for each in studies
        for band in each["bands"]
    ]
    torques = [
        [each["lab"], each["robot"], torque["motion"], torque["joint"], torque["approach"], measured(torque["peak"])]
        for each in studies
        for torque in each["torques"]
    ]
    agreed = [
        [
            f"{each['quantity']}, {each['of']}", each["found"]["labs"],
            each["found"]["verdict"] + (", provisional" if each["found"]["provisional"] else ""),
            measured({**each["found"], "value": each["found"]["mean"], "unit": each["unit"]}),
            *(digits(each["found"][key]) for key in ("tau", "q", "probability", "i_squared", "birge_ratio")),
        ]
        for each in quantities
    ]  # fmt: skip
    return "\n\n".join(
        [
            text_table(("lab", "study", "robot", "specimen", "seen as"), worn),
            text_table(("lab", "study", "band", "approach", "stiffness", "natural length"), bands),
            text_table(("lab", "robot", "motion", "joint", "approach", "peak"), torques),
            text_table(
                ("quantity", "labs", "they", "mean", "between labs", "Q", "by chance", "I²", "Birge ratio"), agreed
            ),
        ]
    )


BAND = (("stiffness_n_per_m", "identifiable"), ("natural_length_m", "length_identifiable"))


def shown(band: dict[str, Any], what: tuple[str, str]) -> str:
    quantity, decided = what
    return measured(band[quantity]) if band[decided] else "not decided"


def measured(number: dict[str, Any]) -> str:
    if number["value"] is None:
        return "-"
    doubt = "" if number["std"] is None else f" ± {number['std']:.2g}"
    return f"{number['value']:.4g}{doubt} {number['unit']}"


def digits(number: float | None) -> str:
    return "-" if number is None else f"{number:.2g}"
