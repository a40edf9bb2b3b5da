"""A reverse proxy that serves another server below a path, as a lab's front door does, and may ask who comes in."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, quote, urlsplit

HOP = {"connection", "keep-alive", "transfer-encoding", "upgrade", "host", "content-length"}
SIGN_IN = "/sign-in"
PAGE = '<!doctype html><html lang="en"><title>The lab</title><h1>The lab</h1><a href="{done}">Sign in</a></html>'


@dataclass
class Guard:
    """Lets in who holds a session; to all others it says `says`: 401 or 403 with a page, or 302 to its sign-in page."""

    says: int
    session: str = field(default_factory=secrets.token_hex)

    def expire(self) -> None:
        """End the session of everybody."""
        self.session = secrets.token_hex()


@contextmanager
def serve_below(url: str, prefix: str, guard: Guard | None = None) -> Iterator[str]:
    """The address at which `url` is to be found below `prefix`, until the context ends; all else is 404."""
    target = urlsplit(url)

    class Front(BaseHTTPRequestHandler):
        def answer(self) -> None:
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            if guard and self.path.startswith(SIGN_IN):
                self.sign_in(guard)
            elif guard and f"session={guard.session}" not in self.headers.get("Cookie", ""):
                self.stop(guard)
            elif self.path.startswith(f"{prefix}/"):
                self.pass_on(body)
            else:
                self.send_error(404)

        def sign_in(self, guard: Guard) -> None:
            """The page with its link, or after that where it was asked for."""
            asked = urlsplit(self.path)
            back = parse_qs(asked.query)["back"][0]
            if asked.path == SIGN_IN:
                self.say(200, PAGE.format(done=f"{SIGN_IN}/done?back={quote(back)}"))
            else:
                self.say(302, "", {"Location": back, "Set-Cookie": f"session={guard.session}; Path=/"})

        def stop(self, guard: Guard) -> None:
            back = f"back={quote(self.path)}"
            if guard.says == 302:
                self.say(302, "", {"Location": f"{SIGN_IN}?{back}"})
            else:
                self.say(guard.says, PAGE.format(done=f"{SIGN_IN}/done?{back}"))

        def pass_on(self, body: bytes) -> None:
            headers = {name: value for name, value in self.headers.items() if name.lower() not in HOP}
            behind = HTTPConnection(target.hostname or "", target.port, timeout=60)
            with closing(behind):
                behind.request(self.command, self.path[len(prefix) :], body, headers | {"Host": self.headers["Host"]})
                answer = behind.getresponse()
                content = answer.read()
            headers = {name: value for name, value in answer.getheaders() if name.lower() not in HOP}
            self.say(answer.status, content, headers)

        def say(self, status: int, content: str | bytes, headers: dict[str, str] | None = None) -> None:
            content = content.encode() if isinstance(content, str) else content
            self.send_response(status)
            for name, value in (headers or {"Content-Type": "text/html"}).items():
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            with suppress(BrokenPipeError, ConnectionResetError):  # the browser may have left
                self.wfile.write(content)

        do_GET = do_POST = do_PUT = do_PATCH = do_HEAD = do_DELETE = do_OPTIONS = answer

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Front)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}{prefix}"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
