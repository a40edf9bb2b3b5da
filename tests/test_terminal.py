"""What a person reads in a terminal, and what a log of a build gets instead."""

from __future__ import annotations

import pytest

from exogauge import terminal
from exogauge.terminal import bar, text_table


def test_where_stderr_is_no_terminal_progress_is_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with bar("run") as say:
        for k in range(100):
            say(k / 100, "thinking")
    assert capsys.readouterr().err == "run 99 % thinking\n"
    monkeypatch.setattr(terminal, "LINE_EVERY_S", 0.0)
    with bar("run") as say:
        say(0.25, "thinking")
        say(0.5, "writing", "second")
    assert capsys.readouterr().err == "run 25 % thinking\nsecond 50 % writing\n"


def test_numbers_stand_to_the_right_also_when_they_are_text() -> None:
    table = text_table(("what", "value", "part"), [["a", "−0.5", "9%"], ["b", "12.75", ""], ["c", None, "52%"]])
    assert table.splitlines()[2:] == ["a      −0.5    9%", "b     12.75", "c             52%"]
