"""Every route, asked by those who may not: another lab, nobody, a viewer, a token that was revoked, a session that is
over, an account of no lab. Routes, bodies and tables that this file does not know fail it."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest
import sqlalchemy as sa
from fastapi import FastAPI
from fastapi.routing import APIWebSocketRoute
from fastapi.testclient import TestClient
from starlette.testclient import WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect
from tests.api.people import COOKIE, ORIGIN, PAGE, People

from exogauge.api import live
from exogauge.api.rights import right_of
from exogauge.settings import Settings
from exogauge.storage.account_tables import SessionRow
from exogauge.storage.accounts import Identities
from exogauge.storage.files import PinnedFile
from exogauge.storage.live_streams import Counts
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.records import PublishedFile
from exogauge.storage.store import Store
from exogauge.storage.tables import Artifact, Base, Job, Result, new_id, utc_now

V1 = "/api/v1"
DOCUMENT = Path(__file__).parents[2] / "web" / "openapi.json"  # the API's own: `test_openapi_file` holds that
PATHS: dict[str, Any] = json.loads(DOCUMENT.read_text(encoding="utf-8"))["paths"]
JSON, FORM, TUS = "json", "files", "tus"
OPEN = {  # what needs nobody to say who they are, and proves itself otherwise or holds no data
    ("GET", "/api/v1/session"), ("POST", "/api/v1/session"), ("DELETE", "/api/v1/session"), ("POST", "/api/v1/set-up"),
    ("POST", "/api/v1/invitations/look"), ("POST", "/api/v1/invitations/accept"), ("GET", "/api/v1/scenes/player"),
    ("GET", "/api/v1/published/{key}"), ("GET", "/api/v1/published/{key}/datacite"),
    ("GET", "/api/v1/published/{key}/SHA256SUMS"), ("GET", "/api/v1/published/{key}/files/{path}"),
    ("POST", "/api/v1/oidc/begin"), ("GET", "/api/v1/oidc/callback"),
    ("GET", "/healthz"), ("GET", "/readyz"), ("GET", "/metrics"),
}  # fmt: skip
SESSION = {  # of one's own account, in whichever lab or none
    "changePassword", "signOutElsewhere", "showLab", "createLab", "listTokens", "createToken", "revokeToken",
    "listIdentities", "unlinkIdentity",
}  # fmt: skip
ADMIN = {
    "closeLab", "renameLab", "setRole", "removeMember", "listInvitations", "invite", "withdrawInvitation", "listAudit",
    "getRetention", "listWebhooks", "addWebhook", "deleteWebhook", "enableWebhook", "pingWebhook", "listDeliveries",
}  # fmt: skip
ASKS = {"whatIf"}  # POSTs that change nothing, which a viewer may
READ = {  # by a process of its own, which takes a second: asked for once
    "getRobotScene", "getDeviceScene", "getMotionScene", "getMotionSeries", "getMotionSeriesTiles",
    "exportMotionSeries",
}  # fmt: skip
NOT_OF_A_LAB = {"worker_leases", "orphans", "chores", "labs", "accounts", "sessions", "identities", "sign_in_tries"}
SEEN_BY_ROUTES = {  # table -> where its rows would show, were they shown to another lab; see `filled`
    "robots": "listRobots", "robot_files": "getRobotFile", "devices": "listDevices", "device_files": "getDeviceFile",
    "logs": "listLogs", "studies": "listStudies", "study_files": "getStudyFile", "payloads": "listPayloads",
    "payload_files": "getPayloadFile", "live_streams": "listLiveStreams", "jobs": "listJobs",
    "results": "getJobResults", "artifacts": "listArtifacts", "uploads": "getUploadOffset",
    "robot_mappings": "getRobotMapping", "audit": "listAudit", "memberships": "listMembers",
    "api_tokens": "listTokens", "invitations": "listInvitations", "shares": "listShares",
    "webhooks": "listWebhooks", "deliveries": "listDeliveries",
    "motions": "listMotions", "motion_files": "getMotionFile", "motion_contacts": "getMotionContacts",
    "motion_maps": "listMotionMaps", "plans": "listPlans", "plan_files": "getPlanFile",
    "publications": "listPublications", "publication_files": "getPublication",
    "idempotency_keys": None,  # test_one_key_of_two_labs_is_two_requests
}  # fmt: skip


@dataclass
class World:
    """north: what the lab has, by the name of a route's parameter. words: what nobody else may read."""

    people: People
    north: dict[str, str] = field(default_factory=dict)
    words: set[str] = field(default_factory=set)


@pytest.fixture
def app(people: People) -> FastAPI:
    return people.app


@pytest.fixture
def world(people: People, settings: Settings) -> World:
    """North has one of everything."""
    made = World(people)
    account = made.people.person("ada@example.org", "north", "admin")
    with made.people.installation.session() as session:
        Identities(session).link(account, "https://login.example", "Northern subject")
        identity = Identities(session).of(account)[0].id
    made.people.person("eve@example.org", "south", "admin")
    made.people.person("wes@example.org", "west", "admin")
    with made.people.installation.of_lab("north", "test").transaction() as store:
        made.north = filled(store, settings)
        made.north["account_id"] = account
        made.north["identity_id"] = identity
        made.north["share_id"] = store.shares.add(made.north["study_id"], "west").id
        made.north["invitation_id"] = store.invitations.add("guest@example.org", "viewer", account)[0].id
        made.north["token_id"] = store.tokens.add(
            "of the north", "read", made_by=account, account_id=None, expires_at=None
        )[0].id
    made.words = {*made.north.values(), "Northern", "guest@example.org", "https://north.example/hook", "of the north",
                  "ada@example.org"} - {
        "north.txt", "id", "csv",
    }  # fmt: skip
    return made


def filled(store: Store, settings: Settings) -> dict[str, str]:
    sha = store.blobs.put(b"what the north has")
    files = [PinnedFile("north.txt", sha, 18)]
    robot, _ = store.robots.add("Northern robot", files, {})
    device, _ = store.devices.add("Northern device", files, {}, robot_id=robot.id)
    log, _ = store.logs.add(PinnedFile("Northern.csv", sha, 18), None, {})
    study, _ = store.studies.add("Northern study", files, {"logs": []})
    payload, _ = store.payloads.add("Northern payload", files, {"pose": "logged", "logs": []})
    store.mappings.keep(robot.id, {"of": "Northern"}, "h")
    said = store.blobs.put(b"file: north.txt")
    motion, _ = store.motions.add("Northern motion", [*files, PinnedFile("motion.yaml", said, 15)], {"seconds": 1.0})
    store.contacts.keep(motion.id, {"left": [[0.0, 0.5]], "right": []}, "h")
    names, _ = store.maps.keep("Northern map", {"A": "LASI"}, "h")
    plan, _ = store.plans.add(
        "Northern plan", files, {"kind": "retarget", "robot": "Northern"}, robot_id=robot.id, motion_id=motion.id
    )
    job = Job(kind="evaluate", study_id=study.id, request_hash="h", state="succeeded", finished_at=utc_now())
    of_payload = Job(kind="payload", payload_id=payload.id, request_hash="i", state="succeeded", finished_at=utc_now())
    store.session.add_all([job, of_payload])
    store.session.flush()
    results = store.blobs.put(b'{"version": 1, "name": "Northern"}')
    for each, owner in ((job, {"study_id": study.id}), (of_payload, {"payload_id": payload.id})):
        store.session.add(Result(job_id=each.id, sha256=results, size=34, **owner))
    store.session.add(Artifact(job_id=job.id, name="Northern.html", sha256=sha, size=18, media_type="text/html"))
    stream = store.live_streams.begin(payload.id, summary={"rate_hz": 250.0})
    store.live_streams.end(stream.id, Counts(), "ended", (sha, 18))
    publication = store.publications.add(
        study.id, job.id, [PublishedFile("results/north.txt", sha, 18, "text/plain")],
        {"title": "Northern bend", "creators": [{"name": "Ada"}], "licence": "CC0-1.0"},
    )  # fmt: skip
    webhook, _ = store.webhooks.add("https://north.example/hook", ["job.ended"])
    delivery = store.webhooks.ping(webhook.id)
    upload = new_id()
    PartialFiles(settings.uploads).create(upload)
    store.uploads.add(upload, "Northern.csv", 0, timedelta(hours=1))
    return {
        "robot_id": robot.id, "device_id": device.id, "log_id": log.id, "study_id": study.id, "payload_id": payload.id,
        "job_id": job.id, "stream_id": stream.id, "upload_id": upload, "path": "north.txt", "name": "id",
        "format": "csv", "motion_id": motion.id, "plan_id": plan.id, "map_id": names.id,
        "publication_id": publication.id, "webhook_id": webhook.id, "delivery_id": delivery.id,
    }  # fmt: skip


def bodies(north: dict[str, str]) -> dict[str, dict[str, Any]]:
    """operationId -> how it is asked about what the north has, rightly in all but whose it is."""
    file = ("files", ("a.txt", b"x"))
    draft = {"text": "version: 1", "base_id": north["payload_id"], "keep": ["north.txt"], "upload_ids": []}
    uploads = {"upload_ids": [north["upload_id"]]}
    logs = [{"log_id": north["log_id"], "role": "identification"}]
    return {
        "createDevice": {"files": [file], "data": {"robot": north["robot_id"]}},
        "previewLog": {JSON: {"upload_id": north["upload_id"]}},
        "submitJob": {JSON: {"study_id": north["study_id"], "kind": "evaluate"}},
        "createLog": {"files": [("file", ("a.csv", b"t\n1\n"))], "data": {"robot_id": north["robot_id"]}},
        "createLogFromUpload": {JSON: {"upload_id": north["upload_id"]}},
        "createPayload": {"files": [file]},
        "checkPayload": {JSON: draft},
        "createPayloadFromDraft": {JSON: draft},
        "lookAtPayload": {JSON: draft},
        "createPayloadFromUpload": {JSON: uploads},
        "createStudyFromUpload": {JSON: uploads},
        "planPayload": {JSON: {"what": "postures"}},
        "createMotion": {"files": [file]},
        "restateMotion": {JSON: {"up": "z"}},
        "putMotionContacts": {JSON: {"left": [[0.0, 1.0]], "right": []}},
        "keepMotionMap": {JSON: {"name": "m", "names": {"A": "B"}}},
        "createPlan": {JSON: {"robot_id": north["robot_id"], "motion_id": north["motion_id"], "retarget": {}}},
        "listMotions": {"params": {"search": "Northern"}},
        "getMotionSeriesTiles": {"params": {"channels": ["q"]}},
        "createRobot": {"files": [file]},
        "putRobotMapping": {JSON: {"mapping": {"columns": {}}}},
        "createStudy": {JSON: {"name": "s", "robot_id": north["robot_id"], "logs": logs}},
        "whatIf": {JSON: {"log": "id"}},
        "createUpload": {"headers": {"Tus-Resumable": "1.0.0", "Upload-Length": "3"}},
        "deleteUpload": {"headers": {"Tus-Resumable": "1.0.0"}},
        "getUploadOffset": {"headers": {"Tus-Resumable": "1.0.0"}},
        "appendUpload": {
            "headers": {
                "Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream",
            },
            "content": b"x",
        },
        "setRole": {JSON: {"role": "viewer"}},
        "renameLab": {JSON: {"name": "Taken"}},
        "invite": {JSON: {"email": "new@example.org", "role": "viewer"}},
        "createToken": {JSON: {"name": "t"}},
        "shareStudy": {JSON: {"lab": None}},
        "publish": {JSON: {"title": "t", "creators": [{"name": "Eve"}], "job_id": north["job_id"]}},
        "addWebhook": {JSON: {"url": "https://new.example", "events": ["job.ended"]}},
        "revokePublication": {JSON: {"reason": "r"}},
        "createLab": {JSON: {"name": "Another"}},
        "showLab": {JSON: {"lab_id": "north"}},
        "changePassword": {JSON: {"current": "x", "new": "x"}},
        "closeLab": {"params": {"name": "not its name"}},
        "compareDevice": {"params": {"model": "Northern"}},
        "compareStudies": {"params": {"jobs": [north["job_id"]]}},
        "listDevices": {"params": {"robot_id": north["robot_id"]}},
        "listStudies": {"params": {"search": "Northern"}},
        "listRobots": {"params": {"search": "Northern"}},
        "listPayloads": {"params": {"search": "Northern"}},
        "listJobs": {"params": {"study_id": north["study_id"]}},
        "getSeriesTiles": {"params": {"channels": ["q"]}},
        "getRawSeriesTiles": {"params": {"channels": ["q"]}},
    }  # fmt: skip


NAMED_ELSEWHERE = {  # what names a thing of a lab not in its path: the other lab gets 404 for it
    "createDevice", "previewLog", "submitJob", "createLog", "createLogFromUpload", "checkPayload",
    "createPayloadFromDraft", "lookAtPayload", "createPayloadFromUpload", "createStudyFromUpload", "createStudy",
    "compareStudies", "compareDevice", "showLab", "createPlan",
}  # fmt: skip


def operations() -> list[tuple[str, str, str]]:
    """Method, path, operationId of all that the app answers and the document tells."""
    return [
        (method.upper(), path, each["operationId"])
        for path, methods in PATHS.items()
        for method, each in methods.items()
    ]


def ask(client: TestClient, world: World, method: str, path: str, name: str) -> httpx.Response:
    filled_in = re.sub(r"\{(\w+)\}", lambda found: world.north[found[1]], path)
    assert "{" not in filled_in
    how = bodies(world.north).get(name, {})
    answer: httpx.Response = client.request(method, filled_in, **how)
    return answer


def on_sqlite(world: World) -> bool:
    return world.people.installation.engine.dialect.name == "sqlite"


def of_labs() -> list[tuple[str, str, str]]:
    return [each for each in operations() if each[:2] not in OPEN and each[2] not in SESSION]


def test_every_route_is_sorted_and_closed_unless_it_is_said() -> None:
    for method, path, name in operations():
        right = right_of(method, path)
        expected = (
            "open" if (method, path) in OPEN else "session" if name in SESSION else "admin" if name in ADMIN
            else "read" if name in ASKS or method in ("GET", "HEAD", "OPTIONS") else "write"
        )  # fmt: skip
        assert right == expected, (method, path)
    assert right_of("GET", "/what-comes-next") == right_of("GET", "/api/v1/what-comes-next") == "read"
    assert right_of("POST", "/api/v1/what-comes-next") == right_of("WEBSOCKET", "/anything") == "write"
    assert right_of("GET", "/api/v1/sessionx") == "read"
    assert right_of("POST", "/api/v1/session/") == "session"


def test_every_table_of_labs_is_looked_for_in_the_answers() -> None:
    names = {name for _, _, name in operations()}
    assert set(Base.metadata.tables) == set(SEEN_BY_ROUTES) | NOT_OF_A_LAB
    assert {name for name in SEEN_BY_ROUTES.values() if name is not None} <= names


def test_every_body_is_known() -> None:
    known = bodies(defaultdict(str))
    for path, methods in PATHS.items():
        for method, each in methods.items():
            if "requestBody" in each and (method.upper(), path) not in OPEN:
                assert each["operationId"] in known, each["operationId"]


@pytest.mark.slow
def test_nobody_a_revoked_token_and_a_session_that_is_over_get_nothing_but_401(app: FastAPI, world: World) -> None:
    people = world.people
    over, late = people.session(world.north["account_id"]), people.session(world.north["account_id"])
    key, revoked = people.token("north")
    _, expired = people.token("north", expires_at=utc_now())
    with people.installation.of_lab("north").transaction() as store:
        store.tokens.revoke(key)
    with people.installation.session() as session:
        session.execute(sa.update(SessionRow).values(expires_at=utc_now()))
    bearer = [{"Authorization": f"Bearer {each}"} for each in (revoked, expired, "exg_", "x" * 42)]
    clients = [TestClient(app, base_url=ORIGIN, headers=PAGE)]
    clients += [TestClient(app, base_url=ORIGIN, headers=PAGE, cookies={COOKIE: each}) for each in (over, late, "x")]
    clients += [TestClient(app, base_url=ORIGIN, headers=each) for each in bearer]
    closed = [each for each in operations() if each[:2] not in OPEN]
    for method, path, name in closed if on_sqlite(world) else closed[::10]:  # no database decides which it is
        for client in clients:
            answer = ask(client, world, method, path, name)
            assert answer.status_code == 401, (method, path, answer.text)
            assert not shown(answer, world), (method, path)


@pytest.mark.slow
def test_an_account_of_no_lab_gets_nothing(app: FastAPI, world: World) -> None:
    client = TestClient(
        app,
        base_url=ORIGIN,
        headers=PAGE,
        cookies={COOKIE: world.people.session(world.people.person("no@example.org"))},
    )
    for method, path, name in [*of_labs(), ("GET", f"{V1}/tokens", "listTokens")]:
        answer = ask(client, world, method, path, name)
        assert answer.status_code == 403, (method, path, answer.text)
        assert not shown(answer, world), (method, path)


@pytest.mark.slow
def test_a_viewer_reads_and_changes_nothing(app: FastAPI, world: World) -> None:
    key = world.people.session(world.people.person("viewer@example.org", "north", "viewer"))
    _, token = world.people.token("north", "read")
    browser = TestClient(app, base_url=ORIGIN, headers=PAGE, cookies={COOKIE: key}, raise_server_exceptions=False)
    program = TestClient(
        app, base_url=ORIGIN, headers={"Authorization": f"Bearer {token}"}, raise_server_exceptions=False
    )
    before = rows(world)
    for client in (browser, program):
        for method, path, name in of_labs():
            if name in READ and (client is program or not on_sqlite(world)):  # its right is that of the browser's
                continue
            answer = ask(client, world, method, path, name)
            right = right_of(method, path)
            assert (answer.status_code == 403) == (right in ("write", "admin")), (method, path, answer.text)
            assert answer.status_code < 500, (method, path, answer.text)
            assert name not in READ or answer.status_code != 404, (method, path, answer.text)
    assert rows(world) == before


@pytest.mark.slow
def test_another_lab_gets_404_for_what_is_named_and_finds_nothing_of_it(app: FastAPI, world: World) -> None:
    with world.people.installation.session() as session:
        account = session.scalar(sa.text("SELECT id FROM accounts WHERE email = 'eve@example.org'"))
    cookies = {COOKIE: world.people.session(account)}
    admin = TestClient(app, base_url=ORIGIN, headers=PAGE, cookies=cookies, raise_server_exceptions=False)
    _, token = world.people.token("south")
    robot = TestClient(
        app, base_url=ORIGIN, headers={"Authorization": f"Bearer {token}"}, raise_server_exceptions=False
    )
    before = rows(world)
    asked = [each for each in operations() if each[:2] not in OPEN and each[2] != "signOutElsewhere"]
    for client in (admin, robot):
        for method, path, name in asked:
            answer = ask(client, world, method, path, name)
            if client is robot and (name in SESSION | ADMIN):
                assert answer.status_code == 403, (method, path)
                continue
            named = "{" in path or name in NAMED_ELSEWHERE
            assert (answer.status_code == 404) == named, (method, path, name, answer.status_code, answer.text)
            assert not shown(answer, world), (method, path, answer.text)
    assert rows(world) == before


@pytest.mark.slow
def test_the_lab_itself_finds_all_of_it(app: FastAPI, world: World) -> None:
    """Else the 404 above would say nothing."""
    cookies = {COOKIE: world.people.session(world.north["account_id"])}
    client = TestClient(app, base_url=ORIGIN, headers=PAGE, cookies=cookies, raise_server_exceptions=False)
    by_content = {  # 404 for what is in the files, which are none of a robot here
        "getScene", "getPayloadScene", "getSeriesTiles", "exportSeries", "getRawSeries", "getRawSeriesTiles",
        "exportRawSeries", "getArtifact", "getPayloadResults", "exportPayload", "whatIf", "getStudyResults",
        "exportPlan", "getPlanScene", "getMotionScene",
        "compareDevice",
    }  # fmt: skip
    found = set[str]()
    for method, path, name in of_labs():
        if method in ("GET", "HEAD") and name not in by_content | READ:  # of those a viewer finds all
            answer = ask(client, world, method, path, name)
            assert answer.status_code != 404, (path, answer.text)
            found |= {name} if shown(answer, world) else set()
    assert {name for name in SEEN_BY_ROUTES.values() if name and name.startswith("list")} - {"listTokens"} <= found


@pytest.mark.parametrize("who", ["nobody", "other lab", "viewer", "revoked"])
def test_live_lines_are_closed_to_whoever_may_not(app: FastAPI, world: World, who: str) -> None:
    people = world.people
    key, revoked = people.token("north")
    with people.installation.of_lab("north").transaction() as store:
        store.tokens.revoke(key)
    bearer = {"other lab": people.token("south")[1], "viewer": people.token("north", "read")[1], "revoked": revoked}
    headers = {"Authorization": f"Bearer {bearer[who]}"} if who in bearer else {}
    client = TestClient(app, base_url=ORIGIN, headers=headers)
    expected = {"nobody": 401, "other lab": 404, "viewer": 403, "revoked": 401}[who]
    paths = [route.path for route in live.router.routes if isinstance(route, APIWebSocketRoute)]
    assert len(paths) == 2
    for path in paths:
        asked = path.replace("{payload_id}", world.north["payload_id"]) + f"?stream={world.north['stream_id']}"
        status = 409 if who == "viewer" and path.endswith("/watch") else expected  # it has ended
        assert refused(client, asked) == status, path


def test_a_line_by_a_cookie_comes_from_our_own_page(app: FastAPI, world: World) -> None:
    cookies = {COOKIE: world.people.session(world.north["account_id"])}
    path = f"{V1}/live/payload/{world.north['payload_id']}"
    for headers in ({}, {"Origin": "https://evil.example"}):
        assert refused(TestClient(app, base_url=ORIGIN, cookies=cookies, headers=headers), path) == 403


def refused(client: TestClient, path: str) -> int:
    """The status before the line begins; 0 where it began."""
    try:
        with client.websocket_connect(f"{ORIGIN.replace('https', 'wss')}{path}"):
            return 0
    except WebSocketDenialResponse as denial:
        return denial.status_code
    except WebSocketDisconnect as closed:
        return closed.code


def shown(answer: httpx.Response, world: World) -> list[str]:
    """Which of the north's words are in the answer, beyond those that the request named itself."""
    asked = f"{answer.request.url} {answer.request.read().decode(errors='replace')}"
    said = f"{answer.text} {json.dumps(dict(answer.headers))}"
    return [word for word in world.words if word in said and word not in asked]


def rows(world: World) -> dict[str, list[Any]]:
    """All that is kept of the north but who looked when."""
    with world.people.installation.session() as session:
        return {
            name: session.execute(sa.select(table).where(table.c.lab_id == "north").order_by(*table.primary_key)).all()
            for name, table in Base.metadata.tables.items()
            if "lab_id" in table.columns and name != "api_tokens"
        }
