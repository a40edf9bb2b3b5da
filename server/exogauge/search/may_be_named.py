"""What every finding has to hold before it is told, whoever made it; what does not is at most also possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.order import LOG, SINCE
from exogauge.findings.objection import Objection, Why
from exogauge.findings.result import Alternative, Finding


def refused(finding: Finding, judging: Judging) -> Objection | None:
    """Why it may not be named."""
    held = finding.held_out
    if not held.falls(judging):
        of = (held.channel, *([held.log] if held.log else []))
        return Objection(Why.NOT_FALLING, held.rmse_before, held.rmse_after, held.unit, of)
    sizes = _sizes(finding)
    if sizes and all(abs(each.value) < judging.significant * each.std for each in sizes.values()):
        return Objection(Why.MAY_BE_NONE, sizes=sizes)
    return None


def told(findings: Sequence[Finding], judging: Judging) -> tuple[tuple[Finding, ...], tuple[Alternative, ...]]:
    """Those that may be named, and the others as what was rejected."""
    judged = [(each, refused(each, judging)) for each in findings]
    named = tuple(each for each, objection in judged if objection is None)
    return named, tuple(not_named(each, objection) for each, objection in judged if objection is not None)


def not_named(finding: Finding, objection: Objection) -> Alternative:
    return Alternative(finding.effect, finding.place, finding.score, objection)


def _sizes(finding: Finding) -> dict[str, Estimate]:
    """Name -> how far from none. Of a body its mass, where that is told: its centre may
    well lie at the origin. Of a gain its distance from what is stated. Else the coefficients, of which one is enough:
    of a wave's two parts one may be zero. Of a curve with free shapes nothing: size and shape may trade against each
    other (`as_drawn`), and that the error falls says that there is something."""
    found = finding.parameters
    if "mass" in found:
        return {"mass": found["mass"]}
    if "ratio" in found and finding.effect != "coupling":  # there it is a shape: of the speeds of two joints
        return {"ratio - 1": replace(found["ratio"], value=found["ratio"].value - 1.0)}
    effects = [each for each in missing_effects() if each.name == finding.effect]
    straight = [each for each in effects if all(one.choice or one.name in (LOG, SINCE) for one in each.shapes)]
    names = {one.name for each in straight for one in each.coefficients}
    return {name: found[name] for name in found if name in names}
