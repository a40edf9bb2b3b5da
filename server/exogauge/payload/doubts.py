"""What is said of a payload's data beside its numbers: sentences, made once."""

from __future__ import annotations

from exogauge.criteria.criteria import Criteria
from exogauge.payload.both_stages import Logs, Stages
from exogauge.payload.dynamics import reading_of_mu
from exogauge.payload.intake import Payload
from exogauge.payload.missing.search import Missing
from exogauge.payload.missing.words import cause_of_residual


def told_clocks(payload: Payload) -> list[str]:
    """A sentence for each log whose stamps were replaced."""
    return [
        f"{each.pose.file}, column '{payload.file.time.column}': stamps jitter by {1e3 * each.evened:.2g} ms though "
        "samples were taken evenly, as the pose tells: replaced by the even clock beneath them."
        for each in payload.recordings
        if each.evened > 0.0
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
            f"The wrench seems {abs(late):.2g} ± {std:.1g} ms {way} against the pose: too little to be named; the "
            "doubt of all numbers holds it."
        )
    if excitation.left_out and (rigid is not None or not missing.found):
        spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in excitation.left_out[:5])
        out.append(f"Something touched the payload in the excitation; left out: {spans}.")
    return out
