"""Publishing: what a job found becomes a snapshot that anybody may read and cite, and that can be revoked."""

from __future__ import annotations

import mimetypes
from datetime import datetime
from typing import Annotated, Any, Literal, Self, final
from uuid import UUID

from fastapi import Query, Response
from pydantic import BaseModel, Field, StringConstraints

from exogauge.api.datacite import link
from exogauge.api.dependencies import (
    NO_NUL,
    Cursor,
    Id,
    Limit,
    PublicAddress,
    ReaderDep,
    StoreDep,
    encoded_cursor,
)
from exogauge.api.results import content_of
from exogauge.api.routing import Router
from exogauge.api.session import Name
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import NotFound
from exogauge.storage.records import PublicationRecord, PublishedFile
from exogauge.storage.store import Store

router = Router(tags=["publications"])
MOST_CREATORS = 100  # judgement: of a publication; each is a line of its page
DOI = r"^10\.\d{4,9}/[\x21-\x7e]+$"
ORCID = r"^\d{4}-\d{4}-\d{4}-\d{3}[\dX]$"
Licence = Literal["CC-BY-4.0", "CC0-1.0", "CC-BY-SA-4.0", "CC-BY-NC-4.0", "CC-BY-NC-SA-4.0", "ODbL-1.0"]
Text = Annotated[str, StringConstraints(strip_whitespace=True, max_length=10_000, pattern=NO_NUL)]
Reason = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=1000, pattern=NO_NUL)]


@final
class Creator(Answer):
    """name: `Family, Given`, or an organisation's."""

    name: Name
    orcid: Annotated[str | None, Field(pattern=ORCID)] = None
    affiliation: Name | None = None


class About(Answer):
    """What a DOI's record says of it; licence: by its SPDX name; doi: one that a registrar has reserved."""

    title: Name
    creators: Annotated[list[Creator], Field(min_length=1, max_length=MOST_CREATORS)]
    description: Text = ""
    keywords: Annotated[tuple[Name, ...], Field(max_length=50)] = ()
    licence: Licence = "CC-BY-4.0"
    doi: Annotated[str | None, Field(max_length=200, pattern=DOI)] = None


@final
class NewPublication(About):
    """job_id: of an evaluation; null: the study's latest. inputs: whether robot, logs and device are published too.
    follows: id of a publication, of which this is the next version."""

    job_id: UUID | None = None
    inputs: bool = False
    follows: UUID | None = None


@final
class PublishedFileOut(Answer):
    path: str
    sha256: str
    size: int
    media_type: str


@final
class PublicationOut(About):
    """url: its permalink. content_hash: over paths and hashes of all files. revoked_at: since when its files are gone;
    its record and their hashes stay."""

    id: str
    key: str
    url: str
    created_at: datetime
    version: int
    series_id: str
    study_id: str
    job_id: str
    content_hash: str
    files: list[PublishedFileOut]
    revoked_at: datetime | None
    revoked_because: str | None

    @classmethod
    def of(cls, found: PublicationRecord, address: str) -> Self:
        return cls.model_validate({**vars(found), **found.about, "files": found.manifest, "url": link(found, address)})


@final
class PublicationList(ListOf):
    items: list[PublicationOut]


@final
class Revocation(BaseModel):
    """reason: told to whoever follows the link."""

    reason: Reason


@router.post(
    "/studies/{study_id}/publications",
    operation_id="publish",
    status_code=201,
    responses={200: {"model": PublicationOut, "description": "The same is published already"}},
)
def publish(
    study_id: Id, wanted: NewPublication, store: StoreDep, address: PublicAddress, response: Response
) -> PublicationOut:
    """For everybody, at once, without a login. It stays as it is when the study is deleted. The same asked for again is
    what stands, unless it was revoked."""
    key = str(study_id)
    store.studies.get(key)
    job_id = store.results.of_study(key).job_id if wanted.job_id is None else str(wanted.job_id)
    content_of(store, job_id)
    if store.jobs.get(job_id).study_id != key:
        raise NotFound(f"the study has no job {job_id}")
    files = files_of(store, key, job_id, wanted.inputs)
    about = wanted.model_dump(include=set(About.model_fields))
    follows = None if wanted.follows is None else str(wanted.follows)
    if (stands := store.publications.standing(key, job_id, files, about, follows)) is not None:
        response.status_code = 200
        return PublicationOut.of(stands, address)
    store.refuse_bytes(sum(file.size for file in files))
    made = PublicationOut.of(store.publications.add(key, job_id, files, about, follows), address)
    store.webhooks.tell("publication.published", told(made))
    return made


@router.get("/publications", operation_id="listPublications")
def list_publications(
    store: ReaderDep,
    cursor: Cursor,
    address: PublicAddress,
    limit: Limit = 50,
    study_id: Annotated[UUID | None, Query(description="of this study, which may be gone")] = None,
) -> PublicationList:
    """The lab's, newest first, also those of studies that are gone, and those that were revoked."""
    page = store.publications.page(cursor, limit, None if study_id is None else str(study_id))
    items = [PublicationOut.of(each, address) for each in page.items]
    return PublicationList(items=items, next_cursor=encoded_cursor(page.after))


@router.get("/publications/{publication_id}", operation_id="getPublication")
def get_publication(publication_id: Id, store: ReaderDep, address: PublicAddress) -> PublicationOut:
    return PublicationOut.of(store.publications.get(str(publication_id)), address)


@router.post("/publications/{publication_id}/revoke", operation_id="revokePublication")
def revoke_publication(
    publication_id: Id, wanted: Revocation, store: StoreDep, address: PublicAddress
) -> PublicationOut:
    """Its files are gone from the public at once; its address keeps telling what it was, and why."""
    key = str(publication_id)
    before = store.publications.get(key)
    found = PublicationOut.of(store.publications.revoke(key, wanted.reason), address)
    if before.revoked_at is None:
        store.webhooks.tell("publication.revoked", told(found) | {"reason": wanted.reason})
    return found


def told(found: PublicationOut) -> dict[str, Any]:
    return {"publication_id": found.id, "url": found.url, "version": found.version, "study_id": found.study_id}


def files_of(store: Store, study_id: str, job_id: str, inputs: bool) -> list[PublishedFile]:
    made = [
        PublishedFile(f"results/{each.name}", each.sha256, each.size, each.media_type)
        for each in store.results.artifacts(job_id)
    ]
    handed_in: list[Any] = list(store.studies.files(study_id)) if inputs else []
    return made + [
        PublishedFile(f"study/{each.path}", each.sha256, each.size, media_type_of(each.path)) for each in handed_in
    ]


def media_type_of(path: str) -> str:
    return mimetypes.guess_type(path, strict=True)[0] or "application/octet-stream"
