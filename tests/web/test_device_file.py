"""device.yaml as the page reads and writes it: what was not changed stays as it was."""

from __future__ import annotations

from typing import Any

import yaml
from tests.web.page_code import by_the_page

FILE = """# written by hand
version: 1
name: Suit
bands:
  - {name: left, group: back, via_points: [{link: a, xyz: [0, 0, 0]}, {link: b, xyz: [0, 0, 1]}]}
"""
RECORD = "record: {model: SSL-2, serial: 0042, size: 1.10, straps: third hole}  # the specimen\n"


def read(text: str) -> dict[str, Any]:
    (found,) = by_the_page("pages/device/deviceFile.ts", [("readDevice", [text])])
    assert isinstance(found, dict)
    return found


def written(text: str, content: dict[str, Any]) -> str:
    (found,) = by_the_page("pages/device/deviceFile.ts", [("writeDevice", [text, content])])
    return str(found)


def test_the_record_of_the_specimen_is_kept_when_something_else_changes() -> None:
    content = read(FILE + RECORD)
    text = written(FILE + RECORD, content | {"name": "Suit 2"})
    assert yaml.safe_load(text)["record"] == {
        "model": "SSL-2", "serial": "0042", "size": "1.10", "straps": "third hole",
    }  # fmt: skip
    assert text.startswith("# written by hand")
    assert "# the specimen" in text


def test_a_record_is_added_changed_and_taken_away() -> None:
    content = read(FILE)
    assert content["record"] == {}
    said = written(FILE, content | {"record": {"serial": "0042", "garment": "cotton: thin"}})
    assert yaml.safe_load(said)["record"] == {"serial": "0042", "garment": "cotton: thin"}
    assert read(said)["record"] == {"serial": "0042", "garment": "cotton: thin"}
    assert "record" not in yaml.safe_load(written(said, content))
