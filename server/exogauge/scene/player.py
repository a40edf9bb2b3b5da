"""The page that shows scenes: viser's own client, with `player.js` before it and nothing that it could ask for."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

FORMAT = 1  # of the files that player.js reads
# The client unpacks itself (eval, WebAssembly) and draws; it reaches no server, not even ours. `sandbox` gives it an
# origin of its own also where it is opened without a frame.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:; worker-src 'none'; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'; sandbox allow-scripts"
)
# The client's panels and notices speak of a live server, and there is none.
STYLE = ".mantine-Paper-root, .mantine-Notifications-root { display: none !important }"


@cache
def player_page() -> bytes:
    """The HTML. viser itself is not imported: only its client is served."""
    found = find_spec("viser")
    assert found is not None  # it is a dependency
    assert found.origin is not None
    client = Path(found.origin).parent / "client" / "build" / "index.html"
    script = Path(__file__).with_name("player.js").read_text(encoding="utf-8")
    before, head, after = client.read_text(encoding="utf-8").partition("<head>")
    return f"{before}{head}<script>{script}</script><style>{STYLE}</style>{after}".encode()


@cache
def made_for() -> str:
    """What a scene must have been made for to be shown: it goes into the key under which scenes are kept."""
    return f"{FORMAT} {version('viser')}"
