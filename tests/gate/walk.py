"""A document as leaves: the path of every number, name and sentence in it.

An entry of a list is found by what it is called, not by where it stands: `findings[stribeck torso_pitch]`. Where two
entries are called the same they are counted, `[train #2]`, and a list of numbers is counted throughout.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

Leaf = str | float | bool | None
# What calls an entry of a list by name in results.json, the more general first.
CALLED_BY = (
    *("name", "joint", "effect", "where", "log", "logs", "channel", "channels", "step", "version", "kind"),
    *("file", "motion", "device", "suit", "band", "pair", "sensor", "rule", "parameter", "factor"),
)
SOFTWARE = "software"  # versions of the environment, which both trees share


def leaves(document: Any, path: str = "") -> dict[str, Leaf]:
    """path -> number, name, sentence, truth value or None. An empty mapping is a leaf `{}`, an empty list one of its
    length; a list of names is one leaf."""
    return dict(_leaves(document, path))


def _leaves(value: Any, path: str) -> Iterator[tuple[str, Leaf]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if key != SOFTWARE:
                yield from _leaves(inner, f"{path}.{key}" if path else str(key))
        if not value:
            yield path, "{}"
    elif isinstance(value, list):
        yield from _entries(value, path)
    else:
        yield path, value


def _entries(entries: Sequence[Any], path: str) -> Iterator[tuple[str, Leaf]]:
    """Their number, every entry, and their order where they have names."""
    yield f"{path}[length]", len(entries)
    if not entries:
        return
    if all(isinstance(entry, str) and not is_sentence(entry) for entry in entries):
        yield path, ",".join(entries)
    elif all(isinstance(entry, Mapping) for entry in entries):
        names = _unique([_name(entry) for entry in entries])
        for name, entry in zip(names, entries, strict=True):
            yield from _leaves(entry, f"{path}[{name}]")
        yield f"{path}[order]", ", ".join(names)
    else:
        for k, entry in enumerate(entries):
            yield from _leaves(entry, f"{path}[{k}]")


def _name(entry: Mapping[str, Any]) -> str:
    return " ".join(word for key in CALLED_BY if key in entry for word in _words(entry[key]))


def _words(value: Any) -> list[str]:
    if isinstance(value, Mapping):
        return [word for inner in value.values() for word in _words(inner)]
    if isinstance(value, list):
        return [word for inner in value for word in _words(inner)]
    return [] if value in (None, "") else [str(value)]


def _unique(names: Sequence[str]) -> list[str]:
    """The second of a name is `name #2`; one without a name is its number."""
    met: Counter[str] = Counter()
    found = []
    for name in names:
        met[name] += 1
        found.append(f"{name} #{met[name]}".strip() if met[name] > 1 or not name else name)
    return found


def is_sentence(leaf: Leaf) -> bool:
    """What a person reads, with numbers rounded in it; a name has no space."""
    return isinstance(leaf, str) and " " in leaf
