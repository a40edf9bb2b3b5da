"""What robots, devices, studies and payloads have in common: files come in, are checked and kept, and go out again."""

# Annotations of a route made in a function are looked up there, so they are values here, not texts.
from collections.abc import Callable
from pathlib import Path as FilesystemPath
from typing import Annotated, Any, TypeVar
from uuid import UUID

from fastapi import Path, Request, Response

from exogauge.api.dependencies import ReaderDep, StoreDep, encoded_cursor
from exogauge.api.results import ANY_FILE, FilePath, file_response
from exogauge.api.routing import Router
from exogauge.api.shapes import Kept, ListOf
from exogauge.api.uploads import root_of
from exogauge.storage.bundles import Bundles, Record
from exogauge.storage.files import PinnedFile, content_hash, hashed_folder, keep_folder
from exogauge.storage.records import Page
from exogauge.storage.store import Storage, Store

Answered = TypeVar("Answered", bound=Kept)
Listed = TypeVar("Listed", bound=ListOf)


def keep(
    folder: FilesystemPath,
    main: str,
    check: Callable[[FilesystemPath], dict[str, Any]],
    storage: Storage,
    bundles: Callable[[Store], Bundles[Record]],
    name: str | None = None,
    **facts: str,
) -> tuple[Record, tuple[PinnedFile, ...], bool]:
    """The bundle below `folder`, whose `main` file `check` reads, as it is stored; its files; whether it is new."""
    root = root_of(folder, main)
    summary = check(root)
    name = name or summary["name"]
    with storage.reading() as store:
        if store.quotas.bytes and bundles(store).same(name, content_hash(hashed_folder(root)), **facts) is None:
            store.refuse_bytes(sum(path.stat().st_size for path in root.rglob("*") if path.is_file()))
    files = keep_folder(storage.blobs, root)
    with storage.transaction() as store:
        kept, new = bundles(store).add(name, files, summary, **facts)
        if new:
            store.refuse_bytes(0)
    return kept, files, new


def listed(
    store: Store, bundles: Bundles[Record], page: Page[Record], answer: type[Answered], of_list: type[Listed]
) -> Listed:
    """One page of a list; with the newest job of each, where they have jobs."""
    keys = [record.id for record in page.items] if "latest_job" in answer.model_fields else []
    jobs = store.jobs.latest(bundles.sort.noun, keys) if keys else {}
    items = [answer.told(record, jobs.get(record.id)) for record in page.items]
    return of_list.model_validate({"items": items, "next_cursor": encoded_cursor(page.after)})


def shown(store: Store, bundles: Bundles[Record], key: str, answer: type[Answered]) -> Answered:
    """One of them with its files. Raises NotFound."""
    record = bundles.get(key)
    job = store.jobs.latest(bundles.sort.noun, [key]).get(key) if "latest_job" in answer.model_fields else None
    return answer.of(record, job, bundles.files(key))


def let_go(router: Router, noun: str, nouns: str, of: Callable[[Store], Any], what_else: str) -> None:
    """Add the route by which one is deleted. what_else: goes with it, and what stays."""
    Key = Annotated[UUID, Path(alias=f"{noun}_id", description="id of the thing")]

    @router.delete(
        f"/{nouns}/{{{noun}_id}}",
        operation_id=f"delete{noun.title()}",
        summary=f"Delete {noun.title()}",
        description=what_else,
        status_code=204,
        response_class=Response,
    )
    def delete(key: Key, store: StoreDep) -> Response:
        of(store).delete(str(key))
        return Response(status_code=204)


def give_files(router: Router, noun: str, nouns: str, bundles: Callable[[Store], Bundles[Any]]) -> None:
    """Add the route by which the files of a bundle are had."""
    Key = Annotated[UUID, Path(alias=f"{noun}_id", description="id of the thing")]

    @router.get(
        f"/{nouns}/{{{noun}_id}}/files/{{path:path}}",
        operation_id=f"get{noun.title()}File",
        summary=f"Get {noun.title()} File",
        responses=ANY_FILE,
    )
    def get_file(key: Key, path: FilePath, store: ReaderDep, request: Request) -> Response:
        """One file as it was handed in; ranges and If-None-Match are honoured."""
        file = bundles(store).file(str(key), path)
        return file_response(store.blobs, request, file.sha256, file.path, "application/octet-stream")
