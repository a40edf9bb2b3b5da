"""A live stream is its lab's: for whoever takes it up or watches it, and for the server that buries it."""

from __future__ import annotations

import asyncio

import pytest

from exogauge.api.live_hub import Hub, Running
from exogauge.errors import NotFound
from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Installation, Storage

pytestmark = pytest.mark.usefixtures("without_bytes")

FILES = (PinnedFile("payload.yaml", "1" * 64, 10),)


@pytest.fixture
def north(storage: Storage) -> Storage:
    return Installation(storage.engine, storage.blobs).of_lab("north")


@pytest.fixture
def hub(storage: Storage, settings: Settings) -> Hub:
    return Hub(Installation(storage.engine, storage.blobs), settings)


@pytest.fixture
def stream(north: Storage) -> tuple[str, str]:
    """Of which payload, and its id."""
    with north.transaction() as store:
        payload = store.payloads.add("Door", FILES, {})[0].id
        return payload, store.live_streams.begin(payload, summary={"rate_hz": 250.0}).id


def test_a_stream_that_runs_is_no_other_lab_s_and_no_other_payload_s(
    hub: Hub, north: Storage, settings: Settings, stream: tuple[str, str]
) -> None:
    payload, key = stream
    south = Installation(north.engine, north.blobs).of_lab("south")
    with north.transaction() as store:
        window = store.payloads.add("Window", FILES, {})[0].id

    async def look() -> None:
        running = hub._running[key] = Running(north, key, settings.data_dir / key, 250.0)
        running.taken = False
        for storage, of in ((south, payload), (north, window)):
            with pytest.raises(NotFound):
                await hub.attach(storage, of, key, 250.0)
            with pytest.raises(NotFound):
                await hub.watch(storage, of, key)
        assert await hub.watch(north, payload, key) is running
        assert await hub.attach(north, payload, key, 250.0) is running

    asyncio.run(look())


def test_what_an_earlier_server_left_is_kept_in_the_lab_of_the_stream(
    hub: Hub, north: Storage, settings: Settings, stream: tuple[str, str]
) -> None:
    _, key = stream
    assert settings.lab != "north"
    folder = settings.data_dir / "live" / key
    folder.mkdir(parents=True)
    (folder / "log.parquet").write_bytes(b"what came")
    hub._end(None, key, None, "lost")
    with north.reading() as store:
        kept = store.live_streams.get(key)
        assert (kept.state, kept.size) == ("lost", 9)
    assert not folder.exists()
