"""Recorded elsewhere, as laboratories do: what is told is the truth within its interval, or what is wrong is said."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tests.payload import foreign
from tests.payload.told import broken, evaluated, off, still, streamed

from exogauge.errors import BadStudy, NotIdentifiable
from exogauge.payload.evaluate import evaluate
from exogauge.payload.intake import open_payload
from exogauge.payload.prepare import holds_of

Array = NDArray[np.float64]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plain", "jitter", "colour"])
def test_intervals_hold_whoever_recorded(kind: str, tmp_path: Path) -> None:
    errors, named = [], 0
    for seed in range(2):
        folder = tmp_path / str(seed)
        folder.mkdir()
        spoil = foreign.stamps_jitter(seed) if kind == "jitter" else None
        truth = foreign.write(folder, seed, spoil=spoil, colour=0.5 if kind == "colour" else 0.0)
        found = evaluated(folder)
        errors.append(off(found, truth))
        named += found.missing.decision.verdict != "none"
        assert bool([each for each in found.warnings if "stamps jitter" in each]) == (kind == "jitter")
    assert not broken(errors)
    assert named <= 1


@pytest.mark.slow
def test_noise_with_tails_is_nothing_that_is_missing(tmp_path: Path) -> None:
    """Student's of three degrees, of the stated spread: a median deviation takes it for two thirds."""
    rng = np.random.default_rng(2)
    stated = np.repeat([foreign.FORCE_NOISE, foreign.MOMENT_NOISE], 3)

    def spoil(_name: str, table: Array) -> Array:
        tails = stated * rng.standard_t(3, (len(table), 6)) / np.sqrt(3.0)
        return np.column_stack([table[:, :6], table[:, 6:] + tails])

    truth = foreign.write(tmp_path, 2, spoil=spoil, noise=0.01)
    found = evaluated(tmp_path)
    assert found.missing.decision.verdict == "none"
    assert np.abs(off(found, truth)).max() < 4.0


@pytest.mark.slow
def test_channels_that_are_noisier_than_stated_are_taken_as_found_and_told(tmp_path: Path) -> None:
    """One axis alone of six times the noise bent the others' numbers, and its peaks were called touches."""
    rng = np.random.default_rng(4)
    more = np.array([6.0, 0.0, 0.0, 0.0, 5.0, 0.0]) * np.repeat([foreign.FORCE_NOISE, foreign.MOMENT_NOISE], 3)
    noisy = foreign.wrench(lambda w: w + more * rng.standard_normal(w.shape))
    truth = foreign.write(tmp_path, 4, spoil=noisy, tests=False)
    found = evaluated(tmp_path)
    assert found.stages.excitation is not None
    assert not found.stages.excitation.left_out
    assert found.stages.excitation.chosen.mu == pytest.approx(1.0, abs=0.1)
    assert np.abs(off(found, truth)).max() < 4.0
    (told,) = [each for each in found.warnings if "Channels scatter" in each]
    assert re.search(r"FT_X [56]\.\d, FT_B [45]\.\d\. What is more than stated is taken as found", told)


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.0, 1.1])
def test_another_payload_in_motion_than_in_the_postures_is_told_with_its_mass(share: float, tmp_path: Path) -> None:
    """It was unexplained, and another zero was suspected."""
    truth = foreign.write(tmp_path, 6)

    def changed(name: str, table: Array) -> Array:
        w = truth.zero + (1.0 if name == "still" else share) * (table[:, 6:] - truth.zero)
        return np.column_stack([table[:, :6], w])

    foreign.write(tmp_path, 6, spoil=changed)
    told = [each for each in evaluated(tmp_path).warnings if "another body" in each]
    assert bool(told) == (share != 1.0)
    if told:
        said = re.search(r"another body of ([\d.]+) ± ([\d.e-]+) kg", told[0])
        assert said is not None
        assert float(said[1]) == pytest.approx(share * truth.phi[0], rel=2e-3)


@pytest.mark.slow
def test_noisy_angles_are_not_taken_for_motion(tmp_path: Path) -> None:
    """Encoders that err six times as much as is stated."""
    rng = np.random.default_rng(1)

    def spoil(_name: str, table: Array) -> Array:
        noise = 6.0 * foreign.ANGLE_NOISE * rng.standard_normal((len(table), 5))
        return np.column_stack([table[:, 0], table[:, 1:6] + noise, table[:, 6:]])

    truth = foreign.write(tmp_path, 3, spoil=spoil)
    found = evaluated(tmp_path)
    assert np.abs(off(found, truth)).max() < 4.0
    assert found.stages.excitation is not None
    assert found.stages.excitation.chosen.mu < 1.3
    assert [each for each in found.warnings if "shake.csv" in each and "pose.noise_rad" in each]


LATE = 0.006


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["jitter", "low-pass"])
def test_live_numbers_hold_though_gravity_stamps_and_delay_are_only_known_so_well(kind: str, tmp_path: Path) -> None:
    errors = []
    for seed in range(3):
        folder = tmp_path / str(seed)
        folder.mkdir()
        spoil = foreign.stamps_jitter(seed) if kind == "jitter" else foreign.low_passed(LATE)
        error, known = streamed(folder, foreign.write(folder, seed, spoil=spoil, tests=False))
        errors.append(error)
        assert (known.late is None) == (kind == "jitter")
        if known.late is not None:
            assert known.late[0] == pytest.approx(LATE, abs=3e-4)  # a pole is a delay but for its square
            assert known.late[1] < 3e-4
    assert not broken(errors)


@pytest.mark.slow
def test_numbers_hold_behind_a_coarse_converter_and_live_does_not_take_its_steps_for_touches(tmp_path: Path) -> None:
    """Steps of six times the noise: postures do not average them away, motion reads them as more noise than stated."""
    steps = np.repeat([6.0 * foreign.FORCE_NOISE, 6.0 * foreign.MOMENT_NOISE], 3)
    truth = foreign.write(tmp_path, 0, spoil=foreign.wrench(lambda w: np.round(w / steps) * steps), tests=False)
    found = evaluated(tmp_path)
    assert found.stages.excitation is not None
    assert found.stages.excitation.chosen.mu < 1.5
    assert not broken([off(found, truth)])
    assert not broken([streamed(tmp_path, truth)[0]])


@pytest.mark.slow
def test_a_delay_too_small_to_be_named_is_told_and_held(tmp_path: Path) -> None:
    """Two milliseconds, a quarter of a sample: hardly more is left by them than noise."""
    errors = []
    for seed in range(2):
        folder = tmp_path / str(seed)
        folder.mkdir()
        truth = foreign.write(folder, seed, spoil=foreign.low_passed(0.002))
        found = evaluated(folder)
        errors.append(off(found, truth))
        told = {each.effect: each.parameters for each in found.missing.found}
        if "delay" in told:
            late, std = 1e-3 * told["delay"][0].value, 1e-3 * told["delay"][0].std
        else:
            assert found.missing.late is not None
            late, std = found.missing.late
            assert [each for each in found.warnings if "against the pose" in each]
        assert abs(late - 0.002) < 3.0 * std + 2e-4
    assert not broken(errors, 4.0)


def shifted(samples: int) -> foreign.Spoil:
    return lambda _name, table: np.column_stack([table[samples:, :6], table[:-samples, 6:]])


@pytest.mark.slow
def test_a_wrench_as_late_as_may_be_named_is_found_from_afar_and_all_else_holds(tmp_path: Path) -> None:
    """40 ms: what a log reads before its first pose is of no use."""
    truth = foreign.write(tmp_path, 1, spoil=shifted(5), seconds=10.0)
    found = evaluated(tmp_path)
    assert [each.effect for each in found.missing.found] == ["delay"]
    late = found.missing.found[0].parameters[0]
    assert abs(late.value - 40.0) < 3.5 * late.std
    assert late.std < 1.0
    assert np.abs(off(found, truth)).max() < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("settles_s", [60.0, 1e6], ids=["settles", "even"])
def test_a_zero_that_drifts_through_a_session_is_followed_from_its_begin(settles_s: float, tmp_path: Path) -> None:
    """As a sensor warms up: in the postures too. Its value at the begin was wrong by 5 to 37 standard deviations."""
    begun = {"still": 1e4, "shake": 1e4 + 50.0, "other": 1e4 + 80.0}
    drift = 0.025 * np.array([1.0, -0.6, 0.8, 0.02, -0.016, 0.012])

    def spoil(name: str, table: Array) -> Array:
        t = table[:, [0]] - table[0, 0] + begun[name] - 1e4
        course = -drift * settles_s * np.expm1(-t / settles_s)
        return np.hstack([t + 1e4, table[:, 1:6], table[:, 6:] + course])

    truth = foreign.write(tmp_path, 4, spoil=spoil, seconds=10.0)
    found = evaluated(tmp_path)
    assert found.missing.decision.verdict == "effects"
    assert "zero_drift" in {each.effect for each in found.missing.found}
    assert np.abs(off(found, truth)).max() < 4.0


@pytest.mark.slow
def test_a_gain_that_was_found_leaves_the_others_in_doubt(tmp_path: Path) -> None:
    """Two axes read 2 % more alike: that is another mass and a gain of the third, and no data tell which it is."""
    gains = np.array([1.02, 1.02, 1.0, 1.0, 1.0, 1.0])
    truth = foreign.write(tmp_path, 2, spoil=foreign.wrench(lambda w: w * gains))
    found = evaluated(tmp_path)
    assert {(each.effect, each.place) for each in found.missing.found} == {("gain", "fz")}
    assert found.missing.in_the_model
    assert found.stages.excitation is not None
    chosen = found.stages.excitation.chosen
    assert 0.998 < chosen.value[0] / truth.phi[0] < 1.022  # anything between the two is as good
    assert np.abs(off(found, truth)[:10]).max() < 3.0
    assert 0.005 < chosen.std[0] / truth.phi[0] < 0.04


QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def late(_name: str, table: Array) -> Array:
    return np.column_stack([table[60:, :6], table[:-60, 6:]])


@pytest.mark.parametrize(
    ("spoil", "rule", "told"),
    [
        (foreign.wrench(lambda w: np.hstack([w[:, :3] @ QUARTER.T, w[:, 3:] @ QUARTER.T])), "other_axes",
         "'FT_X' reads what +y of `hand` should, 'FT_Y' reads what -x of `hand` should"),
        (foreign.wrench(lambda w: w[:, [1, 0, 2, 4, 3, 5]]), "other_axes", "'FT_X' reads what +y of `hand` should"),
        (foreign.wrench(lambda w: w[:, [0, 1, 2, 4, 3, 5]]), "other_axes", "'FT_A' reads what +y should"),
        (foreign.wrench(lambda w: w * [1, 1, 1, 1, -1, 1]), "other_axes", "'FT_B' reads what -y should"),
        (foreign.wrench(lambda w: w[:, [3, 4, 5, 0, 1, 2]]), "forces_last", "forces first"),
        (foreign.wrench(lambda w: w * np.repeat([1.0, -1.0], 3)), "moments_reversed", "action"),
        (late, "clocks_apart", "0.480 s late"),
        (foreign.wrench(lambda w: -w), "sees_contradicted", "sensor_on_payload"),
    ],
    ids=["turned", "exchanged", "moments exchanged", "a moment reversed", "forces last", "moments reversed", "late",
         "reversed"],
)  # fmt: skip
def test_what_was_done_wrong_is_named(spoil: foreign.Spoil, rule: str, told: str, tmp_path: Path) -> None:
    foreign.write(tmp_path, 2, spoil=spoil)
    with pytest.raises(BadStudy) as refused:
        evaluated(tmp_path)
    assert refused.value.faults[0].rule == rule
    assert told in str(refused.value)


def test_gravity_turned_round_is_told_by_motion_where_nobody_said_which_way_the_sensor_reads(tmp_path: Path) -> None:
    """Postures fit both alike."""
    foreign.write(tmp_path, 2, sees=None, seconds=8.0, tests=False)
    file = tmp_path / "payload.yaml"
    file.write_text(file.read_text().replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, 9.81]"))
    with pytest.raises(BadStudy) as refused:
        evaluated(tmp_path)
    assert refused.value.faults[0].rule == "gravity_reversed"


def test_axes_that_stand_a_little_off_are_told_with_their_angle(tmp_path: Path) -> None:
    c, s = np.cos(np.radians(5.0)), np.sin(np.radians(5.0))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    foreign.write(tmp_path, 4, spoil=foreign.wrench(lambda w: np.hstack([w[:, :3] @ turn.T, w[:, 3:] @ turn.T])))
    found = evaluate(still(tmp_path))
    told = next(each for each in found.warnings if "off those of `hand`" in each)
    angle = float(told.split("stand ")[1].split("°")[0])
    assert abs(angle - 5.0) < 1.5  # the base leans by 1°, which nobody knows before


def test_no_motion_is_said_to_be_none_and_no_unit_is_blamed(tmp_path: Path) -> None:
    foreign.write(tmp_path, 5, size=1e-5)
    with pytest.raises(NotIdentifiable, match="turn the wrist"):
        evaluated(tmp_path)


@pytest.mark.slow
def test_a_sensor_zeroed_before_the_motion_is_named_and_not_called_a_poor_motion(tmp_path: Path) -> None:
    def zeroed(name: str, table: Array) -> Array:
        held = table[:40, 6:].mean(axis=0) if name != "still" else 0.0
        return np.column_stack([table[:, :6], table[:, 6:] - held])

    truth = foreign.write(tmp_path, 6, spoil=zeroed)
    found = evaluated(tmp_path)
    assert ("zero_of_log", "shake") in {(each.effect, each.place) for each in found.missing.found}
    assert np.abs(off(found, truth)[:10]).max() < 4.0
    errors, known = streamed(tmp_path, truth, role="test", after=("postures", "excitation"))
    assert np.abs(errors[:10]).max() < 4.0  # another zero again: it is found anew
    assert known.estimate.std[0] < 0.02 * truth.phi[0]
    assert not known.in_doubt


@pytest.mark.slow
def test_three_postures_do_and_a_dead_channel_is_told(tmp_path: Path) -> None:
    foreign.write(tmp_path, 7, postures=3, tests=False)
    assert evaluate(still(tmp_path)).stages.postures is not None

    def dead(_name: str, table: Array) -> Array:
        return np.column_stack([table[:, :8], np.full(len(table), 21.5), table[:, 9:]])

    foreign.write(tmp_path, 7, spoil=dead, seconds=8.0, tests=False)
    assert [each for each in evaluated(tmp_path).warnings if "'FT_Z'" in each and "all" in each]


@pytest.mark.slow
def test_a_wrench_in_another_unit_is_asked_for_where_its_noise_is_too_small(tmp_path: Path) -> None:
    foreign.write(tmp_path, 8, spoil=foreign.wrench(lambda w: w / 9.80665))
    assert [each for each in evaluated(tmp_path).warnings if "kgf" in each]


@pytest.mark.parametrize(
    ("factor", "unit", "other"), [(1e3, "s", "ms"), (1e6, "ms", "us"), (1.0, "ms", "s")], ids=["ms", "us", "s"]
)
def test_time_in_another_unit_is_told_by_the_rate_and_no_poor_motion_is_blamed(
    factor: float, unit: str, other: str, tmp_path: Path
) -> None:
    foreign.write(
        tmp_path, 1, seconds=2.0, postures=3, tests=False,
        spoil=lambda _name, table: np.column_stack([factor * table[:, 0], table[:, 1:]]),
    )  # fmt: skip
    file = tmp_path / "payload.yaml"
    file.write_text(file.read_text().replace("{column: stamp}", f"{{column: stamp, unit: {unit}}}"))
    with pytest.raises(BadStudy, match=f"`time.unit: {other}`") as refused:
        open_payload(tmp_path)
    assert refused.value.faults[0].rule == "time_unit"


def only_moved(folder: Path) -> None:
    """Without the log of postures."""
    file = folder / "payload.yaml"
    file.write_text("\n".join(line for line in file.read_text().splitlines() if "role: postures" not in line) + "\n")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda w: np.hstack([w[:, :3] @ QUARTER.T, w[:, 3:] @ QUARTER.T]), "'FT_X' reads what +y of `hand` should"),
        (lambda w: w * [-1, 1, 1, 1, 1, 1], "'FT_X' reads what -x of `hand` should"),
        (lambda w: w * [1, 1, 1, 1, -1, 1], "'FT_B' reads what -y should"),
        (lambda w: -w, "sensor_on_payload"),
    ],
    ids=["turned", "a force reversed", "a moment reversed", "all reversed"],
)  # fmt: skip
def test_motion_alone_tells_axes_and_signs_too(change: Callable[[Array], Array], told: str, tmp_path: Path) -> None:
    foreign.write(tmp_path, 2, spoil=foreign.wrench(change), tests=False)
    only_moved(tmp_path)
    with pytest.raises(BadStudy, match=r"axes|sees") as refused:
        evaluated(tmp_path)
    assert told in str(refused.value)


@pytest.mark.parametrize("factor", [1 / 9.80665, 9.80665], ids=["kgf as N", "N as kgf"])
def test_a_unit_of_forces_is_told_though_it_changes_their_noise_too(factor: float, tmp_path: Path) -> None:
    """Gains of 80 % in place of a unit, all said to be in the model: masses were wrong by a hundred deviations."""
    foreign.write(tmp_path, 8, spoil=foreign.wrench(lambda w: w * np.repeat([factor, 1.0], 3)))
    with pytest.raises(BadStudy) as refused:
        evaluated(tmp_path)
    assert refused.value.faults[0].rule == "units_disagree"
    assert "_unit: " in str(refused.value)


@pytest.mark.parametrize("first", [0, 3], ids=["forces", "moments"])
def test_postures_alone_tell_a_unit_by_what_a_wrench_scatters_at_rest(first: int, tmp_path: Path) -> None:
    factor = np.where(np.arange(6) // 3 == first // 3, 0.1, 1.0)
    foreign.write(tmp_path, 8, spoil=foreign.wrench(lambda w: w * factor))
    found = evaluate(still(tmp_path))
    told = [each for each in found.warnings if "Channels scatter" in each]
    assert len(told) == 1
    assert all(name in told[0] for name in foreign.COLUMNS[6 + first : 9 + first])
    assert foreign.COLUMNS[6 + (first + 3) % 6] not in told[0]


RATED = "  range: {force_n: [400, 400, 800], moment_nm: [40, 40, 40]}"


@pytest.mark.slow
@pytest.mark.parametrize(("rated", "mass", "rule"), [(True, None, "beyond_range"), (False, 6.0, "no_such_mass")])
def test_all_in_thousandths_is_refused_with_the_unit_where_no_sensor_or_no_arm_bears_it(
    rated: bool, mass: float | None, rule: str, tmp_path: Path
) -> None:
    """It was told by its scatter alone."""
    for factor in (1.0, 1000.0):
        foreign.write(tmp_path, 8, mass=mass, tests=False, spoil=foreign.wrench(lambda w, f=factor: f * w))
        text = (tmp_path / "payload.yaml").read_text(encoding="utf-8")
        text = text.replace("sensor:\n", f"sensor:\n{RATED}\n") if rated else text
        (tmp_path / "payload.yaml").write_text(text, encoding="utf-8")
        if factor == 1.0:
            evaluated(tmp_path)
            continue
        with pytest.raises(BadStudy) as refused:
            evaluated(tmp_path)
        assert refused.value.faults[0].rule == rule
        assert "`sensor.force_unit: mN`" in str(refused.value)


def test_an_excitation_alone_in_which_nothing_moves_is_refused(tmp_path: Path) -> None:
    """Rows that hold less than the noise of their columns were taken for sure."""
    foreign.write(tmp_path, 5, size=0.0, tests=False)
    only_moved(tmp_path)
    with pytest.raises(NotIdentifiable, match="turn the wrist"):
        evaluated(tmp_path)


@pytest.mark.slow
def test_a_base_that_leans_a_little_is_in_the_doubt_where_no_posture_tells_it(tmp_path: Path) -> None:
    """The generator's base leans by 1°; of payloads of this size that is half the noise."""
    errors = []
    for seed in range(2):
        folder = tmp_path / str(seed)
        folder.mkdir()
        truth = foreign.write(folder, seed, seconds=12.0)
        only_moved(folder)
        found = evaluated(folder)
        errors.append(off(found, truth))
        named = {each.effect for each in found.missing.found}
        assert named == {"inclination"} or found.missing.leans is not None
    assert not broken(errors, 4.0)


@pytest.mark.parametrize(
    ("pull", "verdict", "said"), [(0.0, "undecided", False), (0.4, "undecided", True), (4.0, "unexplained", True)]
)
def test_postures_tell_that_a_cable_pulls_though_not_what_it_is(
    pull: float, verdict: str, said: bool, tmp_path: Path
) -> None:
    """[N] up and aside, by up to its size more or less as the arm turns: most of it looks like weight."""

    def spoil(_name: str, table: Array) -> Array:
        R, *_ = foreign.sensor(table[:, 1:6], 0.0 * table[:, 1:6], 0.0 * table[:, 1:6])
        force = np.outer(pull * (1.0 + np.sin(2.0 * table[:, 1] + table[:, 2])), [0.3, 0.0, 0.95])
        force = np.einsum("tji,tj->ti", R, force)
        moment = np.cross([0.0, 0.0, 0.1], force)
        return np.column_stack([table[:, :6], table[:, 6:] + np.hstack([force, moment])])

    foreign.write(tmp_path, 3, spoil=spoil, tests=False)
    found = evaluate(still(tmp_path))
    assert found.missing.decision.verdict == verdict
    told = [each for each in found.warnings if "looks like weight" in each]
    assert bool(told) == said


@pytest.mark.parametrize(("share", "said"), [(1.0, False), (0.95, True), (1.04, True)])
def test_a_weighed_mass_that_contradicts_is_told_with_what_it_may_mean(
    share: float, said: bool, tmp_path: Path
) -> None:
    truth = foreign.write(tmp_path, 3, tests=False)
    file = tmp_path / "payload.yaml"
    file.write_text(file.read_text() + f"ground_truth: {{mass_kg: {share * truth.phi[0]:.5f}}}\n")
    found = evaluate(still(tmp_path))
    told = [each for each in found.warnings if "weighed" in each]
    assert bool(told) == said
    if said:
        assert f"too {'much' if share < 1.0 else 'little'}" in told[0]
        assert "ft_gain_common" in told[0]


@pytest.mark.slow
def test_what_the_excitation_leaves_open_is_not_called_unexplained_in_a_log_that_asks_for_it(tmp_path: Path) -> None:
    """The last joint alone turns: that shows of the inertia what it has about its axis."""
    truth = foreign.write(tmp_path, 3, shaken=(4,), size=1.2)
    found = evaluated(tmp_path)
    assert found.missing.decision.verdict == "undecided"
    assert found.missing.decision.reason is not None
    assert found.missing.decision.reason.why == "not_foretold"
    assert np.abs(off(found, truth)).max() < 4.0


@pytest.mark.parametrize(("postures", "seed"), [(3, 5), (3, 14), (4, 17)])
def test_intervals_of_few_postures_hold_lean_and_force_noise(postures: int, seed: int, tmp_path: Path) -> None:
    """Three cannot tell the lean by one that is left out: it was taken for none, errors were 5.9 and 5.4 deviations.
    Forces are read, and their noise with the lever is in the moments: the centre was 3.9 off."""
    truth = foreign.write(tmp_path, seed, postures=postures, seconds=0.3, tests=False)
    file = tmp_path / "payload.yaml"
    file.write_text(file.read_text() + "uncertainty: none\n")
    found = evaluate(still(tmp_path)).stages.postures
    assert found is not None
    value = np.concatenate([[found.chosen.mass], found.chosen.mass * found.chosen.centre, found.chosen.zero])
    wrong = np.abs(value - truth.x[[*range(4), *range(10, 16)]])
    known, covariance = found.chosen.moments
    assert value == pytest.approx(known)
    assert (wrong / np.sqrt(np.diag(covariance)[:10])).max() < 3.5


def test_a_base_taken_to_be_level_is_told_where_its_postures_leave_more_than_noise(tmp_path: Path) -> None:
    foreign.write(tmp_path, 4, postures=8, tests=False)
    file = tmp_path / "payload.yaml"
    file.write_text(file.read_text() + "settings: {inclination: ignore}\n")
    (told,) = [each for each in evaluate(still(tmp_path)).warnings if "the noise is left" in each]
    assert "taken to be level" in told


def test_clocks_that_are_a_little_more_apart_than_a_filter_makes_them_are_told(tmp_path: Path) -> None:
    """60 ms: beside what a light payload reads that is hardly more than the noise."""

    def spoil(_name: str, table: Array) -> Array:
        return np.column_stack([table[8:, :6], table[:-8, 6:]])

    foreign.write(tmp_path, 5, spoil=spoil, size=0.15, tests=False)
    with pytest.raises(BadStudy) as refused:
        evaluated(tmp_path)
    assert refused.value.faults[0].rule == "clocks_apart"
    assert "0.064 s late" in str(refused.value)


@pytest.mark.parametrize(("colour", "least", "most"), [(0.0, 1.0, 1.5), (0.98, 3.0, 12.0)])
def test_the_mean_of_a_posture_is_as_doubtful_as_its_halves_differ(
    colour: float, least: float, most: float, tmp_path: Path
) -> None:
    """Noise that remembers 0.4 s was averaged as if it were white."""
    foreign.write(tmp_path, 0, colour=colour, postures=6)
    holds, _ = holds_of(open_payload(tmp_path))
    white = np.repeat([foreign.FORCE_NOISE, foreign.MOMENT_NOISE], 3) / np.sqrt(1.0 * foreign.RATE)
    assert np.all(holds.std > 0.9 * least * white)
    assert np.all(holds.std < most * white)


@pytest.mark.slow
@pytest.mark.parametrize("mass", [0.15, 0.6])
def test_axes_that_stand_off_are_no_gains_of_a_sensor(mass: float, tmp_path: Path) -> None:
    """Of a light payload postures do not tell them: gains and crosstalk of all channels were named in their place."""
    turn = Rotation.from_rotvec(np.radians([2.0, -1.5, 1.7]))

    def read(w: Array) -> Array:
        return np.hstack([turn.inv().apply(w[:, :3]), turn.inv().apply(w[:, 3:])])

    truth = foreign.write(tmp_path, 1, spoil=foreign.wrench(read), mass=mass, noise=0.3)
    found = evaluated(tmp_path)
    (named,) = found.missing.found
    assert (named.effect, named.rivals) == ("turned", ())
    assert found.missing.in_the_model
    for each, angle in zip(named.parameters, (2.0, -1.5, 1.7), strict=True):
        assert abs(each.value - angle) < 4.0 * each.std < 1.0
    assert found.stages.excitation is not None
    z = np.abs(off(found, truth))[:10]
    assert z.max() < 4.0
