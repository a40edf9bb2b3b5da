"""A motion in a few lines, and as arrays for other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.findings import longest_run
from exogauge.motion.human import HumanMotion

Array = NDArray[np.float64]


def summarise(motion: HumanMotion) -> dict[str, str | float | int]:
    """What the file is: frames, rate, what it holds, gaps, what was read and what was guessed."""
    said: dict[str, str | float | int] = {
        "name": motion.name, "frames": len(motion.time), "rate_hz": round(motion.rate, 6),
        "seconds": round(float(motion.time[-1]), 6),
    }  # fmt: skip
    if motion.markers is not None:
        gap = ~np.isfinite(motion.markers.position[..., 0])
        longest = [longest_run(column)[1] for column in gap.T]
        said["markers"] = len(motion.markers.labels)
        said["gaps"] = f"{100 * gap.mean():.2g} % of samples, in {100 * gap.any(axis=1).mean():.3g} % of frames"
        if max(longest):
            worst = int(np.argmax(longest))
            said["longest_gap"] = f"{motion.markers.labels[worst]}: {max(longest)} frames"
    if motion.tree is not None:
        said["bones"] = len(motion.tree.names)
    if motion.angles is not None:
        said["coordinates"] = len(motion.angles.names)
    if motion.contacts is not None:
        left, right = motion.contacts.left, motion.contacts.right
        shares = [100.0 * part.mean() for part in (left & right, left ^ right, ~left & ~right)]
        said["feet"] = "both stand in {:.3g} % of frames, one in {:.3g} %, none in {:.3g} %".format(*shares)
    return said | dict(motion.told)


def write_arrays(motion: HumanMotion, path: Path) -> None:
    """npz: time [s]; names, position (T, N, 3) [m], z up, NaN in gaps; of a skeleton rotation (T, N, 3, 3) R_world_bone
    too; of markers filled (T, N); of angles names, value (T, K) [rad or m]."""
    arrays: dict[str, NDArray[np.generic]] = {"time": motion.time}
    if motion.markers is not None:
        markers = motion.markers
        arrays |= {"names": np.array(markers.labels), "position": markers.position, "filled": markers.filled}
    if motion.tree is not None:
        tree = motion.tree
        arrays |= {"names": np.array(tree.names), "position": tree.position, "rotation": tree.rotation}
    if motion.angles is not None:
        arrays |= {"names": np.array(motion.angles.names), "value": motion.angles.value}
    if motion.contacts is not None:
        arrays |= {"left_stands": motion.contacts.left, "right_stands": motion.contacts.right}
    with path.open("wb") as stream:  # as it is called: numpy would add .npz
        np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
