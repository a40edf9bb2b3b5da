"""What the doctor says of a payload's logs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import STD, case

from exogauge.payload.doctor import delayed, drift_in_holds, noise_in_holds, quantised, saturated, zero_steps
from exogauge.payload.dynamics import dynamic_rows
from exogauge.payload.intake import Payload, Stream, open_payload
from exogauge.synthetic.payload import write_payload

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def payload(tmp_path_factory: pytest.TempPathFactory) -> Payload:
    out = tmp_path_factory.mktemp("doctor")
    write_payload(out, 5)
    return open_payload(out)


def changed(payload: Payload, change: Callable[[Array, Array], Array]) -> Payload:
    """change: (T,) time, (T, 6) wrench -> wrench, of the postures."""
    first = payload.recordings[0]
    wrench = first.wrench
    spoiled = Stream(wrench.time, change(wrench.time, wrench.values.copy()), wrench.file)
    return replace(payload, recordings=(replace(first, wrench=spoiled), *payload.recordings[1:]))


def ramp(time: Array, wrench: Array) -> Array:
    wrench[:, 1] += 3.0 * (time % 2.0) * (time > 10.0) * (time < 12.0)
    return wrench


def rezeroed(time: Array, wrench: Array) -> Array:
    wrench[time > 21.0, 2] -= 1.0
    return wrench


RULES = {
    "saturated": (saturated, lambda t, w: np.clip(w * 20.0, -2500.0, 2500.0)),
    "coarse_steps": (quantised, lambda t, w: np.round(w / 4.0) * 4.0),
    "noise_differs": (noise_in_holds, lambda t, w: w + np.random.default_rng(0).standard_normal(w.shape)),
    "drift_in_hold": (drift_in_holds, ramp),
}


@pytest.mark.parametrize("rule", RULES)
def test_each_fault_is_found_and_none_where_there_is_none(rule: str, payload: Payload) -> None:
    look, spoil = RULES[rule]
    assert not list(look(payload, payload.recordings[0]))
    spoiled = changed(payload, spoil)  # type: ignore[arg-type]
    assert rule in {each.rule for each in look(spoiled, spoiled.recordings[0])}


def test_a_sensor_zeroed_between_two_postures_is_found_on_its_axis(payload: Payload) -> None:
    assert not list(zero_steps(payload))
    found = list(zero_steps(changed(payload, rezeroed)))
    assert "fz" in {each.channel for each in found}
    assert any("posture 12" in each.detail for each in found if each.channel == "fz")


@pytest.mark.parametrize("late", [0, 5])
def test_a_late_wrench_is_found_with_its_delay(late: int) -> None:
    one = case(0)
    motion = one.motion()
    wrench = np.roll(one.excitation[1], late, axis=0)
    inner = slice(motion.edge, -motion.edge)
    rows = dynamic_rows(motion.rows(inner), wrench[inner], one.static.gravity, -1, STD)
    found = list(delayed(motion.time[inner], rows.z))
    assert bool(found) == bool(late)
    if late:
        assert found[0].value == pytest.approx(late / 250.0, abs=0.002)


def test_the_command_says_what_it_found_and_ends_with_1_for_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from exogauge.cli import main

    write_payload(tmp_path, 5)
    assert main(["payload", "doctor", str(tmp_path)]) == 0
    assert "nothing to find fault with" in capsys.readouterr().out
    text = (tmp_path / "payload.yaml").read_text()
    assert "[2500.0, 2500.0, 6250.0]" in text
    text = "".join(line for line in text.splitlines(True) if "role: test" not in line and "role: contact" not in line)
    (tmp_path / "payload.yaml").write_text(text.replace("[2500.0, 2500.0, 6250.0]", "[2500.0, 2500.0, 300.0]"))
    assert main(["payload", "doctor", str(tmp_path)]) == 1
    assert "saturated" in capsys.readouterr().out
