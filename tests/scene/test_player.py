"""The page that plays: viser's client, our script before it, and nowhere to go."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path

from exogauge.scene.stage import POLICY, player_page

CLIENT = Path(str(find_spec("viser").origin)).parent / "client"  # type: ignore[union-attr]


def test_our_script_runs_before_any_of_the_clients() -> None:
    page = player_page().decode()
    assert page.index("window.Worker = Feed") < page.index("<script", page.index("window.Worker = Feed"))
    assert page.index("<script>") < page.index("window.Worker = Feed")
    assert page.count("<head>") == 1


def test_the_page_names_no_address_to_load_from() -> None:
    page = player_page().decode()
    assert re.findall(r"(?:src|href)\s*=\s*[\"']?(?!data:)[a-z]*:?//[^\"' >]+", page) == []
    assert "importmap" not in page


def test_the_policy_lets_it_reach_nobody_and_be_framed_by_us_alone() -> None:
    rules = {rule.split()[0]: rule.split()[1:] for rule in POLICY.split(";")}
    assert rules["connect-src"] == ["data:", "blob:"]
    assert rules["default-src"] == rules["form-action"] == rules["base-uri"] == rules["worker-src"] == ["'none'"]
    assert rules["frame-ancestors"] == ["'self'"]
    assert rules["sandbox"] == ["allow-scripts"]
    assert not any(source.startswith(("http", "ws", "*")) for sources in rules.values() for source in sources)


def test_the_client_still_speaks_as_our_script_expects() -> None:
    """player.js stands in for this worker: what it takes and gives is read in the client's own source."""
    worker = (CLIENT / "src" / "WebsocketClientWorker.ts").read_text()
    interface = (CLIENT / "src" / "WebsocketInterface.tsx").read_text()
    for said in ('{ type: "send"; message: Message }', '{ type: "set_server"; server: string }'):
        assert said in worker
    for heard in (
        'data.type === "connected"',
        'data.type === "message_batch"',
        "enqueueMessages(viewerMutable, data.m",
    ):
        assert heard in interface
    assert "new WebsocketClientWorker()" in interface
    assert "worker.onmessage = " in interface
    messages = (CLIENT / "src" / "WebsocketMessages.ts").read_text()
    script = Path(str(find_spec("exogauge.scene").origin)).with_name("player.js").read_text()  # type: ignore[union-attr]
    for name in sorted(set(re.findall(r'"(\w+Message)"', script))):
        assert f'type: "{name}"' in messages
