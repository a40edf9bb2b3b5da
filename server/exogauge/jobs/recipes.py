"""What kinds of jobs there are. A recipe loads from the store, says what to compute, and saves what came out.

The computation itself (`compute`) runs in the compute child, on a folder of files, and knows neither database nor
blob store; loading and saving run in the worker.
"""

from __future__ import annotations

import mimetypes
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.storage.blobs import BlobStore, copy_out
from exogauge.storage.tables import Artifact, Job, Result, StudyFile

RESULTS = "results.json"
MEDIA_TYPES = {".parquet": "application/vnd.apache.parquet", ".urdf": "application/xml", ".json": "application/json"}


@dataclass(frozen=True)
class Recipe:
    """compute: `package.module:function`, called as function(folder, out, progress, settings)."""

    kind: str
    compute: str
    timeout_s: float


RECIPES: dict[str, Recipe] = {
    recipe.kind: recipe for recipe in (Recipe("evaluate", "exogauge.studies.evaluate:evaluate", timeout_s=6 * 3600.0),)
}


@dataclass(frozen=True)
class Product:
    """A file a job made, already in the blob store."""

    name: str
    sha256: str
    size: int

    @property
    def media_type(self) -> str:
        suffix = Path(self.name).suffix
        return MEDIA_TYPES.get(suffix) or mimetypes.guess_type(self.name)[0] or "application/octet-stream"


def pinned_files(session: Session, job: Job) -> dict[str, str]:
    """The study's files: path -> sha256."""
    rows = session.execute(sa.select(StudyFile.path, StudyFile.sha256).where(StudyFile.study_id == job.study_id))
    return {row.path: row.sha256 for row in rows}


def load(blobs: BlobStore, files: dict[str, str], folder: Path) -> None:
    """Write the pinned files below `folder`."""
    for path, sha256 in files.items():
        copy_out(blobs, sha256, folder / path)


def keep(blobs: BlobStore, out: Path) -> list[Product]:
    """Put every file below `out` into the blob store."""
    return [Product(str(path.relative_to(out)), blobs.put(path), path.stat().st_size) for path in files_below(out)]


def files_below(out: Path) -> Iterator[Path]:
    yield from (path for path in sorted(out.rglob("*")) if path.is_file() and not path.is_symlink())


def save(session: Session, job: Job, products: list[Product]) -> None:
    """Rows for what the job made, in the transaction that ends it: all of it appears, once, or nothing does."""
    for product in products:
        common = {"lab_id": job.lab_id, "job_id": job.id, "sha256": product.sha256, "size": product.size}
        session.add(Artifact(name=product.name, media_type=product.media_type, **common))
        if product.name == RESULTS:
            session.add(Result(study_id=job.study_id, **common))
