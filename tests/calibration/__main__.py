"""`make coverage SEEDS=20`: fresh samples as a laboratory records them, evaluated; how often stated intervals hold."""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from tests.calibration.kinds import LEVELS, Told, told
from tests.calibration.picture import calibration
from tests.calibration.torque import APPROACHES, true_torque

from exogauge.studies.evaluate import evaluate
from exogauge.synthetic.disturbances import chosen
from exogauge.synthetic.study import write_study


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument(
        "--kept", type=Path, required=True, help="folder for results; those that stand are not made anew"
    )
    parser.add_argument("--realism", choices=("lab", "ideal"), default="lab")
    parser.add_argument("--with", dest="added", action="append", default=[], metavar="NAME[=SIZE]")
    parser.add_argument(
        "--search", action="store_true", help="with the search for missing effects, which takes minutes"
    )
    parser.add_argument("--picture", type=Path, help="an SVG: share inside, by the share that is claimed")
    asked = parser.parse_args()
    numbers, torques = list[Told](), list[dict[str, Any]]()
    for seed in range(asked.first, asked.first + asked.seeds):
        results, truth = _answer(asked, seed)
        numbers += told(results, truth)
        torques.append(truth["torque"]["rmse"])
        print(f"seed {seed} done", flush=True)
    print(f"{table(numbers)}\n\n{torque_table(torques)}")
    if asked.picture:
        drawn = calibration(numbers, f"{asked.seeds} synthetic samples, {asked.realism}")
        asked.picture.write_text(drawn, encoding="utf-8")


def _answer(asked: argparse.Namespace, seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Results and truth of one seed, made where they do not stand."""
    name = "_".join([asked.realism, *asked.added, *(["search"] if asked.search else []), str(seed)])
    out = asked.kept / name
    if not (out / "truth.json").is_file():
        study = asked.kept / f"{name}_study"
        shutil.rmtree(study, ignore_errors=True)
        write_study(study, seed, (), suit="normal", disturbed=chosen(asked.realism, asked.added))
        if not asked.search:
            with (study / "study.yaml").open("a", encoding="utf-8") as file:
                file.write("steps: [identify, support, stiffness]\n")
        evaluate(study / "study.yaml", out, lambda *_: None)
        truth = json.loads((study / "truth.json").read_text())
        worn = {Path(each["file"]).stem: each["motion"] for each in _logs(study) if each["role"] == "with_device"}
        truth["torque"] = true_torque(study, out / "series", worn)
        (out / "truth.json").write_text(json.dumps(truth))
        shutil.rmtree(study)
        shutil.rmtree(out / "series", ignore_errors=True)
    return json.loads((out / "results.json").read_text()), json.loads((out / "truth.json").read_text())


def _logs(study: Path) -> list[dict[str, str]]:
    listed: list[dict[str, str]] = yaml.safe_load((study / "study.yaml").read_text())["logs"]
    return listed


def table(numbers: list[Told]) -> str:
    """By kind: how many that are called identifiable, share inside, std over error (1 / RMS of z), and the median error
    over the RMS of the truths."""
    shares_of = " | ".join(f"in {100 * level:.0f} %" for level in LEVELS)
    lines = [f"| kind | numbers | {shares_of} | std / rms error | median error / size |"]
    lines.append("|---|---|" + "---|" * (len(LEVELS) + 2))
    for kind in sorted({each.kind for each in numbers}):
        own = [each for each in numbers if each.kind == kind and each.told]
        if not own:
            continue
        shares = " | ".join(f"{100 * np.mean([each.inside(level) for each in own]):.0f} %" for level in LEVELS)
        errors = np.array([each.value - each.truth for each in own])
        width = 1.0 / max(float(np.sqrt(np.mean([(each.value - each.truth) ** 2 / each.std**2 for each in own]))), 1e-9)
        size = max(float(np.sqrt(np.mean([each.truth**2 for each in own]))), 1e-300)
        off = 100.0 * float(np.median(np.abs(errors))) / size
        lines.append(f"| {kind} | {len(own)} | {shares} | {width:.2f} | {off:.2g} % |")
    return "\n".join(lines)


def torque_table(found: Sequence[Mapping[str, Any]]) -> str:
    """RMSE [N·m] of the torque at the trunk against the truth, over all samples: median over the seeds, and largest."""
    lines = ["| motion, joint | " + " | ".join(APPROACHES) + " |", "|---|" + "---|" * len(APPROACHES)]
    places = {(motion, joint) for each in found for motion, joints in each.items() for joint in joints}
    for motion, joint in sorted(place for place in places if "torso" in place[1]):
        cells = []
        for approach in APPROACHES:
            values = [each[motion][joint].get(approach) for each in found]
            known = [value for value in values if value is not None]
            cells.append(f"{np.median(known):.2f}, at most {max(known):.2f}" if known else "–")
        lines.append(f"| {motion}, {joint} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
