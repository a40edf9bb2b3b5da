"""Accounts: the first one, signing in and out, tokens, invitations, roles, and what of it an attacker could use."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator
from datetime import timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient
from tests.api.people import COOKIE, ORIGIN, PASSWORD, People

from exogauge.api import access
from exogauge.api.app import create_app
from exogauge.api.passwords import checked
from exogauge.errors import BadInput
from exogauge.serving import say_set_up_code
from exogauge.settings import Settings
from exogauge.storage import callers
from exogauge.storage.account_tables import ApiToken, Invitation, SessionRow
from exogauge.storage.accounts import Accounts
from exogauge.storage.callers import Caller
from exogauge.storage.secrets import is_token, new_token
from exogauge.storage.tables import AuditEntry, IdempotencyKey, utc_now

V1 = "/api/v1"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def ada(people: People) -> Iterator[TestClient]:
    """An admin of north, in a browser."""
    with people.browser(people.session(people.person("ada@example.org", "north", "admin"))) as opened:
        yield opened


def audit_of(browser: TestClient) -> list[str]:
    return [
        f"{each['who']}: {each['action']} {each['said']}" for each in browser.get(f"{V1}/lab/audit").json()["items"]
    ]


@on_sqlite
def test_the_first_account_takes_the_server_s_code_and_the_data_that_are_there(
    settings: Settings, people: People, capsys: pytest.CaptureFixture[str]
) -> None:
    with people.installation.of_lab(settings.lab).transaction() as store:
        store.studies.add("from before", [], {})
    say_set_up_code(settings, "https://x")
    said = capsys.readouterr().err
    say_set_up_code(settings, "https://x")
    assert capsys.readouterr().err == said  # the same to who starts it again
    assert settings.set_up_code.stat().st_mode & 0o777 == 0o600
    first = {"email": "Ada@Example.org", "name": "Ada", "password": PASSWORD, "lab": "North", "code": "guessed"}
    with people.browser() as browser:
        assert browser.get(f"{V1}/session").json()["set_up"] is True
        assert browser.get(f"{V1}/studies").status_code == 401
        assert browser.post(f"{V1}/set-up", json=first).status_code == 403
        first["code"] = said.split()[-1]
        weak = browser.post(f"{V1}/set-up", json=first | {"password": "ada@example.org!"})
        assert (weak.status_code, weak.json()["errors"][0]["code"]) == (422, "password_weak")
        assert browser.post(f"{V1}/set-up", json=first).status_code == 204
        shown = browser.get(f"{V1}/session").json()
        assert shown["set_up"] is False
        assert (shown["account"]["email"], shown["lab"]["name"], shown["lab"]["role"]) == (
            "ada@example.org",
            "North",
            "admin",
        )
        assert [each["name"] for each in browser.get(f"{V1}/studies").json()["items"]] == ["from before"]
        assert browser.post(f"{V1}/set-up", json=first).status_code == 403
    assert not settings.set_up_code.exists()


@on_sqlite
def test_no_code_fits_where_the_server_said_none(people: People) -> None:
    first = {"email": "a@example.org", "name": "A", "password": PASSWORD, "lab": "L"}
    with people.browser() as browser:
        assert {browser.post(f"{V1}/set-up", json=first | {"code": code}).status_code for code in ("None", "-")} == {
            403
        }


@on_sqlite
@pytest.mark.slow
def test_a_wrong_password_and_an_unknown_address_are_answered_alike_and_not_for_ever(people: People) -> None:
    people.person("ada@example.org", "north", password=PASSWORD)
    with people.browser() as browser:
        answers = []
        for email in ("ada@example.org", "nobody@example.org"):
            tries = [browser.post(f"{V1}/session", json={"email": email, "password": "wrong"}) for _ in range(6)]
            assert [each.status_code for each in tries] == [403] * 5 + [429]
            assert int(tries[-1].headers["retry-after"]) > 0
            answers.append([each.json() for each in tries])
        assert answers[0] == answers[1]
        # the right one is not looked at either, as long as that lasts
        right = {"email": "ada@example.org", "password": PASSWORD}
        assert browser.post(f"{V1}/session", json=right).status_code == 429
        with people.installation.session() as session:
            Accounts(session).forget_tries([], timedelta(0))
        assert browser.post(f"{V1}/session", json=right | {"email": "ADA@example.org"}).status_code == 204
        assert browser.get(f"{V1}/session").json()["account"]["email"] == "ada@example.org"


@on_sqlite
@pytest.mark.slow
def test_an_unknown_address_takes_as_much_work_as_a_wrong_password(people: People) -> None:
    people.person("ada@example.org", "north", password=PASSWORD)
    with people.browser() as browser:

        def cost(email: str) -> float:
            began = time.process_time()
            assert browser.post(f"{V1}/session", json={"email": email, "password": "wrong"}).status_code == 403
            return time.process_time() - began

        cost("first@example.org")  # makes the hash that unknown ones are compared with
        known, unknown = (min(cost(email) for _ in range(4)) for email in ("ada@example.org", "b@example.org"))
    assert 0.6 < unknown / known < 1.7


@on_sqlite
def test_the_cookie_is_for_this_host_alone_and_new_with_each_sign_in(people: People) -> None:
    account = people.person("ada@example.org", "north", password=PASSWORD)
    with people.browser(before := people.session(account)) as browser:
        answer = browser.post(f"{V1}/session", json={"email": "ada@example.org", "password": PASSWORD})
        name, _, rest = answer.headers["set-cookie"].partition("=")
        key, *flags = [part.strip().lower() for part in rest.split(";")]
        assert name == COOKIE
        assert {"secure", "httponly", "samesite=lax", "path=/"} <= set(flags)
        assert not any(flag.startswith("domain") for flag in flags)
        assert key != before.lower()
    with people.browser(before) as old:
        assert old.get(f"{V1}/studies").status_code == 401
    tossed = TestClient(people.app, base_url=ORIGIN, cookies={"exogauge-443": people.session(account)})
    assert tossed.get(f"{V1}/studies").status_code == 401  # one that a page without encryption could have set


@on_sqlite
def test_a_password_does_not_go_over_an_open_line(people: People) -> None:
    people.person("ada@example.org", "north", password=PASSWORD)
    browser = TestClient(people.app, base_url="http://exo.example")
    answer = browser.post(f"{V1}/session", json={"email": "ada@example.org", "password": PASSWORD})
    assert (answer.status_code, "set-cookie" in answer.headers) == (403, False)


@on_sqlite
def test_what_a_cookie_may_change_comes_from_our_own_page(people: People) -> None:
    key = people.session(people.person("ada@example.org", "north", "admin"))
    foreign: list[dict[str, str]] = [
        {}, {"Origin": "https://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site", "Origin": ORIGIN},
    ]  # fmt: skip
    for headers in foreign:
        browser = TestClient(people.app, base_url=ORIGIN, cookies={COOKIE: key}, headers=headers)
        for ask in (browser.post, browser.put, browser.patch, browser.delete):
            assert ask(f"{V1}/lab").status_code == 403, headers
        assert browser.post(f"{V1}/lab/invitations", json={"email": "a@b", "role": "admin"}).status_code == 403
    for headers in ({"Origin": ORIGIN}, {"Sec-Fetch-Site": "same-origin"}):
        browser = TestClient(people.app, base_url=ORIGIN, cookies={COOKIE: key}, headers=headers)
        assert browser.post(f"{V1}/lab/invitations", json={"email": "a@b.c", "role": "admin"}).status_code == 201


@on_sqlite
@pytest.mark.slow
def test_a_session_ends_by_time_by_silence_by_hand_and_with_its_account(people: People) -> None:
    account = people.person("ada@example.org", "north", "admin", password=PASSWORD)

    def still(key: str) -> bool:
        with people.browser(key) as browser:
            return browser.get(f"{V1}/studies").status_code == 200

    def age(**values: Any) -> None:
        with people.installation.session() as session:
            session.execute(sa.update(SessionRow).values(**values))

    for values in ({"expires_at": utc_now()}, {"seen_at": utc_now() - timedelta(days=8)}):
        key = people.session(account)
        assert still(key)
        age(**values)
        assert not still(key)
    one, other = people.session(account), people.session(account)
    with people.browser(one) as browser:
        assert browser.delete(f"{V1}/sessions").status_code == 204
        assert (still(one), still(other)) == (True, False)
        other = people.session(account)
        wrong = {"current": "wrong", "new": "six brown hens walk home"}
        assert browser.put(f"{V1}/account/password", json=wrong).status_code == 403
        assert browser.put(f"{V1}/account/password", json=wrong | {"current": PASSWORD}).status_code == 204
        assert (still(one), still(other)) == (True, False)
        assert browser.delete(f"{V1}/session").status_code == 204
    assert not still(one)
    key, (_, token) = people.session(account), people.token("north", account_id=account)
    with people.installation.session() as session:
        Accounts(session).disable(account, True)
    assert not still(key)
    with people.program(token) as program:
        assert program.get(f"{V1}/studies").status_code == 401


def test_a_token_is_shown_once_and_nothing_that_is_kept_opens_anything(ada: TestClient, people: People) -> None:
    again = {"Idempotency-Key": "twice"}
    made = ada.post(f"{V1}/tokens", json={"name": "bench", "scope": "write"}, headers=again).json()
    invited = ada.post(f"{V1}/lab/invitations", json={"email": "b@example.org", "role": "viewer"}, headers=again).json()
    secret = made["secret"]
    assert is_token(secret)
    assert made["token"]["hint"] == secret[:8]
    assert secret not in ada.get(f"{V1}/tokens").text
    with people.installation.session() as session:
        assert session.scalars(sa.select(IdempotencyKey)).all() == []
        for table in sa.inspect(session.connection()).get_table_names():
            kept = str(session.execute(sa.text(f'SELECT * FROM "{table}"')).all())
            assert not any(each in kept for each in (secret, invited["code"], ada.cookies[COOKIE])), table


def test_a_mistyped_token_is_told_without_being_looked_up() -> None:
    token = new_token()
    assert is_token(token)
    wrong = [token[:k] + ("a" if token[k] != "a" else "b") + token[k + 1 :] for k in range(4, len(token))]
    assert not any(is_token(each) for each in [*wrong, token[:-1], token + "a", token.upper(), ""])


def test_a_token_may_what_its_scope_its_owner_and_its_time_allow(people: People, study_files: Any) -> None:
    account = people.person("bob@example.org", "north")
    with people.browser(people.session(people.person("ada@example.org", "north", "admin"))) as ada:

        def may(token: str) -> tuple[int, int]:
            """Read; write, which fails behind the door."""
            with people.program(token) as program:
                return program.get(f"{V1}/studies").status_code, program.post(f"{V1}/jobs", json={}).status_code

        _, robot = people.token("north", "read")
        key, his = people.token("north", account_id=account)
        assert (may(robot), may(his)) == ((200, 403), (200, 422))
        assert ada.put(f"{V1}/lab/members/{account}", json={"role": "viewer"}).status_code == 200
        assert may(his) == (200, 403)
        assert ada.put(f"{V1}/lab/members/{account}", json={"role": "admin"}).status_code == 200
        with people.program(his) as program:  # an admin's token administers nothing
            assert program.get(f"{V1}/lab/audit").status_code == 403
            assert program.post(f"{V1}/tokens", json={"name": "more"}).status_code == 403
        with people.installation.session() as session:
            session.execute(sa.update(ApiToken).where(ApiToken.id == key).values(expires_at=utc_now()))
        assert may(his) == (401, 401)
        _, his = people.token("north", account_id=account)
        assert may(his)[0] == 200
        assert ada.delete(f"{V1}/lab/members/{account}").status_code == 204
        assert may(his) == (401, 401)
        key, robot = people.token("north", "write")
        assert may(robot) == (200, 422)
        assert ada.delete(f"{V1}/tokens/{key}").status_code == 204
        assert may(robot) == (401, 401)


@on_sqlite
def test_a_member_sees_and_revokes_its_own_tokens_and_makes_no_robots(people: People) -> None:
    account = people.person("bob@example.org", "north")
    _, hers = people.token("north", account_id=people.person("eve@example.org", "north"))
    key, _ = people.token("north")
    with people.browser(people.session(account)) as bob:
        assert bob.post(f"{V1}/tokens", json={"name": "r", "robot": True}).status_code == 403
        assert bob.post(f"{V1}/tokens", json={"name": "mine"}).status_code == 201
        assert [each["name"] for each in bob.get(f"{V1}/tokens").json()["items"]] == ["mine"]
        assert bob.delete(f"{V1}/tokens/{key}").status_code == 404
    with people.program(hers) as program:
        assert program.get(f"{V1}/studies").status_code == 200


def test_an_invitation_is_good_once_for_its_address_until_it_ends(ada: TestClient, people: People) -> None:
    def invite(email: str, role: str = "member") -> dict[str, Any]:
        answer = ada.post(f"{V1}/lab/invitations", json={"email": email, "role": role})
        assert answer.status_code == 201
        made: dict[str, Any] = answer.json()
        return made

    withdrawn, late, replaced = invite("w@example.org"), invite("l@example.org"), invite("bob@example.org")
    ada.delete(f"{V1}/lab/invitations/{withdrawn['invitation']['id']}")
    with people.installation.session() as session:
        late_one = Invitation.id == late["invitation"]["id"]
        session.execute(sa.update(Invitation).where(late_one).values(expires_at=utc_now()))
    code = {"code": invite("bob@example.org")["code"]}
    new = {"name": "Bob", "password": PASSWORD}
    with people.browser() as browser:
        for none in (withdrawn, late, replaced, {"code": "x"}):
            assert browser.post(f"{V1}/invitations/look", json={"code": none["code"]}).status_code == 404
            assert browser.post(f"{V1}/invitations/accept", json={"code": none["code"], **new}).status_code == 404
        look = browser.post(f"{V1}/invitations/look", json=code).json()
        assert (look["lab"], look["email"], look["has_account"]) == ("north", "bob@example.org", False)
        assert (
            browser.post(f"{V1}/invitations/accept", json=code | {"name": "B", "password": "short"}).status_code == 422
        )
        assert ada.post(f"{V1}/invitations/accept", json=code).status_code == 409  # it is Bob's
        assert browser.post(f"{V1}/invitations/accept", json=code | new).status_code == 204
        assert browser.get(f"{V1}/session").json()["lab"]["role"] == "member"
        assert browser.post(f"{V1}/invitations/accept", json=code | new).status_code == 404
        # somebody who has an account takes one as who is signed in, and is shown the lab
        with people.installation.session() as session:
            south = Accounts(session).found_lab("south", "south")
        with people.installation.of_lab(south.id).transaction() as store:
            _, second = store.invitations.add("bob@example.org", "viewer", None)
        assert browser.post(f"{V1}/invitations/accept", json={"code": second}).status_code == 204
        shown = browser.get(f"{V1}/session").json()
        assert (shown["lab"]["name"], shown["lab"]["role"], len(shown["labs"])) == ("south", "viewer", 2)
        assert browser.put(f"{V1}/session/lab", json={"lab_id": "north"}).status_code == 204
        assert browser.get(f"{V1}/session").json()["lab"]["name"] == "north"
    said = audit_of(ada)
    assert "bob@example.org: join bob@example.org as member, invited" in said
    assert "ada@example.org: invite bob@example.org as member" in said


def test_a_lab_keeps_an_admin(ada: TestClient, people: People) -> None:
    me = ada.get(f"{V1}/session").json()["account"]["id"]
    assert ada.put(f"{V1}/lab/members/{me}", json={"role": "member"}).status_code == 409
    assert ada.delete(f"{V1}/lab/members/{me}").status_code == 409
    other = people.person("bob@example.org", "north")
    assert ada.put(f"{V1}/lab/members/{other}", json={"role": "admin"}).status_code == 200
    assert ada.put(f"{V1}/lab/members/{me}", json={"role": "member"}).status_code == 200
    assert ada.get(f"{V1}/lab/audit").status_code == 403


def test_the_audit_says_who_did_what_and_is_only_ever_added_to(
    ada: TestClient, people: People, unchecked: None, pack: Callable[..., bytes], study_files: dict[str, bytes]
) -> None:
    key, robot = people.token("north")
    with people.program(robot) as program:
        made = program.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))}).json()
    (entry,) = ada.get(f"{V1}/lab/audit", params={"search": f"study {made['id']}"}).json()["items"]
    assert (entry["who"], entry["action"], entry["after_hash"]) == (
        "robot, token of a test",
        "add",
        made["content_hash"],
    )
    assert entry["actor"] == f"token:{key}"
    for change in (sa.update(AuditEntry).values(actor="nobody"), sa.delete(AuditEntry)):
        with pytest.raises(sa.exc.DBAPIError, match="only ever added to"), people.installation.session() as session:
            session.execute(change)
    assert len(ada.get(f"{V1}/lab/audit").json()["items"]) >= 3


@on_sqlite
def test_accounts_that_are_there_are_asked_for_whatever_the_settings_say(settings: Settings, people: People) -> None:
    people.person("ada@example.org", "north")
    forgot = create_app(settings)
    with TestClient(forgot, base_url="http://127.0.0.1:8765") as browser:
        assert browser.get(f"{V1}/studies").status_code == 401


@on_sqlite
def test_without_accounts_all_is_as_it_was_and_the_pages_of_accounts_say_why(client_without: TestClient) -> None:
    assert client_without.get(f"{V1}/session").json()["accounts"] is False
    assert client_without.get(f"{V1}/studies").status_code == 200
    for path in ("lab/members", "tokens", "lab/audit", "lab"):
        answer = client_without.get(f"{V1}/{path}")
        assert (answer.status_code, "EXOGAUGE_ACCOUNTS" in answer.text) == (409, True), path


@pytest.fixture
def client_without(settings: Settings) -> Iterator[TestClient]:
    with TestClient(create_app(settings)) as opened:
        yield opened


@on_sqlite
def test_events_end_soon_after_the_session_that_asked_for_them(
    people: People, study_id_of: Callable[[str], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access, "LOOK_EVERY_S", 0.1)
    account = people.person("ada@example.org", "north")
    job, key = study_id_of("north"), people.session(account)
    with people.browser(key) as browser, browser.stream("GET", f"{V1}/jobs/{job}/events") as events:
        lines = events.iter_lines()
        assert next(lines)
        with people.installation.session() as session:
            Accounts(session).end_sessions(account)
        assert all("succeeded" not in line for line in lines)  # it ended, and the job did not
    with people.browser(key) as browser:
        assert browser.get(f"{V1}/jobs/{job}/events").status_code == 401


@on_sqlite
def test_streams_of_one_token_are_looked_at_together_and_a_revoked_one_is_not_known_for_long(
    people: People, monkeypatch: pytest.MonkeyPatch
) -> None:
    people.person("ada@example.org", "north")
    (row, secret), (_, other) = people.token("north"), people.token("north")
    looks, by_token = list[str](), callers.by_token

    def counted(session: Any, token: str) -> Any:
        looks.append(token)
        return by_token(session, token)

    monkeypatch.setattr(callers, "by_token", counted)
    gate = access.Access(people.app)

    def still(token: str, lab: str = "north") -> bool:
        headers = [(b"authorization", f"Bearer {token}".encode())]
        scope = {"type": "http", "method": "GET", "path": f"{V1}/jobs/{row}/events", "headers": headers}
        return asyncio.run(gate.still({**scope, "app": people.app, access.CALLER: Caller("token", lab, "member")}))

    assert all(still(secret) for _ in range(50))
    assert still(other)
    assert looks == [secret, other]
    with people.installation.reading() as session:
        assert session.get(ApiToken, row).used_at is not None  # a stream alone is use, too
    assert not still(secret, "south")
    with people.installation.of_lab("north").transaction() as store:
        store.tokens.revoke(row)
    monkeypatch.setattr(access, "SHARED_S", -1.0)
    assert not still(secret)
    assert not still("no token")


@pytest.fixture
def study_id_of(people: People) -> Callable[[str], str]:
    """A job of the lab that nobody takes."""
    from exogauge.storage.tables import Job

    def make(lab: str) -> str:
        with people.installation.of_lab(lab).transaction() as store:
            study, _ = store.studies.add("s", [], {})
            job = Job(kind="evaluate", study_id=study.id, request_hash="h")
            store.session.add(job)
            store.session.flush()
            key: str = job.id
        return key

    return make


@pytest.mark.parametrize(
    "password", ["short", "aaaaaaaaaaaaaaaaaaaa", "passwordpassword", "ada@example.orgada", "x" * 257]
)
def test_a_password_that_is_easily_thought_of_is_refused(password: str) -> None:
    with pytest.raises(BadInput):
        checked(password, "ada@example.org", "Ada")


def test_a_password_is_the_same_however_its_letters_are_written() -> None:
    assert checked("caf\u00e9 au lait, tr\u00e8s chaud") == checked("cafe\u0301 au lait, tre\u0300s chaud")
