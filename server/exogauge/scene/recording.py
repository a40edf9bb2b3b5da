"""One log as a recording: everything drawn, packed into one file that the player shows at any time asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from exogauge.scene.band_view import draw_bands
from exogauge.scene.colours import FORCE, SLACK, SUPPORT, TENSION, TORQUE, UNKNOWN, as_hex
from exogauge.scene.effort_view import draw_forces, draw_torques, mark_joints
from exogauge.scene.robot_view import BASE_WORDS, RobotView, draw_robot
from exogauge.scene.stage import Stage
from exogauge.scene.take import Take
from exogauge.studies.intake.mesh_files import Opener


def record(take: Take, log: str, open_mesh: Opener) -> bytes:
    """The packed scene (`Stage.packed`). log: its name."""
    stage, tree = Stage.empty(), take.robot.tree
    view = draw_robot(stage, take.robot, take.urdf, open_mesh, take.q, take.base, take.up)
    legend = list[dict[str, Any]]()
    if take.device is not None:
        most = draw_bands(stage, view, tree, take.device, take.tension)
        legend += band_legend(bool(take.tension), most, any((t <= 0.0).any() for t in take.tension.values()))
    if take.torque:
        most = draw_torques(stage, view, tree, take.torque)
        legend.append(_entry("torques", "joint torque", as_hex(TORQUE), f"¾ turn = {most:g} N·m"))
    if take.support:
        most = draw_torques(stage, view, tree, take.support, "support")
        legend.append(_entry("support", "supporting torque", as_hex(SUPPORT), f"¾ turn = {most:g} N·m"))
    if take.force:
        most = draw_forces(stage, view, take.robot, take.force)
        legend.append(_entry("forces", "contact force", as_hex(FORCE), f"longest = {most:g} N"))
    if take.marked:
        mark_joints(stage, view, tree, take.marked)
    aim(stage, view)
    frames = take.frames
    about = {
        "log": log,
        "start": frames.start,
        "end": frames.end,
        "fps": frames.fps,
        "frames": frames.count,
        "legend": legend,
        "marked": [{"joint": joint, "effect": effect} for joint, effect in take.marked.items()],
        "notes": [BASE_WORDS[view.known], f"{frames.said}.".capitalize()],
    }
    return stage.packed(about)


def band_legend(known: bool, most: float, slack: bool) -> list[dict[str, Any]]:
    """The scale of tensions, or that none is known."""
    if not known:
        return [_entry("bands", "band, tension unknown", as_hex(UNKNOWN), "")]
    stops = [as_hex(colour.astype(np.uint8)) for colour in TENSION]
    scale = {"scale": stops, "low": 0.0, "high": most, "unit": "N"}
    entries = [_entry("bands", "band tension", stops[-1], "") | scale]
    return [*entries, _entry("bands", "slack band", as_hex(SLACK), "dashed")] if slack else entries


def aim(stage: Stage, view: RobotView, toward: Sequence[float] = (-1.2, -1.5, 0.45)) -> None:
    """The camera looks at the robot from behind and its right, a little from above: suits pull over the back."""
    centre = (view.low + view.high) / 2
    away = np.array(toward) / np.linalg.norm(toward)
    stage.look(centre + away * view.size * 0.95, centre)


def _entry(layer: str, label: str, colour: str, size: str) -> dict[str, Any]:
    return {"layer": layer, "label": label, "color": colour, "size": size}
