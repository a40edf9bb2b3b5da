"""Detectors are values in, values out, and stand in one tuple."""

import dataclasses
import importlib
import inspect
from dataclasses import replace
from pathlib import Path

import pytest

from exogauge.detect import pipeline
from exogauge.detect.pipeline import DETECTORS, find_missing_effects
from exogauge.detect.so_far import SoFar
from exogauge.effects.catalogue import missing_effects
from exogauge.findings.result import Alternative, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.settings import Settings
from exogauge.identification.sites import AxisSite
from exogauge.search.state import Problem, Search

DETECT = Path(pipeline.__file__).parent
ARCHITECTURE = Path(__file__).parents[2] / "docs" / "architecture.md"


def of_module(file):
    """Its functions that take and give `SoFar`."""
    module = importlib.import_module("exogauge.detect." + ".".join(file.relative_to(DETECT).with_suffix("").parts))
    own = [each for _, each in inspect.getmembers(module, inspect.isfunction) if each.__module__ == module.__name__]
    public = [each for each in own if not each.__name__.startswith("_")]
    return [each for each in public if inspect.signature(each).return_annotation == "SoFar"]


def test_every_detector_stands_in_the_tuple_once():
    found = [
        each for file in (*DETECT.glob("*/detector.py"), DETECT / "missing_effects.py") for each in of_module(file)
    ]
    assert sorted(found, key=lambda each: each.__name__) == sorted(DETECTORS, key=lambda each: each.__name__)
    assert len(set(DETECTORS)) == len(DETECTORS)


def test_the_document_says_where_another_one_goes():
    said = ARCHITECTURE.read_text(encoding="utf-8")
    assert "`DETECTORS` of `detect/pipeline.py`" in said
    assert "`detector.py` (`SoFar` in, `SoFar` out)" in said


@pytest.mark.parametrize("state", [SoFar, Search, Problem])
def test_what_a_search_has_come_to_is_frozen(state):
    assert state.__dataclass_params__.frozen
    mutable = [each.name for each in dataclasses.fields(state) if str(each.type).startswith(("list", "dict", "set"))]
    assert mutable == []


def test_a_try_that_failed_is_not_known_to_the_search_that_it_began_from():
    earlier = Search(Problem(None, (), (), Settings()))  # nothing is identified here
    why = Alternative("stribeck", Place("joint", "j1"), 0.0, Objection(Why.LITTLE, 0.0))
    later = earlier.having_failed(("stribeck", AxisSite(0)), why)
    assert dict(later.failed) == {("stribeck", AxisSite(0)): why}
    assert dict(earlier.failed) == {}


@pytest.mark.slow
def test_another_detector_is_one_entry(study, identified, monkeypatch):
    """One that says of its own what the logs are not about: its finding is told, and its step stands in the chain."""
    recordings = study()
    found = identified(recordings)
    plain = find_missing_effects(found, recordings, missing_effects(), Settings(cutoff_hz=found.cutoff_hz))
    assert plain.discrepancy.findings == ()
    seen = []

    def looking(so_far: SoFar) -> SoFar:
        seen.append(so_far.current)
        return replace(so_far, doubtful=(*so_far.doubtful, why))

    why = Alternative("rust", Place("joint", "j1"), 0.0, Objection(Why.LITTLE, 0.0))
    monkeypatch.setattr(pipeline, "DETECTORS", (*DETECTORS, looking))
    with_it = find_missing_effects(found, recordings, missing_effects(), Settings(cutoff_hz=found.cutoff_hz))
    assert len(seen) == 1
    assert [each for each in with_it.discrepancy.rejected if each not in plain.discrepancy.rejected] == [why]
