"""From payload.yaml and its files to arrays; what is wrong is told with file, column, value and advice."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, final, get_args

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.judging import CARRYING, Carrying
from exogauge.criteria.payload_doctor import USUAL, Complaining
from exogauge.errors import BadStudy, Fault
from exogauge.logs.channels import shorten
from exogauge.logs.even_stamps import even_stamps
from exogauge.logs.noise import noise_of, quantisation_step
from exogauge.logs.open_table import open_table
from exogauge.logs.reading import refuse, time_faults, value_faults
from exogauge.logs.tables import Table, as_vector, read_names
from exogauge.logs.units import find_unit, units_of
from exogauge.payload.contract import LogEntry, PayloadFile, Role, TimeEntry, WrenchNoise
from exogauge.payload.log_names import log_names
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree
from exogauge.studies.intake.yaml_file import load_yaml, suggestion
from exogauge.studies.words.names import counted

Array = NDArray[np.float64]

ROLES: tuple[Role, ...] = get_args(Role)


@final
@dataclass(frozen=True)
class Stream:
    """time: (T,) [s] from the log's first sample. values: (T, K) SI. file: that it came from."""

    time: Array
    values: Array
    file: str

    def cut(self, first: float, last: float) -> Stream:
        keep = (self.time >= first) & (self.time <= last)
        return Stream(self.time[keep], self.values[keep], self.file)


@final
@dataclass(frozen=True)
class Steps:
    """size: (6,) [N, N·m] of the converter's steps, 0 where none are seen. noise: (6,) that a sample shows, with
    rounding; 0 where steps are coarser than the stated noise and nothing moves, and of rows."""

    size: Array
    noise: Array


NO_STEPS = Steps(np.zeros(6), np.zeros(6))


def steps_of(
    wrench: Stream, stated: WrenchNoise, *, still: bool, rows: bool = False, criteria: Carrying = CARRYING
) -> Steps:
    """still: whether nothing moves, so that rounding is no noise. rows: whether each is the mean of a posture."""
    if rows:
        size = np.array([quantisation_step(each) or 0.0 for each in wrench.values.T])
        return Steps(size, np.zeros(6))
    rate = 1.0 / float(np.median(np.diff(wrench.time)))
    told = noise_of(list(wrench.values.T), rate, criteria.above_motion * rate / 2)
    size = np.array([each.step or 0.0 for each in told])
    hidden = still & (size > np.repeat([stated.force_n, stated.moment_nm], 3))
    return Steps(size, np.where(hidden, 0.0, [each.std for each in told]))


@final
@dataclass(frozen=True)
class Recording:
    """wrench: (T, 6) as read. angles: (T, J) [rad] or None; rotation: (T, 9) R_BS or None; position: (T, 3) or None;
    acceleration: (T, 3) [m/s²] of the IMU in its own axes, or None. each_row: rows are postures, time is their number.
    evened: std [s] of stamps that jittered though samples were taken evenly, and were replaced; 0 where none were.
    steps: of what resolution the wrench is. begun: [s] stamp from which its time counts; 0 of rows.
    """

    name: str
    role: Role
    wrench: Stream
    angles: Stream | None
    rotation: Stream | None
    position: Stream | None
    acceleration: Stream | None
    each_row: bool
    evened: float = 0.0
    steps: Steps = NO_STEPS
    begun: float = 0.0

    @property
    def pose(self) -> Stream:
        chosen = self.angles or self.rotation
        assert chosen is not None
        return chosen


@final
@dataclass(frozen=True)
class Payload:
    """What was handed in. tree: of the URDF, or None where the pose is logged."""

    file: PayloadFile
    name: str
    tree: RigidTree | None
    recordings: tuple[Recording, ...]

    def of(self, role: Role) -> list[Recording]:
        return [each for each in self.recordings if each.role == role]

    @property
    def session(self) -> float | None:
        """[s] stamp at which the first log begins, where one clock went on through all of them; else None."""
        spans = sorted((each.begun + each.pose.time[[0, -1]]).tolist() for each in self.recordings)
        apart = all(end < begin for (_, end), (begin, _) in pairwise(spans))
        return spans[0][0] if apart and not any(each.each_row for each in self.recordings) else None


def open_payload(path: Path, roles: Collection[Role] = ROLES, criteria: Complaining = USUAL) -> Payload:
    """path: payload.yaml, or its folder. roles: of the logs that are read. Raises BadInput."""
    path = path / "payload.yaml" if path.is_dir() else path
    if not path.is_file():
        raise BadStudy(Fault("there is no such file", "no_file", "Name payload.yaml or its folder.", str(path)))
    file = load_yaml(path.read_bytes(), PayloadFile, file=path.name)
    _require_units(file, path.name)
    folder = path.parent
    named = [name for entry in file.logs for name in entry.file] + ([file.pose.urdf] if file.pose.urdf else [])
    missing = [name for name in dict.fromkeys(named) if not (folder / name).is_file()]
    if missing:
        advice = "Paths are relative to payload.yaml."
        raise BadStudy([Fault("there is no such file", "no_file", advice, path.name, value=name) for name in missing])
    tree = None
    if file.pose.joints is not None and file.pose.urdf is not None:
        tree = load_tree(
            (folder / file.pose.urdf).read_bytes(), joints=list(file.pose.joints), base_link=file.pose.base_link or "",
            floating=False, file=file.pose.urdf,
        )  # fmt: skip
        if file.sensor.frame not in tree.frames:
            advice = suggestion(file.sensor.frame or "", list(tree.frames))
            fault = Fault("the URDF has no such frame", "unknown_frame", advice, path.name, None, "sensor.frame")
            raise BadStudy(fault)
    named_logs = zip(log_names(file.logs, path.name), file.logs, strict=True)
    recordings = tuple(
        _recording(folder, file, entry, name, criteria) for name, entry in named_logs if entry.role in roles
    )
    if set(roles) == set(ROLES):
        _require_somewhere(file, recordings, folder, path.name)
    return Payload(file, path.name, tree, recordings)


def _require_somewhere(file: PayloadFile, recordings: Sequence[Recording], folder: Path, name: str) -> None:
    """What may be left out of a log must not be left out of all."""
    optional = {
        "imu.acceleration": (() if file.imu is None else file.imu.acceleration, [r.acceleration for r in recordings]),
        "pose.position": (file.pose.position or (), [r.position for r in recordings]),
    }
    for key, (columns, found) in optional.items():
        if columns and recordings and not any(found):
            tables = [open_table(folder / each, each) for entry in file.logs for each in entry.file]
            held = {column for table in tables for column in read_names(table)}
            lacking = next((each for each in columns if each not in held), columns[0])
            detail = "no log has all of these columns"
            advice = suggestion(lacking, sorted(held))
            raise BadStudy(Fault(detail, "missing_column", advice, name, None, key, shorten(lacking)))


def _recording(folder: Path, file: PayloadFile, entry: LogEntry, name: str, criteria: Complaining) -> Recording:
    tables = [open_table(folder / name, name) for name in entry.file]
    sensor, pose, imu = file.sensor, file.pose, file.imu
    clocks, begun = (None, 0.0) if entry.each_row else _clocks(tables, file, criteria)

    def stream(columns: Sequence[str], unit: str, dimension: str, late: float = 0.0) -> Stream:
        table = _holding(tables, columns)
        factor = factor_of(unit, dimension, table.file)
        raw = table.read(list(columns))
        values = np.column_stack([np.asarray(as_vector(raw[c], table.file, c), np.float64) for c in columns])
        faults = [
            fault
            for column, each in zip(columns, values.T, strict=True)
            for fault in value_faults(each, table.file, column, allow_gaps=False)
        ]
        refuse(faults)
        time = np.arange(len(values), dtype=np.float64) if clocks is None else clocks[table.file] - late
        return Stream(time, values * factor, table.file)

    force = stream(sensor.wrench, sensor.force_unit, "force")
    moment_factor = factor_of(sensor.moment_unit, "torque", force.file) / factor_of(
        sensor.force_unit, "force", force.file
    )
    wrench = Stream(force.time, force.values * np.repeat([1.0, moment_factor], 3), force.file)
    angles = rotation = position = acceleration = None
    if pose.joints is not None:
        angles = stream(list(pose.joints.values()), pose.angle_unit, "angle")
        check_angles(angles, list(pose.joints.values()), criteria)
    elif pose.rotation is not None:
        rotation = stream(pose.rotation, "1", "ratio")
        check_rotation(rotation, pose.rotation[0], criteria)
    elif pose.quaternion is not None:
        rotation = from_quaternion(stream(pose.quaternion, "1", "ratio"), pose.quaternion_order or "xyzw", criteria)
    names = {name for table in tables for name in read_names(table)}
    if pose.position is not None and set(pose.position) <= names:
        position = stream(pose.position, pose.position_unit, "length")
    if imu is not None and set(imu.acceleration) <= names:
        acceleration = stream(imu.acceleration, imu.unit, "acceleration", imu.delay_s or 0.0)
    parts = [wrench, angles, rotation, position, acceleration]
    evened = 0.0
    pose_read = angles or rotation
    if clocks is not None and pose_read is not None:
        even = even_stamps(pose_read.time, pose_read.values)
        evened = float(np.std(even - pose_read.time))
        if evened > 0.0:
            first, clock = pose_read.file, even
            parts = [replace(each, time=clock - (clocks[first] - each.time)) if each and each.file == first else each
                     for each in parts]  # fmt: skip
    if entry.span is not None:
        parts = [None if each is None else each.cut(*entry.span) for each in parts]
    present = [each for each in parts if each is not None]
    if any(len(each.time) < 2 for each in present) or (
        not entry.each_row and max(each.time[0] for each in present) >= min(each.time[-1] for each in present)
    ):
        spans = "; ".join(f"{each.file} {_span(each)}" for each in present)
        advice = "All files of a log must count time from the same instant; check `time.unit` and `span`."
        raise BadStudy(Fault(f"the clocks do not overlap: {spans}", "clocks_apart", advice, entry.file[0]))
    assert parts[0] is not None
    steps = steps_of(parts[0], sensor.noise, still=entry.role == "postures", rows=entry.each_row)
    return Recording(
        name, entry.role, parts[0], parts[1], parts[2], parts[3], parts[4], entry.each_row, evened, steps, begun
    )


def _span(stream: Stream) -> str:
    return f"{stream.time[0]:.3f} to {stream.time[-1]:.3f} s" if len(stream.time) else "nothing"


def _clocks(tables: Sequence[Table], file: PayloadFile, criteria: Complaining) -> tuple[dict[str, Array], float]:
    """Seconds per file, 0 at the earliest sample of all, and [s] its stamp; whole stamps are subtracted before they
    become floats."""
    column, factor = file.time.column, factor_of(file.time.unit, "time", tables[0].file)
    raw = {}
    for table in tables:
        if column not in read_names(table):
            raise BadStudy(_no_column(column, [table], "Name it in `time.column`, or say `each_row: true`."))
        raw[table.file] = as_vector(table.read([column], exact=(column,))[column], table.file, column)
        if len(raw[table.file]) < criteria.fewest_samples:
            detail, advice = f"the log has {counted(len(raw[table.file]), 'sample')}", "Record a few seconds at least."
            raise BadStudy(Fault(detail, "too_few_samples", advice, table.file))
        refuse(time_faults(raw[table.file], table.file, column))
        _require_rate(raw[table.file], file.time, table.file, criteria)
    first = min(values[0] for values in raw.values())
    return {name: np.asarray(values - first, np.float64) * factor for name, values in raw.items()}, float(
        first
    ) * factor


def _require_rate(time: Array, entry: TimeEntry, file: str, criteria: Complaining) -> None:
    """Raises BadStudy where no sensor samples so often or so seldom as `time.unit` says."""
    step, (least, most) = float(np.median(np.diff(time))), criteria.rates_hz

    def rate(unit: str) -> float:
        return 1.0 / (step * factor_of(unit, "time", file))

    if least <= rate(entry.unit) <= most:
        return
    others = [f"`time.unit: {unit}`" for unit in units_of(("time",)) if least <= rate(unit) <= most]
    detail = f"by `time.unit: {entry.unit}` there are {rate(entry.unit):.3g} samples a second"
    advice = f"Say {' or '.join(others)}." if others else f"Record {least:g} to {most:g} a second."
    raise BadStudy(Fault(detail, "time_unit", advice, file, 2, shorten(entry.column), f"{step:g} from row to row"))


def _holding(tables: Sequence[Table], columns: Sequence[str]) -> Table:
    """The file that has all of the columns."""
    for table in tables:
        if set(columns) <= set(read_names(table)):
            return table
    best = max(tables, key=lambda table: len(set(columns) & set(read_names(table))))
    lacking = next(column for column in columns if column not in read_names(best))
    raise BadStudy(_no_column(lacking, [best], ""))


def _no_column(column: str, tables: Sequence[Table], advice: str) -> Fault:
    names = [name for table in tables for name in read_names(table)]
    return Fault(
        "the file has no such column", "missing_column", f"{advice} {suggestion(column, names)}".strip(),
        tables[0].file, 0, shorten(column),
    )  # fmt: skip


def factor_of(unit: str, dimension: str, file: str, key: str | None = None) -> float:
    """key: of payload.yaml, where the unit stands."""
    found = find_unit(unit)
    if found is None or found.dimension != dimension:
        advice = f"Known: {', '.join(units_of((dimension,)))}."
        detail = f"{shorten(unit)!r} is no unit of {dimension}"
        raise BadStudy(Fault(detail, "unknown_unit", advice, file, None, key, shorten(unit)))
    return found.factor


def _require_units(file: PayloadFile, name: str) -> None:
    sensor, pose, imu = file.sensor, file.pose, file.imu
    stated = [(sensor.force_unit, "force", "sensor.force_unit"), (sensor.moment_unit, "torque", "sensor.moment_unit"),
              (pose.angle_unit, "angle", "pose.angle_unit"), (pose.position_unit, "length", "pose.position_unit"),
              (file.time.unit, "time", "time.unit"),
              *([(imu.unit, "acceleration", "imu.unit")] if imu else [])]  # fmt: skip
    for unit, dimension, key in stated:
        factor_of(unit, dimension, name, key)


def check_angles(angles: Stream, columns: Sequence[str], criteria: Complaining = USUAL) -> None:
    k = int(np.argmax(np.abs(angles.values).max(axis=0)))
    most = float(np.abs(angles.values[:, k]).max())
    if most > criteria.most_turn_rad:
        advice = "If the column is in degrees, say `pose.angle_unit: deg`."
        detail = f"an angle of {most:.4g} rad is more than a joint turns"
        raise BadStudy(Fault(detail, "angle_too_large", advice, angles.file, column=columns[k], value=f"{most:.6g}"))


def check_rotation(rotation: Stream, column: str, criteria: Complaining = USUAL) -> None:
    R = rotation.values.reshape(-1, 3, 3)
    off = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
    wrong = (off > criteria.orthonormal) | (np.linalg.det(R) < 0)
    if wrong.any():
        k = int(np.argmax(wrong))
        advice = "Name the nine entries row by row: r11, r12, r13, r21, …"
        detail = "these nine numbers are no rotation (RᵀR = 1, det = 1)"
        fault = Fault(detail, "not_a_rotation", advice, rotation.file, k + 1, shorten(column), f"{off[k]:.3g}")
        raise BadStudy(fault)


def from_quaternion(stream: Stream, order: str, criteria: Complaining = USUAL) -> Stream:
    from scipy.spatial.transform import Rotation

    size = np.linalg.norm(stream.values, axis=1)
    if np.abs(size - 1.0).max() > criteria.orthonormal:
        k = int(np.argmax(np.abs(size - 1.0)))
        detail, advice = "a quaternion of another length than 1", "Check which four columns it is."
        raise BadStudy(Fault(detail, "not_a_quaternion", advice, stream.file, k + 1, value=f"{size[k]:.6g}"))
    R = Rotation.from_quat(stream.values, scalar_first=order == "wxyz").as_matrix()
    return Stream(stream.time, R.reshape(-1, 9), stream.file)


def summary(payload: Payload) -> dict[str, Any]:
    """What a list shows of it, before anything is identified. logs: rate_hz and duration_s of the wrench, None where
    each row is one posture. plan: joints that move."""
    file = payload.file
    pose = file.pose
    return {
        "name": file.name,
        "gravity": list(file.gravity),
        "sensor": file.sensor.model_dump(mode="json"),
        "pose": "joints" if pose.joints else "quaternion" if pose.quaternion else "rotation",
        "joints": list(pose.joints or ()),
        "imu": file.imu is not None,
        "settings": file.settings.model_dump(mode="json"),
        "ground_truth": file.ground_truth.model_dump(mode="json"),
        "logs": [
            {"file": list(entry.file)} | _seen(each) for entry, each in zip(file.logs, payload.recordings, strict=True)
        ],
        "plan": None if file.plan is None else {"joints": list(file.plan.joints)},
    }


def _seen(recording: Recording) -> dict[str, Any]:
    time = recording.wrench.time
    duration = None if recording.each_row else float(time[-1] - time[0])
    rate = None if not duration else (len(time) - 1) / duration
    return {
        "name": recording.name,
        "role": recording.role,
        "samples": len(time),
        "rate_hz": rate,
        "duration_s": duration,
    }
