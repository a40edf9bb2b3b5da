"""results.json and the result tables: the contract's keys, finite numbers, the same bytes for the same inputs.

`criteria` in results.json: every number that decided, with its reason and its source.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any, final

from exogauge.criteria.criterion import entries
from exogauge.devices.result import StiffnessResult
from exogauge.findings.result import Discrepancy
from exogauge.identification.added_columns import COMPONENTS, MASS
from exogauge.identification.result import ChannelFit, Identification, Parameter
from exogauge.identification.settings import Settings
from exogauge.identification.total_mass import TotalMass
from exogauge.logs.model import Log
from exogauge.robots.description import JOINT_PARAMETERS, Robot
from exogauge.studies.csv_table import csv_table
from exogauge.studies.intake.bundle import Input
from exogauge.studies.intake.open import Step
from exogauge.studies.results.configuration import (
    StudyRecord,
    configuration_entry,
    says_synthetic,
    software,
    stated_settings,
)
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.plan_results import PlansOfStudy, plan_entries
from exogauge.studies.results.schema import StudyResults
from exogauge.studies.results.scope import scope_entry
from exogauge.studies.results.support_results import (
    budget,
    cross_checks,
    stiffness_details,
    stiffness_entries,
    support_entries,
)
from exogauge.studies.words.doubt_words import doubt_sources
from exogauge.studies.words.names import channel
from exogauge.studies.words.notices import Notice, notice
from exogauge.studies.words.reading_words import READING
from exogauge.support.result import SupportResult
from exogauge.support.settings import SupportSettings

VERSION = 1
SENSORS = {"sensor_force": "f", "sensor_moment": "m"}
BASE_MOMENT = ("base.mx", "base.my", "base.mz")
TRUNK_WORDS = ("torso", "waist", "chest", "lumbar", "trunk", "spine")


@final
@dataclass(frozen=True)
class Evaluation:
    """All that an evaluation found: what results.json, the tables and the report are written from.

    findings: of the doctor, as mappings with `log`, `severity`, `channel`, `detail` … notices: to be kept in mind.
    support, stiffness: None and empty where no device was worn; the study's own device comes first.
    discrepancy: None where that step was skipped. record: what was handed in, and what the logs reach. logs: those that
    a series shows the joints' motion of. taken_over: rank of a finding -> file of the device that states it.
    plans: which logs are of which planned motion.
    """

    name: str
    robot: Robot
    settings: Settings
    steps: Sequence[Step]
    inputs: Sequence[Input]
    findings: Sequence[Mapping[str, Any]]
    identification: Identification
    notices: Sequence[Notice]
    files: Mapping[str, str]
    support: SupportResult | None = None
    stiffness: Sequence[StiffnessResult] = ()
    discrepancy: Discrepancy | None = None
    record: StudyRecord = field(default_factory=StudyRecord)
    support_settings: SupportSettings = field(default_factory=SupportSettings)
    logs: Sequence[Log] = ()
    taken_over: Mapping[int, str] = field(default_factory=dict)
    plans: PlansOfStudy = field(default_factory=PlansOfStudy)

    @property
    def synthetic(self) -> bool:
        return bool(self.record.synthetic) or says_synthetic(self.name)


@final
@dataclass(frozen=True)
class Summary:
    """RMSE over several channels and logs, pooled over samples.

    kind: `base_moment`, `trunk_torque`, `joint_torque`, `joint_force` (of joints that slide), `sensor_force`,
    `sensor_moment`.
    """

    kind: str
    channels: tuple[str, ...]
    logs: tuple[str, ...]
    unit: str
    held_out: bool
    rmse_prior: float
    rmse_identified: float
    noise_floor: float


def all_notices(evaluation: Evaluation) -> list[Notice]:
    """Of the study, of the identification, of the supporting torque."""
    support = evaluation.support.remarks if evaluation.support else ()
    return [*evaluation.notices, *map(notice, (*evaluation.identification.remarks, *support))]


def results(evaluation: Evaluation) -> dict[str, Any]:
    """The content of results.json, held to its schema; NaN and infinity become null."""
    found, support = evaluation.identification, evaluation.support
    joints = [joint.name for joint in evaluation.robot.joints]
    content = {
        "version": VERSION,
        "name": evaluation.name,
        "robot": evaluation.robot.name,
        "scope": scope_entry(evaluation.record, evaluation.robot, evaluation.synthetic, support),
        "configuration": configuration_entry(
            evaluation.record,
            evaluation.robot,
            evaluation.settings,
            evaluation.support_settings,
            found,
            evaluation.inputs,
        ),
        "software": software(),
        "inputs": [asdict(each) for each in evaluation.inputs],
        "steps": [
            {"step": each.step, "status": "skipped", "reason": each.skipped}
            if each.skipped
            else {"step": each.step, "status": "failed", "reason": each.failed}
            if each.failed
            else {"step": each.step, "status": "done"}
            for each in evaluation.steps
        ],
        "settings": stated_settings(evaluation.settings),
        "criteria": entries(evaluation.settings.criteria),
        "warnings": [each.sentence for each in all_notices(evaluation)],
        "notices": [each.as_data() for each in all_notices(evaluation)],
        "plans": plan_entries(evaluation.plans),
        "doctor": list(evaluation.findings),
        "identification": {
            "summary": [asdict(each) for each in summaries(found, joints)],
            "validation": [asdict(fit) | {"channel_words": channel(fit.channel)} for fit in found.validation],
            "parameters": [parameter_entry(each) for each in found.parameters],
            "joints": joint_entries(found, joints),
            "sensors": sensor_entries(found, evaluation.robot),
            "known_loads": load_entries(found, evaluation.robot),
            "common_factor": {name: getattr(found.factor, name) for name in ("measured", "std", "unweighed", "known")},
            "total_mass": None if found.total_mass is None else mass_entry(found.total_mass),
            "unidentifiable": list(found.unidentifiable),
            "consistent_links": dict(zip(evaluation.robot.tree.bodies, map(bool, found.consistent_links), strict=True)),
            "prior_strength": found.prior_strength,
            "prior_curve": [{"factor": factor, "score": score} for factor, score in found.prior_curve],
            "rank": found.rank,
            "condition": found.condition,
            "samples": found.samples,
            "cutoff_hz": found.cutoff_hz,
            "steady": [asdict(each) for each in found.steady],
            "velocity_threshold": [
                {
                    "joint": joint,
                    "value": float(value),
                    "unit": "m/s" if joint in evaluation.robot.tree.sliding else "rad/s",
                }
                for joint, value in zip(joints, found.velocity_threshold, strict=False)
            ],
        },
        "support": support_entries(support) if support else [],
        "stiffness": stiffness_entries(evaluation.stiffness),
        "cross_checks": cross_checks(evaluation.stiffness),
        "doubt_sources": [{"source": each, **said} for each, said in doubt_sources().items()],
        "stiffness_details": stiffness_details(evaluation.stiffness),
        "discrepancy": discrepancy_entry(evaluation.discrepancy, evaluation.taken_over),
        "reading": READING,
        "files": dict(evaluation.files),
    }
    cleaned = finite(content)
    assert isinstance(cleaned, dict)
    StudyResults.model_validate(cleaned)
    return cleaned


def parameter_entry(parameter: Parameter) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": parameter.name,
        "value": parameter.value,
        "std": parameter.std,
        "unit": parameter.unit,
        "prior": parameter.prior,
        "prior_std": parameter.prior_std,
        "identifiable": bool(parameter.identifiable),
    }
    if parameter.identifiable and parameter.parts:
        entry["budget"] = budget(parameter.parts)
    if parameter.combination:
        entry["combination"] = dict(parameter.combination)
    return entry


def mass_entry(mass: TotalMass) -> dict[str, Any]:
    return {
        "found_kg": mass.found,
        "found_std_kg": mass.std,
        "stated_kg": mass.stated,
        "stated_std_kg": mass.stated_std,
        "z": mass.z,
        "limit": mass.limit,
        "agrees": bool(mass.agrees),
    }


def joint_entries(found: Identification, joints: Sequence[str]) -> list[dict[str, Any]]:
    """{joint, k_T: {value, std, unit}, …} with every joint parameter that was in the model."""
    known = {parameter.name: parameter for parameter in found.parameters}
    names = [*JOINT_PARAMETERS, *(name for name in found.joint_values if name not in JOINT_PARAMETERS)]
    entries = []
    for joint in joints:
        entry: dict[str, Any] = {"joint": joint}
        for name in names:
            parameter = known.get(f"{name}[{joint}]")
            if parameter is not None:
                entry[name] = _told(parameter)
        entries.append(entry)
    return entries


def sensor_entries(found: Identification, robot: Robot) -> list[dict[str, Any]]:
    """{sensor, bodies beyond it, zero: {fx: {value, std, unit, …}, …}} of every sensor inside the robot."""
    known = {parameter.name: parameter for parameter in found.parameters}
    entries = []
    for sensor in robot.cuts:
        zero = {component: known.get(f"zero.{component}[{sensor.name}]") for component in COMPONENTS}
        entries.append({
            "sensor": sensor.name,
            "carries": [robot.tree.bodies[body] for body in robot.tree.cuts[sensor.frame]],
            "zero": {name: _told(each) for name, each in zero.items() if each is not None},
        })  # fmt: skip
    return entries


def load_entries(found: Identification, robot: Robot) -> list[dict[str, Any]]:
    """Of every known load: what was stated, what the logs say with it, whether it cannot be told from its link."""
    known = {parameter.name: parameter for parameter in found.parameters}
    entries = []
    for load in robot.loads:
        mass = known.get(f"{MASS}[{load.name}]")
        entries.append({
            "load": load.name,
            "logs": list(load.logs),
            "mass_kg": load.mass,
            "std_kg": load.std,
            "found_kg": mass.value if mass else None,
            "found_std_kg": mass.std if mass else None,
            "part_of_its_link": mass is not None and mass.prior_std > load.std,
        })  # fmt: skip
    return entries


def _told(parameter: Parameter) -> dict[str, Any]:
    return {key: getattr(parameter, key) for key in ("value", "std", "unit", "prior", "identifiable")}


def summaries(found: Identification, joints: Sequence[str]) -> list[Summary]:
    """Base moment, trunk torque, all joint torques, and what sensors inside the robot read, on held-out logs (on fitted
    ones where none is held out)."""
    held_out = any(fit.held_out for fit in found.validation)
    forces = {fit.channel for fit in found.validation if fit.channel.startswith("tau.") and fit.unit == "N"}
    efforts = [f"tau.{name}" for name in joints]
    torques = tuple(name for name in efforts if name not in forces)
    trunk = tuple(name for name in torques if any(word in name.lower() for word in TRUNK_WORDS))
    kinds = {
        "base_moment": BASE_MOMENT,
        "trunk_torque": trunk,
        "joint_torque": torques,
        "joint_force": tuple(name for name in efforts if name in forces),
        **{
            kind: tuple(dict.fromkeys(fit.channel for fit in found.validation if _is_reading(fit.channel, letter)))
            for kind, letter in SENSORS.items()
        },
    }
    samples = {prediction.log: prediction.time.size for prediction in found.predictions}
    pooled = []
    for kind, channels in kinds.items():
        fits = [fit for fit in found.validation if fit.channel in channels and fit.held_out == held_out]
        if fits:
            pooled.append(_pool(kind, fits, samples, held_out))
    return pooled


def _is_reading(channel: str, letter: str) -> bool:
    return channel.startswith("ft.") and channel.rsplit(".", 1)[1].startswith(letter)


def _pool(kind: str, fits: Sequence[ChannelFit], samples: Mapping[str, int], held_out: bool) -> Summary:
    weights = [samples.get(fit.log, 1) for fit in fits]

    def rms(values: Iterable[float]) -> float:
        return math.sqrt(sum(w * x * x for w, x in zip(weights, values, strict=True)) / sum(weights))

    return Summary(
        kind,
        tuple(dict.fromkeys(fit.channel for fit in fits)),
        tuple(dict.fromkeys(fit.log for fit in fits)),
        fits[0].unit,
        held_out,
        rms(fit.rmse_prior for fit in fits),
        rms(fit.rmse_identified for fit in fits),
        rms(fit.noise_floor for fit in fits),
    )


def to_json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, allow_nan=False, ensure_ascii=False, indent=1) + "\n").encode()


def parameter_table(found: Identification) -> bytes:
    """parameters.csv: one row per parameter."""
    columns = ("name", "value", "std", "unit", "prior", "prior_std", "identifiable")
    return csv_table(columns, ([getattr(each, column) for column in columns] for each in found.parameters))


def validation_table(found: Identification) -> bytes:
    """validation.csv: one row per channel and log."""
    columns = tuple(each.name for each in fields(ChannelFit))
    return csv_table(columns, ([getattr(each, column) for column in columns] for each in found.validation))
