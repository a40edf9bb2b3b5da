"""Where model and measurement disagree, of results.json, as text for a terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from exogauge.studies.words.discrepancy_sentences import chain_unit, chain_words, looked_at, moves
from exogauge.studies.words.names import capital, counted, listed
from exogauge.studies.words.rounding import significant, with_std
from exogauge.terminal import text_table

WIDTH = 100
LEAST = 0.005  # share of the excess: below, it explains none of it
SHOWN = 3  # alternatives, and channels that stay unexplained


def lead_text(result: Mapping[str, Any]) -> str:
    """The first sentence: which effect the model lacks. Empty where nothing was named or looked for."""
    entry = result.get("discrepancy")
    return filled(entry["sentence"]) if entry and entry["verdict"] != "none" else ""


def discrepancy_text(result: Mapping[str, Any]) -> str:
    """Verdict, what was looked at, each finding with its evidence, and the chain down to the noise floor."""
    entry = result.get("discrepancy")
    if not entry:
        return ""
    said = " ".join(part for part in (entry["sentence"], entry["left_sentence"]) if part)
    parts = [f"DISAGREEMENT between model and measurement\n\n{filled(said)}\n{filled(looked_at(result))}"]
    if entry["chain"]:
        parts.append(chain(entry["chain"]))
    parts += ["\n".join(finding(each)) for each in entry["findings"]]
    if entry["unexplained"]:
        parts.append(unexplained(entry["unexplained"]))
    if entry["before_after"]:
        parts.append(changes(entry["before_after"]))
    parts += [filled(note, "- ") for note in entry["notes"]]
    return "\n\n".join(parts)


def chain(links: Sequence[Mapping[str, Any]]) -> str:
    """RMSE of each model, and the channel furthest above its floor."""
    rows = [[each["step"], figure(each["rmse"]), figure(each["noise_floor"]), *furthest(each)] for each in links]
    unit = links[-1]["unit"]
    columns = ("model", f"RMSE {chain_unit(unit)}", "noise floor", "furthest above its floor", "RMSE", "floor")
    table = text_table(columns, rows, widest=60)
    return f"{chain_words(unit)}, in steady motion on held-out logs:\n\n{table}"


def furthest(link: Mapping[str, Any]) -> list[str]:
    """Channel, RMSE and floor; blank where all are at their floors or below."""
    rmse, floor = link["worst_rmse"], link["worst_floor"]
    if rmse is None or floor is None or rmse <= floor:
        return ["none", "", ""]
    return [link["worst_words"], figure(rmse), figure(floor)]


def finding(found: Mapping[str, Any]) -> Iterator[str]:
    yield filled(f"{found['rank']}. {capital(found['title'])}", "", "   ")
    yield filled(found["evidence"], "   ", "   ")
    values = (f"{name} {quantity(value)}" for name, value in found["parameters"].items())
    yield filled(", ".join(values), "   ", "   ")
    yield filled(f"Explains{percent(found['score']) or ' part'} of the excess. {next_best(found)}", "   ", "   ")
    if found["also_possible"]:
        named = listed([each["title"] for each in found["also_possible"]])
        yield filled(f"These data cannot tell it from {named}.", "   ", "   ")
    if found["motion"]:
        yield filled(f"The motion that would tell: {found['motion']}", "   ", "   ")
    if found.get("planned"):
        files = listed([each["file"] for each in found["planned"]])
        yield filled(f"Every joint's position over it: {files}.", "   ", "   ")


def next_best(found: Mapping[str, Any]) -> str:
    some = [each for each in found["alternatives"] if each["score"] and each["score"] >= LEAST]
    ordered = sorted(some, key=lambda each: -each["score"])[:SHOWN]
    if not ordered:
        return "Nothing else that was judged explains any."
    named = ", ".join(each["title"] + percent(each["score"]) for each in ordered)
    return f"Next best: {named}."


def quantity(found: Mapping[str, Any]) -> str:
    """`3.00 ± 0.20 N·m`."""
    if found["value"] is None:
        return "unknown"
    value, std = with_std(found["value"], found["std"] or 0.0)
    unit = "" if found["unit"] == "1" else found["unit"]
    return f"{value}{'' if std == '–' else f' ± {std}'} {unit}".rstrip()


def percent(score: float | None) -> str:
    return "" if score is None else f" {100 * max(score, 0.0):.0f} %"


def unexplained(found: Sequence[Mapping[str, Any]]) -> str:
    ordered = sorted(found, key=lambda each: -(each["z"] or 0.0))
    rows = [
        [each["channel_words"], figure(each["rmse"]), figure(each["noise_floor"]), each["unit"], each["where"]]
        for each in ordered[:SHOWN]
    ]
    more = f"\n… and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    table = text_table(("left unexplained", "RMSE", "noise floor", "unit", "where"), rows, widest=60)
    return f"{table}{more}"


def changes(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Those that change, and how many do not."""
    changed = {name: pair for name, pair in found.items() if moves(pair["before"], pair["after"])}
    rows = [[name, quantity(pair["before"]), quantity(pair["after"])] for name, pair in changed.items()]
    others = len(found) - len(changed)
    if not rows:
        return f"{counted(others, 'number')} on the device, none of which it changes."
    more = f"\n… and {others} that hardly change" if others else ""
    return text_table(("with the device", "without the effect", "with it"), rows, widest=60) + more


def figure(value: float | None) -> str:
    return significant(math.nan if value is None else value)


def filled(text: str, first: str = "", other: str | None = None) -> str:
    indent = " " * len(first) if other is None else other
    return textwrap.fill(text, WIDTH, initial_indent=first, subsequent_indent=indent, break_on_hyphens=False)
