"""series/<log>.parquet: what was measured and what each model predicts, on the log's own sample times.

A log as it was read has the same form.

Columns of a series file as they are gathered: names, units and values on one set of sample times.

How the joints moved, for plots: positions and currents as logged, and what the fit took of them.

The columns of a log with a device: supporting torques with their uncertainty, phases of the motion, bands.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import ArrayLike

from exogauge.identification.result import Prediction
from exogauge.logs.channels import Channel, parse_channel
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.robots.parameters import of_slide
from exogauge.support.result import Array, Trial

ROW_GROUP = 12_000


@final
@dataclass(frozen=True)
class Moved:
    """The log of a series, whose robot moved, and the low-pass of the fit [Hz]."""

    robot: Robot
    log: Log
    cutoff_hz: float


def series_table(prediction: Prediction, trial: Trial | None = None, moved: Moved | None = None) -> pa.Table:
    """`t`, then `measured.`, `predicted.`, `predicted_prior.` per channel; the unit is in each field's metadata.

    trial: for a log with a device, its supporting torques, phases and bands as well. moved: for how its joints moved.
    """
    columns = Columns(prediction.time)
    told = prediction.channels()
    parts = (
        ("measured", told.measured),
        ("predicted", told.predicted),
        ("predicted_prior", told.predicted_prior),
    )
    for channel in told.measured:
        for part, values in parts:
            if channel in values:
                columns.add(f"{part}.{channel}", values[channel], prediction.units.get(channel, ""))
    if moved is not None:
        add_motion(columns, moved.robot, moved.log, moved.cutoff_hz)
    metadata = {"log": prediction.log, "held_out": "true" if prediction.held_out else "false", "version": "1"}
    if trial is not None:
        add_support(columns, trial)
        add_phases(columns, trial)
        add_bands(columns, trial)
        metadata |= {"device": trial.device, "motion": trial.motion, "reference": trial.reference or ""}
    return columns.table(metadata)


def raw_table(log: Log, units: Mapping[str, str]) -> pa.Table:
    """`t` and every channel of a log as it was read, with its unit."""
    columns = Columns(log.time)
    for channel, values in log.channels.items():
        columns.add(channel, values, units[channel])
    return columns.table({"log": log.name, "version": "1"})


def write_series(prediction: Prediction, path: Path, trial: Trial | None = None, moved: Moved | None = None) -> None:
    write_table(series_table(prediction, trial, moved), path)


def write_table(table: pa.Table, path: Path) -> None:
    words = [field.name for field in table.schema if pa.types.is_dictionary(field.type)]
    pq.write_table(table, path, compression="zstd", use_dictionary=words, row_group_size=ROW_GROUP)


@final
class Columns:
    """`t` [s] and what is added to it; NaN and infinity become null."""

    def __init__(self, time: ArrayLike) -> None:
        self._fields: list[Any] = [pa.field("t", pa.float64(), False, {"unit": "s"})]
        self._arrays: list[Any] = [pa.array(np.asarray(time, dtype=np.float64))]

    def add(self, name: str, values: ArrayLike, unit: str, short: bool = False) -> None:
        """short: in seven digits, more than any sensor has; half as large."""
        column = np.asarray(values, dtype=np.float32 if short else np.float64)
        self._fields.append(pa.field(name, pa.float32() if short else pa.float64(), True, {"unit": unit}))
        self._arrays.append(pa.array(column, mask=~np.isfinite(column)))

    def add_truth(self, name: str, values: ArrayLike) -> None:
        self._fields.append(pa.field(name, pa.bool_(), False))
        self._arrays.append(pa.array(np.asarray(values, dtype=np.bool_)))

    def add_words(self, name: str, index: ArrayLike, words: tuple[str, ...]) -> None:
        """Sample by sample one of a few words."""
        column = pa.DictionaryArray.from_arrays(pa.array(np.asarray(index, dtype=np.int32)), pa.array(words))
        self._fields.append(pa.field(name, column.type, False))
        self._arrays.append(column)

    def table(self, metadata: Mapping[str, str]) -> pa.Table:
        return pa.table(self._arrays, schema=pa.schema(self._fields, dict(metadata)))


def add_motion(columns: Columns, robot: Robot, log: Log, cutoff_hz: float) -> None:
    """`measured.q.<joint>`, `measured.i.<joint>`, then `filtered.` q, dq, ddq and i: low-passed at the cut-off of the
    fit, and differentiated after, as `identification.preparation` does."""
    names = [joint.name for joint in robot.joints]
    driven = [joint.name for joint in robot.joints if joint.actuation == "current"]
    low_pass = LowPass(cutoff_hz, log.rate_hz)
    raw = {"q": log.stack([f"q.{name}" for name in names])}
    q = low_pass.apply(raw["q"])
    filtered = {"q": q, "dq": differentiate(q, log.rate_hz), "ddq": differentiate_twice(q, log.rate_hz)}
    if driven:
        raw["i"] = log.stack([f"i.{name}" for name in driven])
        filtered["i"] = low_pass.apply(raw["i"])
    for part, found in (("measured", raw), ("filtered", filtered)):
        for kind, values in found.items():
            for k, name in enumerate(driven if kind == "i" else names):
                unit = unit_of(parse_channel(f"{kind}.{name}"), robot.tree.sliding)
                columns.add(f"{part}.{kind}.{name}", values[:, k], unit, short=part == "filtered")


def unit_of(channel: Channel, sliding: Set[str]) -> str:
    """sliding: prismatic joints, whose positions are lengths and whose efforts are forces."""
    if not channel.of_joint or channel.subject not in sliding:
        return channel.unit
    return of_slide(channel.unit)


TORQUE, LENGTH, FORCE = "N·m", "m", "N"


def add_support(columns: Columns, trial: Trial) -> None:
    """`support_a.<joint>` … with `_std`, and `_low`, `_high`, the ends of the interval where friction leaves only one.

    support_compared, support_steady, support_rest: where A compares like with like, where the joint moves steadily,
    where it stands still.
    """
    by_approach = {
        "a": (trial.support_a, trial.support_a_std, *interval(trial.low_a, trial.high_a)),
        "b": (trial.support_b, trial.support_b_std, *interval(trial.low_b, trial.high_b)),
        "paired": (
            trial.support_paired,
            trial.support_paired_std,
            *interval(trial.low_paired, trial.high_paired),
        ),
        "prior": (trial.support_prior, None, None, None),
        "band_model": (trial.band_model, None, None, None),
    }
    for k, joint in enumerate(trial.joints):
        for approach, parts in by_approach.items():
            for part, values in zip(("", "_std", "_low", "_high"), parts, strict=True):
                if values is not None:
                    columns.add(f"support_{approach}{part}.{joint}", values[:, k], TORQUE)
        if trial.support_a is not None:
            columns.add_truth(f"support_compared.{joint}", trial.compared[:, k])
        columns.add_truth(f"support_steady.{joint}", trial.steady[:, k])
        columns.add_truth(f"support_rest.{joint}", trial.rest[:, k])


def interval(low: Array | None, high: Array | None) -> tuple[Array | None, Array | None]:
    """Its ends, NaN where both are one number."""
    if low is None or high is None:
        return None, None
    wide = high > low
    return np.where(wide, low, np.nan), np.where(wide, high, np.nan)


def add_phases(columns: Columns, trial: Trial) -> None:
    columns.add_words("phase", trial.phase, trial.phase_names)


def add_bands(columns: Columns, trial: Trial) -> None:
    for band, length in trial.length.items():
        columns.add(f"band.{band}.length", length, LENGTH)
        if band in trial.tension:
            columns.add(f"band.{band}.tension", trial.tension[band], FORCE)
