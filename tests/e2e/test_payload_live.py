"""A stream that a robot's program sends, watched on the payload's page."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow.parquet as pq
import pytest
from playwright.sync_api import expect

from exogauge.client import Client
from exogauge.synthetic import payload as generator
from exogauge.synthetic import write_payload_sample

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

RATE_HZ, AT_ONCE = 250, 5
SENT_S = 5.0


def test_a_push_is_seen_on_the_page_while_it_is_streamed(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    folder = tmp_path / "sample"
    write_payload_sample(folder, 1)
    table = pq.read_table(folder / "logs" / "contact.parquet")
    begin, length, force, _ = generator.PUSHES[0]
    with Client(service.url) as client:
        payload = client.upload_payload(folder)
        page.goto(f"/payloads/{payload.id}")
        expect(page.get_by_text("No stream yet")).to_be_visible()
        with client.live(payload, rate_hz=RATE_HZ) as stream:
            rows = np.column_stack([table[name].to_numpy() for name in stream.columns])[: int(SENT_S * RATE_HZ)]
            live = page.locator(f"[data-live='{stream.stream}']")
            expect(live).to_be_visible()

            def send() -> None:
                began = time.monotonic()
                for k in range(0, len(rows), AT_ONCE):
                    time.sleep(max(0.0, k / RATE_HZ - (time.monotonic() - began)))
                    stream.send(rows[k : k + AT_ONCE])
                    list(stream.received())

            sender = threading.Thread(target=send)
            sender.start()
            expect(live.locator("[data-alarm]")).to_have_count(1)
            expect(live).to_contain_text("something touches")
            expect(live.locator("[data-touched=true]")).to_be_visible()
            sender.join()
            alarm = live.locator("[data-alarm=over]")
            expect(alarm).to_have_count(1)
            start, end, *_, along, _, _ = (float(x.replace("−", "-")) for x in alarm.locator("td").all_inner_texts())
            assert begin < start < begin + 0.1
            assert begin + length - 0.1 < end < begin + length + 0.1
            assert along == pytest.approx(force[1], abs=4.0)
            expect(live).to_contain_text(re.compile(r"1[12]\d\d taken, 0 dropped"))
            expect(live.locator("[data-known=m]")).to_contain_text("40.")
            expect(live.locator("[data-touched=false]")).to_be_visible()
            live.get_by_label("Course of").select_option("Ixx")
            expect(live.get_by_role("img", name="Ixx since watching began, with its 95 % interval")).to_be_visible()
            screenshot("payload-live")
            stream.end()
        expect(live).to_have_count(0)
        row = page.locator(f"[data-stream='{stream.stream}']")
        expect(row).to_contain_text("ended")
        with page.expect_download() as download:
            row.get_by_role("link").click()
        assert pq.read_table(download.value.path()).num_rows == len(rows)


def test_why_a_stream_is_not_to_be_believed_and_what_its_doubt_holds_stand_on_the_page(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    folder = tmp_path / "sample"
    write_payload_sample(folder, 3, ["hose"])
    file = folder / "payload.yaml"
    file.write_text(re.sub(r"\nuncertainty: .*", "", file.read_text()))
    table = pq.read_table(folder / "logs" / "contact.parquet")
    with Client(service.url) as client:
        payload = client.upload_payload(folder)
        page.goto(f"/payloads/{payload.id}")
        with client.live(payload, rate_hz=RATE_HZ) as stream:
            live = page.locator(f"[data-live='{stream.stream}']")
            expect(live).to_be_visible()
            rows = np.column_stack([table[name].to_numpy() for name in stream.columns])[: 2 * RATE_HZ]
            for k in range(0, len(rows), AT_ONCE):
                stream.send(rows[k : k + AT_ONCE])
                list(stream.received())
                time.sleep(AT_ONCE / RATE_HZ)
            expect(live.get_by_role("alert")).to_contain_text("nothing explains: what is told live does not hold")
            expect(live).to_contain_text("1 % of each axis, 1 % that all share, 1 % of crosstalk")
            screenshot("payload-live-in-doubt")
            stream.end()
