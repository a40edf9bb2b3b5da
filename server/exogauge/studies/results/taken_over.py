"""device.yaml with what a result has named of its bands: laws and their values, stiffness, natural length.

What it states afterwards is what the search has found, so that evaluating the logs with it leaves nothing of that, and
what-if can ask it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import yaml

from exogauge.effects.band import BandEffect
from exogauge.effects.band_laws import AND, LINEAR
from exogauge.effects.catalogue import band_effects
from exogauge.errors import BadInput, Fault
from exogauge.studies.words.rounding import with_std

TAKEN_OVER = "taken_over_*.yaml"
DIGITS = 8  # of a number in the file
SPRING = {"stiffness_n_per_m": "stiffness", "natural_length_m": "natural length"}
STATED = {"band_stiffness": "stiffness_n_per_m", "band_length": "natural_length_m"}


@final
@dataclass(frozen=True)
class TakenOver:
    """content: of the new device.yaml. ranks: of the findings that it holds. said: what was written, with unit and
    standard deviation; left: what cannot be written, and why."""

    content: Mapping[str, Any]
    ranks: tuple[int, ...]
    said: tuple[str, ...]
    left: tuple[str, ...]

    def text(self, source: str) -> str:
        """As a file. source: where the numbers come from, in words."""
        lines = [f"Taken over from {source}; ± is one standard deviation.", *self.said]
        lines += [f"Not taken over: {each}" for each in self.left]
        written = yaml.safe_dump(
            dict(self.content), sort_keys=False, allow_unicode=True, default_flow_style=None, width=120
        )
        return "".join(f"# {line}\n" for line in lines) + written


def taken_over(
    content: Mapping[str, Any], findings: Sequence[Mapping[str, Any]], stiffness: Sequence[Mapping[str, Any]]
) -> TakenOver:
    """content: of a device.yaml. findings, stiffness: of results.json.

    A band of which something was named has the springs beside it in `stiffness[]`, by A where there is one, and leaves
    its group unless all bands of that are told alike: bands of a group share stiffness and law.
    """
    bands = {band["name"]: dict(band) for band in content["bands"]}
    own = [each for each in findings if _names(each, content["name"]) in bands]
    said, left, ranks, touched = list[str](), list[str](), list[int](), dict[str, list[str]]()
    for finding in own:
        name = _names(finding, content["name"])
        why = _write(bands[name], finding)
        if why:
            left.append(f"{name}: {finding.get('title', finding['effect'])}, {why}.")
            continue
        ranks.append(finding["rank"])
        touched.setdefault(name, []).extend(_told(each, *one) for each, one in _parameters(finding).items())
    for name, told in touched.items():
        springs = _springs(name, content["name"], stiffness)
        for key, words in SPRING.items():
            value, std, unit = springs.get(key, (None, None, ""))
            if value is not None:
                bands[name][key] = float(f"{value:.{DIGITS}g}")
                told.append(_told(words, value, std, unit))
        bands[name].pop("ground_truth", None)
        said.append(f"{name}: {'; '.join(dict.fromkeys(told))}.")
    for group in _broken(bands, content.get("tied", [])):
        for band in [each for each in bands.values() if _group(each) == group and each["name"] in touched]:
            band["group"] = band["name"]
            said.append(f"{band['name']}: a group of its own, no longer {group}.")
    kept = {key: value for key, value in content.items() if key != "tied"}
    groups = {_group(band) for band in bands.values()}
    tied = [each for each in content.get("tied", []) if each in groups]
    written = {**kept, "bands": list(bands.values())} | ({"tied": tied} if tied else {})
    return TakenOver(written, tuple(ranks), tuple(said), tuple(left))


def taken_over_of(results: Mapping[str, Any], device: Mapping[str, Any]) -> TakenOver:
    """results: content of results.json. device: of a device.yaml. Raises BadInput where nothing can be written."""
    taken = taken_over(device, (results.get("discrepancy") or {}).get("findings", []), results.get("stiffness", []))
    if not taken.ranks:
        raise nothing_named(device["name"], taken.left)
    return taken


def nothing_named(device: str, left: Sequence[str]) -> BadInput:
    detail = f"nothing was named of the bands of {device!r} that its file can hold"
    advice = " ".join(left) or "Give the device.yaml that the logs of this result were worn with."
    return BadInput(Fault(detail, "nothing_to_take_over", advice, column="name", value=device))


def _names(finding: Mapping[str, Any], device: str) -> str:
    """The band that it is about; "" of another device."""
    return str(finding["where"].get("band", "")) if finding.get("device", device) == device else ""


def _write(band: dict[str, Any], finding: Mapping[str, Any]) -> str:
    """Into the entry of the band; why not, or "". Stiffness and natural length follow for all of them."""
    effect, found = band_effects()[finding["effect"]], _parameters(finding)
    if effect.name in STATED:
        return ""
    if not effect.law:
        return "it happens at one moment of the logs" if effect.once else "where it runs is not known well enough"
    names = {each.name for each in effect.coefficients} | {each.name for each in effect.shapes}
    values = {name: found[name][0] for name in sorted(names) if name in found}
    missing = names - set(values)
    if missing:
        return f"these logs do not decide its {', '.join(sorted(missing))}"
    law, stated = band.get("law", LINEAR), dict(band.get("law_values", {}))
    laws = [] if law == LINEAR else [part.strip() for part in law.split(AND)]
    if effect.law in laws:
        return _added(effect, band, stated, values)
    band["law"] = AND.join([*laws, effect.law])
    band["law_values"] = stated | {name: float(f"{value:.{DIGITS}g}") for name, value in values.items()}
    return ""


def _added(effect: BandEffect, band: dict[str, Any], stated: dict[str, float], values: Mapping[str, float]) -> str:
    """To the same law: sizes add where the shapes are the same."""
    sizes = {each.name for each in effect.coefficients}
    for shape in effect.shapes:
        default = effect.stated[shape.name].default
        if shape.name not in sizes and abs(stated.get(shape.name, default or 0.0) - values[shape.name]) > 1e-9:
            return f"the file states this law with another {shape.name}, and two of one law cannot be stated"
    band["law_values"] = stated | {name: stated.get(name, 0.0) + values[name] for name in sizes}
    return ""


def _springs(
    name: str, device: str, stiffness: Sequence[Mapping[str, Any]]
) -> dict[str, tuple[float | None, float | None, str]]:
    """By A where there is one."""
    own = {each["approach"]: each for each in stiffness if (each["device"], each["band"]) == (device, name)}
    chosen = own.get("A") or own.get("B")
    return {} if chosen is None else {key: _number(chosen[key]) for key in SPRING}


def _parameters(finding: Mapping[str, Any]) -> dict[str, tuple[float, float | None, str]]:
    found = {name: _number(each) for name, each in finding["parameters"].items()}
    return {name: (each[0], *each[1:]) for name, each in found.items() if each[0] is not None}


def _number(found: Mapping[str, Any]) -> tuple[Any, float | None, str]:
    return found["value"], found["std"], found["unit"]


def _told(name: str, value: float, std: float | None, unit: str) -> str:
    number = " ± ".join(with_std(value, std)) if std else f"{value:.6g}"
    return f"{name.replace('_', ' ')} {number}{'' if unit == '1' else f' {unit}'}"


def _broken(bands: Mapping[str, Mapping[str, Any]], tied: Sequence[str]) -> list[str]:
    """Groups whose bands no longer share what bands of a group share."""
    broken = []
    for group in dict.fromkeys(map(_group, bands.values())):
        own = [band for band in bands.values() if _group(band) == group]
        shared = {
            (band.get("stiffness_n_per_m"), band.get("law", LINEAR), tuple(sorted(band.get("law_values", {}).items())))
            for band in own
        }
        lengths = {band.get("natural_length_m") for band in own} if group in tied else set()
        if len(shared) > 1 or len(lengths) > 1:
            broken.append(group)
    return broken


def _group(band: Mapping[str, Any]) -> str:
    return str(band.get("group") or band["name"])
