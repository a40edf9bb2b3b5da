"""A wrong gain and a wrong mass that logs confuse: the motion that would tell them apart, and what it then tells.

What is recorded is MuJoCo's inverse dynamics (`tests.bench.poor_logs`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from tests.bench.poor_logs import JOINTS, RATE_HZ, PoorArm

from exogauge.detect.nominal.contradicted import contradicted, row_memory
from exogauge.detect.nominal.detector import doubt_of
from exogauge.detect.nominal.nominal_values import stated_numbers, undecided_between
from exogauge.detect.pipeline import Found, find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.experiment.design import Known
from exogauge.experiment.motion_choices import choices
from exogauge.experiment.planned_rows import as_log, new_rows, with_next_log
from exogauge.experiment.workspace_limits import room
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.motion.robot_file import load_motion_robot
from exogauge.search.ambiguity import Number
from exogauge.studies.intake.robot_file import load_robot

SETTINGS, DOUBT = Settings(cutoff_hz=8.0), 0.03
LAST = 2


def logs_of(arm: PoorArm, style: str, seed: int) -> list[Recording]:
    """Two to fit, one to judge by."""
    names = ("id_1", "id_2", "val")
    return [Recording(arm.poor(name, style, 20.0, 10 * seed + k), name == "val") for k, name in enumerate(names)]


def found_in(arm: PoorArm, folder: Path, recordings: Sequence[Recording]) -> Found:
    path = arm.folder(folder)
    first = identify(load_robot(path.parent, path.name), recordings, SETTINGS)
    return find_missing_effects(first, recordings, missing_effects(), SETTINGS, moving=load_motion_robot(path))


@pytest.fixture(scope="module")
def heavy(tmp_path_factory: pytest.TempPathFactory):
    """An arm whose last link is heavier, moved joint by joint, and what was found."""
    arm = PoorArm(8, "link_mass", LAST, 0.6, DOUBT)
    recordings = logs_of(arm, "alone", 8)
    return arm, recordings, found_in(arm, tmp_path_factory.mktemp("arm"), recordings)


@pytest.mark.slow
def test_the_doubt_that_is_planned_for_is_the_evidence_that_was_found(heavy) -> None:
    """What is left of each number beside all that the maker may be off in, as letting it go has it, gains apart."""
    _, recordings, found = heavy
    model = replace(found.identification.model, known_scale=False)  # then gains are not asked about
    memory = row_memory(model, [each.log for each in recordings if not each.held_out])
    stated, data = stated_numbers(model, range(len(JOINTS)), memory)
    seen, phi = model.solution.prior.seen, model.robot.tree.phi
    for each in stated:
        if each.sort == "scaled":
            moves = (seen[:, 10 * each.index : 10 * each.index + 10] @ phi[each.index])[:, None]
            number = Number("link_mass", ("link", "l", ""), np.ones(1), moves)
        elif each.sort == "load":
            number = Number("payload", ("link", "l", ""), np.ones(10), seen[:, 10 * each.index : 10 * each.index + 10])
        else:
            continue
        left = Known.of(undecided_between(model, [number], memory)).now
        told = data.S[np.ix_(each.columns, each.columns)] / np.outer(each.broad, each.broad)
        assert left == pytest.approx(told, abs=1e-6 * np.abs(told).max(), rel=1e-4)


@pytest.mark.slow
def test_what_a_heavier_link_would_add_to_a_planned_motion_is_what_pinocchio_says(heavy) -> None:
    arm, recordings, found = heavy
    model = found.identification.model
    logs = [each.log for each in recordings if not each.held_out]
    memory = row_memory(model, logs)
    seen = model.solution.prior.seen[:, 10 * LAST : 10 * LAST + 10]
    more = Number("link_mass", ("link", "l", ""), np.ones(1), (seen @ model.robot.tree.phi[LAST])[:, None])
    factor = Number("kt_gain", ("joint", JOINTS[LAST], ""), np.ones(1), None, LAST)
    doubt = undecided_between(model, [more, factor], memory)
    here, known = room(model, logs), Known.of(doubt)
    own = with_next_log(doubt.model)
    sweep = choices(own, here, more.kinds(own.equations), [LAST], slow_change=False)[0]
    rows = new_rows(doubt, own, here, sweep, known.kept)
    assert rows is not None
    log = as_log(own, here, sweep)
    prepared = own.prepare(log)
    q = log.stack([f"q.{name}" for name in JOINTS])
    v = np.gradient(q, axis=0) * log.rate_hz
    a = np.gradient(v, axis=0) * log.rate_hz
    robot = pin.buildModelFromXML(arm.urdf())
    bare, whole = robot.copy(), robot
    bare.inertias[LAST + 1] = pin.Inertia.Zero()
    extra = np.array([pin.rnea(whole, whole.createData(), *each) - pin.rnea(bare, bare.createData(), *each)
                      for each in zip(q, v, a, strict=True)])  # fmt: skip
    axis = own.equations.layout.axis(LAST)
    scale = np.sqrt(own.solution.weights[axis])
    said = rows.c[:, 0]
    largest = scale * np.abs(extra[prepared.kept, LAST]).max()
    share = np.sqrt(RATE_HZ / log.rate_hz)  # rows stand for more of them, by up to this
    assert largest / share < np.abs(said).max() < 4.0 * share * largest


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "currents"), [(8, False), (11, True)])
def test_the_motion_tells_a_heavy_link_from_what_it_was_taken_for(tmp_path: Path, seed: int, currents: bool) -> None:
    """In logs that move the last joint alone its gain looks the same: what other joints feel says which. They never
    moved, so that how well they are measured is not known, and counts as much as that of the one that did."""
    arm = PoorArm(seed, "link_mass", LAST, 0.7, DOUBT, currents)
    recordings = logs_of(arm, "alone", seed)
    (finding,) = found_in(arm, tmp_path / "before", recordings).discrepancy.findings
    assert finding.effect == "kt_gain"
    (pair,) = finding.apart
    assert (pair.rival, pair.place) == ("payload", f"l{JOINTS[LAST]}")
    (motion,) = finding.plans
    assert any(np.ptp(motion.q[:, k]) > 0.1 for k in (0, 1))
    table, rate = np.concatenate([motion.q] * motion.repeats), 1.0 / (motion.time[1] - motion.time[0])
    more = [Recording(arm.played(name, table, rate, noise), held) for name, noise, held in
            (("planned", 77, False), ("again", 78, True))]  # fmt: skip
    (after,) = found_in(arm, tmp_path / "after", [*recordings, *more]).discrepancy.findings
    assert after.effect in ("payload", "link_mass")  # of a last link the two are one
    assert after.place.name == f"l{JOINTS[LAST]}"
    assert "kt_gain" not in {each.effect for each in after.also_possible}


def test_numbers_that_nothing_contends_with_ask_for_no_motion(heavy) -> None:
    _, recordings, found = heavy
    model = found.identification.model
    logs = [each.log for each in recordings if not each.held_out]
    for odd in contradicted(model, logs).one_by_one:
        assert doubt_of(model, replace(odd, alike=()), row_memory(model, logs)) is None
