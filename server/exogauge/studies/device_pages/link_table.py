"""The links of a robot, where their frames are and how they lie: what one needs to write down a via point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exogauge.devices.posture import Posture
from exogauge.errors import BadStudy, Fault
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.studies.intake.yaml_file import suggestion
from exogauge.studies.words.pull_words import WAYS
from exogauge.terminal import text_table

ALONG = 0.985  # cosine: within 10° an axis counts as pointing along one of the base link's


def link_table(robot: Robot) -> str:
    """Every link, and the frames fixed to it, with all joints at zero. Names for one place share a line."""
    tree, posture = robot.tree, Posture(robot.tree)
    joint_of = {body: tree.joints[dof] for body, dof in enumerate(tree.dof) if dof >= 0}
    rows = []
    for body in range(-1, len(tree.bodies)):
        named = [name for name, (carrier, _) in tree.frames.items() if carrier == body]
        own = tree.bodies[body] if body >= 0 else base_link(tree)
        places: dict[tuple[str, ...], list[str]] = {}
        for name in [own, *(name for name in named if name != own)] if named else []:
            pose = posture.pose(name)
            origin = [f"{value:.3f}" for value in np.round(pose.translation, 3) + 0.0]
            axes = ", ".join(_way(column) for column in np.asarray(pose.rotation).T)
            places.setdefault((*origin, axes), []).append(name)
        for place, names in places.items():
            moved = joint_of.get(body, "the base") if own in names else f"fixed to {own}"
            rows.append([", ".join(names), moved, *place])
    return text_table(["link", "moved by", "x [m]", "y [m]", "z [m]", "its x, y, z axes point"], rows, widest=60)


def via_point_at(robot: Robot, link: str, place: Sequence[str]) -> str:
    """`{link: …, xyz: […]}` for a place [m] seen from the base link with all joints at zero, fit for device.yaml."""
    try:
        seen = np.array([float(each) for each in place])
    except ValueError:
        seen = np.full(3, np.nan)
    if not np.isfinite(seen).all():
        raise BadStudy(Fault("not three numbers", "not_a_number", "Give LINK X Y Z [m].", value=" ".join(place)[:80]))
    if link not in robot.tree.frames:
        advice = suggestion(link, list(robot.tree.frames))
        raise BadStudy(Fault("the robot has no such link or frame", "unknown_link", advice, value=link[:80]))
    xyz = np.round(Posture(robot.tree).pose(link).actInv(seen), 4) + 0.0
    return f"{{link: {link}, xyz: [{', '.join(f'{value:.4g}' for value in xyz)}]}}"


def base_link(tree: RigidTree) -> str:
    """The link that all places are seen from."""
    if tree.floating:
        return tree.bodies[0]
    return next((name for name, (body, _) in tree.frames.items() if body < 0), "the base")


def _way(direction: np.ndarray) -> str:
    """`forward`; `forward-down` where it lies between the two."""
    order = np.argsort(-np.abs(direction))
    words = [WAYS[axis][0 if direction[axis] > 0 else 1] for axis in order]
    return words[0] if abs(direction[order[0]]) > ALONG else f"{words[0]}-{words[1]}"
