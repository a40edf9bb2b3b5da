"""`make load SOAK=3600`: does anything grow while a service works for so long?

    python -m tests.load.soak --seconds 3600

One server and one worker on PostgreSQL; clients hand in small studies, have them evaluated, read lists, details and
results, listen to events, and delete what they made, so that what is stored does not grow. Every ten seconds memory,
open files and threads of each process are noted. Printed: each in the second and in the last fifth of the time
(medians; the first fifth warms up), and the growth between the two per hour. Ends with 1 where an aim was missed. Less
than half an hour decides nothing: one megabyte more would be many an hour.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import threading
import time
from collections import defaultdict
from contextlib import suppress
from pathlib import Path
from statistics import median
from uuid import uuid4

import httpx
from tests.load.costs import closed
from tests.whole_service import SERVER, Service, database, descendants, small_study

LOOK_S = 10.0
CLIENTS = 4
# judgement, per hour: memory that allocators keep moves by some MB; a file or thread that is left, by one a request
SHORTEST_S = 1800.0  # judgement
MEMORY_AIM, COUNT_AIM = 20.0, 10.0


class Noted:
    """name -> its values over time, in order."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self.values = defaultdict[str, list[float]](list)

    def look(self) -> None:
        server = self._service.process.pid
        of = {"server": [server], "worker": []}
        for pid in descendants(server):
            with suppress(OSError):
                told = (Path(f"/proc/{pid}") / "cmdline").read_bytes()
                if b"\0work\0" in told or b"exogauge.jobs.child" in told:
                    of["worker"].append(pid)
        for who, pids in of.items():
            found = [self._of(pid) for pid in pids]
            for place, what in enumerate(("MB", "files", "threads")):
                self.values[f"{who}, {what}"].append(sum(each[place] for each in found))
        data = self._service.folder / "data"
        walked = (each for name in ("work", "scratch") for each in os.walk(data / name))  # folders go meanwhile
        left = sum(len(folders) + len(files) for _, folders, files in walked)
        self.values["files that lie about, files"].append(left)

    def _of(self, pid: int) -> tuple[float, float, float]:
        with suppress(OSError, IndexError):
            status = Path(f"/proc/{pid}/status").read_text()
            memory = int(status.partition("VmRSS:")[2].split()[0]) / 1e3
            threads = int(status.partition("Threads:")[2].split()[0])
            return memory, float(len(list(Path(f"/proc/{pid}/fd").iterdir()))), float(threads)
        return 0.0, 0.0, 0.0


def work(url: str, until: float, done: list[int], errors: list[str]) -> None:
    with httpx.Client(base_url=f"{url}/api/v1", timeout=120.0) as client:
        while time.monotonic() < until:
            try:
                files = [("files", (path, content)) for path, content in small_study(uuid4().hex).items()]
                study = client.post("/studies", files=files).raise_for_status().json()["id"]
                asked = {"study_id": study, "kind": "evaluate"}
                job = client.post("/jobs", json=asked).raise_for_status().json()["id"]
                with client.stream("GET", f"/jobs/{job}/events") as told:
                    for _ in told.iter_lines():
                        pass
                for path in (
                    "/studies",
                    "/jobs",
                    f"/jobs/{job}",
                    f"/jobs/{job}/artifacts",
                    f"/studies/{study}/results",
                ):
                    client.get(path).raise_for_status()
                client.delete(f"/studies/{study}").raise_for_status()
                done.append(1)
            except httpx.HTTPError as error:
                errors.append(str(error))


def grown(noted: Noted, seconds: float) -> bool:
    """Print; whether an aim was missed."""
    bad = False
    for name, values in sorted(noted.values.items()):
        fifth = max(len(values) // 5, 1)
        early, late = median(values[fifth : 2 * fifth]), median(values[-fifth:])
        hourly = (late - early) / (0.7 * seconds) * 3600  # between the middles of the two
        aim = MEMORY_AIM if name.endswith("MB") else COUNT_AIM
        missed = hourly > aim and seconds >= SHORTEST_S
        bad |= missed
        said = " MISSED" if missed else "" if seconds >= SHORTEST_S else ", undecided: too short"
        print(f"{name}: {early:.1f} -> {late:.1f}, {hourly:+.1f} an hour (aim {aim:g}){said}")
    return bad


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seconds", type=float, default=3600.0)
    options.add_argument("--server", default=SERVER, help="where the database is made")
    given = options.parse_args()
    folder, done, errors = Path(tempfile.mkdtemp(prefix="exogauge-soak-")), list[int](), list[str]()
    with database("postgresql", given.server) as url:
        service = Service(folder, url, workers="1")
        address = service.start()
        with closed(service):
            noted, until = Noted(service), time.monotonic() + given.seconds
            clients = [threading.Thread(target=work, args=(address, until, done, errors)) for _ in range(CLIENTS)]
            for each in clients:
                each.start()
            while time.monotonic() < until:
                time.sleep(LOOK_S)
                noted.look()
            for each in clients:
                each.join()
    shutil.rmtree(folder, ignore_errors=True)
    print(f"{len(done)} studies in {given.seconds:.0f} s, {len(errors)} errors{': ' + errors[0] if errors else ''}")
    return 1 if grown(noted, given.seconds) or errors else 0


if __name__ == "__main__":
    sys.exit(main())
