"""`make coverage SEEDS=20`: fresh samples as a laboratory records them, evaluated; how often stated intervals hold."""

from __future__ import annotations

import argparse
import json
import shutil
from pathlib import Path

import numpy as np
from tests.calibration.kinds import LEVELS, Told, told

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
    asked = parser.parse_args()
    numbers: list[Told] = []
    for seed in range(asked.first, asked.first + asked.seeds):
        numbers += told(*_answer(asked, seed))
        print(f"seed {seed} done", flush=True)
    print(table(numbers))


def _answer(asked: argparse.Namespace, seed: int) -> tuple[dict[str, object], dict[str, object]]:
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
        shutil.copy(study / "truth.json", out / "truth.json")
        shutil.rmtree(study)
        shutil.rmtree(out / "series", ignore_errors=True)
    return json.loads((out / "results.json").read_text()), json.loads((out / "truth.json").read_text())


def table(numbers: list[Told]) -> str:
    """By kind: how many, share inside, median of the std over the rms error, share that is called identifiable."""
    lines = ["| kind | numbers | " + " | ".join(f"in {100 * level:.0f} %" for level in LEVELS) + " | std / rms error |"]
    lines.append("|---|---|" + "---|" * (len(LEVELS) + 1))
    for kind in sorted({each.kind for each in numbers}):
        own = [each for each in numbers if each.kind == kind and each.told]
        if not own:
            continue
        shares = " | ".join(f"{100 * np.mean([each.inside(level) for each in own]):.0f} %" for level in LEVELS)
        errors = np.array([each.value - each.truth for each in own])
        width = float(np.median([each.std for each in own]) / max(np.sqrt(np.mean(errors**2)), 1e-300))
        lines.append(f"| {kind} | {len(own)} | {shares} | {width:.2f} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
