"""Changes of a device as words on a command line: `--set A.stiffness=300`, `--move A_left.3=0,0,0.01`.

    --set     A.stiffness=300 · A_left.natural_length=0.6 · A.pretension=0.02 · A.law=NAME,KEY=VALUE …
              A_left.3=0.1,0,0.2 · A_left.3=chest · A_left.3=chest:0.1,0,0.2        (a via point's place, link, or both)
    --scale   A.stiffness=2 · A_left.natural_length=0.95
    --move    A_left.3=0,0,0.01 · A_left.natural_length=-0.02                       (add to what it is)
    --add     A_left.3=chest:0.1,0,0.2                                              (a new via point number 3)
    --remove  A_left.3 · A_left · A                                                 (a via point, a band, a group)
    --copy    A_left=A_left_2        --mirror  A_left=A_right

What is left of the last dot is a band, a group, or * for all bands; numbers are SI; via points count from 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from exogauge.errors import BadInput, Fault
from exogauge.studies.device_pages.change_entries import ChangeEntry
from exogauge.studies.intake.yaml_file import suggestion

KEYS = ("stiffness", "natural_length", "pretension", "law")
ENTRY: TypeAdapter[ChangeEntry] = TypeAdapter(ChangeEntry)

Entry = dict[str, Any]


def read_change(option: str, text: str) -> ChangeEntry:
    """The change that `--option text` asks for. Raises BadInput that names both."""
    place = f"--{option} {text}"
    try:
        entry = READERS[option](text)
    except ValueError as problem:
        detail = str(problem)
        raise BadInput(Fault(detail, "not_a_change", f"For example: {EXAMPLES[option]}", column=place)) from None
    try:
        return ENTRY.validate_python(entry)
    except ValidationError as invalid:
        found = invalid.errors(include_url=False)
        raise BadInput([Fault(_said(dict(item)), item["type"], column=place) for item in found]) from None


def _set(text: str) -> Entry:
    of, key, value = _parts(text)
    if key.isdecimal():
        link, xyz = _place(value)
        kept = {"xyz": xyz, "link": link}
        return {"change": "place_point", "band": of, "point": int(key)} | {k: v for k, v in kept.items() if v}
    if key == "law":
        name, *given = value.split(",")
        pairs = (pair.partition("=") for pair in given)
        return {"change": "law", "of": of, "law": name, "values": {each: _number(number) for each, _, number in pairs}}
    return {"change": _known(key, KEYS), "of": of, "to": _number(value)}


def _scale(text: str) -> Entry:
    of, key, value = _parts(text)
    return {"change": _known(key, KEYS[:2]), "of": of, "times": _number(value)}


def _move(text: str) -> Entry:
    of, key, value = _parts(text)
    if key.isdecimal():
        return {"change": "move_point", "band": of, "point": int(key), "by": _vector(value)}
    return {"change": _known(key, KEYS[1:2]), "of": of, "by": _number(value)}


def _add(text: str) -> Entry:
    of, key, value = _parts(text)
    link, xyz = _place(value)
    if not key.isdecimal() or not link or xyz is None:
        raise ValueError("a new via point needs its number, its link and its place")
    return {"change": "add_point", "band": of, "at": int(key), "link": link, "xyz": xyz}


def _remove(text: str) -> Entry:
    band, dot, number = text.rpartition(".")
    if dot and number.isdecimal():
        return {"change": "remove_point", "band": band, "point": int(number)}
    return {"change": "remove_band", "of": text}


def _copy(text: str) -> Entry:
    return {"change": "copy_band", **_two_names(text)}


def _mirror(text: str) -> Entry:
    return {"change": "mirror_band", **_two_names(text)}


READERS: Mapping[str, Callable[[str], Entry]] = {
    "set": _set,
    "scale": _scale,
    "move": _move,
    "add": _add,
    "remove": _remove,
    "copy": _copy,
    "mirror": _mirror,
}
EXAMPLES = {
    "set": "--set A.stiffness=300, --set A_left.natural_length=0.6, --set A_left.3=chest:0.1,0,0.2",
    "scale": "--scale A.stiffness=2",
    "move": "--move A_left.3=0,0,0.01",
    "add": "--add A_left.3=chest:0.1,0,0.2",
    "remove": "--remove A_left, --remove A_left.3",
    "copy": "--copy A_left=A_left_2",
    "mirror": "--mirror A_left=A_right",
}


def _parts(text: str) -> tuple[str, str, str]:
    """`A_left.3=0,0,1` -> A_left, 3, 0,0,1"""
    what, equals, value = text.partition("=")
    of, dot, key = what.rpartition(".")
    if not (equals and dot and of and key and value):
        raise ValueError("expected BAND.WHAT=VALUE")
    return of, key, value


def _two_names(text: str) -> Entry:
    band, equals, name = text.partition("=")
    if not (band and equals and name):
        raise ValueError("expected BAND=NEW_NAME")
    return {"band": band, "name": name}


def _known(key: str, keys: tuple[str, ...]) -> str:
    if key not in keys:
        raise ValueError(
            f"{key!r} is no number of a via point and none of {', '.join(keys)}. {suggestion(key, keys)}".strip()
        )
    return key


def _place(text: str) -> tuple[str | None, list[float] | None]:
    """(link, xyz) of `chest:0.1,0,0.2`, `chest` or `0.1,0,0.2`."""
    link, colon, xyz = text.rpartition(":")
    if colon:
        return link, _vector(xyz)
    try:
        return None, _vector(text)
    except ValueError:
        if "," in text:
            raise
        return text, None


def _vector(text: str) -> list[float]:
    numbers = [_number(each) for each in text.split(",")]
    if len(numbers) != 3:
        raise ValueError(f"expected three numbers x,y,z in metres, not {text!r}")
    return numbers


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"expected a number, not {text!r}") from None


def _said(item: dict[str, Any]) -> str:
    key = str(item["loc"][-1]) if item["loc"] else ""
    return f"{key}: {str(item['msg']).removeprefix('Value error, ')}" if key else str(item["msg"])
