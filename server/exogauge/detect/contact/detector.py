"""What happened once, such as a push, is left out before effects that are always there are sought."""

from __future__ import annotations

from dataclasses import replace

from exogauge.detect.contact.contact import contacts, pushes
from exogauge.detect.contact.finding import CONTACT
from exogauge.detect.so_far import SoFar
from exogauge.findings.as_told import OF_THE_LOGS
from exogauge.search.may_be_named import refused
from exogauge.search.rising import still


def contact(so_far: SoFar) -> SoFar:
    """Without the time in which something touched the robot."""
    if not so_far.question.touched:
        return so_far
    touched = contacts(so_far.current, so_far.recordings, so_far.identified, so_far.question.progress)
    if touched is None or any(refused(each, so_far.criteria.judging) for each in touched.findings):
        return so_far
    models = (*so_far.models, *([touched.identification] * len(touched.findings)))
    return replace(so_far, recordings=touched.recordings, models=models).having(touched.findings)


def contact_again(so_far: SoFar) -> SoFar:
    """Where effects were named since that explain what looked like a push, all is sought anew without one."""
    looked_like_one = any(each.effect == CONTACT for each in so_far.findings)
    named_since = any(each.effect not in OF_THE_LOGS for each in so_far.findings)
    if not looked_like_one or not named_since or pushes(so_far.current.model, so_far.whole):
        return so_far
    question = so_far.question
    return replace(so_far, anew=replace(question, touched=False, progress=still(question.progress)))
