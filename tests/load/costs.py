"""What one study costs, for whoever plans an installation (docs/measured/capacity.md): CPU of server, readers and
worker, bytes and rows of the database, bytes of files.

    exogauge sample FOLDER --realism ideal
    python -m tests.load.costs FOLDER

One server and one worker on PostgreSQL, files in a folder. First small studies, for what each leaves in the database;
then the sample's logs as CSV; then the sample as it is, evaluated with all that is searched for. CPU counts, not time.
"""

from __future__ import annotations

import argparse
import base64
import shutil
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from uuid import uuid4

import httpx
import psycopg
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq
import yaml
from tests.load.__main__ import TICK_S
from tests.whole_service import SERVER, Service, database, descendants, small_study

SMALL, LARGER = 10, 5
PIECE = 8 * 1024 * 1024
GB = 1e9
TUS = {"Tus-Resumable": "1.0.0"}


class Meter:
    """CPU seconds of a service since the last look."""

    def __init__(self, service: Service) -> None:
        self.server = service.process.pid
        self.worker = next(
            pid for pid in descendants(self.server) if b"work" in Path(f"/proc/{pid}/cmdline").read_bytes()
        )
        self.before = self.now()

    def now(self) -> dict[str, float]:
        own, readers = times(self.server)
        return {"server": own, "readers": readers, "worker": times(self.worker)[0]}

    def look(self) -> dict[str, float]:
        now = self.now()
        found = {name: now[name] - self.before[name] for name in now}
        self.before = now
        return found


def times(pid: int) -> tuple[float, float]:
    """Of a process, and of its children that have ended."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    own, gone = (int(words[11]) + int(words[12])), (int(words[13]) + int(words[14]))
    return own * TICK_S, gone * TICK_S


def rows(url: str) -> tuple[Counter[str], int]:
    """Of each table that has any, and the bytes of the database."""
    with psycopg.connect(url) as server:
        tables = server.execute(
            "SELECT format('%I.%I', schemaname, tablename) FROM pg_tables WHERE schemaname IN ('public', 'dbos')"
        ).fetchall()
        found = {name: server.execute(f"SELECT count(*) FROM {name}").fetchone() for (name,) in tables}
        size = server.execute("SELECT pg_database_size(current_database())").fetchone()
    assert size is not None
    return Counter({name: row[0] for name, row in found.items() if row is not None}), size[0]


def stored(folder: Path) -> int:
    return sum(path.stat().st_size for path in (folder / "data" / "blobs").rglob("*") if path.is_file())


def sent(client: httpx.Client, files: dict[str, bytes], folder: Path) -> str:
    """The study's id; in pieces, as the page sends it."""
    packed = folder / f"{uuid4().hex}.zip"
    with zipfile.ZipFile(packed, "w") as archive:
        for path, content in files.items():
            archive.writestr(path, content)
    whole, name = packed.read_bytes(), base64.b64encode(b"study.zip").decode()
    packed.unlink()
    begun = {**TUS, "Upload-Length": str(len(whole)), "Upload-Metadata": f"filename {name}"}
    place = client.post("/uploads", headers=begun).raise_for_status()
    for offset in range(0, len(whole), PIECE):
        headers = {**TUS, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"}
        there = urlsplit(place.headers["Location"]).path.partition("/api/v1")[2]
        client.patch(there, headers=headers, content=whole[offset : offset + PIECE]).raise_for_status()
    answer = client.post("/studies/from-upload", json={"upload_ids": [place.json()["id"]]}).raise_for_status()
    return str(answer.json()["id"])


def ended(client: httpx.Client, study: str, kind: str) -> dict[str, Any]:
    key = client.post("/jobs", json={"study_id": study, "kind": kind}).raise_for_status().json()["id"]
    while True:
        job: dict[str, Any] = client.get(f"/jobs/{key}").raise_for_status().json()
        if job["state"] in ("succeeded", "failed", "cancelled"):
            if job["state"] != "succeeded":
                raise SystemExit(f"the job failed: {job['reason']}")
            return job
        time.sleep(1.0)


def read(folder: Path) -> dict[str, bytes]:
    """Of a study's folder what belongs to it."""
    files = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".yaml", ".urdf")}
    return files | {f"logs/{path.name}": path.read_bytes() for path in sorted((folder / "logs").iterdir())}


def as_csv(files: dict[str, bytes], folder: Path, times: int = 1) -> tuple[dict[str, bytes], float]:
    """The same robot, excited, from text, each log so many times in a row; and for how many hours."""
    logs, hours = {}, 0.0
    for path in [path for path in files if path.startswith(("logs/id_", "logs/val_"))]:
        table = repeated(pq.read_table(folder / path), times)
        logs[path.replace(".parquet", ".csv")] = text_of(table)
        t = table.column("t").to_pylist()
        hours += (t[-1] - t[0]) / 3600
    roles = [{"file": path, "role": "validation" if "val_" in path else "identification"} for path in logs]
    said = {"version": 1, "name": "as text", "robot": "robot.yaml", "logs": roles, "steps": ["identify"]}
    kept = {name: files[name] for name in ("robot.yaml", "robot.urdf")}
    return {"study.yaml": yaml.safe_dump(said).encode(), **kept, **logs}, hours


def repeated(table: Any, times: int) -> Any:
    t = table.column("t").to_numpy()
    place, period = table.schema.get_field_index("t"), t[-1] - t[0] + t[1] - t[0]
    return pa.concat_tables([table.set_column(place, "t", pa.array(t + k * period)) for k in range(times)])


def text_of(table: Any) -> bytes:
    with tempfile.NamedTemporaryFile() as file:
        pc.write_csv(table, file.name)
        return Path(file.name).read_bytes()


@contextmanager
def closed(service: Service) -> Iterator[None]:
    try:
        yield
    finally:
        service.kill()


def told(what: str, **found: float) -> None:
    print(f"{what}: " + ", ".join(f"{name} {value:.4g}" for name, value in found.items()), flush=True)


def of_a_large_one(
    client: httpx.Client, meter: Meter, url: str, files: dict[str, bytes], hours: float, name: str, folder: Path
) -> None:
    size = sum(len(content) for content in files.values()) / GB
    bytes_before, (rows_before, database_before) = stored(folder), rows(url)
    meter.look()
    study = sent(client, files, folder)
    found = meter.look()
    told(f"{name}, upload", GB=size, hours=hours, **{f"{who}_s_per_GB": s / size for who, s in found.items()})
    job = ended(client, study, "evaluate")
    found = meter.look()
    told(f"{name}, evaluate", cpu_s=job["cpu_s"], cpu_s_per_hour=job["cpu_s"] / hours, server_s=found["server"],
         worker_s=found["worker"], bytes_kept_per_byte=(stored(folder) - bytes_before) / (size * GB))  # fmt: skip
    rows_after, database_after = rows(url)
    told(f"{name}, rows", database_bytes=database_after - database_before, **(rows_after - rows_before))


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("sample", type=Path, help="folder of `exogauge sample`")
    options.add_argument("--server", default=SERVER, help="where the database is made")
    options.add_argument("--only-text", action="store_true", help="not the whole sample, which takes minutes")
    given = options.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="exogauge-costs-"))
    with database("postgresql", given.server) as url:
        service = Service(folder, url, workers="1")
        service.start()
        with closed(service), httpx.Client(base_url=f"{service.url}/api/v1", timeout=600.0) as client:
            ended(client, sent(client, small_study("first"), folder), "evaluate")  # all is imported and compiled
            (rows_before, size_before), meter = rows(url), Meter(service)
            computed = [
                ended(client, sent(client, small_study(f"{k}"), folder), "evaluate")["cpu_s"] for k in range(SMALL)
            ]
            found = meter.look()
            more, size = rows(url)
            told("a small study and its job", **{who: s / SMALL for who, s in found.items()},
                 computed_s=sum(computed) / SMALL, database_bytes=(size - size_before) / SMALL,
                 rows=(more - rows_before).total() / SMALL)  # fmt: skip
            told("rows", **{name: count / SMALL for name, count in (more - rows_before).most_common()})
            files = read(given.sample)
            text, hours = as_csv(files, given.sample)
            of_a_large_one(client, meter, url, text, hours, "text", folder)
            more_text, _ = as_csv(files, given.sample, LARGER)
            gigabytes = sum(len(content) for content in more_text.values()) / GB
            meter.look()
            sent(client, more_text, folder)
            told("larger text, upload", GB=gigabytes, **meter.look())
            if not given.only_text:
                hours = sum(pq.read_metadata(each).num_rows for each in (given.sample / "logs").iterdir()) / 200 / 3600
                of_a_large_one(client, meter, url, files, hours, "sample", folder)
    shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
