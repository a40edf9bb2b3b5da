"""What the doctor says of a payload's logs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import STD, case

from exogauge.logs.findings import longest_run
from exogauge.payload.doctor import delayed, drift_in_holds, noise_in_holds, quantised, zero_steps
from exogauge.payload.dynamics import dynamic_rows
from exogauge.payload.intake import Payload, Stream, open_payload
from exogauge.payload.limits import cut_off, saturated
from exogauge.synthetic.payload import write_payload

Array = NDArray[np.float64]
LONG = 8  # samples of a run
KUKA = Path(__file__).resolve().parents[3] / "shared/data/kuka_ft_payload"


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


def cut(values: Array, share: float, sides: str) -> Array:
    """Every channel, at a share of what it reaches from its median."""
    middle = np.median(values, axis=0)
    low, high = (share * (end - middle) + middle for end in (values.min(axis=0), values.max(axis=0)))
    return np.clip(values, low if "-" in sides else None, high if "+" in sides else None)


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("sides", ["+", "-", "+-"])
def test_a_channel_cut_off_below_the_rated_range_is_found_on_its_sides(
    sides: str, step: float, payload: Payload
) -> None:
    """step: of the converter, in standard deviations of the noise; the coarser, the longer a run has to be."""
    long = LONG if step < 1.0 else 5 * LONG
    for recording in payload.recordings:
        values = recording.wrench.values
        read = np.round(values / (step * STD)) * (step * STD) if step else values
        for name, whole, channel in zip("xyzXYZ", read.T, cut(read, 0.8, sides).T, strict=True):
            assert not list(cut_off(name, whole))
            found = {each.value for each in cut_off(name, channel)}
            ends = {float(channel.max())} if "+" in sides else set()
            ends |= {float(channel.min())} if "-" in sides else set()
            assert {end for end in ends if longest_run(channel == end)[1] >= long} <= found <= ends
    only = replace(
        payload, file=payload.file.model_copy(update={"sensor": payload.file.sensor.model_copy(update={"range": None})})
    )
    assert not [each for log in only.recordings for each in saturated(only, log)]
    spoiled = changed(only, lambda time, wrench: cut(wrench, 0.8, sides))
    assert "saturated" in {each.rule for each in saturated(spoiled, spoiled.recordings[0])}


@pytest.mark.parametrize("step", [2.0, 4.0, 16.0, 100.0, 300.0])
def test_a_coarse_channel_is_not_said_to_be_cut_off(step: float, payload: Payload) -> None:
    coarse = [(log.name, np.round(log.wrench.values / (step * STD)) * (step * STD)) for log in payload.recordings]
    assert not [(name, each) for name, values in coarse for channel in values.T for each in cut_off(name, channel)]


@pytest.mark.skipif(not KUKA.is_dir(), reason="no recordings beside the repository")
@pytest.mark.parametrize("log", ["0-steady-state_wrench", "1-baseline_wrench"])
def test_no_channel_of_a_real_sensor_is_said_to_be_cut_off(log: str) -> None:
    table = np.genfromtxt(KUKA / f"{log}.csv", delimiter=",", names=True)
    for name in ("fx", "fy", "fz", "tx", "ty", "tz"):
        assert not list(cut_off(name, table[name]))
        for sides in "+-":
            channel = cut(table[name][:, None], 0.5, sides)[:, 0]
            end = channel.max() if sides == "+" else channel.min()
            assert [each.value for each in cut_off(name, channel)] == [end] * (longest_run(channel == end)[1] >= LONG)


def test_a_zero_that_settles_through_the_postures_is_no_step(payload: Payload) -> None:
    def settling(time: Array, wrench: Array) -> Array:
        course = 2.0 * (1.0 - np.exp(-3.0 * (time - time[0]) / np.ptp(time)))
        return wrench + course[:, None] * np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    found = {(each.channel, each.rule): each for each in zero_steps(changed(payload, settling))}
    name = payload.file.sensor.wrench[0]
    assert (name, "zero_drifts") in found
    assert (name, "zeroed") not in found
    assert 0.5 < (found[name, "zero_drifts"].value or 0.0) < 2.0


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


@pytest.mark.slow
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
