"""From cases to results by the product's own entry, in processes of their own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from exogauge.blind.generator.case import write_case
from exogauge.blind.generator.make import make
from exogauge.blind.generator.plan import plan_case
from exogauge.blind.run import RESULTS, run
from exogauge.errors import BadInput
from exogauge.identification.identify import identify
from exogauge.identification.settings import Settings
from exogauge.studies.evaluate import evaluate
from exogauge.studies.intake.open import open_study, read_recordings

CLEAN_SEED = next(seed for seed in range(100) if not plan_case(seed, 1).kinds and not plan_case(seed, 1).clutter)


def silent(*_: object) -> None:
    pass


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One case in which nothing is hidden."""
    out = tmp_path_factory.mktemp("blind") / "clean"
    make(out, CLEAN_SEED, 1, robots="arm6")
    return out


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "channels", "cutoff_hz"), [("arm6", 6, None), ("torso8", 8, None)])
def test_a_case_without_hidden_effects_is_identified_down_to_its_noise(
    tmp_path: Path, robot: str, channels: int, cutoff_hz: float | None
) -> None:
    """In steady motion, on logs that were not fitted, joint by joint. So what is above the noise elsewhere is what was
    hidden there."""
    write_case(tmp_path, CLEAN_SEED, 1, robot)
    with open_study(tmp_path) as study:
        found = identify(study.robot, read_recordings(study), Settings(cutoff_hz=cutoff_hz), silent)
    held_out = [fit for fit in found.validation if fit.held_out and fit.channel.startswith("tau.")]
    assert len(held_out) == {"arm6": 2, "torso8": 3}[robot] * channels
    for fit in held_out:
        assert fit.rmse_moving is not None
        assert fit.rmse_moving < 1.1 * fit.noise_floor, fit


@pytest.mark.slow
@pytest.mark.parametrize("effect", [pytest.param("band_hardening", marks=pytest.mark.thorough), "extra_band"])
def test_what_a_band_lacks_is_named_and_every_step_comes_to_its_end(tmp_path: Path, effect: str) -> None:
    """On an upper body whose arms, which no band of its wear crosses, move as well."""
    answer = write_case(tmp_path / "case", 3, 1, "torso8", (effect,))
    evaluate(tmp_path / "case" / "study.yaml", tmp_path / "out", silent)
    result = json.loads((tmp_path / "out" / "results.json").read_text())
    assert {step["status"] for step in result["steps"]} == {"done"}
    (hidden,) = answer["effects"]
    found = {(each["effect"], *each["where"].values()) for each in result["discrepancy"]["findings"]}
    assert (effect, *hidden["where"].values()) in found or not hidden["visible"]


@pytest.mark.slow
def test_a_case_that_fails_does_not_stop_the_others_and_is_tried_again(clean: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(clean, out)
    shutil.copytree(out / "case_0001", out / "case_0002")
    (out / "case_0002" / "logs" / "id_1.parquet").write_bytes(b"no log")
    assert run(out, silent, 2) == ["case_0002"]
    good, bad = (json.loads((out / RESULTS / f"case_000{n}.json").read_bytes()) for n in (1, 2))
    assert good["error"] is None
    assert good["seconds"] > 0.0
    assert good["discrepancy"] is not None or good["why"]
    assert "id_1" in bad["error"]

    before = (out / RESULTS / "case_0001.json").stat().st_mtime_ns
    shutil.copy(clean / "case_0001" / "logs" / "id_1.parquet", out / "case_0002" / "logs" / "id_1.parquet")
    assert run(out, silent, 2, keep=True) == []
    assert (out / RESULTS / "case_0001.json").stat().st_mtime_ns == before, "what is known is not computed again"
    assert not list((out / RESULTS).glob("*.started"))


def test_a_folder_without_cases_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no cases"):
        run(tmp_path, silent, 1)
