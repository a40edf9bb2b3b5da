"""A motion that a finding asks for is played by the robot that the case has, with what is hidden in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.blind.generator.case import undisturbed, write_case
from exogauge.blind.generator.plan import plan_case
from exogauge.blind.generator.play import play
from exogauge.blind.generator.robot_files import built
from exogauge.errors import BadInput
from exogauge.synthetic.random_streams import stream

SEED, NUMBER, HIDDEN = 5, 1, ("stribeck",)


@pytest.mark.slow
def test_a_robot_that_plays_what_it_did_gives_what_it_gave(tmp_path: Path) -> None:
    folder = tmp_path / "case"
    answer = write_case(folder, SEED, NUMBER, "arm6", HIDDEN)
    before = {path.name: path.read_bytes() for path in (folder / "logs").iterdir()}
    plan = plan_case(SEED, NUMBER, "arm6", HIDDEN)
    here = undisturbed(plan, built(stream(SEED, f"maker {NUMBER}"), plan.robot), SEED)
    slowly = here.motion.time[::4]
    play(folder, SEED, NUMBER, [(slowly, here.motion.q[0, ::4], 1)], "arm6", HIDDEN)
    assert {path.name: path.read_bytes() for path in (folder / "logs").iterdir() if path.name in before} == before
    assert yaml.safe_load((folder / "study.yaml").read_text())["logs"][-2:] == [
        {"file": "logs/planned_1.parquet", "role": "identification"},
        {"file": "logs/planned_1_again.parquet", "role": "validation"},
    ]
    twice = [pq.read_table(folder / "logs" / f"planned_1{name}.parquet") for name in ("", "_again")]
    assert twice[0] != twice[1]  # noise of its own
    first, again = (pq.read_table(folder / "logs" / name) for name in ("id_1.parquet", "planned_1.parquet"))
    (hidden,) = answer["effects"]
    for column in first.column_names:
        one, other = (table[column].to_numpy()[: 4 * len(slowly) - 4] for table in (first, again))
        off, (kind, _, joint) = np.abs(other - one), column.partition(".")
        if kind == "q":
            assert np.quantile(off, 0.99) < 2e-3, column
        if kind in ("i", "tau"):
            k_T = answer["joints"][joint]["k_T"]
            amperes = np.median(off) / (k_T if kind == "tau" else 1.0)
            assert amperes < 0.03, column  # two draws of .02 A
            if joint == hidden["where"]["joint"]:
                assert k_T * amperes < 0.3 * hidden["parameters"]["size"]


def test_a_robot_that_wears_bands_plays_nothing(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="bands"):
        play(tmp_path, SEED, NUMBER, [], "torso8", ("band_stiffness",))
