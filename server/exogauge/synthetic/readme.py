"""README.txt of a sample: what lies in the folder, and that none of it was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from exogauge.synthetic.disturbances import Disturbances
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.robot_facts import NAME
from exogauge.synthetic.simulation import LOG_RATE_HZ

_SUIT = (
    "The suit is drawn after what is published of the Smart Suit Lite: two bands A from the shoulders over the back",
    "to the thighs (197.8 N/m each, twice that in the modified suit), two short bands B round the sides of the waist.",
    "Bands pull and never push, and have no mass and no damping. Repetitions of a motion follow one plan; each log",
    "begins at another moment and has noise of its own. `ground_truth` marks a stiffness measured on the bare band.",
)


_LAB = (
    "It is as a laboratory would record it: runs of a motion differ, motors and friction warm up, sensors have gains,",
    "zeros and mountings of their own, via points are known by tape measure. truth.json has what of it is in here.",
)


def readme(seed: int, plans: Sequence[LogPlan], devices: Mapping[str, str], disturbed: Disturbances) -> str:
    """devices: file by kind of suit."""
    return "\n".join(
        [
            "SYNTHETIC DATA. Nothing in this folder was measured on a robot.",
            "",
            f"Made by `exogauge sample --seed {seed}` with MuJoCo: `{NAME}`, a humanoid of our own drawn from what is",
            "published of HRP-4 (1.51 m, 39 kg, 34 joints), stands on both feet under a position controller.",
            f"Logs at {LOG_RATE_HZ:.0f} Hz from a simulation at 1 kHz, raw: no filter anywhere.",
            *_log_lines(plans),
            *(f"  {file}  the {kind} suit" for kind, file in devices.items()),
            *(_SUIT if devices else ()),
            *(_LAB if disturbed else ()),
            "robot.urdf and robot.yaml hold the a-priori robot. The robot that made the logs differs from it by",
            "what the standard deviations in robot.yaml say, and may do what the a-priori model has no term for; it",
            "is written in truth.json, for scoring only.",
            *(["The torque that the suit really gave in each log is in truth/."] if devices else []),
            "",
        ]
    )  # fmt: skip


def _log_lines(plans: Sequence[LogPlan]) -> list[str]:
    """One line per log; repetitions together."""
    lines: dict[str, int] = {}
    for plan in plans:
        name = f"{plan.name.rpartition('_')[0]}_*" if plan.repeats else plan.name
        worn = f", {plan.suit} suit" if plan.suit else ""
        line = f"  logs/{name}.parquet  {plan.duration_s:.0f} s, {plan.motion}, {plan.role}{worn}"
        lines[line] = lines.get(line, 0) + 1
    return [f"{line}, {count} repetitions" if count > 1 else line for line, count in lines.items()]
