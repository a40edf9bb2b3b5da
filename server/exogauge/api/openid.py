"""Sign-in by an OpenID provider, as its client: authorization code with PKCE, state and nonce (OpenID Connect Core 1.0,
RFC 6749, 7636, 9207, 9700).

The provider is known by its issuer alone; where its endpoints are and by which keys it signs it says itself. Of an ID
token the signature, issuer, audience, times and nonce are checked. Who it is of is (issuer, subject); an address in it
is not believed.
"""

from __future__ import annotations

import hmac
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final
from urllib.parse import quote, urlsplit

import httpx
from authlib.common.errors import AuthlibBaseError
from authlib.common.security import generate_token
from authlib.common.urls import add_params_to_uri
from authlib.oauth2.rfc7636 import create_s256_code_challenge
from authlib.oidc.core import CodeIDToken
from joserfc import jwt
from joserfc.errors import JoseError
from joserfc.jwk import KeySet

from exogauge.settings import Settings, is_loopback

ALGORITHMS = ("RS256", "PS256", "ES256", "RS384", "PS384", "ES384", "RS512", "PS512", "ES512", "Ed25519", "EdDSA")
PATIENCE_S = 10.0  # for an answer of the provider
KNOWN_FOR_S = 3600.0  # after which the provider is asked anew where its endpoints are
CLOCKS_S = 60  # judgement: by which its clock and ours may differ
LONGEST_ANSWER = 1 << 20  # bytes
LONGEST_SUBJECT = 255  # Core 1.0, 2: letters of `sub`


class NotSignedIn(Exception):
    """reason: a word of the page; detail: for the log."""

    def __init__(self, reason: str, detail: str) -> None:
        self.reason, self.detail = reason, detail
        super().__init__(f"{reason}: {detail}")


@final
@dataclass(frozen=True)
class Flow:
    """What this browser has to bring back. verifier: of PKCE, which the provider sees last."""

    state: str
    nonce: str
    verifier: str


@final
@dataclass(frozen=True)
class Identity:
    """subject: who it is, at this issuer. name: as it says, or empty."""

    issuer: str
    subject: str
    name: str


@final
class Provider:
    """One of an installation; safe to share between threads."""

    def __init__(self, settings: Settings) -> None:
        self.issuer, self.client_id = settings.oidc_issuer, settings.oidc_client_id
        self._secret = settings.oidc_client_secret
        self._lock = threading.Lock()
        self._said: Mapping[str, Any] | None = None
        self._keys: KeySet | None = None
        self._asked_at = 0.0

    def begin(self, redirect_uri: str) -> tuple[str, Flow]:
        """Where the browser goes, and what it keeps meanwhile."""
        flow = Flow(generate_token(32), generate_token(32), generate_token(64))
        asked = {
            "response_type": "code", "client_id": self.client_id, "redirect_uri": redirect_uri,
            "scope": "openid profile", "state": flow.state, "nonce": flow.nonce,
            "code_challenge": create_s256_code_challenge(flow.verifier), "code_challenge_method": "S256",
        }  # fmt: skip
        return add_params_to_uri(self._endpoint("authorization_endpoint"), list(asked.items())), flow

    def finish(self, flow: Flow, came: Mapping[str, str], redirect_uri: str) -> Identity:
        """came: the parameters with which the browser came back. NotSignedIn."""
        if not hmac.compare_digest(came.get("state", "").encode(), flow.state.encode()):
            raise NotSignedIn("expired", "the state is not that of this browser")
        if came.get("iss", self.issuer) != self.issuer:
            raise NotSignedIn("failed", "the answer is of another issuer")
        if "error" in came:
            denied = came["error"] == "access_denied"
            raise NotSignedIn("denied" if denied else "failed", f"the provider says {came['error'][:100]!r}")
        if not came.get("code"):
            raise NotSignedIn("failed", "the answer has no code")
        return self._identity(self._token(came["code"], flow.verifier, redirect_uri), flow.nonce)

    def _token(self, code: str, verifier: str, redirect_uri: str) -> str:
        form = {
            "grant_type": "authorization_code", "code": code, "redirect_uri": redirect_uri, "code_verifier": verifier,
        }  # fmt: skip
        ways = self._document().get("token_endpoint_auth_methods_supported") or ["client_secret_basic"]
        basic = None
        if not self._secret:
            form["client_id"] = self.client_id
        elif "client_secret_basic" in ways:
            basic = httpx.BasicAuth(quote(self.client_id, safe=""), quote(self._secret, safe=""))
        else:
            form |= {"client_id": self.client_id, "client_secret": self._secret}
        said = self._ask("POST", self._endpoint("token_endpoint"), data=form, auth=basic)
        if not isinstance(said.get("id_token"), str):
            raise NotSignedIn("failed", "the provider gave no ID token")
        token: str = said["id_token"]
        return token

    def _identity(self, token: str, nonce: str) -> Identity:
        try:
            claims = self._claims(token)
            options: dict[str, Any] = {
                "iss": {"essential": True, "value": self.issuer},
                "aud": {"essential": True, "value": self.client_id},
                "nonce": {"essential": True, "value": nonce},
            }
            checked = CodeIDToken(claims, {}, options, {"client_id": self.client_id, "nonce": nonce})
            checked.validate(leeway=CLOCKS_S)
        except (JoseError, AuthlibBaseError, ValueError) as error:
            raise NotSignedIn("failed", f"the ID token is refused: {error}") from error
        subject = claims.get("sub")
        if not isinstance(subject, str) or not 0 < len(subject) <= LONGEST_SUBJECT:
            raise NotSignedIn("failed", "the ID token names nobody")
        name = claims.get("name")
        return Identity(self.issuer, subject, name.strip()[:200] if isinstance(name, str) else "")

    def _claims(self, token: str) -> dict[str, Any]:
        """Of a token that one of the provider's keys has signed; new keys are asked for once."""
        for anew in (False, True):
            try:
                return dict(jwt.decode(token, self._key_set(anew), algorithms=list(ALGORITHMS)).claims)
            except (JoseError, ValueError):
                if anew:
                    raise
        raise AssertionError

    def _key_set(self, anew: bool) -> KeySet:
        with self._lock:
            keys = self._keys
        if keys is None or anew:
            keys = KeySet.import_key_set(self._ask("GET", self._endpoint("jwks_uri")))  # type: ignore[arg-type]
            with self._lock:
                self._keys = keys
        return keys

    def _endpoint(self, name: str) -> str:
        url = self._document().get(name)
        if not isinstance(url, str) or not is_private_line(url):
            raise NotSignedIn("failed", f"the provider names no {name} over https")
        return url

    def _document(self) -> Mapping[str, Any]:
        with self._lock:
            said = self._said if time.monotonic() - self._asked_at < KNOWN_FOR_S else None
        if said is None:
            said = self._ask("GET", f"{self.issuer.rstrip('/')}/.well-known/openid-configuration")
            if said.get("issuer") != self.issuer:
                raise NotSignedIn("failed", f"the provider calls itself {str(said.get('issuer'))[:200]!r}")
            with self._lock:
                self._said, self._keys, self._asked_at = said, None, time.monotonic()
        return said

    def _ask(self, method: str, url: str, **more: Any) -> dict[str, Any]:
        try:
            with (
                httpx.Client(timeout=PATIENCE_S, follow_redirects=False) as client,
                client.stream(method, url, headers={"Accept": "application/json"}, **more) as answer,
            ):
                body = b""
                for part in answer.iter_bytes():
                    body += part
                    if len(body) > LONGEST_ANSWER:
                        raise NotSignedIn("failed", "the provider's answer is too long")
                answer.raise_for_status()
            said = httpx.Response(200, content=body).json()
        except (httpx.HTTPError, ValueError) as error:
            raise NotSignedIn("failed", f"{method} {url}: {error}") from error
        if not isinstance(said, dict):
            raise NotSignedIn("failed", f"{method} {url}: the answer is no object")
        return said


def is_private_line(url: str) -> bool:
    """Encrypted, or within this machine."""
    parts = urlsplit(url)
    return parts.scheme == "https" or (parts.scheme == "http" and is_loopback(parts.hostname or ""))
