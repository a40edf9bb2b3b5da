"""Logs whose label does not go with what they show: the device was on, or off, where study.yaml says the reverse."""

from __future__ import annotations

from dataclasses import replace

import pytest

from exogauge.criteria.supporting import Supporting
from exogauge.remarks import About
from exogauge.support.evaluate import gather_support
from exogauge.support.labels import Level, said
from exogauge.support.settings import PlainLog, WornLog

STARTS = {"fit": 0.0, "before1": 600.0, "worn1": 1300.0, "worn2": 1420.0, "after1": 2200.0}
LABELS = {About.LABELS_EXCHANGED, About.DEVICE_ON, About.DEVICE_OFF, About.DEVICE_ON_WHERE_FITTED}
WORN, BARE = ("worn1", "worn2"), ("before1", "after1")


@pytest.fixture(scope="module")
def clean(biped, suit, recorded):
    return recorded(biped, suit, STARTS)


def told(model, clean, suit, worn, bare=None):
    """(about, logs) with these logs labelled so."""
    bare = [name for name in (*BARE, *WORN) if name not in worn] if bare is None else bare
    plain = [PlainLog(clean[name], "stoop", True) for name in bare]
    found = gather_support(model, plain, [WornLog(clean[name], "stoop", suit) for name in worn])
    return [(each.about, set(each.names)) for each in found.notes if each.about in LABELS]


def test_labels_that_are_right_are_not_doubted(biped, clean, suit):
    assert told(biped.known(), clean, suit, WORN) == []


def test_nor_where_the_device_file_states_neither_stiffness_nor_length(biped, clean, suit):
    bare = replace(suit, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in suit.bands))
    assert told(biped.known(), clean, bare, WORN) == []
    assert told(biped.known(), clean, bare, BARE) == [(About.LABELS_EXCHANGED, {*WORN, *BARE})]


def test_labels_that_were_exchanged_in_all_logs_or_in_a_pair_are_told(biped, clean, suit):
    assert told(biped.known(), clean, suit, BARE) == [(About.LABELS_EXCHANGED, {*WORN, *BARE})]
    pair = told(biped.known(), clean, suit, ("worn1", "after1"))
    assert pair == [(About.LABELS_EXCHANGED, {"worn2", "after1"})]


def test_a_single_wrong_label_is_told(biped, clean, suit):
    assert told(biped.known(), clean, suit, ("worn1",)) == [(About.DEVICE_ON, {"worn2"})]
    assert told(biped.known(), clean, suit, (*WORN, "after1")) == [(About.DEVICE_OFF, {"after1"})]


def test_a_device_that_was_on_where_the_robot_was_identified_is_told():
    """The model then holds the device: it is missed where it is off."""
    criteria = Supporting()
    worn, bare = (
        [Level("w1", 0.05, 0.2), Level("w2", -0.04, -0.1)],
        [Level("b1", -0.9, -0.97), Level("b2", -1.0, -0.98)],
    )
    (remark,) = said(worn, bare, "suit", criteria)
    assert (remark.about, remark.names) == (About.DEVICE_ON_WHERE_FITTED, ("b1", "b2"))


def test_what_is_missed_otherwise_than_bands_pull_raises_no_doubt():
    worn, bare = [Level("w1", 1.0, 0.95)], [Level("b1", 0.7, 0.4), Level("b2", -0.3, -0.9)]
    assert said(worn, bare, "suit", Supporting()) == []
