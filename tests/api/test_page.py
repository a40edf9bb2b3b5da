"""The web app's document and files, as the service hands them out. The build is a small one of our own."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from urllib.parse import urljoin

import pytest
from fastapi.testclient import TestClient

from exogauge.api import page
from exogauge.api.app import create_app
from exogauge.settings import Settings, packaged_folder

ROOT = Path(__file__).resolve().parents[2]
BROWSER = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
pytestmark = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What Vite makes of web/index.html, in short."""
    folder = tmp_path / "dist"
    (folder / "assets").mkdir(parents=True)
    (folder / "assets" / "index-1a2b.js").write_text("export {}")
    (folder / "assets" / "index-3c4d.css").write_text("a {}")
    (folder / "icon.svg").write_text("<svg/>")
    text = (ROOT / "web" / "index.html").read_text().replace("./src/main.tsx", "./assets/index-1a2b.js")
    (folder / "index.html").write_text(text)
    monkeypatch.setattr(page, "packaged_folder", lambda name: folder)
    return folder


def base_of(document: str) -> str:
    found = re.search(r'<base href="([^"]*)"', document)
    assert found is not None
    return found.group(1)


@pytest.mark.parametrize("path", ["/", "/studies", "/studies/abc", "/studies/abc/plots/", "/robots/x", "/compare"])
@pytest.mark.parametrize("below", ["", "/lab/exo"])
def test_every_address_of_a_page_finds_its_files_below_any_path(
    client: TestClient, build: Path, path: str, below: str
) -> None:
    """The proxy took its path away; a browser puts base and link together with what it sees."""
    answer = client.get(path, headers=BROWSER)
    assert (answer.status_code, answer.headers["cache-control"]) == (200, "no-cache")
    assert answer.headers["content-type"].startswith("text/html")
    base = urljoin(f"https://lab.example{below}{path}", base_of(answer.text))
    assert base == f"https://lab.example{below}/"
    links = re.findall(r'(?:href|src)="(\./[^"]+)"', answer.text)
    assert links
    for link in links:
        assert client.get(urljoin(base, link).removeprefix(f"https://lab.example{below}")).status_code == 200, link


def test_a_service_that_is_told_its_path_serves_the_same(settings: Settings, build: Path) -> None:
    app = create_app(settings.model_copy(update={"root_path": "/lab/exo"}))
    with TestClient(app, root_path="/lab/exo") as client:
        for path in ("/lab/exo/", "/lab/exo/assets/index-1a2b.js", "/lab/exo/api/v1/studies", "/lab/exo/healthz"):
            assert client.get(path).status_code == 200, path
        assert base_of(client.get("/lab/exo/studies/abc").text) == "../"


def test_files_are_kept_for_long_and_have_their_types(client: TestClient, build: Path) -> None:
    for name, media_type in (("index-1a2b.js", "text/javascript"), ("index-3c4d.css", "text/css")):
        answer = client.get(f"/assets/{name}")
        assert answer.headers["content-type"].startswith(media_type)
        assert "immutable" in answer.headers["cache-control"]
    assert client.get("/icon.svg").headers["content-type"] == "image/svg+xml"


def test_nothing_but_the_build_can_be_read(client: TestClient, build: Path) -> None:
    (build / "secret.js").write_text("no")
    for name in ("..%2Fsecret.js", "%2e%2e/secret.js", "missing.js", "..\\secret.js", "index-1a2b"):
        assert client.get(f"/assets/{name}").status_code in (404, 422), name


def test_the_page_may_load_from_its_own_service_only(client: TestClient, build: Path) -> None:
    first, second = (client.get("/studies", headers=BROWSER) for _ in range(2))
    policy = dict(part.strip().split(" ", 1) for part in first.headers["content-security-policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["connect-src"] == policy["frame-src"] == "'self'"
    assert "unsafe" not in first.headers["content-security-policy"]
    (key,) = re.findall(r'csp-nonce" nonce="([\w-]{16,})"', first.text)
    assert f"'nonce-{key}'" in policy["style-src"]
    assert key not in second.text
    assert not re.search(r"(?:href|src)=\"(?:https?:)?//|style=|onclick=", first.text)


def test_the_page_is_told_what_this_installation_takes(client: TestClient, build: Path, settings: Settings) -> None:
    (said,) = re.findall(r'name="limits" content="([^"]+)"', client.get("/", headers=BROWSER).text)
    assert json.loads(html.unescape(said)) == {
        "upload_bytes": settings.max_upload_bytes,
        "bundle_bytes": settings.max_bundle_bytes,
        "bundle_files": settings.max_bundle_files,
    }


def test_an_unknown_address_is_a_page_for_a_browser_and_a_problem_for_others(client: TestClient, build: Path) -> None:
    answer = client.get("/no/such", headers=BROWSER)
    assert (answer.status_code, base_of(answer.text)) == (404, "../")
    for path in ("/no/such", "/api/v1/nothing", "/api"):
        answer = client.get(path, headers={} if path == "/no/such" else BROWSER)
        assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json"), path


def test_without_a_build_the_page_says_how_to_make_one(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(name: str) -> Path:
        raise FileNotFoundError(name)

    monkeypatch.setattr(page, "packaged_folder", nowhere)
    answer = client.get("/studies/abc", headers=BROWSER)
    assert answer.status_code == 503
    assert "make web" in answer.text
    assert 'href="../api/v1/openapi.json"' in answer.text
    assert client.get("/api/v1/studies").status_code == 200


def test_every_route_of_the_app_is_a_page_of_the_service(client: TestClient) -> None:
    text = (ROOT / "web" / "src" / "app" / "router.tsx").read_text()
    routes = {path.split("/")[0] for path in re.findall(r'path: "([^"*]+)', text)}
    assert routes
    assert routes | {""} == set(page.PLACES)


def test_what_was_built_loads_nothing_from_elsewhere(client: TestClient) -> None:
    try:
        folder = packaged_folder("web")
    except FileNotFoundError:
        pytest.skip("the web app is not built: `make web`")
    for path in folder.glob("assets/*.css"):
        assert not re.search(r"url\(\s*[\"']?(?:https?:)?//|@import", path.read_text()), path.name
