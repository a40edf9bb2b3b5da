"""What was published, for everybody: nobody is asked who he is. Of what was revoked the record alone is told."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Self, final

from fastapi import Path, Request
from fastapi.responses import JSONResponse, PlainTextResponse, Response

from exogauge.api.datacite import citation, datacite, link
from exogauge.api.dependencies import InstallationDep, PublicAddress
from exogauge.api.publications import About, PublishedFileOut
from exogauge.api.results import ANY_FILE, FilePath, file_response
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer
from exogauge.storage.publications import published, published_file, versions_of
from exogauge.storage.records import PublicationRecord

router = Router(tags=["published"], asks_anything=True)  # who passes a link on appends to it
Key = Annotated[str, Path(pattern=r"^[0-9a-z]{1,16}$", description="the last part of a permalink")]
SUMS: dict[int | str, dict[str, Any]] = {200: {"content": {"text/plain": {"schema": {"type": "string"}}}}}


@final
class VersionOut(Answer):
    key: str
    version: int
    url: str
    created_at: datetime
    revoked_at: datetime | None

    @classmethod
    def of(cls, found: PublicationRecord, address: str) -> Self:
        return cls.model_validate({**vars(found), "url": link(found, address)})


@final
class PublishedOut(About):
    """lab: who published it. content_hash: over paths and hashes of all files. versions: all of its series, oldest
    first. revoked_at: since when its files are gone; their hashes are told all the same."""

    key: str
    url: str
    lab: str
    citation: str
    created_at: datetime
    version: int
    content_hash: str
    files: list[PublishedFileOut]
    versions: list[VersionOut]
    revoked_at: datetime | None
    revoked_because: str | None


@router.get("/published/{key}", operation_id="getPublished")
def get_published(key: Key, installation: InstallationDep, address: PublicAddress) -> PublishedOut:
    with installation.reading() as session:
        found = published(session, key)
        versions = versions_of(session, found.series_id)
    return PublishedOut.model_validate(
        {
            **vars(found), **found.about, "lab": found.lab_name, "files": found.manifest, "url": link(found, address),
            "citation": citation(found, address), "versions": [VersionOut.of(each, address) for each in versions],
        }
    )  # fmt: skip


@router.get("/published/{key}/datacite", operation_id="getDataCite", response_model=dict[str, Any])
def get_datacite(key: Key, installation: InstallationDep, address: PublicAddress) -> JSONResponse:
    """Metadata for a registrar of DOIs, DataCite 4.5 as JSON."""
    with installation.reading() as session:
        found = published(session, key)
        versions = versions_of(session, found.series_id)
    return JSONResponse(datacite(found, versions, address))


@router.get(
    "/published/{key}/SHA256SUMS",
    operation_id="getPublishedSums",
    response_class=PlainTextResponse,
    responses=SUMS,
)
def get_sums(key: Key, installation: InstallationDep) -> str:
    """What `sha256sum -c` takes beside the files."""
    with installation.reading() as session:
        found = published(session, key)
    return "".join(f"{file['sha256']}  {file['path']}\n" for file in found.manifest)


@router.get("/published/{key}/files/{path:path}", operation_id="getPublishedFile", responses=ANY_FILE)
def get_published_file(key: Key, path: FilePath, installation: InstallationDep, request: Request) -> Response:
    """One file; ranges and If-None-Match are honoured. 410 where the publication was revoked."""
    with installation.reading() as session:
        file = published_file(session, key, path)
    return file_response(installation.blobs, request, file.sha256, file.path, file.media_type)
