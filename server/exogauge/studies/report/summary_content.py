"""The one-page report as content: what was tested, what was found, for what it holds. Made of results.json alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from exogauge.devices.result import Estimate
from exogauge.remarks import About
from exogauge.studies.report.page_model import Block, Column, Page, Row, Table, plain
from exogauge.studies.report.summary_configuration import configuration_facts, provenance_facts
from exogauge.studies.report.summary_figure import support_figure, units_of
from exogauge.studies.report.support_section import SAID, plus_minus
from exogauge.studies.words.names import NO_BREAK, counted, listed
from exogauge.studies.words.rounding import significant

LABEL = "SYNTHETIC DATA: made by a simulator, not measured"
FOOTER = (
    "± one standard deviation: noise, what the model leaves unexplained, and the prior; not effects that nobody named. "
    "A: run without minus run with the wear. B: model minus measurement. All else: report.html and results.json. "
    "No date of evaluation stands here, so that equal inputs give equal files; the job’s own page has it."
)
KINDS = {
    "base_moment": "base moment", "trunk_torque": "trunk torque", "joint_torque": "joint torque",
    "joint_force": "force of sliding joints",
    "sensor_force": "sensor force", "sensor_moment": "sensor moment",
}  # fmt: skip


@final
@dataclass(frozen=True)
class Detail:
    """How much of a long study the page tells; the rest is counted. name, sentence: characters at most."""

    name: int
    sentence: int
    supports: int
    groups: int
    points: int
    devices: int
    files: int


DETAILS = (
    Detail(60, 700, 10, 8, 8, 4, 60),
    Detail(40, 500, 8, 6, 6, 3, 12),
    Detail(24, 300, 5, 4, 4, 2, 4),
    Detail(16, 160, 4, 3, 3, 1, 3),
)


def summary_content(results: Mapping[str, Any], detail: Detail) -> Page:
    support, stiffness = _support(results, detail), _stiffness(results, detail)
    figure = support_figure(by_weight(results["support"])[: detail.supports], detail.name)
    unsaid = Block("What these data cannot say", points=tuple(_unsaid(results, detail)))
    rows = [
        Row((Block("Scope", (_scope(results["scope"], 2 * detail.sentence),)),)),
        Row((Block("What was found", tuple(plain(each, detail.sentence) for each in _found(results, detail))),)),
    ]
    if support is not None:
        rows.append(Row((support, Block("", drawing=figure)), (0.66, 0.34)) if figure else Row((support,)))
    rows.append(Row((stiffness, unsaid), (0.56, 0.44)) if stiffness is not None else Row((unsaid,)))
    facts = configuration_facts(results, detail.name, detail.devices)
    told = [(name, plain(text, 2 * detail.sentence)) for name, text in facts]
    rows.append(Row((Block("Configuration", facts=tuple(told)),)))
    rows.append(Row((Block("Settings, software, files", facts=tuple(provenance_facts(results, detail.files))),)))
    label = LABEL if results["scope"]["synthetic"] else ""
    return Page(plain(results["name"], 2 * detail.name), _kicker(results, detail), label, tuple(rows), FOOTER)


def _kicker(results: Mapping[str, Any], detail: Detail) -> str:
    worn, robot = results["scope"]["devices"], plain(results["robot"], detail.name)
    shown = [f"“{plain(each, detail.name)}”" for each in worn[: detail.devices]]
    shown += [f"{len(worn) - len(shown)} more"] if len(worn) > len(shown) else []
    about = f"evaluation of {listed(shown)} on {robot}" if worn else f"identification of {robot}"
    return f"exogauge · one-page report · {about}"


def _scope(scope: Mapping[str, Any], most: int) -> str:
    """Where it is too long, what it ends with stays: that nothing is claimed beyond."""
    sentence, (head, tail) = scope["sentence"], scope.get("clauses", ("", ""))
    if len(sentence) <= most or not tail or 2 * len(tail) > most:
        return plain(sentence, most)
    return f"{plain(head, most - len(tail))} {tail}"


def _found(results: Mapping[str, Any], detail: Detail) -> list[str]:
    """What the doctor holds for wrong, and what is left out for it; how much the wears support, what the model lacks,
    how well it predicts: a paragraph each."""
    of_doctor = (About.SPOILED_FIT, About.DOCTOR_ERRORS, About.LOGS_SPOILED, About.LOGS_LEFT_OUT)
    wrong = " ".join(each["sentence"] for each in results["notices"] if each["code"] in of_doctor)
    worn = " ".join(_strongest(results, device) for device in results["scope"]["devices"][: detail.devices])
    lacks = ""
    if results["discrepancy"] is not None:
        lacks = f"{results['discrepancy']['sentence']} {results['discrepancy']['left_sentence']}"
    return [each for each in (wrong, worn, lacks.strip(), _errors(results["identification"]["summary"])) if each]


def _errors(pooled: Sequence[Mapping[str, Any]]) -> str:
    """RMSE with the maker's values, as identified, and the noise floor."""
    if not pooled:
        return ""
    where = counted(len(pooled[0]["logs"]), "held-out log") if pooled[0]["held_out"] else "the fitted logs themselves"
    parts = [
        f"{KINDS.get(each['kind'], each['kind'])} {figure(each['rmse_prior'])} → {figure(each['rmse_identified'])} "
        f"{each['unit']} (noise floor {figure(each['noise_floor'])})"
        for each in pooled
    ]
    return f"RMSE on {where}, with the maker’s values → identified: {', '.join(parts)}."


def _strongest(results: Mapping[str, Any], device: str) -> str:
    """Where this wear supports most, by the best approach."""
    peaks = [
        (each["peak"], each["peak"]["approach"], each)
        for each in by_weight(results["support"])
        if each["device"] == device and each["peak"] is not None
    ]
    known = [found for found in peaks if found[0]["value"] is not None]
    if not known:
        return f"Nothing is said of the support of “{device}”."
    peak, approach, each = max(known, key=lambda found: abs(found[0]["value"]))
    size = estimate({**peak, "value": abs(peak["value"])})
    return f"“{device}” gives up to {size} {peak['unit']} at {each['joint']} in {each['motion']} ({SAID[approach]})."


def _support(results: Mapping[str, Any], detail: Detail) -> Block | None:
    """Peak by A and B, the band model's, errors against it: the main joints, then as many others as there is room."""
    found = by_weight(results["support"])
    if not found:
        return None
    columns = (
        Column("Motion, joint", 0.16), Column("Wear", 0.13), Column("Peak A", 0.13, True),
        Column("Peak B", 0.13, True), Column("Paired", 0.13, True), Column("Bands", 0.08, True),
        Column("RMSE A", 0.08, True), Column("RMSE B", 0.08, True), Column("Paired", 0.08, True),
    )  # fmt: skip
    rows = tuple(
        (
            f"{plain(each['motion'], detail.name)}, {plain(each['joint'], detail.name)}",
            plain(each["device"], detail.name),
            *(_peak(each, approach) for approach in ("A", "B", "paired")),
            _model_peak(each),
            *(figure(each[f"rmse_{approach}"]) for approach in ("a", "b", "paired")),
        )
        for each in found[: detail.supports]
    )
    units = units_of(found[: detail.supports])
    caption = f"{units} on the joint, positive along its axis; RMSE against the band model (Bands)" + _more(found, rows)
    return Block("Supporting torque", table=Table(caption, columns, rows))


def by_weight(found: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Main joints, motion by motion and then joint by joint, so that wears stand together; all where none is main."""
    chosen = [each for each in found if each["main"]] or list(found)
    order = list(dict.fromkeys((each["motion"], each["joint"]) for each in chosen))
    motions = list(dict.fromkeys(motion for motion, _ in order))
    order.sort(key=lambda place: motions.index(place[0]))
    return sorted(chosen, key=lambda each: order.index((each["motion"], each["joint"])))


def _model_peak(entry: Mapping[str, Any]) -> str:
    """Without its deviation, which is that between trials alone."""
    found = entry["approaches"].get("band_model")
    return figure(found["peak"]["value"]) if found else "–"


def _peak(entry: Mapping[str, Any], approach: str) -> str:
    """In brackets where the data do not decide it."""
    found = entry["approaches"].get(approach)
    shown = estimate(found["peak"]) if found else "–"
    return shown if entry["peak"] is not None or not found else f"({shown})"


def _stiffness(results: Mapping[str, Any], detail: Detail) -> Block | None:
    """One row per device and group: by A, B, as stated, and the truth where one is known."""
    groups: dict[tuple[str, str], dict[str, Mapping[str, Any]]] = {}
    for each in results["stiffness"]:
        groups.setdefault((each["device"], each["group"]), {}).setdefault(each["approach"], each)
    if not groups:
        return None
    stated = {
        (wear["device"], band["group"]): band["stiffness_n_per_m"]
        for wear in results["configuration"]["devices"]
        for band in wear["bands"]
    }
    columns = (
        Column("Wear, bands", 0.25), Column("A", 0.18, True), Column("B", 0.18, True), Column("Paired", 0.18, True),
        Column("Stated", 0.105, True), Column("Truth", 0.105, True),
    )  # fmt: skip
    rows = tuple(
        (
            f"{plain(device, detail.name)}, {plain(group, detail.name)}",
            *(_stiff(by.get(approach)) for approach in ("A", "B", "paired")),
            figure(stated.get((device, group)), 4),
            figure(next(iter(by.values()))["truth_n_per_m"], 4),
        )
        for (device, group), by in list(groups.items())[: detail.groups]
    )
    caption = "N/m; in brackets: the data do not decide it" + _more(groups, rows)
    return Block("Stiffness of the bands", table=Table(caption, columns, rows))


def _stiff(entry: Mapping[str, Any] | None) -> str:
    if entry is None:
        return "–"
    shown = estimate(entry["stiffness_n_per_m"])
    return shown if entry["identifiable"] else f"({shown})"


def _unsaid(results: Mapping[str, Any], detail: Detail) -> list[str]:
    found = results["identification"]
    said = [*results["scope"]["not_said"]]
    undecided, total = len(found["unidentifiable"]), len(found["parameters"])
    if undecided:
        said.insert(-1, f"The logs do not decide {undecided} of {counted(total, 'parameter')} of the robot.")
    at_rest = [each for each in by_weight(results["support"]) if each["rest_share"] and each["rest_half_width"]]
    if at_rest:
        widest = max(at_rest, key=lambda each: float(each["rest_half_width"]))
        where = f"{widest['joint']} in {widest['motion']}"
        size = figure(widest["rest_half_width"], 2)
        within = f"±{NO_BREAK}{size} {units_of([widest])} ({where})"
        said.insert(-1, f"Where a joint stands still, friction leaves an interval: by B up to {within}.")
    undecided_groups = sorted({each["group"] for each in results["stiffness"] if _undecided(each)})
    if undecided_groups:
        said.insert(-1, f"Stiffness that the data do not decide: band groups {listed(undecided_groups[:6])}.")
    unlike = [
        f"{each['motion']} with {each['device']} at {each['joint']}"
        for each in by_weight(results["support"])
        if each["motion_equality"] and each["motion_equality"]["verdict"] != "equal"
    ]
    if unlike:
        said.insert(-1, f"The runs that A compares are not quite alike: {unlike[0]}{_others(unlike)}. Believe B there.")
    skipped = [f"{each['step']} ({each['reason']})" for each in results["steps"] if each["status"] != "done"]
    if skipped:
        said.insert(-1, f"Not done: {'; '.join(skipped)}.")
    kept = [*said[: detail.points - 1], said[-1]] if len(said) > detail.points else said
    return [plain(each, detail.sentence) for each in kept]


def _undecided(entry: Mapping[str, Any]) -> bool:
    return entry["approach"] != "prior" and not entry["identifiable"]


def _others(names: Sequence[str]) -> str:
    return f" and {len(names) - 1} more" if len(names) > 1 else ""


def _more(found: Sequence[Any] | Mapping[Any, Any], shown: Sequence[Any]) -> str:
    return f"; {len(found) - len(shown)} more in report.html" if len(found) > len(shown) else ""


def estimate(entry: Mapping[str, Any]) -> str:
    """`5.03 ± 0.12` of {value, std, unit}."""
    value, std = (math.nan if entry[key] is None else float(entry[key]) for key in ("value", "std"))
    return plus_minus(Estimate(value, std, str(entry["unit"]))).replace(" ", NO_BREAK)


def figure(value: float | None, digits: int = 3) -> str:
    return "–" if value is None else significant(value, digits)
