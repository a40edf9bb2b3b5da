"""Sign-in at an OpenID provider: a real one on this machine, and what is refused of its answers."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import secrets
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlsplit

import httpx
import oidc_provider_mock
import pytest
from fastapi.testclient import TestClient
from tests.api.people import ORIGIN, PASSWORD, People

from exogauge.api.app import create_app
from exogauge.settings import Settings

V1 = "/api/v1"
FLOW = "__Host-exogauge-oidc"
pytestmark = [
    pytest.mark.parametrize("database_url", ["sqlite"], indirect=True),
    pytest.mark.filterwarnings("ignore:get_jwt_config:DeprecationWarning"),  # of the provider, in its thread
]


class ProviderHere:
    """issuer: where it is. asked: forms that came to its token endpoint."""

    def __init__(self, server: Any) -> None:
        self.issuer = f"http://localhost:{server.server_port}"
        self.asked: list[dict[str, str]] = []
        self.basic: list[str | None] = []
        self._app, server.app = server.app, self

    def __call__(self, environ: dict[str, Any], start: Any) -> Any:
        if environ["PATH_INFO"] == "/oauth2/token":
            body = environ["wsgi.input"].read(int(environ["CONTENT_LENGTH"]))
            self.asked.append(dict(parse_qsl(body.decode())))
            self.basic.append(environ.get("HTTP_AUTHORIZATION"))
            environ["wsgi.input"] = io.BytesIO(body)
        return self._app(environ, start)


@pytest.fixture(scope="module")
def provider() -> Iterator[ProviderHere]:
    with oidc_provider_mock.run_server_in_thread(require_nonce=True) as server:
        yield ProviderHere(server)


@pytest.fixture
def people(settings: Settings, provider: ProviderHere) -> Iterator[People]:
    oidc = {
        "oidc_issuer": provider.issuer,
        "oidc_client_id": "exo",
        "oidc_client_secret": "s:ecret",
        "oidc_name": "Uni",
    }
    app = create_app(settings.model_copy(update={"accounts": True, "host": "0.0.0.0", **oidc}))
    yield People(app)
    app.state.installation.close()


@pytest.fixture
def browser(people: People) -> Iterator[TestClient]:
    with people.browser() as opened:
        opened.follow_redirects = False
        yield opened


Go = Callable[..., httpx.Response]


@pytest.fixture
def go(browser: TestClient) -> Go:
    """To the provider, in as `subject`, and back; the answer of our own callback."""

    def walk(subject: str, change: Callable[[str], str] = str, deny: bool = False, **wanted: Any) -> httpx.Response:
        keyed = {"Idempotency-Key": secrets.token_hex(8)}  # as the page sends one with every POST
        begun = browser.post(f"{V1}/oidc/begin", json=wanted, headers=keyed)
        assert begun.status_code == 200, begun.text
        form = {"action": "deny"} if deny else {"sub": subject}
        came = httpx.post(begun.json()["url"], data=form, follow_redirects=False)
        assert came.status_code == 302, came.text
        assert came.headers["location"].startswith(f"{ORIGIN}{V1}/oidc/callback?")
        answer: httpx.Response = browser.get(change(came.headers["location"]))
        assert answer.status_code == 303
        return answer

    return walk


def who(browser: TestClient) -> str | None:
    account = browser.get(f"{V1}/session").json()["account"]
    return None if account is None else str(account["email"])


def sign_in(browser: TestClient, people: People, email: str = "ada@example.org") -> str:
    account = people.person(email, "north", password=PASSWORD)
    assert browser.post(f"{V1}/session", json={"email": email, "password": PASSWORD}).status_code == 204
    return account


def reason(answer: httpx.Response) -> str:
    return parse_qs(urlsplit(answer.headers["location"]).query)["oidc"][0]


@pytest.mark.slow
def test_a_login_that_its_owner_linked_signs_in_and_one_that_was_unlinked_does_not(
    go: Go, browser: TestClient, people: People, provider: ProviderHere
) -> None:
    assert browser.get(f"{V1}/session").json()["oidc"] == "Uni"
    sign_in(browser, people)
    assert go("ada-at-uni", purpose="link", next="/account").headers["location"] == f"{ORIGIN}/account"
    (linked,) = browser.get(f"{V1}/account/identities").json()["items"]
    assert (linked["issuer"], linked["subject"]) == (provider.issuer, "ada-at-uni")
    before = browser.cookies["__Host-exogauge"]
    browser.delete(f"{V1}/session")
    assert who(browser) is None
    answer = go("ada-at-uni", next="/devices?search=x#a")
    assert answer.headers["location"] == f"{ORIGIN}/devices?search=x#a"
    assert who(browser) == "ada@example.org"
    assert browser.cookies["__Host-exogauge"] != before, "a new key at every sign-in"
    assert FLOW not in browser.cookies
    assert browser.delete(f"{V1}/account/identities/{linked['id']}").status_code == 204
    browser.delete(f"{V1}/session")
    assert reason(go("ada-at-uni")) == "unknown"
    assert who(browser) is None


def test_an_address_that_the_provider_tells_links_nothing(go: Go, browser: TestClient, people: People) -> None:
    """This provider takes the subject for the address, too."""
    people.person("ada@example.org", "north", password=PASSWORD)
    assert reason(go("ada@example.org")) == "unknown"
    assert who(browser) is None


def test_an_invitation_is_taken_up_once_and_makes_the_account_that_it_names(
    go: Go, browser: TestClient, people: People
) -> None:
    people.person("ada@example.org", "north", "admin")
    with people.installation.of_lab("north").transaction() as store:
        code = store.invitations.add("bob@example.org", "viewer", None)[1]
    assert go("bob-at-uni", purpose="invitation", code=code).headers["location"] == f"{ORIGIN}/studies"
    assert who(browser) == "bob@example.org"
    assert browser.get(f"{V1}/session").json()["lab"]["role"] == "viewer"
    assert reason(go("eve-at-uni", purpose="invitation", code=code)) == "invitation"
    (only,) = browser.get(f"{V1}/account/identities").json()["items"]
    refused = browser.delete(f"{V1}/account/identities/{only['id']}")
    assert refused.status_code == 409, "the account has no password"
    assert "only way" in refused.json()["detail"]


@pytest.mark.slow
def test_an_invitation_of_an_address_that_has_an_account_is_not_taken_over(
    go: Go, browser: TestClient, people: People
) -> None:
    people.person("ada@example.org", "north", password=PASSWORD)
    with people.installation.of_lab("north").transaction() as store:
        code = store.invitations.add("ada@example.org", "admin", None)[1]
    assert reason(go("eve-at-uni", purpose="invitation", code=code)) == "other"
    assert who(browser) is None
    assert reason(go("eve-at-uni")) == "unknown", "nothing was linked on the way"


@pytest.mark.slow
def test_a_login_is_linked_with_one_account(go: Go, browser: TestClient, people: People) -> None:
    sign_in(browser, people)
    go("ada-at-uni", purpose="link")
    sign_in(browser, people, "eve@example.org")
    answer = go("ada-at-uni", purpose="link")
    assert (reason(answer), urlsplit(answer.headers["location"]).path) == ("taken", "/account")
    browser.delete(f"{V1}/session")
    assert browser.post(f"{V1}/oidc/begin", json={"purpose": "link"}).status_code == 403


@pytest.mark.slow
def test_a_locked_account_stays_locked(go: Go, browser: TestClient, people: People) -> None:
    from exogauge.storage.accounts import Accounts

    account = sign_in(browser, people)
    go("ada-at-uni", purpose="link")
    with people.installation.session() as session:
        Accounts(session).disable(account, True)
    assert reason(go("ada-at-uni")) == "locked"
    assert who(browser) is None


def test_the_code_is_bound_to_this_browser_by_pkce_and_the_secret_is_sent_apart(
    go: Go, browser: TestClient, provider: ProviderHere
) -> None:
    url = browser.post(f"{V1}/oidc/begin", json={}).json()["url"]
    asked = dict(parse_qsl(urlsplit(url).query))
    assert (asked["response_type"], asked["code_challenge_method"]) == ("code", "S256")
    assert len({asked["state"], asked["nonce"], asked["code_challenge"]}) == 3
    came = httpx.post(url, data={"sub": "x"}, follow_redirects=False)
    provider.asked.clear()
    provider.basic.clear()
    browser.get(came.headers["location"])
    (form,), (basic,) = provider.asked, provider.basic
    digest = hashlib.sha256(form["code_verifier"].encode()).digest()
    assert base64.urlsafe_b64encode(digest).rstrip(b"=").decode() == asked["code_challenge"]
    assert form["code_verifier"] not in url
    assert base64.b64decode(str(basic).removeprefix("Basic ")) == b"exo:s%3Aecret"
    assert "client_secret" not in form


def changed(browser: TestClient, **what: str) -> None:
    """The cookie of the flow, with other content."""
    kept = json.loads(base64.urlsafe_b64decode(browser.cookies[FLOW].strip('"')))
    forged = base64.urlsafe_b64encode(json.dumps(kept | what).encode()).decode()
    browser.cookies.delete(FLOW)
    browser.cookies.set(FLOW, forged)


@pytest.mark.slow
def test_answers_that_were_not_asked_for_in_this_browser_are_refused(
    go: Go, browser: TestClient, people: People, caplog: pytest.LogCaptureFixture
) -> None:
    sign_in(browser, people)
    go("ada-at-uni", purpose="link")
    browser.delete(f"{V1}/session")

    def other_state(url: str) -> str:
        return url.replace("state=", "state=x")

    def other_issuer(url: str) -> str:
        return f"{url}&iss=https%3A%2F%2Fevil.example"

    def other_nonce(url: str) -> str:
        changed(browser, nonce="of another flow")
        return url

    def no_cookie(url: str) -> str:
        browser.cookies.delete(FLOW)
        return url

    def other_code(url: str) -> str:
        return url.replace("code=", "code=x")

    cases = {
        other_state: ("expired", "state is not"), other_issuer: ("failed", "another issuer"),
        other_nonce: ("failed", "nonce"), no_cookie: ("expired", "has begun nothing"),
        other_code: ("failed", "400"),
    }  # fmt: skip
    for change, (expected, said) in cases.items():
        caplog.clear()
        assert reason(go("ada-at-uni", change)) == expected, change.__name__
        assert any(said in each.getMessage() for each in caplog.records if each.name == "exogauge.api.oidc")
        assert who(browser) is None, change.__name__
    assert reason(go("ada-at-uni", deny=True)) in ("denied", "expired")
    came: list[str] = []
    go("ada-at-uni", lambda url: came.append(url) or url)  # type: ignore[func-returns-value]
    assert who(browser) == "ada@example.org"
    browser.delete(f"{V1}/session")
    assert reason(browser.get(came[0])) == "expired", "an answer is good once"
    assert who(browser) is None


@pytest.mark.slow
def test_a_token_for_another_client_or_of_another_key_is_refused(
    go: Go, browser: TestClient, people: People, caplog: pytest.LogCaptureFixture
) -> None:
    """The provider on this machine signs for whoever asks: what our client is called is changed behind its back."""
    sign_in(browser, people)
    go("ada-at-uni", purpose="link")
    browser.delete(f"{V1}/session")
    provider = people.app.state.oidc

    def renamed(url: str) -> str:
        sent, provider.client_id = provider.client_id, "another"
        provider._token_of = provider._token  # the code is still redeemed as the client that asked for it
        provider._token = lambda *given: as_client(provider, sent, given)
        return url

    assert reason(go("ada-at-uni", renamed)) == "failed"
    assert "aud" in caplog.text
    del provider._token
    provider.client_id = "exo"
    with oidc_provider_mock.run_server_in_thread() as other:
        keys = httpx.get(f"http://localhost:{other.server_port}/jwks").json()
    from joserfc.jwk import KeySet

    def of_another_key(url: str) -> str:
        provider._key_set = lambda anew: KeySet.import_key_set(keys)
        return url

    assert reason(go("ada-at-uni", of_another_key)) == "failed"
    assert "signature" in caplog.text or "no key" in caplog.text.lower()
    del provider._key_set
    assert go("ada-at-uni").headers["location"] == f"{ORIGIN}/studies"


def as_client(provider: Any, name: str, given: tuple[Any, ...]) -> str:
    now, provider.client_id = provider.client_id, name
    try:
        token: str = provider._token_of(*given)
        return token
    finally:
        provider.client_id = now


@pytest.mark.parametrize("back", ["https://evil.example", "//evil.example", "/\\evil.example", "studies", "/a\nb"])
def test_nobody_is_led_to_another_host(browser: TestClient, back: str) -> None:
    assert browser.post(f"{V1}/oidc/begin", json={"next": back}).status_code == 422


def test_a_provider_that_calls_itself_otherwise_or_is_away_is_not_asked(
    settings: Settings, provider: ProviderHere
) -> None:
    for issuer in (provider.issuer.replace("localhost", "127.0.0.1") + "/", "http://127.0.0.1:9"):
        oidc = {"oidc_issuer": issuer, "oidc_client_id": "exo"}
        app = create_app(settings.model_copy(update={"accounts": True, "host": "0.0.0.0", **oidc}))
        with People(app).browser() as opened:
            assert opened.post(f"{V1}/oidc/begin", json={}).status_code == 502
        app.state.installation.close()


def test_settings_ask_for_https_and_a_client(settings: Settings) -> None:
    data = settings.data_dir
    with pytest.raises(ValueError, match="https"):
        Settings(data_dir=data, oidc_issuer="http://login.example", oidc_client_id="exo")
    with pytest.raises(ValueError, match="CLIENT_ID"):
        Settings(data_dir=data, oidc_issuer="https://login.example")
    named = Settings(data_dir=data, oidc_issuer="https://login.example/x", oidc_client_id="exo")
    assert named.oidc_name == "login.example"


def test_without_a_provider_there_is_no_button(settings: Settings) -> None:
    app = create_app(settings.model_copy(update={"accounts": True, "host": "0.0.0.0"}))
    with People(app).browser() as opened:
        assert opened.get(f"{V1}/session").json()["oidc"] is None
        assert opened.post(f"{V1}/oidc/begin", json={}).status_code == 404
    app.state.installation.close()
