"""Studies with one or two slips: each ends with a result that is worth something, or with a fault that names what."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, Phase, example, given, note, settings
from hypothesis import strategies as st
from tests.fuzz.small_robots import JOINTS, K_T, LOGS, RATE, robot_yaml, simulated_logs, write_study

from exogauge.errors import BadInput, NotIdentifiable
from exogauge.studies.evaluate import evaluate

FEW = 8  # in `make test`
EXAMPLES = int(os.environ.get("EXOGAUGE_TEST_STUDIES", FEW))
Columns = dict[str, np.ndarray]
Change = Callable[[Columns], Columns]
CHANNELS = tuple(f"{kind}.{joint}" for kind in ("q", "i") for joint in JOINTS)
FACTORS = (57.29578, 0.0174533, 1000.0, 0.001, 80.0, 0.0125, 100.0, 2.0, 0.5)

pytestmark = pytest.mark.slow


@cache
def recorded(floating: bool) -> dict[str, Columns]:
    return simulated_logs(floating)


def on(name: str, make: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda columns: columns | {name: make(columns[name])} if name in columns else columns


def swap(one: str, other: str) -> Change:
    return lambda columns: columns | {one: columns[other], other: columns[one]}


def rows(which: slice) -> Change:
    return lambda columns: {name: values[which] for name, values in columns.items()}


def without(name: str) -> Change:
    return lambda columns: {key: values for key, values in columns.items() if key != name}


def still(columns: Columns) -> Columns:
    noise = np.random.default_rng(0).standard_normal(len(columns["t"]))
    return {name: values if name == "t" else values[0] + 1e-5 * noise for name, values in columns.items()}


def gaps(columns: Columns) -> Columns:
    return columns | {"t": columns["t"] + 0.5 * (np.arange(len(columns["t"])) > 700)}


channel = st.sampled_from(CHANNELS)
any_channel = st.sampled_from((*CHANNELS, *(f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"),
                               *(f"ft.plate.{kind}{axis}" for kind in "fm" for axis in "xyz")))  # fmt: skip
slips = st.one_of(
    any_channel.map(lambda name: (f"flip {name}", on(name, np.negative))),
    st.tuples(any_channel, st.sampled_from(FACTORS)).map(
        lambda each: (f"scale {each[0]} {each[1]:g}", on(each[0], lambda values: each[1] * values))
    ),
    st.tuples(channel, channel).map(lambda pair: (f"swap {pair[0]} {pair[1]}", swap(*pair))),
    any_channel.map(lambda name: (f"zero {name}", on(name, lambda values: 0.0 * values))),
    any_channel.map(lambda name: (f"half zero {name}", on(name, lambda v: v * (np.arange(len(v)) % 600 < 300)))),
    st.tuples(any_channel, st.sampled_from((-1.57, 0.2, 5.0))).map(
        lambda each: (f"offset {each[0]} {each[1]}", on(each[0], lambda values: values + each[1]))
    ),
    st.tuples(any_channel, st.integers(-20, 20)).map(
        lambda each: (f"delay {each[0]} {each[1]}", on(each[0], lambda values: np.roll(values, each[1])))
    ),
    st.sampled_from((1, 2, 5, 40, 120, 500)).map(lambda count: (f"cut to {count}", rows(slice(0, count)))),
    st.sampled_from((2, 5, 10, 25, 100)).map(lambda step: (f"decimate {step}", rows(slice(None, None, step)))),
    st.sampled_from((1000.0, 1e-3, 1e6, 1e-6, 0.0)).map(
        lambda factor: (f"time times {factor:g}", on("t", lambda t: factor * t))
    ),
    any_channel.map(lambda name: (f"missing {name}", without(name))),
    any_channel.map(lambda name: (f"holes {name}", on(name, lambda v: np.where(np.arange(len(v)) % 50, v, np.nan)))),
    st.just(("standstill", still)),
    st.just(("gap", gaps)),
)  # fmt: skip
robots = st.sampled_from((
    ("as it is", lambda text: text),
    ("order", lambda text: "\n".join([*text.splitlines()[:-2], text.splitlines()[-1], text.splitlines()[-2], ""])),
    ("gear 1", lambda text: text.replace("gear_ratio: 80", "gear_ratio: 1")),
    ("nothing logged", lambda text: "".join(
        line.split("actuation")[0] + "actuation: none}\n" if "actuation" in line else line + "\n"
        for line in text.splitlines()
    )),
    ("k_T ten times", lambda text: text.replace("k_T: ", "k_T: 1")),
    ("no sensor", lambda text: text.replace("  - {name: plate, frame: sole, role: contact, sees: world_on_robot}\n", "")
        .replace("ft_sensors:\n", "")),
    ("sensor sees the reverse", lambda text: text.replace("world_on_robot", "robot_on_world")),
))  # fmt: skip


AS_IT_IS = ("as it is", lambda text: text)


@example(True, [("standstill", still)], True, AS_IT_IS, "", "[identify, discrepancy]")  # nothing is left but rounding
@example(False, [("cut to 500", rows(slice(0, 500))), ("standstill", still)], True, AS_IT_IS, "", "[identify]")
@given(
    floating=st.booleans(),
    changes=st.lists(slips, min_size=1, max_size=2),
    everywhere=st.booleans(),
    robot=st.one_of(st.just(AS_IT_IS), robots),
    chosen=st.sampled_from(("", "cutoff_hz: 6, prior_strength: 1")),
    steps=st.sampled_from(("[identify]", "[identify]", "[identify]", "[identify, discrepancy]")),
)
@settings(
    max_examples=EXAMPLES,
    deadline=None,
    derandomize=EXAMPLES <= FEW,  # `make fuzz` tries others every time
    phases=[Phase.explicit, Phase.reuse, Phase.generate],  # a study takes a second: none is shrunk
    suppress_health_check=list(HealthCheck),
)
def test_a_study_with_slips_is_evaluated_or_refused_with_a_suspect(
    floating: bool, changes: list, everywhere: bool, robot: tuple, chosen: str, steps: str
) -> None:
    note(f"{[name for name, _ in changes]}, {robot[0]}")
    logs = {name: dict(columns) for name, columns in recorded(floating).items()}
    for name in logs if everywhere else ("id_1",):
        for _, change in changes:
            logs[name] = change(logs[name])
    with tempfile.TemporaryDirectory() as place:
        study = write_study(Path(place) / "study", floating, logs, robot[1](robot_yaml(floating)), chosen, steps)
        refused, failed = None, ()
        try:
            failed = evaluate(study, Path(place) / "out", lambda *_: None)
        except (BadInput, NotIdentifiable) as error:
            refused = error
        if refused is not None:
            assert not (Path(place) / "out" / "results.json").exists()
            faults = refused.faults if isinstance(refused, BadInput) else ()
            assert all(fault.detail and (fault.file or fault.column) for fault in faults), str(refused)
            assert len(str(refused)) > 20
            return
        assert all(each.expected for each in failed), failed
        content = json.loads((Path(place) / "out" / "results.json").read_text(), parse_constant=pytest.fail)
        doubted = [text for text in content["warnings"] if text.startswith("Held-out logs are predicted worse")]
        for entry in content["identification"]["joints"]:
            if not any(moves(columns, entry["joint"]) for columns in logs.values()):
                assert not any(entry[name]["identifiable"] for name in ("k_d", "tau_c", "J_r") if name in entry), entry
        for joint, before, after in held_out_errors(Path(place) / "out", content, logs):
            told = any(joint in text for text in doubted)
            assert told or after <= 1.15 * before + 0.03, (joint, before, after)


def moves(columns: Columns, joint: str) -> bool:
    angle = columns.get(f"q.{joint}", np.zeros(1))
    return bool(np.nanmax(angle) - np.nanmin(angle) > 1e-3)


def held_out_errors(out: Path, content: dict, logs: dict[str, Columns]):
    """(joint, a-priori, identified) rms error over the rms current [1], of the held-out log, in amperes."""
    if not (out / "series" / "val_1.parquet").exists():  # a gap has cut it
        return
    series, columns = pq.read_table(out / "series" / "val_1.parquet"), logs["val_1"]
    stated = {f"{name}": 0.9 * k for name, k in zip(JOINTS, K_T, strict=True)}
    for entry in content["identification"]["joints"]:
        name = entry["joint"]
        if f"measured.tau.{name}" not in series.column_names or "k_T" not in entry or entry["k_T"]["prior"] > 10.0:
            continue
        i, prior = columns[f"i.{name}"], series[f"predicted_prior.tau.{name}"].to_numpy()
        measured, predicted = (series[f"{kind}.tau.{name}"].to_numpy() for kind in ("measured", "predicted"))
        if len(i) != len(measured) or not np.isfinite(i).all() or not i.any():
            continue
        if not moves(columns, name):  # friction bears what it is asked for: either of the two is nearer by chance
            continue
        used = measured @ i / (i @ i)
        errors = (i - prior / stated[name]), (measured - predicted) / max(abs(used), 1e-9)
        yield (name, *(float(np.sqrt(np.mean(each**2) / np.mean(i**2))) for each in errors))


@pytest.mark.parametrize("floating", [False, True])
def test_a_current_of_zeros_is_refused_by_its_name(floating: bool, tmp_path: Path) -> None:
    logs = recorded(floating)
    logs = logs | {"id_1": logs["id_1"] | {"i.j1": 0.0 * logs["id_1"]["i.j1"]}}
    with pytest.raises(BadInput, match="its current never changes") as refused:
        evaluate(write_study(tmp_path, floating, logs), tmp_path / "out", lambda *_: None)
    assert [(each.file, each.column) for each in refused.value.faults] == [("id_1.parquet", "i.j1")]


def test_the_studies_are_whole_before_anything_is_changed() -> None:
    for floating in (False, True):
        with tempfile.TemporaryDirectory() as place:
            study = write_study(Path(place) / "study", floating, recorded(floating))
            assert not evaluate(study, Path(place) / "out", lambda *_: None)
            content = json.loads((Path(place) / "out" / "results.json").read_text())
            assert not [each for each in content["doctor"] if each["severity"] == "error"]
    assert set(recorded(True)) == set(LOGS)
    assert RATE > 50.0


def test_what_the_doctor_holds_for_wrong_stands_before_all_that_was_found(tmp_path: Path) -> None:
    logs = {name: columns | {"q.j2": np.radians(columns["q.j2"])} for name, columns in recorded(False).items()}
    study = write_study(tmp_path / "study", False, logs, robot_yaml(False), "", "[identify, discrepancy]")
    evaluate(study, tmp_path / "out", lambda *_: None)
    content = json.loads((tmp_path / "out" / "results.json").read_text())
    (told,) = [each for each in content["notices"] if each["code"] == "doctor_errors"]
    assert told["names"] == ["q.j2"]
    page = (tmp_path / "out" / "summary.html").read_text()
    assert 0 <= page.index("The doctor holds q.j2 for wrong") < page.index("RMSE on")


def test_a_log_whose_efforts_are_of_another_clock_is_neither_fitted_nor_judged_by(tmp_path: Path) -> None:
    right = recorded(False)
    fitted = [name for name in right if name.startswith("id")]
    late = {k: np.roll(v, round(0.4 * RATE)) if k.startswith("i.") else v for k, v in right[fitted[0]].items()}
    found = []
    for name, logs in (("right", right), ("late", right | {fitted[0]: late})):
        study = write_study(tmp_path / name, False, logs, robot_yaml(False), "", "[identify]")
        evaluate(study, tmp_path / f"{name}_out", lambda *_: None)
        found.append(json.loads((tmp_path / f"{name}_out" / "results.json").read_text()))
    (told,) = [each for each in found[1]["notices"] if each["code"] == "logs_left_out"]
    assert told["names"] == [fitted[0]]
    assert told["each"][0][0] == pytest.approx(0.4, abs=0.05)
    assert told["sentence"] in (tmp_path / "late_out" / "summary.html").read_text()
    assert fitted[0] not in {each["log"] for each in found[1]["identification"]["validation"]}
    for then, now in zip(*(each["identification"]["joints"] for each in found), strict=True):
        for name in ("k_T", "tau_c", "k_d"):
            size = abs(now[name]["value"] - then[name]["value"])
            assert size < 3.0 * float(np.hypot(now[name]["std"], then[name]["std"])), (then["joint"], name)
