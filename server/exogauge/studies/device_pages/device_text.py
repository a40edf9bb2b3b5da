"""What the check of a device file says on a terminal."""

from __future__ import annotations

from exogauge.studies.device_pages.link_table import base_link
from exogauge.studies.intake.device_check import ArmCheck, DeviceCheck
from exogauge.terminal import text_table

SMALL_TORQUE = 0.05  # [N·m] not worth a word


def device_text(check: DeviceCheck) -> str:
    """Bands, the joints they pull, what looks like a slip."""
    device = check.device
    parts = [
        f"{device.name} on {check.robot.name}: {_count(len(device.bands), 'band')} in "
        f"{_count(len(device.groups), 'group')}. Forward is +x of {base_link(check.robot.tree)}, left +y, up +z.",
        "\n".join(
            ["Bands, with all joints at zero" + (" and over the log" if _with_log(check) else ""), _bands(check)]
        ),
        "\n".join(["Which way they pull", _arms(check)]),
    ]
    if check.torque:
        ordered = sorted(check.torque.items(), key=lambda item: -abs(item[1]))
        torques = ", ".join(f"{joint} {value:+.3g}" for joint, value in ordered if abs(value) >= SMALL_TORQUE)
        torques = torques or f"less than {SMALL_TORQUE:g} at any joint"
        parts.append(f"All bands together, all joints at zero [N·m]: {torques}.")
    parts += [f"NOTE {note}" for note in check.notes]
    parts += [f"WARNING {doubt}" for doubt in check.doubts]
    parts.append("No fault" + (f", {_count(len(check.doubts), 'warning')}." if check.doubts else "."))
    return "\n\n".join(parts)


def _with_log(check: DeviceCheck) -> bool:
    return check.bands[0].shortest is not None


def _bands(check: DeviceCheck) -> str:
    columns = ["band", "group", "law", "via points", "length [m]"]
    rows: list[list[object]] = [[band.name, band.group, band.law, band.points, band.length] for band in check.bands]
    if _with_log(check):
        columns += ["shortest [m]", "longest [m]"]
        rows = [[*row, band.shortest, band.longest] for row, band in zip(rows, check.bands, strict=True)]
    if any(band.natural_length is not None for band in check.bands):
        columns += ["natural [m]", "stretch [mm]"]
        rows = [
            [*row, band.natural_length, None if band.stretch is None else round(1e3 * band.stretch, 1)]
            for row, band in zip(rows, check.bands, strict=True)
        ]
    if any(band.tension is not None for band in check.bands):
        columns.append("pull [N]")
        rows = [[*row, band.tension] for row, band in zip(rows, check.bands, strict=True)]
    return text_table(columns, rows)


def _arms(check: DeviceCheck) -> str:
    columns = ["band", "joint", "moment arm [m]"] + (["over the log [m]"] if _with_log(check) else [])
    rows = []
    for band in check.bands:
        for k, arm in enumerate(band.arms):
            row = ["" if k else band.name, arm.joint, f"{abs(arm.arm):.3f}"]
            if arm.lowest is not None and arm.highest is not None:
                row.append(" … ".join(f"{abs(each):.3f}" for each in sorted((arm.lowest, arm.highest), key=abs)))
            rows.append([*row, _pull(arm)])
        if not band.arms:
            rows.append([band.name, "none", *[""] * (len(columns) - 2), "it pulls no joint in these postures"])
    return text_table([*columns, "pulls towards"], rows, widest=80)


def _pull(arm: ArmCheck) -> str:
    if arm.changes_sides:
        return "both sides, by posture: from one side of the joint to the other"
    return f"{'negative' if arm.sign < 0 else 'positive'} angles: {arm.way}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
