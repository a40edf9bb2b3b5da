"""What is said of a payload's data beside its numbers: sentences, made once."""

from __future__ import annotations

import numpy as np

from exogauge.criteria.criteria import Criteria
from exogauge.payload.both_stages import Logs, Stages
from exogauge.payload.dynamics import reading_of_mu
from exogauge.payload.intake import Payload
from exogauge.payload.missing.search import Missing
from exogauge.payload.missing.words import cause_of_residual
from exogauge.payload.prepare import std_of


def told_weight(payload: Payload, stages: Stages, criteria: Criteria) -> list[str]:
    """What a mass on a scale contradicts, which never counts in the fit: a gain that all axes share, which no log
    shows, is a mass to them."""
    weighed = payload.file.ground_truth.mass_kg
    if weighed is None:
        return []
    if stages.excitation is not None:
        mass, std = float(stages.excitation.chosen.value[0]), float(stages.excitation.chosen.std[0])
    else:
        assert stages.postures is not None
        mass, std = stages.postures.chosen.mass, float(stages.postures.chosen.std[0])
    more, share = mass / weighed - 1.0, abs(mass / weighed - 1.0)
    if share > criteria.payload.other_mass:
        return [
            f"The mass comes out {mass / weighed:.3g} times the weighed one: check `sensor.force_unit` (kgf and N "
            "differ by 9.81) and what else hangs on the sensor."
        ]
    if abs(mass - weighed) < criteria.judging.significant * std:
        return []
    return [
        f"The mass comes out {1e3 * (mass - weighed):+.3g} g beside the weighed one, {abs(mass - weighed) / std:.2g} "
        f"standard deviations. Either something else hangs on the sensor, or all its axes read {100 * share:.2g} % too "
        f"{'much' if more > 0.0 else 'little'}, which no log shows: centre times mass and inertia are then as wrong. "
        f"State `uncertainty: {{ft_gain_common: {share:.2g}}}`, or have the sensor calibrated."
    ]


def told_clocks(payload: Payload) -> list[str]:
    """A sentence for each log whose stamps were replaced."""
    return [
        f"{each.pose.file}, column '{payload.file.time.column}': stamps jitter by {1e3 * each.evened:.2g} ms though "
        "samples were taken evenly, as the pose tells: replaced by the even clock beneath them."
        for each in payload.recordings
        if each.evened > 0.0
    ]


def told_at_rest(logs: Logs, stages: Stages) -> list[str]:
    """Channels that scatter otherwise in postures than is stated, where no motion tells a μ. A wrench in another unit
    than is said scatters so."""
    excitation, holds, file = stages.excitation, logs.holds, logs.payload.file
    if holds is None or holds.noise is None or (excitation is not None and excitation.noise_known):
        return []
    least, most = logs.criteria.payload_doctor.noise_ratio
    ratios = holds.noise / std_of(logs.payload)
    off = [
        f"{name} {ratio:.2g}"
        for name, ratio in zip(file.sensor.wrench, ratios, strict=True)
        if not least <= ratio <= most
    ]
    if not off:
        return []
    return [
        f"At rest channels scatter by other multiples of the stated noise than 1: {', '.join(off)}. Filtered, or "
        "`sensor.noise` is wrong, or `sensor.force_unit` or `sensor.moment_unit`: kgf and N differ by 9.81, Nm and "
        "Nmm by a thousand, and without motion nothing else tells them apart."
    ]


def told_noise(logs: Logs) -> list[str]:
    """A sentence for each log whose pose shows more noise than is stated."""
    payload, stated = logs.payload, logs.payload.file.pose.noise_rad
    return [
        f"{recording.pose.file}: a channel of the pose scatters {each.motion.noisier:.2g} times as much as stated "
        f"(`pose.noise_rad` {stated:g}{'' if recording.position is None else ', `noise_m`'}): taken as found. A clock "
        "that is not that of the samples does the same."
        for role, moved in logs.moved.items()
        for recording, each in zip(payload.of(role), moved, strict=True)
        if each.motion.noisier > 1.0
    ]


def doubts(stages: Stages, rigid: Stages | None, missing: Missing, criteria: Criteria) -> list[str]:
    """What the motion's residual says, and where something touched."""
    excitation, out = stages.excitation, list[str]()
    if excitation is None:
        return out
    if excitation.noise_known:
        mu, mu_std, cause = excitation.chosen.mu, excitation.chosen.mu_std, cause_of_residual(missing)
        reading = reading_of_mu(mu, mu_std, cause, criteria.payload_dynamic)
        out += [reading] if reading else []
    if missing.late is not None:
        late, std = (1e3 * each for each in missing.late)
        way = "late" if late > 0.0 else "early"
        out.append(
            f"The wrench seems {abs(late):.2g} ± {std:.1g} ms {way} against the pose: too little, or not surely "
            "enough, to be named; the doubt of all numbers holds it."
        )
    if missing.leans is not None:
        lean, std = (float(np.degrees(each)) for each in missing.leans)
        out.append(
            f"The base seems to lean by {lean:.2g} ± {std:.1g}°: too little, or not surely enough, to be named; the "
            "doubt of all numbers holds it. A few postures would tell."
        )
    if excitation.left_out and (rigid is not None or not missing.found):
        spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in excitation.left_out[:5])
        out.append(f"Something touched the payload in the excitation; left out: {spans}.")
    return out
