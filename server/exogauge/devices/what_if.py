"""What a changed device would do over a recorded motion, beside what the present one does.

The paper's simulation "to test different parameters settings and product configurations" ([Evaluator] section 4): the
supporting torque of every joint by (21)-(25), its size, and what it does to joints that were not meant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.bench import BandPull, Bench, complete
from exogauge.devices.device import Band, Device
from exogauge.errors import BadInput, Fault
from exogauge.remarks import About, Remark
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

MEASURES = ("peak", "mean", "rms", "integral", "work")


@final
@dataclass(frozen=True)
class JointLoad:
    """What all bands together do to one joint. torque: (T,) [N·m, or N on a prismatic joint], positive along it.

    peak: of the largest size, with its sign; mean, rms: over time; integral: over time [N·m·s]; work: done by the bands
    on the joint [J], over a closed motion 0 where no band loses energy.
    """

    torque: Array
    peak: float
    mean: float
    rms: float
    integral: float
    work: float


@final
@dataclass(frozen=True)
class JointChange:
    """percent: measure -> 100 (after / before - 1): 100 is twice as much, -100 nothing left, less is the other way
    round; None where before is 0."""

    joint: str
    before: JointLoad
    after: JointLoad
    percent: Mapping[str, float | None]


@final
@dataclass(frozen=True)
class Interference:
    """A joint that is not meant: rms of its torque as a share of that of the main joints (root of summed squares),
    None where theirs is 0."""

    joint: str
    before: float | None
    after: float | None


@final
@dataclass(frozen=True)
class BandLoad:
    """tension: (T,) [N], the largest along the band. length: (T,) [m]. stretch_max: of the natural length, a ratio.
    slack_share: of the time without tension."""

    tension: Array
    length: Array
    tension_max: float
    length_min: float
    length_max: float
    stretch_max: float
    slack_share: float


@final
@dataclass(frozen=True)
class BandChange:
    """None: the band is not there, or (before only) its values are not known."""

    band: str
    before: BandLoad | None
    after: BandLoad | None


@final
@dataclass(frozen=True)
class WhatIf:
    """T samples. joints: in the robot's order, all on which one of both devices acts. bands: of both, by name.

    main: the joints the device is for. notes: what has to be kept in mind.
    """

    device: Device
    changed: Device
    time: Array
    joints: tuple[JointChange, ...]
    bands: tuple[BandChange, ...]
    main: tuple[str, ...]
    interference: tuple[Interference, ...]
    notes: tuple[Remark, ...]


def what_if(
    tree: RigidTree, device: Device, changed: Device, q: Array, time: Array, main: Sequence[str] = ()
) -> WhatIf:
    """q: (T, J) [rad or m], low-passed where a law takes rates. time: (T,) [s], rising.

    main: default the joint with the largest rms torque of `device` (of `changed` where that has none). Raises BadInput
    where a value of `changed` is not known. To ask again for the same motion, keep a `Bench` and call `compare`.
    """
    return compare(Bench(tree, device, q, time), changed, main)


def compare(bench: Bench, changed: Device, main: Sequence[str] = ()) -> WhatIf:
    """The bench's device and another one, over the bench's motion."""
    refuse_unknown(changed)
    known = complete(bench.device.bands)
    (torque, loads), (new_torque, new_loads) = _pulled(bench, known), _pulled(bench, changed.bands)
    idle = np.zeros(len(bench.time))
    joints = tuple(
        _joint(bench, column, torque.get(column, idle), new_torque.get(column, idle))
        for column in sorted(torque.keys() | new_torque.keys())
    )
    chosen = _main(bench.tree, joints, main)
    names = dict.fromkeys(band.name for band in (*bench.device.bands, *changed.bands))
    bands = tuple(BandChange(name, loads.get(name), new_loads.get(name)) for name in names)
    notes = (*_unknown_before(bench.device, known), *_new_groups(bench.device, changed), *_slack(bands))
    return WhatIf(bench.device, changed, bench.time, joints, bands, chosen, _interference(joints, chosen), notes)


def refuse_unknown(changed: Device) -> None:
    faults = [
        Fault(f"the {what.replace('_', ' ')} of band {band.name!r} is not known", "value_missing",
              "Set it by a change, or give it in the device file.", column=f"{band.name}.{what}")
        for band in changed.bands for what in ("stiffness", "natural_length") if getattr(band, what) is None
    ]  # fmt: skip
    if faults:
        raise BadInput(faults)


def _pulled(bench: Bench, bands: Sequence[Band]) -> tuple[dict[int, Array], dict[str, BandLoad]]:
    """Torque by column of q, of all bands together; each band's own load by its name."""
    total, loads = dict[int, Array](), dict[str, BandLoad]()
    for band in bands:
        pull = bench.pull(band)
        loads[band.name] = _band_load(pull, band)
        for column, torque in zip(pull.columns.tolist(), pull.torque, strict=True):
            if column in total:
                total[column] += torque
            else:
                total[column] = torque
    return total, loads


def _joint(bench: Bench, column: int, before: Array, after: Array) -> JointChange:
    loads = [_load(each, bench.time, bench.q[:, column]) for each in (before, after)]
    percent = {name: _percent(*(getattr(load, name) for load in loads)) for name in MEASURES}
    return JointChange(bench.tree.joints[column], loads[0], loads[1], percent)


def _load(torque: Array, time: Array, q: Array) -> JointLoad:
    """Integrals by the trapezoidal rule; a single sample stands for itself."""
    middle, step = 0.5 * (torque[1:] + torque[:-1]), np.diff(time)
    duration = float(time[-1] - time[0])
    integral = float(middle @ step)
    square = float(0.5 * (torque[1:] ** 2 + torque[:-1] ** 2) @ step)
    return JointLoad(
        torque=torque,
        peak=float(torque[np.argmax(np.abs(torque))]),
        mean=integral / duration if duration else float(torque[0]),
        rms=float(np.sqrt(square / duration)) if duration else abs(float(torque[0])),
        integral=integral,
        work=float(middle @ np.diff(q)),
    )


def _percent(before: float, after: float) -> float | None:
    return 100.0 * (after / before - 1.0) if before != 0.0 else None


def _main(tree: RigidTree, joints: Sequence[JointChange], asked: Sequence[str]) -> tuple[str, ...]:
    for name in asked:
        if name not in tree.joints:
            near = get_close_matches(name, tree.joints, n=1)
            advice = f"Did you mean {near[0]!r}?" if near else f"Acted on: {', '.join(each.joint for each in joints)}."
            raise BadInput(
                Fault(f"the robot has no joint {name!r}", "unknown_joint", advice, column="main", value=name)
            )
    if asked or not joints:
        return tuple(dict.fromkeys(asked))
    return (max(joints, key=lambda joint: (joint.before.rms, joint.after.rms)).joint,)


def _interference(joints: Sequence[JointChange], main: Sequence[str]) -> tuple[Interference, ...]:
    """The largest first, by what comes after."""
    meant = [joint for joint in joints if joint.joint in main]
    before, after = (np.sqrt(sum(getattr(joint, when).rms ** 2 for joint in meant)) for when in ("before", "after"))
    others = [
        Interference(
            joint.joint,
            joint.before.rms / float(before) if before else None,
            joint.after.rms / float(after) if after else None,
        )
        for joint in joints
        if joint.joint not in main
    ]
    return tuple(sorted(others, key=lambda each: -(each.after or 0.0)))


def _band_load(pull: BandPull, band: Band) -> BandLoad:
    longest = float(pull.length.max())
    return BandLoad(
        tension=pull.tension,
        length=pull.length,
        tension_max=float(pull.tension.max()),
        length_min=float(pull.length.min()),
        length_max=longest,
        stretch_max=max(longest / band.natural_length - 1.0, 0.0) if band.natural_length else 0.0,
        slack_share=float(np.mean(pull.tension <= 0.0)),
    )


def _unknown_before(device: Device, known: Sequence[Band]) -> list[Remark]:
    left_out = tuple(band.name for band in device.bands if band not in known)
    return [Remark(About.BANDS_LEFT_OUT, left_out)] if left_out else []


def _new_groups(device: Device, changed: Device) -> list[Remark]:
    was = {band.name: band.group for band in device.bands}
    moved = [band for band in changed.bands if was.get(band.name, band.group) != band.group]
    return [Remark(About.OWN_GROUP, (band.name,), beside=(was[band.name],)) for band in moved]


def _slack(bands: Sequence[BandChange]) -> list[Remark]:
    return [Remark(About.SLACK, (each.band,)) for each in bands if each.after and each.after.slack_share == 1.0]
