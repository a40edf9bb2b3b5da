"""viser's scene functions without a server: what they would send is kept, and packed with what moves into one file.

The page that shows it is viser's own client, with `player.js` before it and nothing that it could ask for.
"""

from __future__ import annotations

import asyncio
import gzip
import json
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, final

import numpy as np
import viser
from numpy.typing import NDArray
from viser.infra import Message

Values = NDArray[np.float32] | NDArray[np.uint8]
Kind = Literal["turn", "place", "visible", "points", "colors", "arc"]

KEPT_BITS = 16  # of a float's mantissa: 1 part in 65536, a file half as large
SPEED = 6  # of gzip


@final
class _Sink:
    """What viser takes for a connection; nothing is ever received."""

    def __init__(self) -> None:
        self.messages: list[Message] = []

    def queue_message(self, message: Message) -> None:
        self.messages.append(message)

    def register_handler(self, message_cls: object, callback: object) -> None:
        """Nobody answers a file."""


@final
class _NoServer:
    """What viser takes for a client of a server."""

    client_id = ""

    def __init__(self, sink: _Sink) -> None:
        self._websock_connection = sink
        self._viser_server = self
        self._scene_lifecycle_lock = threading.RLock()


@final
@dataclass(frozen=True)
class Track:
    """One property of one node, frame by frame.

    values: (F, width), or (1, width) where it never changes. kind: turn (wxyz), place (xyz [m]), visible (0 or 1),
    points, colors, or arc: the angle [rad] of an arrow bent round the node's z axis with `radius` [m].
    """

    kind: Kind
    name: str
    values: Values
    radius: float | None = None


@final
@dataclass
class Stage:
    """scene: viser's functions (`add_box` …). tracks: what moves. layers: name -> nodes that are shown together.
    hidden: layers that are not shown before somebody asks for them; their nodes are added invisible.

    >>> stage = Stage.empty()
    >>> _ = stage.scene.add_icosphere("/ball", 0.1)
    """

    scene: viser.SceneApi
    _sink: _Sink
    tracks: list[Track] = field(default_factory=list)
    layers: dict[str, list[str]] = field(default_factory=dict)
    camera: dict[str, list[float]] = field(default_factory=dict)
    hidden: list[str] = field(default_factory=list)

    @classmethod
    def empty(cls) -> Stage:
        sink = _Sink()
        loop = asyncio.new_event_loop()
        loop.close()  # callbacks would need it, and there are none
        return cls(viser.SceneApi(_NoServer(sink), ThreadPoolExecutor(1), loop), sink)

    def move(self, kind: Kind, name: str, values: Values, radius: float | None = None) -> None:
        """Let a property follow `values` (F, …). What never changes is said once."""
        flat = values.reshape(len(values), -1)
        same = bool((flat == flat[0]).all())
        self.tracks.append(Track(kind, name, flat[:1] if same else flat, radius))

    def look(self, place: NDArray[np.float64], at: NDArray[np.float64]) -> None:
        """Where the camera begins, and what it looks at [m]."""
        self.camera = {"position": place.tolist(), "look_at": at.tolist()}

    def packed(self, about: Mapping[str, Any]) -> bytes:
        """gzip of: 8 bytes with the header's length, the header as JSON, arrays; each at a multiple of 8 bytes.

        about: what the header says beside the scene (start, end, fps, frames …).
        """
        arrays = _Arrays()
        header = {
            "version": FORMAT,
            "viser": viser.__version__,
            **about,
            "camera": self.camera,
            "layers": self.layers,
            "hidden": self.hidden,
            "messages": [arrays.plain(message) for message in self._sink.messages],
            "tracks": [
                {
                    "kind": track.kind,
                    "name": track.name,
                    "radius": track.radius,
                    "width": track.values.shape[1],
                    "values": arrays.add(shortened(track.values)),
                }
                for track in self.tracks
            ],
        }
        text = json.dumps(header, allow_nan=False).encode()
        text += b" " * (-len(text) % 8)
        return gzip.compress(len(text).to_bytes(8, "little") + text + arrays.joined(), SPEED, mtime=0)


@final
class _Arrays:
    """Arrays one after another, each begun at a multiple of 8 bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: NDArray[Any]) -> dict[str, Any]:
        """Where it is, as the player reads it."""
        data = np.ascontiguousarray(values)
        place = {"dtype": data.dtype.str, "offset": self._size, "length": data.size}
        raw = data.tobytes()
        raw += b"\0" * (-len(raw) % 8)
        self._parts.append(raw)
        self._size += len(raw)
        return place

    def plain(self, message: Message) -> dict[str, Any]:
        buffers: list[memoryview] = []
        said = message.as_serializable_dict(buffers)
        return dict(self._filled(said, buffers))

    def _filled(self, value: Any, buffers: list[memoryview]) -> Any:
        if isinstance(value, dict) and "__binary_index" in value:
            values = np.frombuffer(buffers[value["__binary_index"]], dtype=value["dtype"])
            return {"__array": self.add(values)}
        if isinstance(value, dict):
            return {key: self._filled(each, buffers) for key, each in value.items()}
        if isinstance(value, tuple | list):
            return [self._filled(each, buffers) for each in value]
        return value

    def joined(self) -> bytes:
        return b"".join(self._parts)


def shortened(values: Values) -> Values:
    """Floats rounded to `KEPT_BITS` of their mantissa, so that they pack well."""
    if values.dtype != np.float32:
        return values
    drop = 23 - KEPT_BITS
    bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    rounded = (bits + np.uint32(1 << (drop - 1))) & np.uint32(0xFFFFFFFF ^ ((1 << drop) - 1))
    short: NDArray[np.float32] = rounded.view(np.float32)
    return short


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
