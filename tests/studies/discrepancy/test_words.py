"""What a reader is told of any effect holds no identifier, whichever effect it is and whatever comes next to it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from typing import Any

from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import all_effects, band_effects, missing_effects
from exogauge.findings.basis import OfBand, OfRobot
from exogauge.findings.result import Alternative, ChainStep, Discrepancy, HeldOut, Link, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.plain_values import finite
from exogauge.studies.words.finding_sentences import finding_sentence
from exogauge.studies.words.names import step_words, words_of_effects
from exogauge.studies.words.reason_sentences import objection_words

IDENTIFIER = re.compile(r"[A-Za-z]\w*_\w+|\w+@\w+")
PLACES = {
    "band": Place("band", "left"),
    "base": Place("base", "base"),
    "ft": Place("sensor", "wrist", "fx"),
    "payload": Place("link", "hand"),
    "link": Place("link", "hand"),
    "contact": Place("link", "hand"),
    "imu": Place("base", "base"),
}
HELD_OUT = HeldOut("tau.elbow", "N·m", 2.0, 1.0, 0.5)


def place_of(name: str) -> Place:
    if name == "band_limited_log":
        return Place("log", "swing")
    return PLACES.get(name.partition("_")[0], Place("joint", "elbow"))


def told(name: str, next_to: str, one: Discrepancy) -> Iterator[str]:
    """Everything that is said of one effect with another one as the next best."""
    place, other = place_of(name), Alternative(next_to, place_of(next_to), 0.3, Objection(Why.LESS))
    found = dataclasses.replace(
        one.findings[0], effect=name, place=place, held_out=HELD_OUT, parameters={},
        alternatives=(other,), also_possible=(other,),
    )  # fmt: skip
    steps = (ChainStep("robot"), ChainStep("effect", name, place))
    links = [Link(step, 1.0, 0.5, "tau.elbow", 1.0, 0.5, "N·m") for step in steps]
    made = dataclasses.replace(
        one, findings=(found,), chain=tuple(links), rejected=(other,), notes=(), unexplained=(), located=(),
        before_after=(),
    )  # fmt: skip
    entry: Any = finite(discrepancy_entry(made))
    yield entry["sentence"]
    yield entry["findings"][0]["motion"]
    yield from (each["step"] for each in entry["chain"])
    yield from (
        each[key] for each in (entry["findings"][0], *entry["rejected"]) for key in ("title", "reason") if key in each
    )


def test_no_sentence_on_an_effect_holds_an_identifier(one: Discrepancy) -> None:
    names = list(words_of_effects())
    for name, next_to in zip(names, [*names[1:], names[0]], strict=True):
        for text in told(name, next_to, one):
            assert IDENTIFIER.search(text) is None, text


def test_the_words_of_every_effect_end_the_same_sentence() -> None:
    """`The identified model does not know of …`: nothing that begins a sentence, no article twice, no end."""
    for name, words in words_of_effects().items():
        assert re.fullmatch(r"(Stribeck|Coulomb|[a-z])[^.:]*", words), name
        assert not re.search(r"\b(an?|the) (an?|the)\b", words), name
        assert re.search(r"\b(a [aeiou]|an [^aeiou])", words) is None, name


def test_what_each_effect_says_of_itself_are_whole_sentences_without_identifiers() -> None:
    for effect in (*all_effects().values(), *missing_effects(), *band_effects().values()):
        assert effect.name in words_of_effects()
        for text in (effect.sentence, getattr(effect, "needs", "Nothing.")):
            assert IDENTIFIER.search(text) is None, (effect.name, text)
            assert re.fullmatch(r"[A-Z].*[.]", text, re.S), (effect.name, text)


def test_the_evidence_names_its_place_and_the_next_best_in_words(one: Discrepancy) -> None:
    words = words_of_effects()
    bases = [OfRobot(effect) for effect in missing_effects()]
    bases += [OfBand(effect, "suit", "motions") for effect in band_effects().values()]
    for basis in bases:
        for name in words:
            other = Alternative(name, place_of(name), 0.3, Objection(Why.LESS))
            text = finding_sentence(dataclasses.replace(
                one.findings[0], effect=basis.effect.name, place=place_of(basis.effect.name), held_out=HELD_OUT,
                basis=basis, alternatives=(other,),
            ))  # fmt: skip
            assert IDENTIFIER.search(text) is None, text
            assert f"The next best, {words[name]}" in text
            assert "the base: " not in text


def test_every_objection_is_a_sentence_with_its_own_numbers() -> None:
    sizes = {"mass": Estimate(-0.1, 0.3, "kg")}
    of = {
        Why.WORSE: ("low_speed",), Why.NOT_FALLING: ("tau.elbow", "swing"), Why.SMALL_BESIDE: ("stribeck",),
        Why.BETTERED: ("payload", "stribeck"), Why.NOT_NEEDED: ("base_tilt",),
        Why.PARTIAL: ("tau.elbow",), Why.OTHER_LAW: ("support.elbow",), Why.AT_ITS_EDGE: ("base.fz",),
    }  # fmt: skip
    said = [objection_words(Objection(why, 1.25, 4.5, "N·m", of.get(why, ()), sizes)) for why in Why]
    assert len(set(said)) == len(Why)
    for text in said:
        assert re.fullmatch(r"[a-z][^{}]*[^ .]", text), text
        assert IDENTIFIER.search(text) is None, text
    assert "error in swing of elbow does not fall (1.25 to 4.5\u00a0N·m)" in " ".join(said)
    assert "with a payload and Stribeck friction in the model, another one explains more" in said
    assert [text.partition(" it ")[0] for text in said if "follows another law" in text] == ["at elbow (support)"]


def test_a_step_of_the_chain_is_told_in_words_whether_it_is_an_effect_or_its_own_curve() -> None:
    friction = "load_coulomb", Place("joint", "elbow")
    assert step_words(ChainStep("effect", *friction)) == "+ load-dependent friction at elbow"
    assert step_words(ChainStep("own_curve", *friction)) == "+ own curve of load-dependent friction at elbow"
    assert step_words(ChainStep("remainder", *friction)) == "+ remainder of load-dependent friction at elbow"
    assert step_words(ChainStep("robot")) == "identified model"
