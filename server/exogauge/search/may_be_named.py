"""What every finding has to hold before it is told, whoever made it; what does not is at most also possible."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.order import LOG, SINCE
from exogauge.findings.result import Alternative, Finding

SURE = 2.0  # standard deviations by which its size must differ from none: one in twenty, as with every interval told


def refused(finding: Finding) -> str:
    """Why it may not be named, in words and numbers, or ""."""
    held = finding.held_out
    if not held.falls:
        where = f"error in {held.log}" if held.log else "held-out error"
        change = f"{held.rmse_before:.3g} to {held.rmse_after:.3g} {held.unit}"
        return f"with it the {where} of {held.channel} does not fall ({change})"
    sizes = _sizes(finding)
    if sizes and all(abs(value) < SURE * std for value, std in sizes.values()):
        told = ", ".join(f"{name} {value:.2g} ± {std:.2g}" for name, (value, std) in sizes.items())
        return f"its size may as well be none ({told})"
    return ""


def told(findings: Sequence[Finding]) -> tuple[tuple[Finding, ...], tuple[Alternative, ...]]:
    """Those that may be named, and the others as what was rejected."""
    reasons = [refused(each) for each in findings]
    named = tuple(each for each, reason in zip(findings, reasons, strict=True) if not reason)
    return named, tuple(not_named(each, reason) for each, reason in zip(findings, reasons, strict=True) if reason)


def not_named(finding: Finding, reason: str) -> Alternative:
    return Alternative(finding.effect, finding.place, finding.score, reason)


def _sizes(finding: Finding) -> dict[str, tuple[float, float]]:
    """Name -> how far from none, and its standard deviation. Of a body its mass, where that is told: its centre may
    well lie at the origin. Of a gain its distance from what is stated. Else the coefficients, of which one is enough:
    of a wave's two parts one may be zero. Of a curve with free shapes nothing: size and shape may trade against each
    other (`as_drawn`), and that the error falls says that there is something."""
    found = finding.parameters
    if "mass" in found:
        return {"mass": _pair(found["mass"])}
    if "ratio" in found and finding.effect != "coupling":  # there it is a shape: of the speeds of two joints
        return {"ratio - 1": (found["ratio"].value - 1.0, found["ratio"].std)}
    effects = [each for each in missing_effects() if each.name == finding.effect]
    straight = [each for each in effects if all(one.choice or one.name in (LOG, SINCE) for one in each.shapes)]
    names = {one.name for each in straight for one in each.coefficients}
    return {name: _pair(found[name]) for name in found if name in names}


def _pair(estimate: Estimate) -> tuple[float, float]:
    return estimate.value, estimate.std
