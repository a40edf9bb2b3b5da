"""A POST to an address that somebody else has named: https, to a public address, and nowhere else.

The name is looked up once, when the connection is made; every address that it has must be public, and the connection
goes to one of those that were looked at. A name that changes between the look and the connection (DNS rebinding) gains
nothing, since there is no second look. Redirects are not followed, and no proxy of the environment is asked.
"""

from __future__ import annotations

import ipaddress
import os
import socket
import ssl
import time
from collections.abc import Collection, Iterable, Mapping
from typing import final
from urllib.parse import urlsplit

import certifi
import httpcore

PATIENCE_S = 10.0  # judgement: for each step of an answer; who is slower is asked again
WHOLE_S = 20.0  # judgement: for all of it: who sends a byte now and then holds up the deliveries of others
GIVEN_OUT = ipaddress.ip_network(
    "2000::/3"
)  # of IPv6, all that the internet has (IANA); the rest is of single networks
ALSO_PRIVATE = tuple(  # public as the registries have it, and a way into a private network
    ipaddress.ip_network(each)
    for each in (
        "64:ff9b::/96",
        "64:ff9b:1::/48",
        "2002::/16",
        "2001::/32",
        "192.88.99.0/24",
        "100.64.0.0/10",
        "3fff::/20",
    )
)
LONGEST_URL = 2000  # letters, as the column of webhooks has it


class Refused(Exception):
    """Nothing was sent."""


class NoAnswer(Exception):
    """Something may have been sent."""


def post(url: str, body: bytes, headers: Mapping[str, str], private: Collection[str] = ()) -> int:
    """The status of the answer; its body is not read. private: names in small letters that may have private
    addresses."""
    checked(url)
    trusted = ssl.create_default_context(cafile=os.environ.get("SSL_CERT_FILE") or certifi.where())
    given = list(headers.items())
    waits = dict.fromkeys(("connect", "read", "write", "pool"), PATIENCE_S)
    try:
        with (
            httpcore.ConnectionPool(ssl_context=trusted, network_backend=PublicNetwork(private)) as pool,
            pool.stream("POST", url, headers=given, content=body, extensions={"timeout": waits}) as answer,
        ):
            return int(answer.status)
    except (httpcore.NetworkError, httpcore.TimeoutException, httpcore.ProtocolError, OSError) as error:
        raise NoAnswer(f"{type(error).__name__}: {error}"[:500]) from error


def checked(url: str) -> None:
    """Refused unless it is an https address with a host, and no name and password in it."""
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        raise Refused("its host or its port is none") from None
    if parts.scheme != "https" or not parts.hostname:
        raise Refused("an address begins with https://")
    if parts.username is not None or parts.fragment or len(url) > LONGEST_URL or port == 0:
        raise Refused("an address has neither name and password nor a fragment, and is not longer than 2000 letters")


def refuse_private_number(url: str, private: Collection[str]) -> None:
    """Refused for an address in numbers, however written, that nothing will be sent to. Names are looked up then."""
    host = urlsplit(url).hostname or ""
    try:
        found = socket.getaddrinfo(host, None, flags=socket.AI_NUMERICHOST)
    except (OSError, UnicodeError):
        return
    if host.casefold() not in private and not all(is_public(str(each[4][0])) for each in found):
        raise Refused(f"{host} is a private address")


@final
class PublicNetwork(httpcore.NetworkBackend):
    """Connections to public addresses alone."""

    def __init__(self, private: Collection[str]) -> None:
        self._private = private
        self._network = httpcore.SyncBackend()

    def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.NetworkStream:
        """TLS asks for the name all the same: the certificate has to be that of the host."""
        until = time.monotonic() + WHOLE_S
        address = self._address(host, port)
        stream = self._network.connect_tcp(address, port, timeout, local_address, socket_options)
        return UntilStream(stream, until)

    def _address(self, host: str, port: int) -> str:
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        except (OSError, UnicodeError) as error:
            raise httpcore.ConnectError(f"{host} has no address") from error
        addresses = [str(each[4][0]) for each in found]
        if host.casefold() not in self._private:
            for address in addresses:
                if not is_public(address):
                    raise Refused(f"{host} has a private address")
        return addresses[0]


@final
class UntilStream(httpcore.NetworkStream):
    """A connection that ends at a time, whatever still comes."""

    def __init__(self, stream: httpcore.NetworkStream, until: float) -> None:
        self._stream, self._until = stream, until
        self.close, self.get_extra_info = stream.close, stream.get_extra_info  # type: ignore[method-assign]

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:
        return self._stream.read(max_bytes, self._left(timeout))

    def write(self, buffer: bytes, timeout: float | None = None) -> None:
        self._stream.write(buffer, self._left(timeout))

    def start_tls(
        self, ssl_context: ssl.SSLContext, server_hostname: str | None = None, timeout: float | None = None
    ) -> httpcore.NetworkStream:
        return UntilStream(self._stream.start_tls(ssl_context, server_hostname, self._left(timeout)), self._until)

    def _left(self, timeout: float | None) -> float:
        left = self._until - time.monotonic()
        if left <= 0:
            raise httpcore.ReadTimeout(f"it did not answer within {WHOLE_S:.0f} s")
        return left if timeout is None else min(timeout, left)


def is_public(address: str) -> bool:
    """Whether it is of the internet: no loopback, private, link-local or reserved one, however it is wrapped."""
    found = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(found, ipaddress.IPv6Address) and found.ipv4_mapped is not None:
        found = found.ipv4_mapped
    if isinstance(found, ipaddress.IPv6Address) and found not in GIVEN_OUT:
        return False
    inside = any(found.version == each.version and found in each for each in ALSO_PRIVATE)
    return found.is_global and not found.is_multicast and not inside
