"""A fit in a few lines, and its angles as a table of OpenSim's."""

from __future__ import annotations

import numpy as np

from exogauge.motion.fit.result import HumanFit


def summarise(fit: HumanFit) -> dict[str, str | float | int]:
    """Scales with their doubt, what is left, the trunk's range, and what fits badly or is not known."""
    said: dict[str, str | float | int] = {"name": fit.name, "frames": len(fit.time), "seconds": round(fit.time[-1], 3)}
    worst = int(fit.residual.argmax())
    said["residual"] = f"{100 * fit.rms:.2f} cm rms, most at {fit.labels[worst]}: {100 * fit.residual[worst]:.2f} cm"
    said["scales"] = ", ".join(f"{name} {fit.scale[name]:.2f} ± {fit.scale_sd[name]:.2f}" for name in fit.scale)
    for k, name in enumerate(("flexion", "bend to the right", "rotation to the left")):
        angle = np.degrees(fit.trunk[:, k])
        said[f"trunk {name}"] = f"{angle.min():.1f} to {angle.max():.1f}°"
    return said | dict(fit.told)


def angle_table(fit: HumanFit) -> bytes:
    """MOT: time [s], then every coordinate [degrees, or m of the pelvis], named and signed as `HumanBody` has them."""
    turning = ~fit.body.prismatic
    values = np.where(turning, np.degrees(fit.q), fit.q)
    size = [f"nRows={len(fit.time)}", f"nColumns={1 + len(turning)}"]
    head = [fit.name, "version=1", *size, "inDegrees=yes", "endheader", "\t".join(["time", *fit.body.coordinates])]
    rows = ("\t".join([f"{t:.6f}", *(f"{x:.8g}" for x in row)]) for t, row in zip(fit.time, values, strict=True))
    return ("\n".join([*head, *rows]) + "\n").encode()
