"""What a changed device would do over a recorded motion, from files to tables, JSON and series; and its
words on a terminal.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, final

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.devices.bench import Bench
from exogauge.devices.changes import apply
from exogauge.devices.what_if import BandLoad, JointLoad, WhatIf, compare
from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.robots.tree import RigidTree
from exogauge.studies.device_pages.change_entries import ChangeEntry, ChangesFile, WhatIfSettings
from exogauge.studies.device_pages.change_text import read_change
from exogauge.studies.device_pages.device_content import device_content, write_device
from exogauge.studies.device_pages.entry_changes import changes_of
from exogauge.studies.intake.bundle import Bundle, open_bundle
from exogauge.studies.intake.yaml_file import load_yaml
from exogauge.studies.series.recorded_motion import RecordedMotion, read_motion
from exogauge.studies.series.write import Columns
from exogauge.studies.words.remark_words import sentence
from exogauge.terminal import text_table

Array = NDArray[np.float64]

RESULT, SERIES, DEVICE = "what_if.json", "series/what_if.parquet", "device.yaml"
TORQUE_DIGITS, LENGTH_DIGITS, TIME_DIGITS = 4, 5, 6  # decimals of a series in JSON: 0.1 mN·m, 10 µm, 1 µs
WHEN = ("before", "after")


@final
@dataclass(frozen=True)
class Asked:
    """One question, answered. root: folder of the study, None where it came as a zip."""

    motion: RecordedMotion
    found: WhatIf
    root: Path | None

    def answer(self) -> dict[str, Any]:
        return answer(self.found, self.motion)

    def text(self) -> str:
        return what_if_text(self.found, self.motion)

    def save(self, path: Path) -> list[Path]:
        return write_device(self.found.changed, path, self.root)


def ask(study: Path, log: str, device: str | None, words: Sequence[tuple[str, str]], main: Sequence[str]) -> Asked:
    """study: as for `open_bundle`. log: a file on this machine, or else a name in study.yaml. device: a file of the
    study, or else on this machine. words: (option, text) in order, see `change_text`; option `changes`: text is a YAML
    file of changes. Raises BadInput where anything of it is wrong."""
    entries, places = list[ChangeEntry](), list[str]()
    for option, text in words:
        if option == "changes":
            read = _changes_file(Path(text))
            entries += read
            places += [f"{text}: changes.{k}" for k in range(len(read))]
        else:
            entries.append(read_change(option, text))
            places.append(f"--{option} {text}")
    bundle = open_bundle(study)
    try:
        motion = read_motion(bundle, Path(log) if Path(log).is_file() else log, _placed(device, bundle))
    finally:
        bundle.close()
    try:
        changed = apply(motion.device, changes_of(entries), motion.tree)
    except BadInput as bad:
        raise type(bad)([replace(each, column=places[_index(each)]) for each in bad.faults]) from None
    found = compare(Bench(motion.tree, motion.device, motion.q, motion.time), changed, main)
    return Asked(motion, found, None if study.suffix == ".zip" else bundle.root)


def _placed(device: str | None, bundle: Bundle) -> str | Path | None:
    if device is None or (not Path(device).is_absolute() and (bundle.root / device).is_file()):
        return device
    return Path(device) if Path(device).is_file() else device


def _index(fault: Fault) -> int:
    """Of the change that a fault of `apply` is about: its column is `changes.<index>.<key>`."""
    return int((fault.column or "").split(".")[1])


def _changes_file(path: Path) -> list[ChangeEntry]:
    if not path.is_file():
        raise BadStudy(Fault("no such file", "missing_file", "", str(path)))
    return load_yaml(path.read_bytes(), ChangesFile, file=path.name).changes


def compute(folder: Path, out: Path, progress: Callable[[float, str], None], settings: Mapping[str, Any]) -> None:
    """The job of kind `whatif`: all samples of the log; what_if.json, the series, and the changed device.

    folder: of the study. settings: as `WhatIfSettings` says.
    """
    asked = WhatIfSettings.model_validate(settings)
    bundle = open_bundle(folder)
    progress(0.0, "reading the log")
    motion = read_motion(bundle, asked.log, asked.device)
    progress(0.6, "asking the bands")
    changed = apply(motion.device, changes_of(asked.changes), motion.tree, "settings.changes")
    found = compare(Bench(motion.tree, motion.device, motion.q, motion.time), changed, asked.main)
    progress(0.8, "writing the answer")
    (out / SERIES).parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(series_table(found, motion.tree, motion.log), out / SERIES, compression="zstd")
    if changed.bands:
        write_device(changed, out / DEVICE)
    (out / f"{RESULT}.part").write_bytes(to_json(answer(found, motion) | {"settings": asked.model_dump(mode="json")}))
    os.replace(out / f"{RESULT}.part", out / RESULT)
    progress(1.0, "done")


def answer(found: WhatIf, motion: RecordedMotion) -> dict[str, Any]:
    """What the CLI prints, the job keeps and the API answers."""
    return {
        "log": motion.log,
        "device": {"file": motion.device_file, "name": motion.device.name},
        "samples": len(motion.time),
        "of_samples": motion.of_samples,
        "every": motion.every,
        "duration_s": float(motion.time[-1] - motion.time[0]),
        "cutoff_hz": motion.cutoff_hz,
        "joints": [
            {
                "joint": each.joint,
                "unit": unit_of(motion.tree, each.joint),
                "before": joint_entry(each.before),
                "after": joint_entry(each.after),
                "percent": dict(each.percent),
            }
            for each in found.joints
        ],
        "main": list(found.main),
        "interference": [asdict(each) for each in found.interference],
        "bands": [
            {"band": each.band, "before": band_entry(each.before), "after": band_entry(each.after)}
            for each in found.bands
        ],
        "notes": [sentence(note) for note in found.notes],
        "changed": device_content(found.changed),
    }


def joint_entry(load: JointLoad) -> dict[str, float]:
    return {key: getattr(load, key) for key in ("peak", "mean", "rms", "integral", "work")}


def band_entry(load: BandLoad | None) -> dict[str, float] | None:
    if load is None:
        return None
    return {
        "tension_max_n": load.tension_max,
        "length_min_m": load.length_min,
        "length_max_m": load.length_max,
        "stretch_max": load.stretch_max,
        "slack_share": load.slack_share,
    }


def series(found: WhatIf) -> dict[str, Any]:
    """Sample by sample: torque of each joint, tension and length of each band; None where a band is not there."""

    def of_band(load: BandLoad | None) -> dict[str, Any] | None:
        if load is None:
            return None
        return {"tension_n": _rounded(load.tension, TORQUE_DIGITS), "length_m": _rounded(load.length, LENGTH_DIGITS)}

    return {
        "t": _rounded(found.time, TIME_DIGITS),
        "joints": {
            each.joint: {when: _rounded(getattr(each, when).torque, TORQUE_DIGITS) for when in WHEN}
            for each in found.joints
        },
        "bands": {each.band: {when: of_band(getattr(each, when)) for when in WHEN} for each in found.bands},
    }


def series_table(found: WhatIf, tree: RigidTree, log: str) -> Any:
    """`t`, `before.<joint>`, `after.<joint>`, `band.<name>.length.before` … `.tension.after`."""
    columns = Columns(found.time)
    for joint in found.joints:
        for when in WHEN:
            columns.add(f"{when}.{joint.joint}", getattr(joint, when).torque, unit_of(tree, joint.joint))
    for band in found.bands:
        for when in WHEN:
            load: BandLoad | None = getattr(band, when)
            if load is not None:
                columns.add(f"band.{band.band}.length.{when}", load.length, "m")
                columns.add(f"band.{band.band}.tension.{when}", load.tension, "N")
    return columns.table({"log": log, "device": found.device.name, "version": "1"})


def to_json(said: Mapping[str, Any]) -> bytes:
    return json.dumps(said, ensure_ascii=False, indent=1, allow_nan=False).encode() + b"\n"


def _rounded(values: Array, digits: int) -> list[float]:
    rounded: list[float] = np.round(values, digits).tolist()
    return rounded


def what_if_text(found: WhatIf, motion: RecordedMotion) -> str:
    """Joints and bands before and after, for a terminal."""
    kept = f"{len(motion.time)} samples" if motion.every == 1 else f"{len(motion.time)} of {motion.of_samples} samples"
    head = f"{motion.log}, {kept}, {motion.time[-1] - motion.time[0]:.1f} s; {motion.device.name}"
    parts = [head, _joint_text(found, motion.tree), _band_text(found)]
    return "\n\n".join([*parts, *(f"NOTE {sentence(note)}" for note in found.notes)])


def _joint_text(found: WhatIf, tree: RigidTree) -> str:
    """Main joints first, then the others by what comes after."""
    shares = {each.joint: each for each in found.interference}
    order = sorted(found.joints, key=lambda each: (each.joint not in found.main, -each.after.rms))
    columns = (
        "joint",
        "unit",
        "peak",
        "→",
        "change %",
        "mean",
        "→",
        "change %",
        "rms",
        "→",
        "change %",
        "share %",
        "→",
    )
    rows: list[Sequence[Any]] = []
    for each in order:
        row: list[Any] = [each.joint + (" *" if each.joint in found.main else ""), unit_of(tree, each.joint)]
        for measure in ("peak", "mean", "rms"):
            percent = each.percent[measure]
            row += [f"{getattr(each.before, measure):.2f}", f"{getattr(each.after, measure):.2f}"]
            row.append("–" if percent is None else f"{percent:.1f}")
        share = shares.get(each.joint)
        row += [
            "–" if value is None else f"{100 * value:.1f}" for value in (share and share.before, share and share.after)
        ]
        rows.append(row)
    legend = "* what the device is for; share: rms as a share of theirs. Torque is positive along the joint."
    return f"{text_table(columns, rows)}\n{legend}"


def _band_text(found: WhatIf) -> str:
    columns = ("band", "", "N/m", "rest m", "shortest m", "longest m", "stretch %", "largest N", "slack %")
    values = {"before": found.device, "after": found.changed}
    rows: list[Sequence[Any]] = []
    for each in found.bands:
        for when, device in values.items():
            load: BandLoad | None = getattr(each, when)
            band = next((band for band in device.bands if band.name == each.band), None)
            if load is None or band is None:
                rows.append([each.band, when, *["–"] * 7])
                continue
            rows.append([
                each.band, when, f"{band.stiffness:.4g}", f"{band.natural_length:.4f}", f"{load.length_min:.4f}",
                f"{load.length_max:.4f}", f"{100 * load.stretch_max:.1f}", f"{load.tension_max:.1f}",
                f"{100 * load.slack_share:.0f}",
            ])  # fmt: skip
    return text_table(columns, rows)


def unit_of(tree: RigidTree, joint: str) -> str:
    return "N" if joint in tree.sliding else "N·m"
