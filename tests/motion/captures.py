"""Captures that tests make themselves: a person who bows, as a skeleton and as markers."""

from __future__ import annotations

import numpy as np

RATE = 60.0
BONES = (  # name, parent, offset [cm]: y up, z ahead, x to the left
    ("Hips", None, (0, 95, 0)), ("Spine2", "Hips", (0, 20, 0)), ("Head", "Spine2", (0, 40, 0)),
    ("LeftArm", "Spine2", (18, 32, 0)), ("LeftForeArm", "LeftArm", (0, -30, 0)),
    ("LeftHand", "LeftForeArm", (0, -25, 0)),
    ("RightArm", "Spine2", (-18, 32, 0)), ("RightForeArm", "RightArm", (0, -30, 0)),
    ("RightHand", "RightForeArm", (0, -25, 0)),
    ("LeftUpLeg", "Hips", (9, 0, 0)), ("LeftLeg", "LeftUpLeg", (0, -43, 0)), ("LeftFoot", "LeftLeg", (0, -42, 0)),
    ("RightUpLeg", "Hips", (-9, 0, 0)), ("RightLeg", "RightUpLeg", (0, -43, 0)), ("RightFoot", "RightLeg", (0, -42, 0)),
)  # fmt: skip
ENDS = {"Head": (0, 20, 0), "LeftHand": (0, -15, 0), "RightHand": (0, -15, 0), "LeftFoot": (0, -8, 15),
        "RightFoot": (0, -8, 15)}  # fmt: skip


def bow(angle_deg: float = 20.0, seconds: float = 2.0) -> np.ndarray:
    """(T,) [deg] of the trunk's flexion: down and up again, smoothly."""
    s = np.linspace(0.0, 1.0, int(seconds * RATE) + 1)
    return np.asarray(angle_deg * np.sin(np.pi * s) ** 2)


def knee(angle_deg: float = 60.0, seconds: float = 2.5) -> np.ndarray:
    """(T,) [deg] of a thigh that is raised after half a second and let down half a second before the end."""
    s = np.clip((np.linspace(0.0, seconds, int(seconds * RATE) + 1) - 0.5) / (seconds - 1.0), 0.0, 1.0)
    return np.asarray(angle_deg * np.sin(np.pi * s) ** 2)


def bvh(
    flexion: np.ndarray, upwards: np.ndarray | None = None, thigh: np.ndarray | None = None, size: float = 1.0
) -> bytes:
    """A person on still feet whose trunk bends ahead by (T,) [deg]; upwards: (T,) [cm] by which all of it is lifted;
    thigh: (T,) [deg] by which the left one is raised, its shank upright. size: units of the file per cm."""
    lift = np.zeros_like(flexion) if upwards is None else upwards
    raised = np.zeros_like(flexion) if thigh is None else thigh
    lines = ["HIERARCHY"]

    def add(name: str, depth: int) -> None:
        parent, offset = next((parent, offset) for each, parent, offset in BONES if each == name)
        offset = (0, 0, 0) if parent is None else offset
        pad = "  " * depth
        lines.extend([f"{pad}{'ROOT' if parent is None else 'JOINT'} {name}", f"{pad}{{",
                      f"{pad}  OFFSET {' '.join(str(size * x) for x in offset)}"])  # fmt: skip
        channels = "6 Xposition Yposition Zposition " if parent is None else "3 "
        lines.append(f"{pad}  CHANNELS {channels}Zrotation Xrotation Yrotation")
        for child, of, _ in BONES:
            if of == name:
                add(child, depth + 1)
        if name in ENDS:
            end = " ".join(str(size * x) for x in ENDS[name])
            lines.extend([f"{pad}  End Site", f"{pad}  {{", f"{pad}    OFFSET {end}", f"{pad}  }}"])
        lines.append(f"{pad}}}")

    add("Hips", 0)
    lines += ["MOTION", f"Frames: {len(flexion)}", f"Frame Time: {1.0 / RATE:.12f}"]
    order = written_order()
    for angle, up, ahead in zip(flexion, lift, raised, strict=True):
        row = [0.0, size * (95.0 + up), 0.0, *[0.0] * 3 * len(order)]
        for bone, turn in (("Spine2", angle), ("LeftUpLeg", -ahead), ("LeftLeg", ahead)):
            row[3 + 3 * order.index(bone) + 1] = turn
        lines.append(" ".join(f"{x:.6f}" for x in row))
    return ("\n".join(lines) + "\n").encode()


def written_order() -> list[str]:
    """Bones as the file lists them: depth first."""

    def below(name: str) -> list[str]:
        return [name, *(deeper for child, of, _ in BONES if of == name for deeper in below(child))]

    return below("Hips")
