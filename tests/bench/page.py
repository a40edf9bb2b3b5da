"""`python -m tests.bench.page DATA`: how long the web app takes in Chromium, by the wall clock, beside the load.

DATA: a data folder that holds the evaluated sample (`make demo` leaves `exogauge-data`); it is copied, not changed.
Without a graphics card Chromium draws in software, and the figures of the 3D view are those of the processor.
"""

from __future__ import annotations

import argparse
import io
import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from tests.e2e.arm import arm_study
from tests.e2e.conftest import ARGUMENTS, CHROMIUM, running

from exogauge import Client
from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import open_installation
from exogauge.studies.series.file import SeriesFile
from exogauge.studies.series.tiles import make_blocks, tiles

if TYPE_CHECKING:
    from playwright.sync_api import Page

SAMPLES, RATE_HZ = 1_000_000, 200.0
CHANNELS = ("q.elbow", "dq.elbow", "ddq.elbow", "tau.elbow", "i.elbow", "temp.elbow")
LOG = "long"
TIMES = 20
WATCHED_S = 8.0
PATIENCE_MS = 240_000
COUNT = """(() => {
  let drew = false;
  for (const name of ["drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced"]) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...given) { drew = true; return draw.apply(this, given); };
  }
  window.pictures = 0;
  const tick = () => { if (drew) window.pictures += 1; drew = false; requestAnimationFrame(tick); };
  requestAnimationFrame(tick);
})()"""
DRAWN = """(count) => {
  const busy = document.querySelectorAll("[aria-busy=true]").length;
  return document.querySelectorAll(".u-over").length === count && busy === 0;
}"""

ZOOMED = f"""([count, before]) => ({DRAWN})(count)
  && document.querySelector("[role=slider][aria-valuemin]").getAttribute("aria-valuemin") !== before"""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.page", description=__doc__)
    parser.add_argument("data", type=Path)
    data = parser.parse_args().data
    from playwright.sync_api import sync_playwright

    chromium = next(path for name in CHROMIUM if (path := shutil.which(name)))
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder) / "data"
        shutil.copytree(data, own)
        study = add_long_log(own)
        with running(own) as service, sync_playwright() as playwright:
            of_tiles(service.url, study)
            of_blocks(own)
            browser = playwright.chromium.launch(executable_path=chromium, args=list(ARGUMENTS))
            page = browser.new_page(base_url=service.url, viewport={"width": 1280, "height": 1000})
            page.set_default_timeout(PATIENCE_MS)
            of_plots(page, study)
            of_the_robot(page, service.url)
            browser.close()
    return 0


def say(what: str, value: str) -> None:
    print(f"{what:58s}{value:>16s}   load {os.getloadavg()[0]:.1f}", flush=True)


def add_long_log(data: Path) -> str:
    """The id of a study of one joint whose log has 10^6 samples of six channels."""
    t, rng = np.arange(SAMPLES) / RATE_HZ, np.random.default_rng(0)
    columns = {"t": t} | {name: np.sin((k + 1) * t) + 0.1 * rng.normal(size=SAMPLES) for k, name in enumerate(CHANNELS)}
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink)
    about = b"version: 1\nname: Long\nrobot: robot.yaml\nlogs:\n  - {file: logs/long.parquet, role: identification}\n"
    files = {path: content for path, content in arm_study("Long").items() if not path.startswith("logs/")}
    files |= {"study.yaml": about, "logs/long.parquet": sink.getvalue()}
    logs = [{"name": LOG, "file": ["logs/long.parquet"], "role": "identification", "motion": None, "device": None,
             "samples": SAMPLES, "rate_hz": RATE_HZ, "duration_s": SAMPLES / RATE_HZ}]  # fmt: skip
    settings = Settings(data_dir=data)
    installation = open_installation(settings)
    with installation.of_lab(settings.lab).transaction() as store:
        pinned = [PinnedFile(path, store.blobs.put(content), len(content)) for path, content in files.items()]
        study, _ = store.studies.add("Long", pinned, {"robot": {"name": "Arm", "joints": ["elbow"]}, "logs": logs})
    installation.close()
    return study.id


def timed(deed: Callable[[], Any]) -> float:
    """[ms]"""
    began = time.perf_counter()
    deed()
    return 1e3 * (time.perf_counter() - began)


def of_blocks(data: Path) -> None:
    """CPU time of what the first and later tiles take, whatever else the machine does."""
    (kept,) = (data / "raw-series").iterdir()
    series = SeriesFile(kept)
    began = time.process_time()
    blocks = make_blocks(series)
    whole = partial(tiles, series, blocks, CHANNELS, *series.span(), 1200)
    whole()
    say("  the same, CPU of blocks and tiles", f"{1e3 * (time.process_time() - began):.0f} ms")
    began = time.process_time()
    for _ in range(TIMES):
        whole()
    say("  again, CPU of six channels", f"{1e3 * (time.process_time() - began) / TIMES:.1f} ms")
    began = time.process_time()
    for start in np.linspace(0.0, SAMPLES / RATE_HZ - 10.0, TIMES).tolist():
        tiles(series, blocks, CHANNELS, start, start + 10.0, 1200)
    say("  10 s somewhere, CPU of six channels", f"{1e3 * (time.process_time() - began) / TIMES:.1f} ms")


def of_tiles(url: str, study: str) -> None:
    rng = np.random.default_rng(1)
    log = f"{url}/api/v1/studies/{study}/series/{LOG}"
    with httpx.Client(timeout=240.0) as client:

        def ask(names: tuple[str, ...], **asked: float) -> None:
            client.get(f"{log}/tiles", params={"channels": names, "width": 1200, **asked}).raise_for_status()

        say(
            "log of 10^6 x 6 read in the sandbox, the first time",
            f"{timed(lambda: client.get(log).raise_for_status()):.0f} ms",
        )
        say("first tiles of the whole, six channels", f"{timed(lambda: ask(CHANNELS)):.0f} ms")
        whole = [timed(lambda: ask(CHANNELS[:1])) for _ in range(TIMES)]
        say("tiles of the whole, one channel, median", f"{statistics.median(whole):.1f} ms")
        starts = rng.uniform(0.0, SAMPLES / RATE_HZ - 10.0, TIMES).tolist()
        parts = [timed(partial(ask, CHANNELS[:1], start=start, end=start + 10.0)) for start in starts]
        say("tiles of 10 s somewhere, one channel, median", f"{statistics.median(parts):.1f} ms")


def of_plots(page: Page, study: str) -> None:
    show = "&".join(f"raw_show={name}" for name in CHANNELS)
    for what in ("with an empty cache", "again"):

        def drawn() -> None:
            page.goto(f"/studies/{study}/run?raw_log={LOG}&{show}")
            page.wait_for_function(DRAWN, arg=len(CHANNELS))

        say(f"page of six plots of 10^6 samples drawn, {what}", f"{timed(drawn):.0f} ms")
    over = page.locator(".u-over").first
    over.scroll_into_view_if_needed()
    for what, low, high in (("half of it", 0.25, 0.75), ("a tenth of that", 0.45, 0.55)):
        box = over.bounding_box()
        assert box is not None
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + low * box["width"], middle)
        page.mouse.down()
        page.mouse.move(box["x"] + high * box["width"], middle, steps=4)
        before = page.locator("[role=slider][aria-valuemin]").first.get_attribute("aria-valuemin")

        def zoomed(before: str | None = before) -> None:
            page.mouse.up()
            page.wait_for_function(ZOOMED, arg=[len(CHANNELS), before])

        say(f"drag to zoom into {what}, six plots anew", f"{timed(zoomed):.0f} ms")


def of_the_robot(page: Page, url: str) -> None:
    with Client(url) as client:
        job = next(each for each in client.jobs() if each.state == "succeeded")
    page.add_init_script(COUNT)
    began = time.perf_counter()
    page.goto(f"/studies/{job.study_id}/plots?log=bend_normal_1&show=support.torso_pitch&robot=yes")
    page.get_by_role("button", name="Play").wait_for()
    say("sample robot, 34 joints and its bands, in 3D, ready", f"{1e3 * (time.perf_counter() - began):.0f} ms")
    player = next(each for each in page.frames if "scenes/player" in each.url)
    page.get_by_role("button", name="Play").click()
    first = player.evaluate("window.pictures")
    started = time.perf_counter()
    page.wait_for_timeout(1e3 * WATCHED_S)
    pictures = player.evaluate("window.pictures") - first
    say("pictures per second while it plays", f"{pictures / (time.perf_counter() - started):.1f}")
    gl = "() => { const gl = document.createElement('canvas').getContext('webgl2');"
    gl += " return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL); }"
    print(f"drawn by {page.evaluate(gl)}")


if __name__ == "__main__":
    sys.exit(main())
