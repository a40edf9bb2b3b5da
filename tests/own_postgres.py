"""A PostgreSQL server of a test's own, which may be stopped and started again."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import final

import pytest

BINARIES = ("/usr/lib/postgresql/*/bin", "/usr/local/pgsql/bin", "/opt/homebrew/bin")
HERE = "127.0.0.1"


@final
class Server:
    """On a free port; addresses: where it listens. It refuses to run as root, so root starts it as `postgres`."""

    def __init__(self, folder: Path, addresses: Sequence[str] = (HERE,)) -> None:
        initdb, pg_ctl = binary("initdb"), binary("pg_ctl")
        if initdb is None or pg_ctl is None:
            pytest.skip("no PostgreSQL can be started")
        run_as: list[str] = []
        if os.getuid() == 0:
            if shutil.which("runuser") is None:
                pytest.skip("PostgreSQL does not run as root, and there is no runuser")
            run_as = ["runuser", "-u", "postgres", "--"]
            shutil.chown(folder, "postgres")
        with socket.socket() as free:
            free.bind((HERE, 0))
            self.port: int = free.getsockname()[1]
        self._data = folder / "data"
        self._control = [*run_as, pg_ctl, "-D", str(self._data), "-w"]
        listening = f"-p {self.port} -k {folder} -c listen_addresses={','.join(addresses)} -c fsync=off"
        self._start = ["-l", str(folder / "log"), "-o", listening, "start"]
        made = [*run_as, initdb, "-D", str(self._data), "-A", "trust", "-U", "postgres", "--no-sync"]
        try:
            subprocess.run(made, check=True, capture_output=True)
            if len(addresses) > 1:
                with (self._data / "pg_hba.conf").open("a") as allowed:
                    allowed.write("host all all samenet trust\n")
            self.start()
        except (subprocess.CalledProcessError, OSError) as error:
            pytest.skip(f"no PostgreSQL could be started: {error}")

    def url(self, address: str = HERE) -> str:
        return f"postgresql://postgres@{address}:{self.port}/postgres"

    def start(self) -> None:
        subprocess.run([*self._control, *self._start], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def stop(self) -> None:
        """At once, as a crash would."""
        subprocess.run([*self._control, "-m", "immediate", "stop"], check=False, capture_output=True)


@contextmanager
def own_server(folder: Path, addresses: Sequence[str] = (HERE,)) -> Iterator[Server]:
    server = Server(folder, addresses)
    yield server
    server.stop()


def binary(name: str) -> str | None:
    found = shutil.which(name)
    if found:
        return found
    places = (path for pattern in BINARIES for path in sorted(Path("/").glob(f"{pattern[1:]}/{name}")))
    return next((str(path) for path in places), None)
