"""The schema of results.json: whole results hold to it, nothing else does, and the documents name every key."""

from __future__ import annotations

import copy
import dataclasses
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import BaseModel, ValidationError

from exogauge.identification.settings import Settings
from exogauge.studies.results.schema import StudyResults

DOCS = Path(__file__).resolve().parents[3] / "docs" / "study.md"
ONLY_WHERE_THERE_IS_ONE = {"combination", "reason", "A", "B", "prior", "band_model", "device", "taken_over"}
OF_DECIDED = {"IdentifiedParameter": {"budget"}}  # what is said of numbers alone that the data decide


def parts(model: type[BaseModel], known: dict[str, type[BaseModel]]) -> dict[str, type[BaseModel]]:
    """Every model below this one, by name."""
    if model.__name__ not in known:
        known[model.__name__] = model
        for field in model.model_fields.values():
            for each in models_in(field.annotation):
                parts(each, known)
    return known


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for each in get_args(annotation):
        yield from models_in(each)


def written(part: Any) -> Iterator[tuple[str, BaseModel]]:
    """Every part of a result, with its model's name."""
    if isinstance(part, BaseModel):
        yield type(part).__name__, part
        for name in type(part).model_fields:
            yield from written(getattr(part, name))
    elif isinstance(part, list | tuple | dict):
        for each in part.values() if isinstance(part, dict) else part:
            yield from written(each)


def test_a_whole_result_says_every_key_of_the_schema(whole: dict[str, Any]) -> None:
    """Also those that older results lack, which the schema therefore does not require."""
    read = StudyResults.model_validate(whole)
    assert read.model_dump(exclude_unset=True, by_alias=True) == whole
    seen = set()
    for name, part in written(read):
        seen.add(name)
        lacks = set(type(part).model_fields) - part.model_fields_set
        assert lacks <= ONLY_WHERE_THERE_IS_ONE | OF_DECIDED.get(name, set()) or name == "JointNumbers", (name, lacks)
    assert seen >= {"NamedEffect", "Support", "BandStiffness", "Scope", "Configuration", "Discrepancy"}


def test_what_the_schema_does_not_hold_is_not_written(evaluated: Callable[..., dict[str, Any]]) -> None:
    """A finding of the doctor of a severity that does not exist; one with a key that nobody describes."""
    said = {"log": "a", "severity": "note", "channel": "t", "rule": "r", "detail": "d", "advice": "e", "row": None}
    assert evaluated(findings=[said | {"value": float("nan")}])["doctor"][0]["value"] is None
    for wrong in ({"severity": "fatal"}, {"colour": "red"}, {"row": "first"}):
        with pytest.raises(ValidationError, match=next(iter(wrong))):
            evaluated(findings=[said | {"value": None} | wrong])


def test_a_result_of_before_the_later_keys_still_opens(whole: dict[str, Any]) -> None:
    old = copy.deepcopy(whole)
    for key in ("scope", "configuration", "reading"):
        del old[key]
    for key in ("left", "reason", "sentence", "left_sentence", "wear_chain"):
        del old["discrepancy"][key]
    for finding in old["discrepancy"]["findings"]:
        del finding["title"], finding["planned"], finding["apart"], finding["held_out"]["log"]
    assert StudyResults.model_validate(old).model_dump(exclude_unset=True) == old


def test_every_setting_is_described() -> None:
    settings = parts(StudyResults, {})["Settings"]
    apart = {"criteria", "started"}  # which stand with their reasons beside the settings, and with each log
    assert set(settings.model_fields) == {each.name for each in dataclasses.fields(Settings)} - apart


def test_every_key_is_described_and_stands_in_the_documents() -> None:
    said = set(re.findall(r"\w+", DOCS.read_text(encoding="utf-8").split("## What you get")[1]))
    for model in parts(StudyResults, {}).values():
        assert model.__doc__
        for name, field in model.model_fields.items():
            assert field.description, (model.__name__, name)
            assert name in said, f"docs/study.md says nothing of {name} ({model.__name__})"
