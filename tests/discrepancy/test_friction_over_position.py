"""Friction that changes with the position, an effect that the catalogue lacks: one class, and it is found and shown."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from types import CodeType
from typing import final

import numpy as np
import pytest
from tests.discrepancy.conftest import SETTINGS

import exogauge
from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape, along_motion
from exogauge.side_by_side import _inside
from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow

HOUSE = Path(exogauge.__file__).parent
SEARCH = ("detect", "search", "experiment", "findings")
DEEPEST_SEARCH, DEEPEST = 10, 17  # calls below `find_missing_effects`, all in one thread; they may only fall

A, B = 0.9, -0.6  # [N·m]


@final
class PositionFriction:
    """τ = -(a cos θ + b sin θ) sgn θ̇: a bearing that is squeezed more at some angles than at others."""

    name = "friction_of_this_test"
    words = "friction that changes with the position"
    place = "joint"
    sentence = "Friction is larger at some positions than at others."
    coefficients = (
        Quantity("tau_a", "N·m", words="part with the cosine of the angle"),
        Quantity("tau_b_sin", "N·m", words="part with the sine of the angle"),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("coulomb",)
    needs = "Slow motion through the whole range, in both directions."
    coordinate = "position"
    along_motion = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        both = np.stack([np.cos(signals.position), np.sin(signals.position)], axis=1)
        return -signals.direction[:, None] * both

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


class Depth:
    """The longest chain of our own functions below `find_missing_effects`, and of those of the search alone."""

    def __init__(self):
        self.chain, self.of_search = (), ()

    def __call__(self, frame, event, arg):
        if event != "call" or not _ours(frame.f_code):
            return
        chain = []
        while frame is not None and frame.f_code is not find_missing_effects.__code__:
            if name := _ours(frame.f_code):
                chain.append(name)
            frame = frame.f_back
        if frame is None:
            return
        of_search = [each for each in chain if each.startswith(SEARCH)]
        self.chain, self.of_search = max(self.chain, chain, key=len), max(self.of_search, of_search, key=len)


@cache
def _ours(code: CodeType) -> str:
    """Where a function of the house stands; empty for others', comprehensions and lambdas."""
    path = Path(code.co_filename)
    if HOUSE not in path.parents or code.co_name.startswith("<"):
        return ""
    return f"{path.relative_to(HOUSE).with_suffix('')}:{code.co_name}"


def _a_twin(effect) -> bool:
    """Friction over the position without a shape: a catalogue that has it is looked at as one that lacks it."""
    return along_motion(effect) and effect.coordinate == "position" and not effect.shapes


@pytest.fixture(scope="module")
def searched(identified, study, on_joint):
    recordings = study(on_joint(1, lambda m: (A * np.cos(m.q) + B * np.sin(m.q)) * np.sign(m.v)))
    effects = (*(each for each in shaped_effects().values() if not _a_twin(each)), PositionFriction())
    before, depth, usual = identified(recordings), Depth(), sys.getprofile()
    in_one_thread = _inside.set(True)  # a frame of another thread would not know who asked for it
    sys.setprofile(depth)
    try:
        return find_missing_effects(before, recordings, effects, SETTINGS).discrepancy.findings, depth
    finally:
        sys.setprofile(usual)
        _inside.reset(in_one_thread)


@pytest.fixture(scope="module")
def found(searched):
    return searched[0]


def test_who_reads_the_search_goes_down_no_deeper_than_before(searched):
    """The search's own layers, and all that it calls: identification, rows, filters."""
    _, depth = searched
    assert 0 < len(depth.of_search) <= DEEPEST_SEARCH, depth.of_search[::-1]
    assert len(depth.of_search) < len(depth.chain) <= DEEPEST, depth.chain[::-1]


def test_it_is_named_alone_at_its_joint_with_its_numbers(found):
    (finding,) = found
    assert (finding.effect, finding.place.name) == ("friction_of_this_test", "j2")
    sine = finding.parameters["tau_b_sin"]
    assert abs(sine.value - B) < 4.0 * sine.std  # the cosine shares its mean with Coulomb friction


def test_its_evidence_is_as_large_as_what_acts_and_not_a_mean_over_both_directions(found):
    """Against the motion at every position, as the truth says but for the part that Coulomb friction took."""
    shown = found[0].evidence
    assert shown.along_motion
    truth = -(A * np.cos(shown.at) + B * np.sin(shown.at))
    gap = shown.before - truth
    assert np.ptp(shown.before) > 0.8 * np.ptp(truth)
    assert np.std(gap) < 0.2 * np.std(truth)
    assert "along the motion" in finding_sentence(found[0])
