"""Many may listen to jobs: each is told at once, and nobody else waits for them."""

from __future__ import annotations

import asyncio

import httpx
import pytest

from exogauge.client import Client

MANY = 60  # three times as many as the server has connections to its database


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_sixty_listeners_are_told_and_others_are_served(make_service, database_url, study_folder, tmp_path):
    service = make_service(database_url=database_url, workers=0)
    url = service.start()
    with Client(url) as client:
        job = client.submit(client.upload_study(study_folder), "burn", {"ledger": str(tmp_path / "l"), "seconds": 0.1})

    async def told(http: httpx.AsyncClient) -> int:
        async with http.stream("GET", f"/api/v1/jobs/{job.id}/events") as stream:
            heard = 0
            async for line in stream.aiter_lines():
                heard += line.startswith("id:")
                if line.startswith("id:") and heard == 1:
                    waiting.release()
        return heard

    async def listen() -> None:
        limits = httpx.Limits(max_connections=None)
        async with httpx.AsyncClient(base_url=url, timeout=60.0, limits=limits) as http:
            listeners = [asyncio.create_task(told(http)) for _ in range(MANY)]
            for _ in listeners:
                await waiting.acquire()
            assert (await http.get("/api/v1/studies")).status_code == 200
            await http.post(f"/api/v1/jobs/{job.id}/cancel")
            assert await asyncio.gather(*listeners) == [2] * MANY  # that it waits, and its end

    waiting = asyncio.Semaphore(0)
    asyncio.run(listen())
