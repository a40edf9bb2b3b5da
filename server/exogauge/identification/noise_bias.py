"""What the sensors' noise does to the estimate by sitting in the regressor, found by adding it once more.

Accelerations are measured; their noise makes the regressor look larger than the motion was, and least squares answers
with coefficients that are off by a share of noise to signal, in the same direction however long the log is. Noise of
the same size drawn again and added to every channel does it once more (simulation extrapolation), so the step it makes
is the step it made. Added with both signs and averaged, what is linear in the noise drops out and the bias is left.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.per_log import PerLog
from exogauge.identification.preparation import Prepared, needed_channels, prepare
from exogauge.identification.solution import Solution
from exogauge.identification.turns import RestDetection
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_before_stored, noise_of
from exogauge.logs.segments import around
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

NOISE_ABOVE = 2.0  # times the cut-off: what a channel holds beyond is taken for noise


@final
@dataclass(frozen=True)
class NoiseFloor:
    """whole: RMSE that noise alone leaves in a channel. beyond_band: of its part above the cut-off."""

    whole: float
    beyond_band: float


def noise_bias(
    equations: Equations, fitted: Sequence[Prepared], at_rest: RestDetection, solution: Solution, kept: PerLog
) -> Array:
    """(P,) estimate of what noise in the regressor added to x. kept: what is known of these logs, prepared alike."""
    rng = np.random.default_rng(0)
    known = known_noise(equations.robot, [each.log for each in fitted], fitted[0].low_pass.cutoff_hz)
    signs, sums = (1.0, -1.0), dict[float, Statistics]()

    def noisier(of: tuple[Prepared, Mapping[str, Array]]) -> dict[float, Statistics]:
        prepared, noise = of
        found = dict[float, Statistics]()
        drawn = hashlib.blake2b(b"".join(each.tobytes() for each in noise.values()), digest_size=8).hexdigest()
        for sign in signs:
            noisy = partial(_noisy_at_kept, equations.robot, prepared, noise, sign, at_rest)
            alone = kept.of(prepared.log, f"noise {drawn} {sign:+}", noisy)
            whole = _beside(alone, prepared.added[prepared.kept], prepared.raw_added[prepared.kept])
            (found[sign],) = equations.collect(whole, solution.x_before, 1)
        return found

    draws = ((each, draw_noise(equations.robot, each, rng, known)) for each in fitted)
    for found in side_by_side(noisier, draws):
        for sign, collected in found.items():
            sums[sign] = sums[sign] + collected if sign in sums else collected
    at_noise = [solution.of(sums[sign]).x for sign in signs]
    return np.asarray(np.mean(at_noise, axis=0) - solution.unbounded.x)


def draw_noise(
    robot: Robot, prepared: Prepared, rng: np.random.Generator, known: Mapping[str, float]
) -> Mapping[str, Array]:
    """Channel -> (T,) white noise as large as the channel's own.

    Its std is seen in the channel's part above twice the cut-off, or is what the maker states, if that is more. A log
    that was low-passed before it was stored hardly shows any: there it is `known`, or what the maker states, or else
    what is seen where that low-pass falls off; and it passes that low-pass too.
    """
    log, seen = prepared.log, _seen_noise(robot, prepared.log, prepared.low_pass.cutoff_hz)
    if log.stored is not None:
        told = {name: max(known.get(name, 0.0), robot.noise.get(noise_kind(name), 0.0)) for name in seen}
        behind = {} if all(told.values()) else noise_behind_stored(robot, prepared)
        seen = {name: max(std, told[name] or behind.get(name) or 0.0) for name, std in seen.items()}
    return {name: log.as_stored(std * rng.normal(size=log.samples)) for name, std in seen.items()}


def noise_behind_stored(robot: Robot, prepared: Prepared) -> Mapping[str, float | None]:
    """Channel -> std of its white noise before the log was low-passed and stored, where that can be seen. A joint's own
    is looked for where it does not stop, start or turn round."""
    log = prepared.log
    assert log.stored is not None
    reach = log.stored.settle_samples(log.rate_hz)
    turns = np.diff(prepared.raw_direction, axis=0, prepend=prepared.raw_direction[:1]) != 0.0
    free = ~around(turns, reach) & prepared.settled[:, None]
    own = {joint.name: np.abs(robot.axes_from_joints[:, k]) > 0.0 for k, joint in enumerate(robot.joints)}
    found = {}
    for name in needed_channels(robot):
        axes = own.get(name.partition(".")[2])
        without_jumps = prepared.settled if axes is None else np.all(free[:, axes], axis=1)
        found[name] = noise_before_stored(log.channels[name], log.rate_hz, log.stored, without_jumps)
    return found


def known_noise(robot: Robot, logs: Sequence[Log], cutoff_hz: float) -> Mapping[str, float]:
    """Channel -> std of its white noise, for logs that were low-passed before they were stored: the median of the other
    logs. Empty where there are no such logs, or no others."""
    others = [log for log in logs if log.stored is None]
    if not others or len(others) == len(logs):
        return {}
    seen = [_seen_noise(robot, log, cutoff_hz) for log in others]
    return {name: float(np.median([each[name] for each in seen])) for name in seen[0]}


def _seen_noise(robot: Robot, log: Log, cutoff_hz: float) -> Mapping[str, float]:
    """Channel -> std."""
    above = min(NOISE_ABOVE * cutoff_hz, 0.4 * log.rate_hz)
    names = needed_channels(robot)
    found = noise_of([log.channels[name] for name in names], log.rate_hz, above)
    return {
        name: max(each.std, robot.noise.get(noise_kind(name), 0.0)) for name, each in zip(names, found, strict=True)
    }


def with_noise(
    robot: Robot, prepared: Prepared, noise: Mapping[str, Array], sign: float, at_rest: RestDetection
) -> Prepared:
    """The same log with sign · noise added; when axes rest or move, and which way, stays as it was."""
    noisy = _noisy(robot, prepared, noise, sign, at_rest)
    return _beside(noisy, prepared.added, prepared.raw_added)


def _beside(noisy: Prepared, added: Array, raw_added: Array) -> Prepared:
    """With what an extension adds, which stands last and stays as it was."""
    own = noisy.added.shape[1]
    return replace(
        noisy,
        added=np.hstack([noisy.added, added[:, own:]]),
        raw_added=np.hstack([noisy.raw_added, raw_added[:, own:]]),
    )


def _noisy_at_kept(
    robot: Robot, prepared: Prepared, noise: Mapping[str, Array], sign: float, at_rest: RestDetection
) -> Prepared:
    return replace(_noisy(robot, prepared, noise, sign, at_rest).at_kept(), log=prepared.log)


def _noisy(
    robot: Robot, prepared: Prepared, noise: Mapping[str, Array], sign: float, at_rest: RestDetection
) -> Prepared:
    """Without what an extension adds."""
    log = prepared.log
    channels = {name: log.channels[name] + sign * noise[name] for name in noise}
    noisy = prepare(robot, replace(log, channels=channels), prepared.low_pass.cutoff_hz, at_rest)
    return replace(
        noisy,
        direction=prepared.direction,
        rest=prepared.rest,
        steady=prepared.steady,
        raw_direction=prepared.raw_direction,
        stored_direction=prepared.stored_direction,
        stored_rest=prepared.stored_rest,
    )


def noise_kind(channel: str) -> str:
    """Key in `Robot.noise` of a channel."""
    if channel.startswith("ft."):
        return "force" if channel.rsplit(".", 1)[1].startswith("f") else "moment"
    return channel.split(".", 1)[0]
