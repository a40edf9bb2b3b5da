"""Whether what is measured with a device on is what its bands could give.

    left² > share² measured²,    left² = Σ_j max(rms_j(b - s)² - c (σ_j² + std_j²), 0),    measured² = Σ_j rms_j(b)²

b: (n, D) what the model leaves in steady motion, approach B; s: of the bands with the springs that are fitted to all
logs; σ: (D,) what B leaves without the device, std: its own doubt, c: what chance may do to a variance. A load that
these logs alone carry, a band that nobody described, or one that runs elsewhere is taken for the device else, with the
doubt of a torque that is well measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import Supporting
from exogauge.devices.device import Device
from exogauge.devices.result import StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.identification.model import RobotModel
from exogauge.remarks import About, Remark
from exogauge.support.evidence import Background, Evidence, on_joints
from exogauge.support.stiffness import with_spring

Array = NDArray[np.float64]


def notes_on_rest(
    model: RobotModel,
    names: Sequence[str],
    evidences: Sequence[Evidence],
    backgrounds: Mapping[str, Background],
    stiffness: Sequence[StiffnessResult],
) -> list[Remark]:
    """One for each device of which logs measure what its bands could not give. names: of the D joints."""
    notes = list[Remark]()
    for found in (each for each in stiffness if each.approach == "B"):
        own = [each for each in evidences if each.worn.device.name == found.device]
        if not own:
            continue
        device = _as_fitted(own[0].worn.device, found)
        told = dict[str, tuple[float, float]]()
        for each in own:
            sigma = backgrounds[each.worn.motion].repeats.b.steady
            left, measured = _sizes(model, names, each, device, sigma, model.criteria.support)
            if left > model.criteria.support.not_of_bands * measured:
                told[each.worn.log.name] = left, measured
        if told:
            notes.append(Remark(About.NOT_OF_BANDS, tuple(told), tuple(told.values()), beside=(found.device,)))
    return notes


def _as_fitted(device: Device, found: StiffnessResult) -> Device:
    """With its springs as identified; slack where nothing is known of them."""
    springs = {each.band: each for each in found.bands}
    bare = [replace(band, stiffness=None, natural_length=None) for band in device.bands]
    fitted = [(band, springs[band.name]) for band in bare]
    bands = [with_spring(band, (own.stiffness, own.natural_length), own.longest) for band, own in fitted]
    return replace(device, bands=tuple(bands))


def _sizes(
    model: RobotModel, names: Sequence[str], each: Evidence, device: Device, sigma: Array, criteria: Supporting
) -> tuple[float, float]:
    """[N·m] what the bands leave beyond chance, and what is measured, all joints together."""
    kept, routing = each.kept, Routing(model.robot.tree, device.bands)
    columns = np.array([model.robot.tree.joints.index(name) for name in names])
    pulled = band_torque(routing, device.bands, each.posture[kept], each.time[kept]).torque
    b, std = each.b[kept], each.std_b[kept]
    counts = each.steady[kept] & np.isfinite(b)

    def square(of: Array) -> Array:
        whole = np.sum(np.where(counts, of, 0.0) ** 2, axis=0)
        return np.asarray(whole / np.maximum(counts.sum(axis=0), 1))

    chance = criteria.misfit * (sigma**2 + square(std))
    left = np.maximum(square(b - on_joints(pulled, routing, columns)) - chance, 0.0)
    return float(np.sqrt(left.sum())), float(np.sqrt(square(b).sum()))
