"""A step that fails keeps the steps before it: the reason is told beside their results."""

from __future__ import annotations

import logging
from collections.abc import Iterator, MutableSequence, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import final

from exogauge.errors import Cancelled, ExogaugeError, Unavailable, no_room
from exogauge.studies.intake.open import Step

log = logging.getLogger(__name__)


@final
@dataclass(frozen=True)
class FailedStep:
    """reason: in a sentence. expected: the data hold no answer; otherwise the fault is exogauge's own."""

    step: str
    reason: str
    expected: bool

    @property
    def sentence(self) -> str:
        return f"The step {self.step} failed, what was found before it stands: {self.reason}"


@contextmanager
def keeping(failed: MutableSequence[FailedStep], *steps: str) -> Iterator[None]:
    """What goes wrong inside is a failure of these steps, and the evaluation goes on.

    Minutes of identification would be lost with it: therefore also what nobody expected is caught here, logged with
    its trace, and told as such.
    """
    try:
        yield
    except (Cancelled, Unavailable):
        raise
    except ExogaugeError as error:
        failed += [FailedStep(step, str(error), expected=True) for step in steps]
    except Exception as error:
        if no_room(error):
            raise
        log.exception("the step %s failed", " and ".join(steps))
        reason = f"unexpected error ({type(error).__name__}: {error})"
        failed += [FailedStep(step, reason, expected=False) for step in steps]


def told(steps: Sequence[Step], failed: Sequence[FailedStep]) -> tuple[Step, ...]:
    """The steps of the study, those that failed with the reason."""
    reasons = {each.step: each.reason for each in failed}
    return tuple(replace(step, failed=reasons.get(step.step)) for step in steps)
