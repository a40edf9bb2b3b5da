"""Examine a log before it is believed: every rule over every channel, worst news first."""

from __future__ import annotations

from exogauge.logs import body_rules, contact_rules, gyro_rules, joint_rules, signal_rules
from exogauge.logs.findings import Expectation, Finding, JointLimits, Rule, Severity, kind_of
from exogauge.logs.model import Log

__all__ = ["Expectation", "Finding", "JointLimits", "Severity", "examine"]

RULES: tuple[Rule, ...] = (
    signal_rules.what_was_done,
    signal_rules.rate_differs,
    signal_rules.slowly_sampled,
    signal_rules.clock_jitters,
    signal_rules.clock_has_gaps,
    signal_rules.not_finite,
    signal_rules.dead,
    signal_rules.frozen,
    signal_rules.held,
    signal_rules.saturated,
    signal_rules.coarse_or_noisy,
    signal_rules.stored_low_passed,
    joint_rules.joint_missing,
    joint_rules.counts,
    joint_rules.jumps,
    joint_rules.beyond_limits,
    joint_rules.beyond_speed,
    joint_rules.current_in_milliamperes,
    joint_rules.velocity_is_another,
    body_rules.gravity_at_rest,
    gyro_rules.gyro_against_tilt,
    gyro_rules.gyro_still,
    body_rules.feet_carry_the_weight,
    contact_rules.contact_stands,
)
CONSEQUENCES = ("noisier_than_declared",)  # said only where nothing else is wrong: a wrong unit scales the noise too
ORDER: dict[Severity, int] = {"error": 0, "warning": 1, "note": 2}


def examine(log: Log, expectation: Expectation | None = None) -> tuple[Finding, ...]:
    """All findings, errors first, within a severity in the order of `RULES`.

    Nothing in the log is changed. A healthy log yields notes at most. Where the clock itself is unusable, that is
    the only finding.
    """
    expected = expectation or Expectation()
    stopped = tuple(signal_rules.unusable_clock(log, expected))
    if stopped:
        return stopped
    findings = [finding for rule in RULES for finding in rule(log, expected)]
    doubted = {f.channel for f in findings if f.severity != "note" and f.rule not in CONSEQUENCES}
    findings = [f for f in findings if f.rule not in CONSEQUENCES or not _family(f.channel) & doubted]
    return tuple(sorted(findings, key=lambda finding: ORDER[finding.severity]))


def dead_moments(log: Log, expected: Expectation) -> dict[str, list[slice]]:
    """Channel -> where it tells nothing while joints move, of those by which the log as a whole is spoiled."""
    return contact_rules.contacts_stopped(log, expected) | signal_rules.sensors_stopped(log, expected)


def _family(channel: str) -> set[str]:
    kind = kind_of(channel)
    return {channel, kind, f"{kind}.*"}
