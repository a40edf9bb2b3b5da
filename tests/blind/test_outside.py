"""What no catalogue has: it obeys its own law, is as large as the answers say, and no name of it is right."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.blind.conftest import joints, plan

from exogauge.blind.answers import write_answers
from exogauge.blind.generator.case import as_read
from exogauge.blind.generator.foot_faults import STD, Alike, Creep, Drift, Gain, Shunt, Tilt, how_large
from exogauge.blind.generator.hidden.outside import CableWrap, EncoderEccentricity, FrictionWanders, StrapSlides
from exogauge.blind.generator.placed import HowLarge, Placed, hide
from exogauge.blind.generator.robot_kind import ARM
from exogauge.blind.score import score, score_text


def test_an_eccentric_disc_is_read_wrongly_by_its_size_and_moves_nothing_else(arm6) -> None:
    (placed,) = hide(np.random.default_rng(8), plan(ARM, "encoder_eccentricity"), arm6)
    read = as_read(arm6.motion, [placed])
    wrong = read.q - arm6.motion.q
    own = [joint.name for joint in joints(arm6)].index(str(placed.where["joint"]))
    assert 0.0 < np.abs(wrong[:, :, own]).max() <= 1.3 * placed.size
    assert not np.delete(wrong, own, axis=2).any()


def test_an_eccentric_disc_is_as_large_as_what_the_believed_motion_asks_more(arm6) -> None:
    """Velocity and acceleration that it believes are those of the angle that it reads, differentiated."""
    effect, joint, size = EncoderEccentricity(0.4, 0.2), 1, 0.02
    placed = Placed(effect, joint, {}, size, HowLarge(1.0, 1.0, 1.0, ""))
    q = as_read(arm6.motion, [placed]).q[0, :, joint]
    wave, slope, bend = (size * each for each in effect._waves(arm6.motion.q[0, :, joint]))
    dq, ddq = arm6.motion.dq[0, :, joint], arm6.motion.ddq[0, :, joint]
    np.testing.assert_allclose(q - arm6.motion.q[0, :, joint], wave, atol=1e-12)
    h = 1.0 / 200.0
    believed = dq * (1.0 + slope)
    np.testing.assert_allclose(np.gradient(q, h)[2:-2], believed[2:-2], atol=2e-3)
    np.testing.assert_allclose(
        np.gradient(believed, h)[2:-2], ((1.0 + slope) * ddq + bend * dq**2)[2:-2], atol=0.02 * np.abs(ddq).max()
    )
    twice, once = (effect.excess(arm6, joint, each)[1].max() for each in (2e-4, 1e-4))
    assert twice == pytest.approx(2.0 * once, rel=0.02)


def test_a_wound_cable_pulls_back_more_while_it_winds_on_and_not_at_all_before(arm6) -> None:
    run = arm6.runs[1]
    effect = CableWrap(0.0, 1.0, 0.8, 0.03)
    torque = effect.torque(run, 1.0)
    assert np.all(torque[run.q <= 0.0] == 0.0)
    wound = (run.q > 0.2) & (np.abs(run.dq) > 0.2)
    on, off = wound & (run.dq > 0), wound & (run.dq < 0)
    assert np.all(torque[on] > run.q[on])
    assert np.all(torque[off] < run.q[off])
    assert np.all(torque[off] > 0.0), "it never pushes"


def test_friction_that_wanders_goes_on_from_log_to_log_and_against_the_motion(arm6) -> None:
    run = arm6.runs[2]
    effect = FrictionWanders.draw(np.random.default_rng(4), run)
    assert len(effect.stages) == len(run.q) + 1
    size = effect.torque(run, 1.0) / np.where(run.direction != 0.0, run.direction + effect.viscous * run.dq, np.nan)
    for log in range(len(run.q)):
        moving = np.flatnonzero(np.isfinite(size[log]))
        ends = effect.stages[log], effect.stages[log + 1]
        assert min(ends) - 1e-9 <= size[log][moving].min()
        assert size[log][moving].max() <= max(ends) + 1e-9
        np.testing.assert_allclose(size[log][moving[0]], ends[0], atol=0.15)
    assert np.all(effect.torque(run, 1.0)[run.direction == 0.0] == 0.0)


def test_a_strap_gives_way_where_it_is_pulled_and_is_back_when_slack(torso8) -> None:
    band = torso8.wear.bands[0]
    effect, size = StrapSlides(band.wire.name, 0.5, 0.3), 0.02
    change = effect.change(torso8, size)
    tension = change.pull.tension
    slid = -tension / band.stiffness
    assert slid.min() >= 0.0
    assert slid.max() <= size + 1e-12
    assert slid.max() > 0.0
    assert np.all(slid <= band.stretch + 1e-12), "no band pushes"
    held = 0.5 * band.stretch.max()
    assert np.all((band.stretch - slid)[slid < size - 1e-9] <= held + 1e-9)


WRENCH = np.random.default_rng(1).standard_normal((4000, 2, 6)).cumsum(axis=0) * 0.05 + [0, 0, 180.0, 0, 0, 0]


def test_a_tilted_foot_reads_the_same_force_in_other_axes() -> None:
    read = Tilt(1, (0.0, 0.02, 0.0)).read(WRENCH, 0)
    for part in (slice(0, 3), slice(3, 6)):
        np.testing.assert_allclose(
            np.linalg.norm(read[:, 1, part], axis=1), np.linalg.norm(WRENCH[:, 1, part], axis=1), rtol=1e-12
        )
    np.testing.assert_array_equal(read[:, 0], WRENCH[:, 0])
    assert np.mean(read[:, 1, 0] - WRENCH[:, 1, 0]) == pytest.approx(180.0 * np.sin(0.02), rel=0.05)


def test_what_bodies_can_take_the_place_of_is_as_large_as_nothing() -> None:
    assert how_large(Alike(0.1), [WRENCH])[0] < 1e-9
    assert how_large(Gain(0, 2, 0.1, 0.0), [WRENCH])[0] > 0.1
    ratio, channel = how_large(Drift(0, 1, 10.0 * STD[1], None, 0.5, 5.0), [WRENCH])
    assert channel == "base.fy"
    assert ratio == pytest.approx(10.0 / np.sqrt(2.0) * 0.64, rel=0.1), "rms of its course, both feet's noise"


def test_a_creeping_gauge_is_late_and_right_in_the_end() -> None:
    step = np.zeros((4000, 2, 6))
    step[1000:, 0, 2] = 100.0
    read = Creep(0, 2, 0.1, 1.0).read(step, 0)[:, 0, 2]
    assert read[1000] == pytest.approx(90.0, rel=0.01)
    assert read[-1] == pytest.approx(100.0, rel=1e-3)


def test_a_shunt_bears_weight_on_its_side_only() -> None:
    wrench = np.zeros((2, 2, 6))
    wrench[:, 0, 2] = 200.0
    wrench[:, 0, 4] = [-200.0 * 0.05, 200.0 * 0.05]  # in front, then behind
    read = Shunt(0, (0.1, 0.0), 0.0, 0.5).read(wrench, 0)[:, 0]
    np.testing.assert_allclose(read[1], wrench[1, 0])
    borne = 200.0 - read[0, 2]
    assert borne == pytest.approx(200.0 * 0.5 * 0.05 / 0.1)
    assert read[0, 4] == pytest.approx(wrench[0, 0, 4] + 0.1 * borne)


def entry(effect: str, channel: str, **more: Any) -> dict[str, Any]:
    return {"effect": effect, "where": {"sensor": "l_foot"}, "visible": True, "ratio": 5.0, "channel": channel, **more}


def test_where_no_name_is_right_unexplained_at_the_place_is(tmp_path: Path) -> None:
    hidden = [entry("foot_shunt", "base.my", outside=True)] * 4 + [entry("feet_alike", "base.fx", undecidable=True)]
    answers = [{"case": f"case_{n}", "robot": "h", "effects": [one], "clutter": []} for n, one in enumerate(hidden)]
    write_answers(tmp_path, 1, answers)
    (tmp_path / "results").mkdir()
    named = [{"rank": 1, "effect": "ft_gain", "where": {"sensor": "l_foot", "axis": "fz"}}]
    said = [
        ("unexplained", [], ["base.fz"]),
        ("unexplained", [], ["tau.l_knee_pitch"]),
        ("effects", named, ["base.mx"]),
        ("none", [], []),
        ("undecided", [], []),
    ]
    for n, (verdict, findings, left) in enumerate(said):
        found = {"verdict": verdict, "findings": findings, "unexplained": [{"channel": each} for each in left]}
        record = {"case": f"case_{n}", "code": "x", "seconds": 1.0, "error": None, "discrepancy": found}
        (tmp_path / "results" / f"case_{n}.json").write_text(json.dumps(record), encoding="utf-8")
    found = score(tmp_path)
    assert found["outside"] == {
        "n": 4, "unexplained": 2, "unexplained_there": 1, "undecided": 0, "silent": 1, "named": 1, "named_and_left": 1,
    }  # fmt: skip
    assert found["undecidable"]["undecided"] == found["undecidable"]["n"] == 1
    assert found["all"]["n"] == found["wrong_names"]["n"] == 0, "they count nowhere else"
    assert "outside, visible" in score_text(found)
