"""The formats by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from pydantic import ValidationError

from exogauge.errors import BadInput, Fault
from exogauge.payload.exports import controllers, plain_values, simulators
from exogauge.payload.exports.body import Body, body_of, in_flange
from exogauge.payload.schema import PayloadResults
from exogauge.studies.intake.yaml_file import suggestion


@final
@dataclass(frozen=True)
class Format:
    """suffix: of the file. media_type: of an answer. of_flange: whether its reader takes it to be in the flange."""

    write: Callable[[Body], str]
    suffix: str
    media_type: str
    title: str
    of_flange: bool = False


PLAIN, XML = "text/plain; charset=utf-8", "application/xml"
FORMATS: dict[str, Format] = {
    "json": Format(plain_values.as_json, ".json", "application/json", "JSON"),
    "csv": Format(plain_values.as_csv, ".csv", "text/csv; charset=utf-8", "CSV"),
    "urdf": Format(simulators.urdf, ".urdf", XML, "URDF <inertial>"),
    "sdf": Format(simulators.sdf, ".sdf", XML, "SDFormat <inertial>"),
    "mjcf": Format(simulators.mjcf, ".xml", XML, "MJCF <inertial>"),
    "ur": Format(controllers.set_target_payload, ".script", PLAIN, "UR set_target_payload", True),
    "kuka": Format(controllers.load_data, ".dat", PLAIN, "KUKA LOAD_DATA", True),
    "abb": Format(controllers.loaddata, ".mod", PLAIN, "ABB loaddata", True),
}


def export(found: PayloadResults, name: str, flange: Sequence[float] | None = None) -> str:
    """flange: pose of the sensor in the flange, x, y, z [m], roll, pitch, yaw [°]; without it all is in the sensor's
    frame. Raises BadInput."""
    body = body_of(found)
    return format_of(name).write(body if flange is None else in_flange(body, flange))


def format_of(name: str) -> Format:
    found = FORMATS.get(name)
    if found is None:
        advice = suggestion(name, list(FORMATS))
        raise BadInput(Fault("there is no such format", "unknown_format", advice, column="format", value=name))
    return found


def read_results(path: Path) -> PayloadResults:
    """path: results.json of a payload, or its folder. Raises BadInput."""
    path = path / "results.json" if path.is_dir() else path
    if not path.is_file():
        raise BadInput(Fault("there is no such file", "no_file", "Name results.json or its folder.", str(path)))
    return results_from(path.read_bytes(), path.name)


def results_from(content: bytes, file: str) -> PayloadResults:
    try:
        return PayloadResults.model_validate_json(content)
    except ValidationError as error:
        advice = "Name results.json of `exogauge payload run`, made by this version."
        raise BadInput([
            Fault(entry["msg"], "bad_results", advice, file, column=".".join(map(str, entry["loc"])))
            for entry in error.errors()[:10]
        ]) from error  # fmt: skip
