"""Each tree answers with its own code, in children too."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.gate.trees import HERE, trees


@pytest.fixture
def other_tree(tmp_path: Path) -> Path:
    package = tmp_path / "tree/server/exogauge"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "cli.py").write_text("print('the other')\n")
    return tmp_path / "tree"


@pytest.mark.slow
def test_each_tree_runs_its_own_code_in_isolated_children_too(other_tree: Path) -> None:
    asked = ["-I", "-c", "import exogauge, numpy; print(exogauge.__file__)"]
    with trees(str(other_tree)) as (base, this):
        assert base.command().stdout == "the other\n"
        told = [subprocess.check_output([tree.python, *asked], text=True).strip() for tree in (base, this)]
    assert Path(told[0]).is_relative_to(other_tree)
    assert Path(told[1]).is_relative_to(HERE)


@pytest.mark.slow
def test_the_version_is_the_codes(other_tree: Path) -> None:
    with trees(str(other_tree)) as (before, _):
        pass
    (other_tree / "server/exogauge/cli.py").write_text("print('another')\n")
    with trees(str(other_tree)) as (after, this):
        assert len({before.version, after.version, this.version}) == 3
    (other_tree / "server/exogauge/cli.py").write_text("print('the other')\n")
    with trees(str(other_tree)) as (again, _):
        assert again.version == before.version
