"""results.json as text for a terminal: what improved, some of what was found, and what could not be told."""

from __future__ import annotations

import math
import textwrap
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from exogauge.discrepancy_text import discrepancy_text, lead_text
from exogauge.studies.words.notices import notice, repeats
from exogauge.studies.words.rounding import significant, with_std
from exogauge.support_text import stiffness_text, support_text
from exogauge.terminal import text_table

MOMENTS = ("base.mx", "base.my", "base.mz")
TRUNK = ("torso", "waist", "chest", "lumbar", "trunk")
SHOWN_JOINTS = 2
SHOWN_NAMES = 3
WIDTH = 100
JOINT_WORDS = {
    "k_T": "torque constant k_T",
    "k_d": "viscous friction k_d",
    "tau_c": "Coulomb friction tau_c",
    "tau_s": "static friction tau_s",
    "tau_o": "offset tau_o",
    "J_r": "rotor inertia J_r",
}
SORTS = {
    "single": "inertial parameters of single links",
    "base": "combinations of them",
    "zero": "zeros of force/torque sensors",
}


def result_text(result: Mapping[str, Any]) -> str:
    """The whole of it, in parts with a heading each."""
    found = result["identification"]
    parts = [lead_text(result), errors(found), joints(found), sensors(found), unknown(found), discrepancy_text(result)]
    parts += [support_text(result), stiffness_text(result)]
    if result["warnings"]:
        parts.append("\n".join(notes(result)))
    return "\n\n".join(part for part in parts if part)


def errors(found: Mapping[str, Any]) -> str:
    """Held-out RMSE, channel by channel and pooled."""
    wanted = [fit for fit in found["validation"] if fit["held_out"] and is_headline(fit["channel"])]
    columns = ("logs", "channel", "maker's", "identified", "steady", "noise floor", "unit")
    rows = [
        row for stem, logs in repeats(fit["log"] for fit in wanted).items() for row in error_rows(stem, logs, wanted)
    ]
    pooled = [
        [
            each["kind"].replace("_", " "),
            *(figures(each[key]) for key in ("rmse_prior", "rmse_identified")),
            f"{each['rmse_identified'] / each['rmse_prior']:.0%}" if each["rmse_prior"] else "",
            figures(each["noise_floor"]),
            each["unit"],
        ]
        for each in found["summary"]
    ]
    return "\n".join(
        [
            "HELD-OUT LOGS: root mean square of measured minus predicted",
            "with the maker's values, with the identified ones, and what the sensors' noise alone would leave",
            "",
            text_table(columns, rows),
            "",
            "steady: only samples in steady motion. At rest friction may be anything between two limits, so the",
            "total exceeds the noise floor at joints that stand still, start or turn.",
            "",
            text_table(("all channels and logs", "maker's", "identified", "of it", "noise floor", "unit"), pooled),
        ]
    )


def error_rows(stem: str, logs: Sequence[str], fits: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    """One row per channel: root mean square over logs that repeat the same."""
    name = logs[0] if len(logs) == 1 else f"{stem} (of {len(logs)})"
    for channel in dict.fromkeys(fit["channel"] for fit in fits if fit["log"] in logs):
        same = [fit for fit in fits if fit["log"] in logs and fit["channel"] == channel]

        def rms(key: str, same: Sequence[Mapping[str, Any]] = same) -> str:
            values = [fit[key] for fit in same if fit[key] is not None]
            return significant(math.sqrt(sum(x * x for x in values) / len(values))) if values else ""

        steady = rms("rmse_moving") if is_trunk(channel) else ""
        yield [name, channel, rms("rmse_prior"), rms("rmse_identified"), steady, rms("noise_floor"), same[0]["unit"]]


def joints(found: Mapping[str, Any]) -> str:
    """The joint parameters of the trunk's joints, each with its standard deviation and what it was believed to be."""
    chosen = sorted(found["joints"], key=lambda entry: not is_trunk(entry["joint"]))[:SHOWN_JOINTS]
    rows = [
        [entry["joint"], JOINT_WORDS.get(name, name), *quantity(value)]
        for entry in chosen
        for name, value in entry.items()
        if isinstance(value, Mapping) and value["value"] is not None
    ]
    columns = ("joint", "parameter", "maker's", "identified", "± std", "unit", "")
    title = f"JOINT PARAMETERS of {len(chosen)} of {len(found['joints'])} joints"
    return f"{title}\n\n{text_table(columns, rows)}"


def sensors(found: Mapping[str, Any]) -> str:
    """The zero of every force/torque sensor inside the robot; empty where there is none."""
    rows = [
        [entry["sensor"], name, *quantity(value)]
        for entry in found.get("sensors", ())
        for name, value in entry["zero"].items()
    ]
    columns = ("sensor", "zero of", "maker's", "identified", "± std", "unit", "")
    return f"SENSORS inside the robot\n\n{text_table(columns, rows)}" if rows else ""


def quantity(value: Mapping[str, Any]) -> list[str]:
    """prior, value, std, unit, and a mark where the data do not decide."""
    number, std = with_std(value["value"], value["std"] or 0.0)
    return [significant(value["prior"]), number, std, value["unit"], "" if value["identifiable"] else "not decided"]


def unknown(found: Mapping[str, Any]) -> str:
    """How many parameters the data do not decide, and which sorts they are of."""
    sorts: dict[str, list[str]] = defaultdict(list)
    for name in found["unidentifiable"]:
        kind = name.partition("[")[0]
        sort = kind.partition(".")[0]
        sorts[sort if sort in ("base", "zero") else JOINT_WORDS.get(kind, "single")].append(name)
    rows = [
        [len(names), SORTS.get(sort, sort), ", ".join(names[:SHOWN_NAMES]) + (" …" if len(names) > SHOWN_NAMES else "")]
        for sort, names in sorted(sorts.items(), key=lambda item: -len(item[1]))
    ]
    count, total = len(found["unidentifiable"]), len(found["parameters"])
    title = f"WHAT COULD NOT BE TOLD: the data do not decide {count} of {total} parameters"
    return f"{title}\n\n{text_table(('count', 'sort', 'such as'), rows, widest=60)}" if rows else title


def notes(result: Mapping[str, Any]) -> Iterator[str]:
    yield "NOTES"
    for warning in result["warnings"]:
        yield textwrap.fill(notice(warning).text, WIDTH, initial_indent="- ", subsequent_indent="  ")


def is_headline(channel: str) -> bool:
    return channel in MOMENTS or channel.startswith("ft.") or is_trunk(channel)


def is_trunk(channel: str) -> bool:
    return any(word in channel.lower() for word in TRUNK)


def figures(value: float | None) -> str:
    return "" if value is None else significant(value)
