"""A running service with a worker, and a browser that looks at it. Without Chromium every test here is skipped.

`service`: new and empty, one for each module. `sample`: the sample study's folder; `sample_service` holds that study,
evaluated, and `study` says where. `page`: a browser tab at the service, which fails its test when a script failed, a
rule of the page's policy was broken or somebody else was asked. `axe(page)`: no violation of accessibility.
`screenshot(name)`: the same in light, dark, narrow and zoomed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import pytest
from tests.e2e.proxy import serve_below

from exogauge import Client

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ARGUMENTS = (
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
SAMPLE = ROOT / ".cache" / "e2e-sample"  # generated and evaluated once, which takes minutes
SAMPLE_NAME = "SYNTHETIC hrp4_like, seed 1"
AXE = ROOT / "web" / "node_modules" / "axe-core" / "axe.min.js"
PATIENCE_MS = int(os.environ.get("EXOGAUGE_TEST_PATIENCE_MS", "60000"))  # others may keep the machine busy
WIDE = {"width": 1280, "height": 800}
MOST_LINES = 6  # of a row's head
BROKEN = """(most) => [...document.querySelectorAll("tbody th")].filter((head) => {
  const words = document.createRange();
  words.selectNodeContents(head);
  return words.getBoundingClientRect().height > most * parseFloat(getComputedStyle(head).lineHeight);
}).map((head) => head.innerText)"""
LOOKS: dict[str, tuple[str, dict[str, int]]] = {
    "light": ("light", WIDE),
    "dark": ("dark", WIDE),
    "narrow": ("light", {"width": 420, "height": 800}),
    "zoom": ("dark", {"width": 640, "height": 400}),  # what a window of 1280 x 800 holds at 200 %
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.e2e)
            item.add_marker(pytest.mark.slow)


@dataclass
class Service:
    """A running service. url: without a slash at its end."""

    url: str
    data: Path


@contextmanager
def running(data: Path, workers: int = 1, root_path: str = "", **more: str) -> Iterator[Service]:
    """The real service as a process of its own, on a free port, until the context ends."""
    command = [sys.executable, "-m", "exogauge.cli", "serve", "--port", "0", "--workers", str(workers)]
    environment = os.environ | {"EXOGAUGE_DATA_DIR": str(data), "EXOGAUGE_ROOT_PATH": root_path, **more}
    with subprocess.Popen(
        [*command, "--with-parent"], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        try:
            assert "serves on" in line, f"the service did not start: {line!r}"
            yield Service(line.split()[-1], data)
        finally:
            process.terminate()
            process.wait(30)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, browser: Browser) -> Iterator[Service]:
    with running(tmp_path_factory.mktemp("service")) as started:
        yield started


@pytest.fixture(scope="session")
def sample(browser: Browser) -> Path:
    """The folder of the ideal sample study, which the demo has evaluated."""
    subprocess.run(
        [sys.executable, "-m", "exogauge.cli", "demo", "--realism", "ideal"],
        env=os.environ | {"EXOGAUGE_DATA_DIR": str(SAMPLE)},
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    return SAMPLE / "sample" / "hrp4_like_1_ideal"


@pytest.fixture(scope="session")
def sample_service(tmp_path_factory: pytest.TempPathFactory, sample: Path) -> Iterator[Service]:
    """Holds the sample study, evaluated. It is shared: tests that add to it must bear each other."""
    data = tmp_path_factory.mktemp("sample") / "data"
    shutil.copytree(SAMPLE, data)
    with running(data) as started:
        yield started


@pytest.fixture(scope="session")
def study(sample_service: Service) -> dict[str, Any]:
    """The evaluated sample: its address, and results.json."""
    with Client(sample_service.url) as client:
        found = next(each for each in client.studies() if each.name == SAMPLE_NAME)
        job = next(each for each in client.jobs(found) if each.state == "succeeded")
        return {"path": f"/studies/{found.id}", "job": job, "results": client.results(job)}


@pytest.fixture(scope="module")
def service_below(service: Service) -> Iterator[str]:
    """The same service below a path of a reverse proxy that it was not told of: that address."""
    with serve_below(service.url, "/lab/exo") as url:
        yield url


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    found = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("there is no Chromium here: `make e2e` installs it")
    if not (ROOT / "web" / "dist" / "index.html").is_file():
        pytest.fail("the web app is not built: `make web`")
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=found, args=list(ARGUMENTS))
        yield launched
        launched.close()


@dataclass
class Seen:
    """What went on in a tab. A test that expects one of these takes it away."""

    errors: list[str] = field(default_factory=list)
    asked: set[str] = field(default_factory=set)


@pytest.fixture
def seen() -> Seen:
    return Seen()


@pytest.fixture
def page(request: pytest.FixtureRequest, browser: Browser, seen: Seen) -> Iterator[Page]:
    """A new tab; `page.goto("/studies")` is at the service, at `sample_service` where the test asks for it."""
    name = "sample_service" if "sample_service" in request.fixturenames else "service"
    home: Service = request.getfixturevalue(name)
    context = browser.new_context(base_url=home.url, viewport=WIDE, locale="en-GB", timezone_id="UTC")  # type: ignore[arg-type]
    context.set_default_timeout(PATIENCE_MS)
    tab = context.new_page()
    tab.on("pageerror", lambda error: seen.errors.append(str(error)))
    tab.on("console", lambda message: seen.errors.append(message.text) if is_fault(message) else None)
    tab.on("request", lambda asked: seen.asked.add(urlsplit(asked.url).hostname or ""))
    yield tab
    context.close()
    assert seen.errors == []
    assert seen.asked <= {"127.0.0.1", ""}


def is_fault(message: Any) -> bool:
    """An error of the page's own; that the service answered 4xx is none."""
    return message.type == "error" and "Failed to load resource" not in message.text


Axe = Callable[..., None]


@pytest.fixture(scope="session")
def axe() -> Axe:
    """axe(page): what a machine can find of what keeps people out, and there is none of it."""

    def check(page: Page, without: tuple[str, ...] = ()) -> None:
        """without: selectors that are left out, such as a frame of another maker's."""
        page.evaluate(AXE.read_text(encoding="utf-8"))
        found = page.evaluate(
            "async (without) => (await axe.run({exclude: without.map((one) => [one])})).violations.map("
            "({id, help, nodes}) => ({id, help, at: nodes.slice(0, 5).map((node) => "
            "node.target + ' ' + node.any.map((one) => one.message))}))",
            list(without),
        )
        assert found == [], json.dumps(found, indent=1)

    return check


@pytest.fixture
def screenshot(page: Page, axe: Axe) -> Callable[..., None]:
    """screenshot(name): the page as it is, in four looks; in each it is accessible, no wider than the window, and no
    row of a table is a tower of words.

    Pictures are kept in the folder that EXOGAUGE_TEST_SCREENSHOTS names (`make screenshots`).
    """
    folder = os.environ.get("EXOGAUGE_TEST_SCREENSHOTS")

    def take(name: str, without: tuple[str, ...] = ()) -> None:
        for look, (scheme, size) in LOOKS.items():
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")  # type: ignore[arg-type]
            page.set_viewport_size(size)  # type: ignore[arg-type]
            page.locator(f"html[data-mantine-color-scheme={scheme}]").wait_for()
            page.wait_for_timeout(300)  # styles that depend on it, and plots that are drawn anew
            if folder:
                page.screenshot(path=Path(folder) / f"{name}-{look}.png", full_page=True)
            axe(page, without)
            broken = page.evaluate(BROKEN, MOST_LINES)
            assert broken == [], f"{name}, {look}: heads of rows broken into many lines: {broken}"
            wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
            assert wide <= 0, f"{name}, {look}: {wide} px wider than the window"
        page.emulate_media(color_scheme="light", reduced_motion="reduce")
        page.set_viewport_size(WIDE)  # type: ignore[arg-type]

    return take
