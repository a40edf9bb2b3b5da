"""What the wear's model leaves of the supporting torque, and what naming the effects of bands came to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground
from exogauge.detect.device.finding import CHANNEL
from exogauge.detect.device.judge import Folds, left_out_residual, rmse
from exogauge.devices.result import Estimate
from exogauge.findings.result import ChainStep, Consequence, Excess, Finding, Link
from exogauge.findings.verdict import Seen
from exogauge.search.sums import summed, sureness
from exogauge.support.band_model import Wear, fit
from exogauge.support.band_rows import BLOCK_S

Array = NDArray[np.float64]


def unexplained(ground: Ground, e: Array) -> tuple[Excess, ...]:
    """Joints on which the wear's model errs by more than repeated runs do. e: (N, D) [N·m] of what was left out."""
    judging, found = ground.model.criteria.judging, list[Excess]()
    for joint, name in enumerate(ground.joints):
        error, floor = rmse(e, joint), float(ground.floor[joint])
        used = np.isfinite(e[:, joint])
        if floor > 0.0 and used.any() and error > judging.above * floor:
            count = summed(used[used].astype(float), ground.setting.logs.block[used])
            z = sureness(
                summed(e[used, joint] ** 2, ground.setting.logs.block[used]) / count - (judging.above * floor) ** 2
            )
            if z > judging.sure_above:
                found.append(Excess(f"{CHANNEL}{name}", ground.unit(joint), error, floor, z))
    return tuple(found)


def seen(ground: Ground, e: Array) -> tuple[Seen, ...]:
    """Joints that the wear acts on, as `unexplained` looks at them, by blocks that were left out of the fit. A joint
    that the robot's own search asked for motion is not asked for it again. e: as there."""
    found = list[Seen]()
    for joint, name in enumerate(ground.joints):
        used = np.isfinite(e[:, joint])
        if ground.floor[joint] > 0.0 and used.any():
            seconds = BLOCK_S * len(np.unique(ground.setting.logs.block[used]))
            found.append(Seen(f"{CHANNEL}{name}", rmse(e, joint) / float(ground.floor[joint]), seconds, 0.0))
    return tuple(found)


def chain(
    ground: Ground, findings: Sequence[Finding], wears: Sequence[Wear], folds: Folds, of: str
) -> tuple[Link, ...]:
    """RMSE of the supporting torque of the joints in question, version by version; nothing where nothing was named."""
    if len(wears) < 2:
        return ()
    joints = sorted({ground.joints.index(each.held_out.channel.removeprefix(CHANNEL)) for each in findings})
    floor = float(np.sqrt(np.mean(ground.floor[joints] ** 2)))
    links = []
    for k, wear in enumerate(wears):
        e = left_out_residual(ground.setting, fit(ground.setting, wear), folds)
        each = np.array([rmse(e, joint) for joint in joints])
        worst = joints[int(np.argmax(each / np.maximum(ground.floor[joints], 1e-12)))]
        step = ChainStep("effect", findings[k - 1].effect, findings[k - 1].place) if k else ChainStep("bands")
        channel = f"{CHANNEL}{ground.joints[worst]}"
        links.append(
            Link(step, float(np.sqrt(np.mean(each**2))), floor, channel, rmse(e, worst), float(ground.floor[worst]))
        )
    return tuple(links)


def before_after(first: Ground, last: Ground, of: str) -> tuple[Consequence, ...]:
    """Stiffness and natural length of every band, as springs alone and with what was named."""
    told: list[Consequence] = []
    W, was, now = len(first.device.bands), first.deviations(first.fitted), last.deviations(last.fitted)

    def estimates(place: int, unit: str) -> tuple[Estimate, Estimate]:
        pair = [(first.fitted.wear.theta, was), (last.fitted.wear.theta, now)]
        one, other = (Estimate(float(theta[place]), float(std[place]), unit) for theta, std in pair)
        return one, other

    for b, band in enumerate(first.device.bands):
        name = (band.name, of) if of else (band.name,)
        told.append(Consequence("stiffness", name, *estimates(b, "N/m")))
        told.append(Consequence("natural_length", name, *estimates(W + b, "m")))
    return tuple(told)
