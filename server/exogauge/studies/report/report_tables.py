"""The report's tables as plain rows of text: what stands in which cell, with the digits a number deserves."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from exogauge.identification.added_columns import COMPONENTS, MASS
from exogauge.identification.result import Array, ChannelFit, Identification, Parameter
from exogauge.robots.description import JOINT_PARAMETERS, Robot
from exogauge.studies.report.figures import label
from exogauge.studies.words.doubt_words import source_advice, source_words
from exogauge.studies.words.rounding import rounded, significant, with_std

_NAME = re.compile(r"^(?P<kind>[^\[\]]+)\[(?P<where>.*)\]$")
JOINT_WORDS = {
    "k_T": "torque constant",
    "k_d": "viscous friction",
    "tau_c": "Coulomb friction",
    "tau_s": "static friction",
    "tau_o": "offset",
    "J_r": "rotor inertia",
}
WORSE = 1.05  # identified / prior from which a row is marked; below it is chance
ADVICE = {
    "single": "Many of these can never be told apart, whatever the motion: no joint torque depends on them alone. "
    "Predictions need only their combinations.",
    "link": "Turn the joints around these links through larger angles and faster, in several directions at once; "
    "with a floating base also tilt and sway the base.",
    "zero": "Turn what the sensor carries, so that gravity pulls along each of its axes both ways.",
    "k_T": "Move these joints with a load that changes: larger accelerations, or against gravity.",
    "k_d": "Move these joints at more than one speed, slow and fast.",
    "tau_c": "Let these joints move steadily in both directions.",
    "tau_s": "Let these joints stand still under load, between movements in both directions.",
    "tau_o": "Move these joints in both directions through the same angles.",
    "J_r": "Accelerate these joints harder, at the same posture and speed in both directions.",
}


@final
@dataclass(frozen=True)
class Cell:
    """A number as shown. kept: it stays at (or near) the maker's value, because the data do not decide it.

    known: it was never in question (k_T of a joint whose torque is logged).
    """

    value: str
    std: str
    prior: str
    kept: bool
    known: bool = False


@final
@dataclass(frozen=True)
class FitRow:
    """One channel on one log. bars: percent of the longer one, prior and identified; floor: the tick's place.

    steady, rest: the identified error in steady motion and at rest; rest_share: of the samples. Empty: not of a joint.
    """

    channel: str
    unit: str
    prior: str
    identified: str
    floor: str
    prior_bar: float
    identified_bar: float
    floor_bar: float
    ratio: str
    worse: bool
    steady: str
    rest: str
    rest_share: str


@final
@dataclass(frozen=True)
class SensorColumn:
    """A force/torque sensor inside the robot: the bodies beyond it, and its zero by component."""

    name: str
    carries: str
    zero: Mapping[str, Cell | None]


@final
@dataclass(frozen=True)
class LinkRow:
    link: str
    mass: Cell | None
    com_prior: str
    com: str
    com_kept: bool
    possible: bool


@final
@dataclass(frozen=True)
class Unknown:
    """What the data cannot tell, of one sort: the places, and what to record to change that."""

    title: str
    places: tuple[str, ...]
    advice: str


def doubts_of_parameters(found: Identification) -> tuple[tuple[str, int, int, str], ...]:
    """Source in words, how many parameters of links and of joints have most of their doubt from it, and what would
    make it smaller; of parameters that the data decide, the most frequent source first."""
    of_links, of_joints = Counter[str](), Counter[str]()
    for each in found.parameters:
        if each.identifiable and each.parts:
            largest = max(each.parts, key=lambda source: each.parts[source])
            (of_joints if each.name.partition("[")[0] in found.joint_values else of_links)[largest] += 1
    return tuple(
        (source_words(source), of_links[source], of_joints[source], source_advice(source))
        for source, _ in (of_links + of_joints).most_common()
    )


def fit_tables(found: Identification, held_out: bool) -> dict[str, list[FitRow]]:
    """Log -> one row per channel."""
    tables: dict[str, list[FitRow]] = defaultdict(list)
    for fit in found.validation:
        if fit.held_out == held_out:
            tables[fit.log].append(_fit_row(fit))
    return dict(tables)


def _fit_row(fit: ChannelFit) -> FitRow:
    longest = max(fit.rmse_prior, fit.rmse_identified, fit.noise_floor, 1e-300)
    ratio = fit.rmse_identified / fit.rmse_prior if fit.rmse_prior > 0 else float("nan")
    return FitRow(
        label(fit.channel),
        fit.unit,
        significant(fit.rmse_prior),
        significant(fit.rmse_identified),
        significant(fit.noise_floor, 2),
        100 * fit.rmse_prior / longest,
        100 * fit.rmse_identified / longest,
        100 * fit.noise_floor / longest,
        significant(ratio, 2),
        ratio >= WORSE,
        _part(fit, fit.rmse_moving),
        _part(fit, fit.rmse_at_rest),
        f"{100 * fit.rest_share:.0f} %" if fit.rmse_at_rest is not None else "",
    )


def _part(fit: ChannelFit, rmse: float | None) -> str:
    return "" if rmse is None or not fit.channel.startswith("tau.") else significant(rmse)


def joint_table(
    found: Identification, robot: Robot
) -> tuple[list[tuple[str, str, str]], list[tuple[str, list[Cell | None]]]]:
    """(columns as symbol, words, unit; rows as joint, cells)."""
    known = {parameter.name: parameter for parameter in found.parameters}
    names = [*JOINT_PARAMETERS, *(name for name in found.joint_values if name not in JOINT_PARAMETERS)]
    joints = [joint.name for joint in robot.joints]
    used = [name for name in names if any(f"{name}[{joint}]" in known for joint in joints)]
    columns = []
    for name in used:
        units = dict.fromkeys(known[f"{name}[{joint}]"].unit for joint in joints if f"{name}[{joint}]" in known)
        columns.append((name, JOINT_WORDS.get(name, name.replace("_", " ")), " or ".join(units)))
    rows = [(joint, [_cell(known.get(f"{name}[{joint}]")) for name in used]) for joint in joints]
    return columns, rows


def sensor_table(found: Identification, robot: Robot) -> list[SensorColumn]:
    known = {parameter.name: parameter for parameter in found.parameters}
    return [
        SensorColumn(
            sensor.name,
            ", ".join(robot.tree.bodies[body] for body in robot.tree.cuts[sensor.frame]),
            {component: _cell(known.get(f"zero.{component}[{sensor.name}]")) for component in COMPONENTS},
        )
        for sensor in robot.cuts
    ]


def load_table(found: Identification, robot: Robot) -> list[tuple[str, str, str, Cell | None, bool]]:
    """(load, its logs, mass as stated, mass with the logs, whether it cannot be told from its link)."""
    known = {parameter.name: parameter for parameter in found.parameters}
    rows = []
    for load in robot.loads:
        mass = known.get(f"{MASS}[{load.name}]")
        stated = " ± ".join(with_std(load.mass, load.std))
        of_link = mass is not None and mass.prior_std > load.std
        rows.append((load.name, ", ".join(load.logs), stated, _cell(mass), of_link))
    return rows


def link_table(found: Identification, robot: Robot) -> list[LinkRow]:
    """Mass and centre of mass of every moving link; a centre of mass has no std here, its parts are in parameters."""
    known = {parameter.name: parameter for parameter in found.parameters}
    rows = []
    for k, link in enumerate(robot.tree.bodies):
        kept = [not known[f"{axis}[{link}]"].identifiable for axis in ("mx", "my", "mz") if f"{axis}[{link}]" in known]
        rows.append(
            LinkRow(
                link,
                _cell(known.get(f"m[{link}]")),
                _com(robot.tree.phi[k, :4]),
                _com(found.phi[k, :4]),
                bool(kept) and all(kept),
                bool(found.consistent_links[k]),
            )
        )
    return rows


def base_table(found: Identification) -> list[tuple[str, str, Cell]]:
    """(leading name, the combination in words, numbers with the unit in the value) of every base parameter."""
    rows = []
    for parameter in found.parameters:
        match = _NAME.match(parameter.name)
        cell = _cell(parameter)
        if match and match["kind"] == "base" and cell:
            value = Cell(f"{cell.value}", f"{cell.std} {parameter.unit}", cell.prior, cell.kept)
            rows.append((match["where"], combination(parameter.combination), value))
    return rows


def combination(parts: Mapping[str, float], shown: int = 5) -> str:
    """`m[a] + 0.31 mz[b] − …`, the largest coefficients first."""
    ordered = sorted(parts.items(), key=lambda item: -abs(item[1]))
    text = ""
    for name, factor in ordered[:shown]:
        size = "" if abs(abs(factor) - 1.0) < 1e-9 else significant(abs(factor), 3) + " "
        sign = "− " if factor < 0 else ("+ " if text else "")
        text += f"{' ' if text else ''}{sign}{size}{name}"
    return text + (f" + {len(ordered) - shown} more" if len(ordered) > shown else "")


def unknowns(found: Identification) -> list[Unknown]:
    """Unidentifiable parameters, by link and by sort of joint parameter, each with advice; not those that are known."""
    links: dict[str, list[str]] = defaultdict(list)
    combinations, zeros = list[str](), list[str]()
    certain = {parameter.name for parameter in found.parameters if parameter.std == 0.0}
    joints: dict[str, list[str]] = defaultdict(list)
    for name in (each for each in found.unidentifiable if each not in certain):
        match = _NAME.match(name)
        kind, where = (match["kind"], match["where"]) if match else (name, "")
        if kind == "base":
            combinations.append(where)
        elif kind.startswith("zero."):
            zeros.append(f"{where}.{kind.removeprefix('zero.')}")
        elif kind in JOINT_WORDS or kind in found.joint_values:
            joints[kind].append(where)
        else:
            links[where].append(kind)
    result = []
    if links:
        places = tuple(
            f"{link}: {'all ten' if len(kinds) == 10 else ', '.join(kinds)}" for link, kinds in links.items()
        )
        result.append(Unknown("Inertial parameters of single links", places, ADVICE["single"]))
    if combinations:
        result.append(Unknown("Combinations of them, by the leading one", tuple(combinations), ADVICE["link"]))
    if zeros:
        result.append(Unknown("Zeros of force/torque sensors", tuple(zeros), ADVICE["zero"]))
    for kind, places_of in joints.items():
        title = f"{JOINT_WORDS[kind]} {kind}" if kind in JOINT_WORDS else kind
        result.append(Unknown(title[0].upper() + title[1:], tuple(places_of), ADVICE.get(kind, "")))
    return result


def figure_channels(
    fits: Sequence[ChannelFit], trunk: Sequence[str], most: int = 4
) -> tuple[list[str], list[str], list[str]]:
    """(base moments, joint torques, sensors' readings) worth drawing for one log: the trunk's, then those that improved
    most."""
    channels = [fit.channel for fit in fits]
    moments: list[str] = [channel for channel in ("base.mx", "base.my", "base.mz") if channel in channels]
    torques = [fit for fit in fits if fit.channel.startswith("tau.")]
    gained = sorted(torques, key=lambda fit: fit.rmse_identified - fit.rmse_prior)
    chosen = [channel for channel in trunk if channel in channels][:most]
    chosen += [fit.channel for fit in gained if fit.channel not in chosen][: most - len(chosen)]
    return moments, chosen, _most_improved_readings(fits)


def _most_improved_readings(fits: Sequence[ChannelFit], most: int = 6) -> list[str]:
    """All of one sensor; of several, by the share of the error that went. In the order of the fits."""
    readings = [fit for fit in fits if fit.channel.startswith("ft.")]
    best = sorted(readings, key=lambda fit: fit.rmse_identified / max(fit.rmse_prior, 1e-300))[:most]
    return [fit.channel for fit in readings if fit in best]


def _cell(parameter: Parameter | None) -> Cell | None:
    if parameter is None:
        return None
    value, std = with_std(parameter.value, parameter.std)
    known = parameter.std == 0.0
    return Cell(value, std, significant(parameter.prior), not parameter.identifiable and not known, known)


def _com(phi: Array) -> str:
    """Centre of mass [mm] in the link frame."""
    mass = float(phi[0])
    if mass <= 0.0:
        return "–"
    return ", ".join(rounded(1000 * float(moment) / mass, 0) for moment in phi[1:4])
