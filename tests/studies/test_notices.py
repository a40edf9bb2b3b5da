"""Long lists are folded for the eye; nothing is lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from exogauge.cli import main
from exogauge.remarks import About, Remark
from exogauge.studies.words.notices import by_sort, notice, repeats

NAMES = ("torso_yaw", "r.arm[2]", "l_hip/roll", "knee", "ankle_pitch", "neck", "r_hand", "l_hand.x")


def test_a_long_list_in_a_sentence_is_cut_and_kept_beside_it() -> None:
    said = notice(Remark(About.NO_URDF_OF, NAMES))
    assert "those of torso_yaw, r.arm[2], l_hip/roll and 5 more. Ask for" in said.short
    assert ", ".join(NAMES) in said.sentence
    assert said.names == NAMES
    assert said.as_data()["short"] == said.short
    assert said.as_data()["names"] == list(NAMES)


def test_a_sentence_with_a_short_list_stays_as_it_is() -> None:
    said = notice(Remark(About.HELD_AT_EDGE, NAMES[:3]))
    assert said.short == said.sentence
    assert said.names == ()


def test_findings_of_one_sort_stand_together_errors_first_and_none_is_lost() -> None:
    sorts = [("note", "coarse"), ("warning", "coarse"), ("error", "dead"), ("note", "coarse"), ("strange", "new")]
    findings = [{"severity": each, "rule": rule, "channel": str(k)} for k, (each, rule) in enumerate(sorts)]
    groups = by_sort(findings)
    assert {groups[0].severity, groups[1].severity} == {"error", "strange"}
    assert [len(group.each) for group in groups] == [1, 1, 1, 2]
    assert sorted(str(each["channel"]) for group in groups for each in group.each) == list("01234")


@pytest.mark.slow
def test_the_doctor_shows_a_few_of_each_sort_and_all_when_asked(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["doctor", str(folder)])
    few = capsys.readouterr().out
    main(["doctor", str(folder), "--all"])
    everything = capsys.readouterr().out
    assert few.splitlines()[-1] == everything.splitlines()[-1]
    assert len(everything.splitlines()) >= len(few.splitlines())
    assert "--all lists them" not in everything


def test_logs_that_differ_by_a_number_are_repeats() -> None:
    assert repeats(["bend_1", "bend_2", "twist", "val-10", "bend_1", "7"]) == {
        "bend": ["bend_1", "bend_2"], "twist": ["twist"], "val": ["val-10"], "7": ["7"],
    }  # fmt: skip
