"""What nothing needs goes, what anything needs or may need stays: beside uploads, jobs and kills, on both databases."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from exogauge.settings import Settings
from exogauge.storage import chores, held_files, orphans
from exogauge.storage.checking import check
from exogauge.storage.files import PinnedFile
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.store import Installation, Storage
from exogauge.storage.sweeping import sweep_installation, sweep_machine
from exogauge.storage.tables import Base, Orphan, StudyFile

NOW = timedelta(0)


@pytest.fixture
def installation(storage: Storage) -> Installation:
    return Installation(storage.engine, storage.blobs)


def study_of(storage: Storage, content: bytes, name: str = "study") -> str:
    blob = storage.blobs.put(content)
    with storage.transaction() as store:
        return store.studies.add(name, [PinnedFile("study.yaml", blob, len(content))], {})[0].id


def test_every_column_that_holds_a_hash_either_names_a_blob_or_is_known_not_to() -> None:
    """A blob whose only name stands in a column that nobody knows would be swept away."""
    hashes = {
        f"{table.name}.{column.name}"
        for table in Base.metadata.sorted_tables
        for column in table.columns
        if isinstance(column.type, sa.String) and column.type.length == 64 and "hash" not in column.name
    }
    others = {name for name in hashes if name.partition(".")[2] in NO_HASHES}
    assert hashes - others - {"orphans.sha256"} == {str(column) for column in orphans.naming_columns()}


NO_HASHES = (
    "id",
    "lab_id",
    "at_lab",
    "to_lab",
    "kind",
    "action",
    "event",
    "subject_kind",
    "name",
    "code_version",
    "requested_code_version",
)


def test_a_blob_that_no_row_names_goes_after_its_wait_and_no_other(
    storage: Storage, installation: Installation
) -> None:
    study_of(storage, b"kept")
    stray = storage.blobs.put(b"stray")
    first = sweep_installation(installation)
    assert (first.orphans_found, first.blobs) == (1, 0)
    assert storage.blobs.exists(stray)
    assert sweep_installation(installation).blobs == 0
    with storage.transaction() as store:
        long_ago = orphans.database_now(store.session) - timedelta(hours=2)
        store.session.execute(sa.update(Orphan).values(found_at=long_ago))
    last = sweep_installation(installation)
    assert (last.blobs, last.orphans_waiting) == (1, 0)
    assert not storage.blobs.exists(stray)
    found = check(installation, None)
    assert found.sound
    assert found.blobs == found.references == 1


def test_rows_of_every_lab_hold_their_blobs(storage: Storage, installation: Installation) -> None:
    for lab in ("north", "south"):
        study_of(installation.of_lab(lab), lab.encode())
    sweep_installation(installation, NOW)
    assert len(list(storage.blobs.iterate())) == 2


def test_who_names_a_waiting_blob_spares_it(storage: Storage, installation: Installation) -> None:
    storage.blobs.put(b"back again")
    assert sweep_installation(installation).orphans_found == 1
    study_of(storage, b"back again")
    assert sweep_installation(installation, NOW).blobs == 0
    assert check(installation, None).sound


def test_no_row_names_a_blob_that_is_about_to_go_or_is_gone(storage: Storage, installation: Installation) -> None:
    """Put before the sweep, named after it: refused, and right when it is sent again."""
    blob = storage.blobs.put(b"late")
    sweep_installation(installation)
    with installation.session() as session:
        orphans.condemn(session, NOW)
    with pytest.raises(orphans.BlobGone, match="send it again"), storage.transaction() as store:
        store.studies.add("late", [PinnedFile("study.yaml", blob, 4)], {})
    assert sweep_installation(installation).blobs == 1
    with pytest.raises(orphans.BlobGone, match="send it again"), storage.transaction() as store:
        store.studies.add("late", [PinnedFile("study.yaml", blob, 4)], {})
    study_of(storage, b"late")
    assert check(installation, None).sound


def test_a_live_stream_does_not_end_with_a_log_that_is_gone(storage: Storage) -> None:
    with storage.transaction() as store:
        blob = store.blobs.put(b"version: 1")
        payload, _ = store.payloads.add("tool", [PinnedFile("payload.yaml", blob, 10)], {})
        stream = store.live_streams.begin(payload.id)
    from exogauge.storage.live_streams import Counts

    with pytest.raises(orphans.BlobGone), storage.transaction() as store:
        store.live_streams.end(stream.id, Counts(), raw=("0" * 64, 1))


@pytest.mark.slow
def test_sweeping_all_the_time_loses_nothing_that_was_acknowledged(
    storage: Storage, installation: Installation
) -> None:
    """Writers put, delete and put the same few contents again, while a sweeper without patience runs."""
    stop, failures = threading.Event(), list[BaseException]()

    def write(seed: int) -> None:
        from exogauge.errors import Conflict, NotFound, Unavailable

        for k in range(25):
            content = str((k * seed) % 7).encode()
            try:
                key = study_of(storage, content)
                with storage.transaction() as store:
                    file = store.studies.files(key)[0]
                    assert storage.blobs.exists(file.sha256)
                if k % 3 == 0:
                    with storage.transaction() as store:
                        store.session.execute(sa.delete(StudyFile).where(StudyFile.study_id == key))
                        store.session.execute(sa.delete(Base.metadata.tables["studies"]))
            except (Unavailable, NotFound, Conflict, IndexError):  # not acknowledged
                continue
            except BaseException as error:
                failures.append(error)
                return

    writers = [threading.Thread(target=write, args=(seed,)) for seed in (3, 5)]
    for each in writers:
        each.start()

    def sweep() -> None:
        while not stop.is_set():
            for prefix in {name[:2] for name in storage.blobs.iterate()}:
                with installation.session() as session:
                    orphans.note(session, prefix, storage.blobs.iterate(prefix))
            with installation.session() as session:
                orphans.condemn(session, timedelta(milliseconds=50))
            from exogauge.storage.sweeping import _remove_condemned

            _remove_condemned(installation, lambda: None)

    sweeper = threading.Thread(target=sweep)
    sweeper.start()
    for each in writers:
        each.join()
    stop.set()
    sweeper.join()
    assert not failures
    found = check(installation, None)
    assert found.sound, found.missing


def test_check_finds_what_is_damaged_missing_and_left(
    storage: Storage, installation: Installation, settings: Settings
) -> None:
    for content in (b"whole", b"damaged", b"missing"):
        study_of(storage, content, content.decode())
    assert check(installation, settings).sound
    damaged, missing, stray = (storage.blobs.put(each) for each in (b"damaged", b"missing", b"stray"))
    path = storage.blobs.path_for(damaged)
    assert path is not None
    path.chmod(0o644)
    path.write_bytes(b"DAMAGED")
    storage.blobs.delete(missing)
    left = settings.scratch / "tmpdead"
    left.mkdir(parents=True)
    os.utime(left, (time.time() - 3600,) * 2)
    found = check(installation, settings)
    assert not found.sound
    assert (found.corrupt, found.orphans) == ([damaged], [stray])
    assert [each.split(":")[0] for each in found.missing] == [missing]
    assert found.left_over == [str(left)]
    assert found.as_json()["missing"]["count"] == 1
    with storage.transaction() as store:
        store.session.execute(sa.update(StudyFile).where(StudyFile.path == "study.yaml").values(size=1))
    assert any("says 1 bytes" in each for each in check(installation, settings).sizes)


HOLDER = """
import sys, time
from pathlib import Path
from exogauge.storage.blobs import FolderBlobs
from exogauge.storage.held_files import OwnFolder
folder = OwnFolder(Path(sys.argv[1])).path
class Slow:
    def read(self, size):
        print(folder, flush=True)
        time.sleep(60)
FolderBlobs(Path(sys.argv[2])).put(Slow())
"""


def test_what_a_process_holds_stays_however_old_and_goes_once_it_was_killed(
    storage: Storage, installation: Installation, settings: Settings
) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(settings.scratch), str(settings.blobs)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout is not None
    own = Path(holder.stdout.readline().strip())
    (half,) = (settings.blobs / "incoming").iterdir()
    for path in (own, half):
        os.utime(path, (time.time() - 10 * 86_400,) * 2)
    assert sweep_machine(installation, settings).scratch == sweep_installation(installation).incoming == 0
    assert own.is_dir()
    assert half.exists()
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    holder.stdout.close()
    assert sweep_machine(installation, settings).scratch == sweep_installation(installation).incoming == 1
    assert not own.exists()
    assert not half.exists()


def test_an_upload_stays_until_its_row_goes(storage: Storage, installation: Installation, settings: Settings) -> None:
    files, key, stray = PartialFiles(settings.uploads), "0" * 8, "1" * 8
    for each in (key, stray):
        files.create(each)
        os.utime(files.path(each), (time.time() - 3600,) * 2)
    with storage.transaction() as store:
        store.uploads.add(key, "log.csv", 3, timedelta(hours=1))
    assert sweep_machine(installation, settings).uploads == 1
    assert files.path(key).exists()
    assert not files.path(stray).exists()
    with storage.transaction() as store:
        store.uploads.wait_longer(key, timedelta(seconds=-1))
    assert sweep_machine(installation, settings).uploads == 1
    assert not files.path(key).exists()


def test_folders_of_workers_and_streams_go_when_nobody_has_them(
    storage: Storage, installation: Installation, settings: Settings
) -> None:
    from exogauge.jobs.leases import Lease

    Lease(installation.engine, "alive", 10.0).take()
    for name in ("alive", "dead"):
        (settings.work / name).mkdir(parents=True)
    with storage.transaction() as store:
        blob = store.blobs.put(b"version: 1")
        payload, _ = store.payloads.add("tool", [PinnedFile("payload.yaml", blob, 10)], {})
        stream = store.live_streams.begin(payload.id)
    for name in (stream.id, "ended"):
        (settings.live / name).mkdir(parents=True)
        os.utime(settings.live / name, (time.time() - 3600,) * 2)
    swept = sweep_machine(installation, settings)
    assert (swept.scratch, swept.live) == (1, 1)
    assert [each.name for each in settings.work.iterdir()] == ["alive"]
    assert [each.name for each in settings.live.iterdir()] == [stream.id]


def test_a_chore_is_done_by_one_when_it_is_due_and_by_another_when_that_one_died(installation: Installation) -> None:
    def take(holder: str, **more: Any) -> bool:
        with installation.session() as session:
            return chores.take(session, "sweep", holder, **more)

    assert take("a")
    assert not take("b")
    assert not take("b", now_due=True)
    with installation.session() as session:
        assert chores.hold_on(session, "sweep", "a")
        assert not chores.hold_on(session, "sweep", "b")
        assert chores.done(session, "sweep", "a", timedelta(hours=1), {"blobs": 3})
        assert chores.outcomes(session) == {"sweep": {"blobs": 3}}
    assert not take("b")
    assert take("b", now_due=True)
    with installation.session() as session:
        past = orphans.database_now(session) - timedelta(seconds=1)
        session.execute(sa.update(chores.Chore).values(held_until=past, due_at=past))
    assert take("c")
    with installation.session() as session:
        assert not chores.done(session, "sweep", "b", timedelta(hours=1), {})


def test_a_folder_of_this_process_is_made_again_when_somebody_removed_it(tmp_path: Path) -> None:
    own = held_files.OwnFolder(tmp_path / "scratch")
    first = own.path
    assert own.path == first
    held_files.remove(first)
    assert own.path.is_dir()
    own.close()
    assert list((tmp_path / "scratch").iterdir()) == []
