"""How often one evaluation prepares a log."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from exogauge.identification import bandwidth, identify, model, preparation
from exogauge.studies.evaluate import evaluate


@pytest.mark.slow
def test_no_log_is_prepared_twice_alike_where_there_is_room(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Counter[tuple[object, ...]]()

    def counted(robot: Any, log: Any, cutoff_hz: float, at_rest: Any) -> preparation.Prepared:
        made[log.name, cutoff_hz, at_rest.threshold.tobytes()] += 1
        return preparation.prepare(robot, log, cutoff_hz, at_rest)

    for module in (bandwidth, identify, model):  # not `noise_bias`, which adds noise of its own every time
        monkeypatch.setattr(module, "prepare", counted)
    evaluate(folder, tmp_path / "out", lambda *_: None)
    assert {name for name, *_ in made} == {"id_1", "val_1"}
    assert set(made.values()) == {1}
