"""What a what-if says on a terminal: joints, then bands, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from exogauge.devices.what_if import BandLoad, WhatIf
from exogauge.robots.tree import RigidTree
from exogauge.studies.series.recorded_motion import RecordedMotion
from exogauge.studies.words.remark_words import sentence
from exogauge.terminal import text_table


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
