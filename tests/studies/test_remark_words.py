"""Every remark has words, and they tell its names and numbers."""

from __future__ import annotations

import math
import string

import pytest

from exogauge.remarks import About, Remark
from exogauge.studies.words.remark_words import FORMS, sentence


def test_every_remark_has_words() -> None:
    assert set(FORMS) == set(About)


@pytest.mark.parametrize("about", About)
def test_a_sentence_names_what_it_is_about(about: About) -> None:
    """One of two names, and of every name two numbers, as the form asks for them."""
    form = FORMS[about]
    said = sentence(Remark(about, ("left", "right"), ((0.25, 0.5),) * 2, ("one", "other"), (0.25, 0.75, 2.0, 3.0)))
    assert "{" not in said
    fields = {field for _, field, _, _ in string.Formatter().parse(form.text) if field}
    assert ("left" in said and "right" in said) is ("names" in fields)


NUMBERS = [
    (
        Remark(About.LITTLE_STEADY, ("elbow",), ((0.31, 4.06),), numbers=(0.25,)),
        "less than 25 % is steady motion, which alone is fitted: elbow (0.3 of 4.1 s).",
    ),
    (
        Remark(About.LOAD_FELT_TOO_LITTLE, ("hand",), ((0.02,),), numbers=(math.nan, 0.31)),
        "The known load of 0.02 kg at hand is felt too little to fix that factor: it takes its doubt from unknown to "
        "31 %.",
    ),
    (
        Remark(About.TOUCHED, ("bend",), numbers=(1.0, 2.0, 3.5, 4.0)),
        "bend, from 1.00 to 2.00 s and from 3.50 to 4.00 s: something touched the robot.",
    ),
    (
        Remark(About.LAW_STATED, ("left", "right"), beside=("maxwell", "hardening")),
        "left (maxwell), right (hardening).",
    ),
    (
        Remark(About.INERTIA_RAISED, ("hand", "foot"), beside=("a.urdf", "foot"), numbers=(2e-6, 1e-3, 2e-3, 4e-3)),
        "a.urdf: no body has the inertia of 'hand', 'foot'; at 'foot' it misses by 2e-06 kg·m²",
    ),
    (
        Remark(About.MOTION_DOUBTFUL, ("deep", "plain"), beside=("hip",), numbers=(0.12, 0.1, 0.052)),
        "deep and plain differ in the motion of hip: 12 % of its rms velocity (limit 10 %), 0.052 rad rms.",
    ),
]


@pytest.mark.parametrize(("remark", "said"), NUMBERS)
def test_names_and_numbers_stand_where_they_belong(remark: Remark, said: str) -> None:
    assert said in sentence(remark)
