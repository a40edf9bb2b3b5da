"""`scope` in results.json: for what the results hold, in one sentence and in numbers, and what they do not say."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from exogauge.robots.description import Robot
from exogauge.studies.results.configuration import JointTravel, LogRecord, StudyRecord
from exogauge.studies.results.support_results import main_joints
from exogauge.studies.words.names import counted, listed
from exogauge.studies.words.rounding import rounded, significant
from exogauge.support.result import SupportResult

SHOWN_MOTIONS = 3  # with their joints in the sentence; of the others the number
SHOWN_JOINTS = 4
LIMIT = "nothing is claimed beyond these positions and speeds, this wear, these settings and this software."
RAD, M = "rad", "m"


def scope_entry(record: StudyRecord, robot: Robot, synthetic: bool, support: SupportResult | None) -> dict[str, Any]:
    """Positions and speeds are low-passed as for the fit. identified: over the fitted logs; motions: over the logs with
    a device, for the joints on which bands act."""
    units = _units(robot)
    fitted = [log for log in record.logs if log.role == "identification"]
    identified = [_reach(joint.name, fitted, units) for joint in robot.joints] if fitted else []
    worn = {log.device for log in record.logs}
    entry: dict[str, Any] = {
        "synthetic": synthetic,
        "robot": robot.name,
        "devices": [wear.device.name for wear in record.wears if wear.device.name in worn],
        "identified": identified,
        "not_moved": [each["joint"] for each in identified if not each["moved"]],
        "motions": _motions(record, support, units) if support else [],
    }
    clauses = [holds_for(entry, len(fitted)), LIMIT]
    return {"sentence": "; ".join(clauses), "clauses": clauses, **entry, "not_said": not_said(entry)}


def _units(robot: Robot) -> dict[str, str]:
    tree = robot.tree
    return {name: M if name in tree.sliding else RAD for name in tree.joints}


def _motions(record: StudyRecord, support: SupportResult, units: dict[str, str]) -> list[dict[str, Any]]:
    """One entry per device and motion that something is said of, with every joint on which its bands act."""
    worn = {log.log: log for log in record.logs}
    entries = []
    for device, motion in dict.fromkeys((each.device, each.motion) for each in support.joints):
        found = [each for each in support.joints if (each.device, each.motion) == (device, motion)]
        names = list(dict.fromkeys(log for each in found for log in each.logs))
        main, logs = main_joints(support, motion), [worn[name] for name in names if name in worn]
        joints = [_reach(each.joint, logs, units) | {"main": each.joint in main} for each in found] if logs else []
        entries.append({"device": device, "motion": motion, "logs": names, "joints": joints})
    return entries


def _reach(joint: str, logs: Sequence[LogRecord], units: dict[str, str]) -> dict[str, Any]:
    """The joint's lowest and highest position and top speed over these logs."""
    travels = [each for log in logs for each in log.joints if each.joint == joint]
    return {"joint": joint, "moved": any(each.moved for each in travels), **_widest(travels), "unit": units[joint]}


def _widest(travels: Sequence[JointTravel]) -> dict[str, float]:
    return {
        "lowest": min(each.lowest for each in travels),
        "highest": max(each.highest for each in travels),
        "top_speed": max(each.top_speed for each in travels),
    }


def holds_for(entry: dict[str, Any], fitted: int) -> str:
    """For what the results hold. entry: the scope without it."""
    hold, robot = "hese results hold for", f"{entry['robot']} as recorded"
    text = f"Synthetic data: t{hold} the simulated robot {robot}" if entry["synthetic"] else f"T{hold} {robot}"
    if entry["devices"]:
        text += f" with {_some([f'“{device}”' for device in entry['devices']])} as in the configuration record"
    if entry["motions"]:
        text += f", in {_motion_words(entry['motions'])}"
    if entry["identified"]:
        total = len(entry["identified"])
        moved = total - len(entry["not_moved"])
        every = "its joint" if total == 1 else f"all {total} joints"
        joints = every if moved == total else f"{moved} of {counted(total, 'joint')}"
        move = "moves" if fitted == 1 else "move"
        text += f"; what is said of the robot itself rests on {counted(fitted, 'fitted log')} that {move} {joints}"
    return text


def _motion_words(motions: Sequence[dict[str, Any]]) -> str:
    """`bend (torso_pitch −2 … 61°, up to 48°/s) and twist (…)`: the main joints, over all devices."""
    names = list(dict.fromkeys(each["motion"] for each in motions))
    words = []
    for name in names[:SHOWN_MOTIONS]:
        every = [joint for each in motions if each["motion"] == name for joint in each["joints"] if joint["main"]]
        joints = [reach_words([j for j in every if j["joint"] == one]) for one in _names(every)]
        words.append(f"{name} ({'; '.join(joints)})" if joints else name)
    rest = len(names) - len(words)
    return f"the motion{'s' * (len(names) > 1)} {listed([*words, f'{rest} more'] if rest else words)}"


def _names(joints: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(each["joint"] for each in joints))


def reach_words(reaches: Sequence[dict[str, Any]]) -> str:
    """`torso_pitch −2 … 61°, up to 48°/s`"""
    low, high = min(each["lowest"] for each in reaches), max(each["highest"] for each in reaches)
    top, joint, metres = max(each["top_speed"] for each in reaches), reaches[0]["joint"], reaches[0]["unit"] == M
    if metres:
        return f"{joint} {significant(low)} … {significant(high)} m, up to {significant(top)} m/s"
    return f"{joint} {_degrees(low)} … {_degrees(high)}°, up to {significant(math.degrees(top), 2)}°/s"


def _degrees(angle: float) -> str:
    return rounded(math.degrees(angle), 1)


def not_said(entry: dict[str, Any]) -> list[str]:
    """What a reader might take for granted and these data do not hold."""
    said = []
    if entry["synthetic"]:
        said.append("The data are synthetic: they say how the method does on them, nothing of a real robot or wear.")
    if entry["not_moved"]:
        said.append(f"Not moved in any fitted log: {_some(entry['not_moved'])}. Nothing is claimed of their friction.")
    main = [(each["motion"], joint) for each in entry["motions"] for joint in each["joints"] if joint["main"]]
    still = dict.fromkeys(f"{joint['joint']} in {motion}" for motion, joint in main if not joint["moved"])
    if still:
        said.append(f"Held still with the wear: {_some(still)}. Friction hides part of the support there.")
    beyond = dict.fromkeys(joint["joint"] for _, joint in main if _goes_beyond(joint, entry["identified"]))
    if beyond:
        words = "went further or faster than in the fitted logs; the robot’s own torque is extrapolated there."
        said.append(f"With the wear {_some(beyond)} {words}")
    said.append("Another robot, specimen, size or way of wearing it was not tested, nor how it feels to a person.")
    return said


def _goes_beyond(joint: dict[str, Any], identified: Sequence[dict[str, Any]]) -> bool:
    """Whether it leaves the fitted logs' range by a tenth of it, or their top speed by a tenth."""
    fit = next((each for each in identified if each["joint"] == joint["joint"]), None)
    if fit is None:
        return False
    room = 0.1 * (fit["highest"] - fit["lowest"])
    further = joint["lowest"] < fit["lowest"] - room or joint["highest"] > fit["highest"] + room
    return bool(further or joint["top_speed"] > 1.1 * fit["top_speed"])


def _some(names: Iterable[str]) -> str:
    every = list(names)
    rest = len(every) - SHOWN_JOINTS
    return listed([*every[:SHOWN_JOINTS], f"{rest} more"] if rest > 0 else every)
