"""Whatever an evaluation can be doing has words."""

from exogauge.progress import Doing
from exogauge.studies.words.progress_words import WORDS, phrase


def test_everything_that_can_be_done_is_told_in_words() -> None:
    assert set(WORDS) == set(Doing)


def test_a_phrase_ends_with_what_it_is_about() -> None:
    assert phrase(Doing.PREDICTING, "bend_1") == "predicting bend_1"
    assert phrase(Doing.FILTERING) == "filtering and differentiating"
