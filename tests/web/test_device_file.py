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


HYSTERESIS = {
    "name": "hysteresis",
    "sentence": "",
    "values": [
        {"name": "hysteresis", "unit": "1", "words": "", "typical": 0.1, "low": 0, "high": 1, "default": None},
        {"name": "thread_way", "unit": "m", "words": "", "typical": 0.002, "low": 1e-6, "high": 1, "default": 0.001},
    ],
}
DAMPED = {
    "name": "kelvin_voigt",
    "sentence": "",
    "values": [
        {"name": "damping", "unit": "N·s/m", "words": "", "typical": 5, "low": 0, "high": None, "default": None},
    ],
}


def changed(name: str, *given: Any) -> dict[str, Any]:
    (found,) = by_the_page("pages/device/edits.ts", [(name, given)])
    assert isinstance(found, dict)
    return found


def test_a_law_is_chosen_for_a_group_with_values_to_begin_with_and_taken_back() -> None:
    twin = FILE + "  - {name: right, group: back, via_points: [{link: a, xyz: [0, 1, 0]}, {link: b, xyz: [0, 1, 1]}]}\n"
    content = read(twin)
    both = changed("withLaw", content, "back", [HYSTERESIS, DAMPED])
    text = written(twin, both)
    for band in yaml.safe_load(text)["bands"]:
        assert band["law"] == "hysteresis+kelvin_voigt"
        assert band["law_values"] == {"hysteresis": 0.1, "thread_way": 0.001, "damping": 5}
    assert text.startswith("# written by hand")
    other = changed("withLawValue", read(text), "back", "damping", 7.5)
    again = written(text, other)
    assert [band["law_values"]["damping"] for band in yaml.safe_load(again)["bands"]] == [7.5, 7.5]
    one = changed("withLaw", read(again), "back", [DAMPED])
    assert yaml.safe_load(written(again, one))["bands"][0]["law_values"] == {"damping": 7.5}  # as it was set
    none = yaml.safe_load(written(again, changed("withLaw", read(again), "back", [])))
    assert none == yaml.safe_load(twin)
