"""The configuration record of the one-page report: what `configuration` in results.json holds, told in lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from exogauge.studies.report.page_model import plain
from exogauge.studies.words.names import counted, listed
from exogauge.studies.words.notices import repeats
from exogauge.studies.words.rounding import significant

HASH = 8  # digits of a SHA-256 shown
WORDS = {"recorded": "date of recording", "robot_cover": "robot cover"}
PACKAGES = {"pin": "pinocchio (pin)"}
ROLES = {
    "identification": "fitted",
    "validation": "validation",
    "without_device": "without wear",
    "with_device": "with wear",
}
Fact = tuple[str, str]


def configuration_facts(results: Mapping[str, Any], name: int, devices: int) -> Iterator[Fact]:
    """name: characters of a name at most; devices: told one by one at most."""
    found = results["configuration"]
    yield "Robot", _robot(found["robot"], name)
    for wear in found["devices"][:devices]:
        yield plain(wear["device"], name), _wear(wear, name)
    rest = len(found["devices"]) - devices
    if rest > 0:
        yield "Other wears", f"{rest} more in results.json"
    yield "Conditions", _told(found["conditions"], 2 * name)
    yield "Logs", _logs(found["logs"])


def _robot(robot: Mapping[str, Any], name: int) -> str:
    kinds = [joint["actuation"] for joint in robot["joints"]]
    words = {"current": "with logged current", "torque": "with logged torque", "none": "with neither"}
    joints = [f"{kinds.count(kind)} {text}" for kind, text in words.items() if kind in kinds]
    sensors = f", {counted(len(robot['sensors']), 'force/torque sensor')}" if robot["sensors"] else ""
    return (
        f"{plain(robot['name'], name)}, {robot['base']} base, {counted(robot['moving_links'], 'moving link')}, "
        f"{counted(len(kinds), 'joint')} ({listed(joints)}){sensors}"
    )


def _wear(wear: Mapping[str, Any], name: int) -> str:
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for band in wear["bands"]:
        groups.setdefault(band["group"], []).append(band)
    bands = "; ".join(_group(plain(group, name), members, name) for group, members in list(groups.items())[:4])
    more = f"; {len(groups) - 4} more groups" if len(groups) > 4 else ""
    worn = f"{wear['file']}, worn in {_names(wear['logs'], name)}"
    return f"{worn}. Stated: {bands}{more}. {_told(wear['record'], 2 * name)}"


def _group(group: str, bands: Sequence[Mapping[str, Any]], name: int) -> str:
    """`A 197.8 N/m: A_left 0.984 m over chest–waist–l_thigh, …`; true values are said to be."""
    first, stiffness = bands[0], "stiffness not stated"
    if first["stiffness_n_per_m"] is not None:
        stiffness = f"{_number(first['stiffness_n_per_m'])} N/m"
    law = "" if first["law"] == "linear" else f" ({first['law']})"
    truth = ", true values" if all(band["ground_truth"] for band in bands) else ""
    told = ", ".join(_band(band, name) for band in bands[:4]) + (f", {len(bands) - 4} more" if len(bands) > 4 else "")
    return f"{group} {stiffness}{law}{truth}: {told}"


def _band(band: Mapping[str, Any], name: int) -> str:
    length = "length not stated" if band["natural_length_m"] is None else f"{_number(band['natural_length_m'])} m"
    links = list(dict.fromkeys(plain(point["link"], name) for point in band["via_points"]))
    return f"{plain(band['band'], name)} {length}, {len(band['via_points'])} via points {'–'.join(links[:6])}"


def _told(told: Mapping[str, Any], most: int) -> str:
    """What was stated, then what was not: a gap in a record should be seen."""
    stated = [f"{WORDS.get(key, key)} {plain(str(value), most)}" for key, value in told.items() if value is not None]
    silent = [WORDS.get(key, key) for key, value in told.items() if value is None]
    parts = [f"{', '.join(stated)}."] if stated else []
    return " ".join([*parts, *([f"Not stated: {', '.join(silent)}."] if silent else [])])


def _logs(logs: Sequence[Mapping[str, Any]]) -> str:
    """`4 fitted (92 s), 2 validation …, at 200 Hz`"""
    parts = []
    for role, words in ROLES.items():
        same = [log for log in logs if log["role"] == role]
        if same:
            parts.append(f"{len(same)} {words} ({significant(sum(log['duration_s'] for log in same))} s)")
    rates = sorted({float(significant(log["rate_hz"], 4)) for log in logs})
    return f"{', '.join(parts)}, at {listed([_number(rate) for rate in rates])} Hz" if parts else "not recorded"


def provenance_facts(results: Mapping[str, Any], files: int) -> Iterator[Fact]:
    """files: hashes shown at most."""
    yield "Settings", _settings(results["configuration"]["settings"], results["settings"])
    yield (
        "Software",
        " · ".join(f"{PACKAGES.get(name, name)} {version}" for name, version in results["software"].items()),
    )
    inputs = sorted(results["inputs"], key=lambda each: each["file"].count("/"))  # what describes comes before logs
    shown = [f"{plain(each['file'], 60)} {each['sha256'][:HASH]}" for each in inputs[:files]]
    rest = f", {len(inputs) - len(shown)} more in results.json" if len(inputs) > len(shown) else ""
    digest = results["configuration"]["inputs_sha256"]
    yield f"SHA-256 of {counted(len(inputs), 'file')}", f"{', '.join(shown)}{rest}; of this list {digest}"


def _settings(used: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    cutoff = "chosen from the logs" if asked["cutoff_hz"] is None else "set"
    parts = [
        f"low-pass {significant(used['cutoff_hz'])} Hz ({cutoff})",
        f"prior {used['prior'].replace('_', ' ')} × {significant(used['prior_strength'], 2)}",
        f"consistency {used['consistency']}",
        f"solver {used['solver']}",
        f"motions doubtful from {_number(used['motion_doubtful'])}, different from {_number(used['motion_different'])}",
        f"effects {listed([str(each).replace('_', ' ') for each in used['effects']])}",
    ]
    return "; ".join(parts)


def _names(logs: Iterable[str], name: int) -> str:
    """`bend_normal_1 to _5 (5 logs)`: repeats of one motion together."""
    groups = repeats(logs)
    shown = [
        plain(same[0], name) if len(same) == 1 else f"{plain(stem, name)} ×{len(same)}"
        for stem, same in list(groups.items())[:6]
    ]
    return ", ".join(shown) + (f", {len(groups) - 6} more" if len(groups) > 6 else "") or "no log"


def _number(value: float) -> str:
    return f"{value:.6g}"
