"""One command that serves: the schema is made, workers are started and kept alive, the API answers."""

from __future__ import annotations

import logging
import os
import secrets
import signal
import socket
import sys
import tempfile
from collections.abc import Callable, Sequence
from typing import final

import uvicorn

from exogauge import tracing
from exogauge.api.app import create_app, has_accounts
from exogauge.api.connection import Limits, connection_within
from exogauge.errors import BadInput, Fault, Unavailable
from exogauge.jobs.schema import prepare
from exogauge.jobs.supervisor import Supervisor, leave_with_parent
from exogauge.settings import Settings, refuse_open_house
from exogauge.storage.held_files import own_folder

WORKER = (sys.executable, "-m", "exogauge.cli", "work", "--with-parent")
MOST_OF_A_MESSAGE = 1024 * 1024  # bytes on a websocket; what is too large is told up to this, and ends the line beyond
PATIENCE_S = 3  # for open requests (event streams among them) when the server stops


def refuse_forgotten_accounts(settings: Settings, accounts: bool) -> None:
    """A server that is open to all although its database has accounts was started by mistake."""
    if settings.open_to_all and accounts:
        detail = "the database has accounts, and EXOGAUGE_OPEN_TO_ALL would let in all without one"
        raise BadInput(Fault(detail, "open_to_all", "Leave it away.", column="EXOGAUGE_OPEN_TO_ALL"))


def say_set_up_code(settings: Settings, url: str) -> None:
    """For whoever started the server, who makes the first account. Kept for a start again, and for other servers beside
    this one."""
    file = settings.set_up_code
    try:
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        pass
    else:
        with os.fdopen(descriptor, "w", encoding="ascii") as new:
            new.write(secrets.token_urlsafe(16))
    print(f"there is no account yet: {url}/set-up takes the code {file.read_text(encoding='ascii')}", file=sys.stderr)


def listening(host: str, port: int) -> socket.socket:
    """A bound socket, so that the address is known (port 0 takes a free one) before anything else starts."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family, socket.SOCK_STREAM)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
    except OSError as error:
        bound.close()
        advice = "Is another server running? EXOGAUGE_PORT or --port takes another port."
        raise Unavailable(f"cannot listen on {host}:{port}: {error.strerror}. {advice}") from error
    return bound


def address(bound: socket.socket, encrypts: bool = False) -> str:
    host, port = bound.getsockname()[:2]
    scheme = "https" if encrypts else "http"
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"


@final
class Announcing(uvicorn.Server):
    """Says where it listens once it does, and sends what spans it holds before it ends by the signal that it got."""

    url = ""
    send_spans: Callable[[], None]

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        print(f"exogauge serves on {self.url}", flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await super().shutdown(sockets)
        self.send_spans()


def serve(settings: Settings, worker_command: Sequence[str] = WORKER, *, with_parent: bool = False) -> None:
    """Serve until SIGINT or SIGTERM, or until stdin ends (`with_parent`); the workers leave with the server."""
    refuse_open_house(settings)  # whoever calls this
    if with_parent:
        leave_with_parent(lambda: os.kill(os.getpid(), signal.SIGTERM))
    send_spans = tracing.send_spans("server")
    prepare(settings)
    with listening(settings.host, settings.port) as bound:
        tempfile.tempdir = str(own_folder(settings.scratch).path)  # swept where this process is killed
        supervisor = Supervisor(worker_command, settings.workers)
        app, url = create_app(settings), address(bound, settings.encrypts)
        refuse_forgotten_accounts(settings, app.state.accounts)
        if app.state.accounts and not has_accounts(app.state.installation):
            say_set_up_code(settings, url)
        config = uvicorn.Config(
            app,
            http=connection_within(Limits(settings.max_connections, settings.silence_s)),
            ws="websockets-sansio",
            ws_max_size=MOST_OF_A_MESSAGE,
            ws_per_message_deflate=False,
            ws_ping_interval=5.0,  # a line that broke without a word is free for its sender before a stream ends
            ws_ping_timeout=10.0,
            log_level="warning",
            access_log=False,
            root_path=settings.root_path,
            proxy_headers=bool(settings.proxy),  # whoever else says so is not believed
            forwarded_allow_ips=settings.proxy or [],
            ssl_certfile=settings.tls_certificate,
            ssl_keyfile=settings.tls_key,
            timeout_graceful_shutdown=PATIENCE_S,
        )
        server = Announcing(config)
        server.url, server.send_spans = url, send_spans
        supervisor.start()
        try:
            server.run(sockets=[bound])
        except KeyboardInterrupt:
            logging.getLogger(__name__).info("stopped")
        finally:
            supervisor.stop()
