"""What is published as metadata of DataCite (schema 4.5): what a registrar of DOIs asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.storage.records import PublicationRecord

SCHEMA = "http://datacite.org/schema/kernel-4"
SPDX = "https://spdx.org/licenses"


def datacite(found: PublicationRecord, versions: Sequence[PublicationRecord], address: str) -> dict[str, Any]:
    """As JSON. versions: of its series, oldest first. address: of the page of all, before `/published/KEY`."""
    about = found.about
    doi, issued = about.get("doi"), found.created_at.date().isoformat()
    dates = [{"date": issued, "dateType": "Issued"}]
    if found.revoked_at is not None:
        dates.append({"date": found.revoked_at.date().isoformat(), "dateType": "Withdrawn"})
    says = {
        "schemaVersion": SCHEMA,
        **({"doi": doi} if doi else {}),
        "url": link(found, address),
        "alternateIdentifiers": [
            {"alternateIdentifier": found.content_hash, "alternateIdentifierType": "SHA-256 over paths and hashes"}
        ],
        "creators": [creator(each) for each in about["creators"]],
        "titles": [{"title": about["title"]}],
        "publisher": {"name": found.lab_name},
        "publicationYear": str(found.created_at.year),
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Identification of a robot and what it wears"},
        "dates": dates,
        "version": str(found.version),
        "rightsList": [
            {
                "rights": about["licence"], "rightsUri": f"{SPDX}/{about['licence']}.html",
                "rightsIdentifier": about["licence"], "rightsIdentifierScheme": "SPDX", "schemeUri": f"{SPDX}/",
            }
        ],
        "sizes": [f"{sum(file['size'] for file in found.manifest)} bytes", f"{len(found.manifest)} files"],
        "formats": sorted({file["media_type"].partition(";")[0] for file in found.manifest}),
        "relatedIdentifiers": [*related(found, versions, address)],
    }  # fmt: skip
    if about.get("description"):
        says["descriptions"] = [{"description": about["description"], "descriptionType": "Abstract"}]
    if about.get("keywords"):
        says["subjects"] = [{"subject": word} for word in about["keywords"]]
    return says


def creator(said: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {"name": said["name"], "nameType": "Personal"}
    if said.get("orcid"):
        found["nameIdentifiers"] = [
            {
                "nameIdentifier": f"https://orcid.org/{said['orcid']}", "nameIdentifierScheme": "ORCID",
                "schemeUri": "https://orcid.org",
            }
        ]  # fmt: skip
    if said.get("affiliation"):
        found["affiliation"] = [{"name": said["affiliation"]}]
    return found


def related(found: PublicationRecord, versions: Sequence[PublicationRecord], address: str) -> list[dict[str, str]]:
    """The versions just before and after it."""
    beside = {found.version - 1: "IsNewVersionOf", found.version + 1: "IsPreviousVersionOf"}
    return [
        {
            "relatedIdentifier": each.about.get("doi") or link(each, address),
            "relatedIdentifierType": "DOI" if each.about.get("doi") else "URL",
            "relationType": beside[each.version],
        }
        for each in versions
        if each.version in beside
    ]


def link(found: PublicationRecord, address: str) -> str:
    return permalink(found.key, address)


def permalink(key: str, address: str) -> str:
    """It stays, whatever becomes of the study."""
    return f"{address}/published/{key}"


def citation(found: PublicationRecord, address: str) -> str:
    """Creators (year). Title (version). Publisher. Kind. Address: as DataCite recommends it."""
    about = found.about
    who = "; ".join(each["name"] for each in about["creators"])
    where = f"https://doi.org/{about['doi']}" if about.get("doi") else link(found, address)
    said = f"{who} ({found.created_at.year}). {about['title']} (Version {found.version}). {found.lab_name}. Dataset."
    return f"{said} {where}"
