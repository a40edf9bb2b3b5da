"""Whatever stands in a device file or a bench table: a device, or faults that name the file; never anything else."""

from __future__ import annotations

import copy
import shutil
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from exogauge.errors import BadStudy, TooLarge
from exogauge.robots.description import Robot
from exogauge.studies.device_pages.device_picture import draw_device
from exogauge.studies.device_pages.device_text import device_text
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.device_check import check_device, device_doubts
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.robot_file import load_robot

DEVICE: dict[str, Any] = {
    "version": 1,
    "name": "Suit",
    "bands": [
        {
            "name": f"A_{side}",
            "group": "A",
            "via_points": [
                {"link": "chest_1", "xyz": [-0.1, y, 0.2]},
                {"link": "chest_0", "xyz": [-0.1, y, 0.0]},
                {"link": "BODY", "xyz": [-0.1, y, 0.1]},
            ],
            "stiffness_n_per_m": 200.0,
            "natural_length_m": 0.45,
            "law": "linear",
            "law_values": {},
            "bench": {"file": "bench.csv", "is_truth": False},
        }
        for side, y in (("left", 0.1), ("right", -0.1))
    ],
    "tied": ["A"],
}
BENCH = "length_m,force_n\n0.40,0\n0.50,10\n0.60,30\n"

words = st.sampled_from(
    ["A", "A_left", "chest_1", "imu_link", "linear", "hardening", "bench.csv", "../x", "", "\x00", "é"]
)
numbers = st.one_of(st.floats(), st.integers(-(10**30), 10**30), st.sampled_from([0, -0.0, 1e-320, 1e308, 100.0]))
odd: st.SearchStrategy[Any] = st.recursive(
    st.one_of(st.none(), st.booleans(), numbers, words, st.text(max_size=8), st.dates()),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.one_of(words, st.integers()), inner, max_size=4)
    ),
    max_leaves=6,
)


@pytest.fixture(scope="module")
def bundle(pristine: Path, tmp_path_factory: pytest.TempPathFactory) -> Bundle:
    root = tmp_path_factory.mktemp("fuzz") / "study"
    shutil.copytree(pristine, root)
    (root / "bench.csv").write_text(BENCH)
    return Bundle(root, "study.yaml")


@pytest.fixture(scope="module")
def robot(bundle: Bundle) -> Robot:
    return load_robot(bundle.root)


def is_read_or_refused(bundle: Bundle, robot: Robot, text: bytes) -> None:
    (bundle.root / "device.yaml").write_bytes(text)
    device, faults = None, ()
    try:
        device = read_device(bundle, "device.yaml", robot)
    except (BadStudy, TooLarge) as bad:
        faults = bad.faults
    if device is None:
        assert faults
        assert all(fault.file and str(fault).isprintable() for fault in faults), faults
    else:
        assert all(doubt.row is not None for doubt in device_doubts(bundle, "device.yaml", robot, device))
        assert fromstring(draw_device(robot, device)).tag.endswith("svg")
        said = device_text(check_device(robot, device))
        assert "No fault" in said
        assert all(band.law in said for band in device.bands)


@pytest.mark.slow
@given(st.data())
@settings(max_examples=60, deadline=None, derandomize=True)
def test_odd_values_anywhere_are_told(bundle: Bundle, robot: Robot, data: st.DataObject) -> None:
    content: Any = copy.deepcopy(DEVICE)
    for _ in range(data.draw(st.integers(1, 3))):
        node = content
        while isinstance(node, dict | list) and node:
            key = data.draw(st.sampled_from(list(node) if isinstance(node, dict) else range(len(node))))
            if not isinstance(node[key], dict | list) or not node[key] or data.draw(st.booleans()):
                change = data.draw(st.sampled_from(["replace", "remove", "add"]))
                if change == "remove":
                    del node[key]
                elif change == "add" and isinstance(node, list):
                    node.append(copy.deepcopy(node[key]))
                elif change == "add":
                    node[data.draw(words)] = data.draw(odd)
                else:
                    node[key] = data.draw(odd)
                break
            node = node[key]
    is_read_or_refused(bundle, robot, yaml.safe_dump(content, allow_unicode=True).encode())


@pytest.mark.slow
@given(st.data())
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_broken_text_is_told(bundle: Bundle, robot: Robot, data: st.DataObject) -> None:
    text = yaml.safe_dump(DEVICE, default_flow_style=None)
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        stop = min(len(text), start + data.draw(st.integers(0, 12)))
        text = (
            text[:start]
            + data.draw(st.text(st.sampled_from("{}[]:,-&*!'\"\n #ab019.|>\t%é"), max_size=5))
            + text[stop:]
        )
    is_read_or_refused(bundle, robot, text.encode())


cells = st.one_of(numbers.map(str), st.sampled_from(["0,5", "", "x", "length_m", "force_n", '"', "\x00", "1e-400"]))


@pytest.mark.slow
@given(st.lists(st.lists(cells, max_size=4), max_size=6), st.sampled_from([",", ";", "\t"]), st.booleans())
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_broken_bench_table_is_told(
    bundle: Bundle, robot: Robot, rows: list[list[str]], mark: str, headed: bool
) -> None:
    head = f"length_m{mark}force_n\n" if headed else ""
    (bundle.root / "bench.csv").write_text(head + "\n".join(mark.join(row) for row in rows), encoding="utf-8")
    try:
        is_read_or_refused(bundle, robot, yaml.safe_dump(DEVICE).encode())
    finally:
        (bundle.root / "bench.csv").write_text(BENCH)
