"""The answers of a benchmark: compressed, beside the cases, under a seal."""

from __future__ import annotations

import gzip
import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from exogauge.errors import BadInput, Fault

ANSWERS, SEAL = "answers.json.gz", "seal.txt"
VERSION = 1


def write_answers(out: Path, seed: int, cases: Sequence[Mapping[str, Any]]) -> None:
    """`ANSWERS` and its `SEAL`: the SHA-256 of the JSON text, as `sha256sum` would print it."""
    record = {"synthetic": True, "version": VERSION, "seed": seed, "cases": list(cases)}
    text = (json.dumps(record, indent=1, allow_nan=False) + "\n").encode()
    (out / ANSWERS).write_bytes(gzip.compress(text, mtime=0))
    (out / SEAL).write_text(f"{hashlib.sha256(text).hexdigest()}  answers.json\n", encoding="utf-8")


def read_answers(out: Path) -> Mapping[str, Any]:
    """The answers, if the seal is whole; BadInput otherwise."""
    for name in (ANSWERS, SEAL):
        if not (out / name).is_file():
            advice = "Give the folder that `exogauge blind make` has written."
            raise BadInput(Fault("this file is missing", "answers_missing", advice, file=str(out / name)))
    try:
        text = gzip.decompress((out / ANSWERS).read_bytes())
    except (OSError, EOFError) as broken:
        raise _broken(out) from broken
    sealed = (out / SEAL).read_text(encoding="utf-8").split()
    if sealed[:1] != [hashlib.sha256(text).hexdigest()]:
        raise _broken(out)
    answers: Mapping[str, Any] = json.loads(text)
    return answers


def _broken(out: Path) -> BadInput:
    detail = "the seal is broken: these are not the answers that were written with the cases"
    return BadInput(Fault(detail, "seal_broken", "Make the benchmark again.", file=str(out / ANSWERS)))
