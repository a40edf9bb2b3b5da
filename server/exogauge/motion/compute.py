"""What the service computes of motions: bodies fitted to captures, and plans, as `compute(folder, out, report,
settings)`.

folder of a motion: motion.yaml and its files. folder of a plan: plan.yaml, and below `robot`, `motion` and `study` the
files of what it names.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from exogauge.criteria.motion_excite import USUAL as EXCITE
from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion, Fault
from exogauge.motion import played
from exogauge.motion.channels import add_judged, of_fit, of_retargeted
from exogauge.motion.contract import PlanFile
from exogauge.motion.excite.plan import SEARCH, ExcitationPlan, motion_table, plan_excitation
from exogauge.motion.figure import figure_of, write_figure
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.fit.told import angle_table, summarise
from exogauge.motion.intake import Capture, contacts_from, open_capture
from exogauge.motion.person import person_of, person_of_fit
from exogauge.motion.plan.export import exported, sheet
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.solve import Round
from exogauge.motion.plan_document import excite_document, retarget_document
from exogauge.motion.retargeting import retargeted
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.stance import Standing
from exogauge.robots.moving.touching import Pairs
from exogauge.studies.intake.yaml_file import load_yaml
from exogauge.studies.series.write import Columns, write_table

Progress = Callable[[float, str], None]
FIT, PLAN, PLAN_YAML, MOTION, FIGURE, PLAYED = (
    "fit.json", "plan.json", "plan.yaml", "motion.csv", "human.npz", "played.npz",
)  # fmt: skip
SERIES = "series/motion.parquet"
EXCITED_HZ = 200.0  # at which a motion that excites is written
SLOWLY = 8.0  # rounds after which a search is two thirds told; nobody knows how many it takes


def fit(folder: Path, out: Path, progress: Progress, settings: Mapping[str, Any]) -> None:
    """fit.json; angles.mot, their series, and the figure that is drawn."""
    progress(0.0, "reading the capture")
    capture = open_capture(folder)
    progress(0.1, "fitting a body")
    found = fit_human(capture.motion, capture.static)
    progress(0.95, "writing")
    scales = [{"name": name, "value": float(value), "std": float(found.scale_sd[name])}
              for name, value in found.scale.items()]  # fmt: skip
    points = [{"label": label, "rms_m": float(rms)}
              for label, rms in zip(found.labels, found.residual, strict=True)]  # fmt: skip
    document = {"version": 1, "name": capture.name, "told": summarise(found), "rms_m": found.rms, "scales": scales,
                "points": points}  # fmt: skip
    write_document(out / FIT, document)
    (out / "angles.mot").write_bytes(angle_table(found))
    write_series(of_fit(found), out)
    write_figure(figure_of(capture.motion, found), out / FIGURE)


def retarget(folder: Path, out: Path, progress: Progress, settings: Mapping[str, Any]) -> None:
    """plan.json, motion.csv with what tells of it, series, and what is drawn."""
    progress(0.0, "reading the robot")
    file = _asked(folder, "retarget")
    assert file.retarget is not None
    robot = load_motion_robot(folder / "robot" / "robot.yaml")
    progress(0.02, "reading the capture")
    capture = _with_contacts(open_capture(folder / "motion"), file)
    progress(0.06, "fitting a body" if capture.motion.markers is not None else "taking its skeleton")
    fitted = None if capture.motion.markers is None else fit_human(capture.motion, capture.static)
    person = person_of(capture.motion) if fitted is None else person_of_fit(fitted, capture.motion.contacts)

    def tell(now: Round) -> None:
        done = (now.part + 1.0 - math.exp(-now.number / SLOWLY)) / now.parts
        progress(0.1 + 0.8 * done, f"planning: stretch {now.part + 1} of {now.parts}, round {now.number}")

    def tried(what: str, value: float, nodes: int, holds: bool) -> None:
        progress(0.9, f"what would do: {what} {value:.2f} {'holds' if holds else 'does not hold'}")

    found = retargeted(robot, person, file.retarget, tell, tried)
    progress(0.95, "writing")
    write_document(out / PLAN, retarget_document(found))
    files = {f"motion{end}": data for end, data in exported(robot, found.planned.spline, found.judged, "csv").items()}
    for name, data in files.items():
        (out / name).write_bytes(data)
    write_document(out / "motion.json", sheet(robot, found.judged, "csv", files, _sources(folder)))
    write_series(of_retargeted(found), out)
    write_figure(figure_of(capture.motion, fitted), out / FIGURE)
    played.of_retargeted(found, file.retarget).write(out / PLAYED)


def excite(folder: Path, out: Path, progress: Progress, settings: Mapping[str, Any]) -> None:
    """The same of a motion that identifies; promise.json: how well every parameter will be known."""
    progress(0.0, "reading the robot")
    file = _asked(folder, "excite")
    assert file.excite is not None
    study = folder / "study" / "study.yaml"

    most = EXCITE.steps * len(EXCITE.costs)

    def tell(start: int, count: int, cost: float, largest: float) -> None:
        done = (start - 1 + min(count / most, 1.0)) / EXCITE.starts
        progress(SEARCH[0] + done * (SEARCH[1] - SEARCH[0]),
                 f"search {start}, motion {count} of {most}: nearest bound {100 * largest:.0f} %")  # fmt: skip

    found = plan_excitation(
        folder / "robot" / "robot.yaml", file.excite.seconds, study=study if study.is_file() else None,
        seed=file.excite.seed, report=tell, say=progress,
    )  # fmt: skip
    progress(0.95, "writing")
    document, judged, acceleration = excitation_document(found)
    write_document(out / PLAN, document)
    (out / MOTION).write_bytes(motion_table(found, EXCITED_HZ))
    columns = add_judged(Columns(judged.time), found.robot, judged, acceleration)
    write_series(columns.table({"log": "motion", "version": "1"}), out)
    played.of_judged(found.robot, judged, acceleration).write(out / PLAYED)


def excitation_document(found: ExcitationPlan) -> tuple[dict[str, Any], Judged, Any]:
    """plan.json, whoever asked; with what it was judged by, as `judged_excitation`."""
    judged, acceleration = judged_excitation(found)
    return excite_document(found, judged, acceleration), judged, acceleration


def judged_excitation(found: ExcitationPlan) -> tuple[Judged, Any]:
    """At `EXCITED_HZ`, with the accelerations (T, n); of a robot on a fixed base, which has no balance, NaN."""
    robot, planned = found.robot, found.planned
    time = np.arange(int(planned.duration * EXCITED_HZ + 1e-6) + 1) / EXCITED_HZ
    q, v, a = planned.at(time)
    stance = planned.task.stance
    if isinstance(stance, Standing):
        return judge(robot, planned, stance.place, rate=EXCITED_HZ), a
    torque = np.stack([pin.rnea(robot.model, robot.data, *each) for each in zip(q, v, a, strict=True)])
    none = np.full(len(time), np.nan)
    lost = np.full((len(time), 3), np.nan)
    apart = np.full(len(time), USUAL.look_m)
    pairs = Pairs(robot, USUAL.clearance_m)
    near = pairs.near(q, USUAL.look_m)
    np.minimum.at(apart, near.sample, near.distance)
    nearest = None
    if len(near.distance):
        k = int(near.distance.argmin())
        nearest = (*pairs.names[near.pair[k]], float(time[near.sample[k]]))
    stands = np.ones((len(time), len(robot.soles)), dtype=bool)
    return Judged(time, q, v, stands, lost, none, none, torque, 0.0, 0.0, apart, nearest, pairs.left_out), a


def write_series(table: Any, out: Path) -> None:
    (out / "series").mkdir(exist_ok=True)
    write_table(table, out / SERIES)


def _asked(folder: Path, kind: str) -> PlanFile:
    file = load_yaml((folder / PLAN_YAML).read_bytes(), PlanFile, file=PLAN_YAML)
    if file.kind != kind:
        raise BadMotion(Fault("another kind of plan is asked", "wrong_kind", f"This one is to {file.kind}", PLAN_YAML,
                              column="kind", value=kind))  # fmt: skip
    return file


def _with_contacts(capture: Capture, file: PlanFile) -> Capture:
    if file.contacts is None:
        return capture
    motion = capture.motion
    contacts = contacts_from(motion.time, file.contacts.within(float(motion.time[-1]), motion.rate))
    return replace(capture, motion=replace(motion, contacts=contacts))


def _sources(folder: Path) -> dict[str, bytes]:
    """What the motion was made from, by path."""
    paths = [path for part in ("robot", "motion") for path in sorted((folder / part).rglob("*")) if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in [folder / PLAN_YAML, *paths]}


def write_document(path: Path, document: Mapping[str, Any]) -> None:
    """JSON, as plan.json, fit.json and motion.json are written."""
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
