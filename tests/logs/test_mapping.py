"""Foreign columns become contract channels: units, signs, frames, order, gears, clocks; nothing is guessed."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from exogauge.errors import BadLog, Fault
from exogauge.logs.mapping import read_mapped
from exogauge.logs.mapping_rules import (
    Clock,
    FileMapping,
    LogMapping,
    Rule,
    Source,
    Values,
    Vector,
    Wrench,
    check_rotation,
)
from exogauge.logs.model import Array, Log
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import TextLayout

T = 20
SAME = Clock(rate_hz=100.0)


def column(name: str, channel: str, unit: str, **more: object) -> Values:
    return Values(Source((name,)), (channel,), unit, **more)  # type: ignore[arg-type]


def table(folder: Path, columns: dict[str, Array], name: str = "log.csv") -> Path:
    path = folder / name
    rows = np.column_stack(list(columns.values()))
    path.write_text(",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist()))
    return path


def one(
    path: Path,
    *rules: Rule,
    clock: Clock = SAME,
    joints: Sequence[str] = ("a", "b"),
    gear: Array | None = None,
    ignore: tuple[str, ...] | None = (),
    layout: TextLayout | None = None,
    **options: object,
) -> Log:
    mapping = LogMapping((FileMapping(path.name, clock, rules, ignore, layout or TextLayout()),))
    mapping = LogMapping.from_plain(json.loads(json.dumps(mapping.to_plain())))
    return read_mapped({path.name: path}, mapping, joints=joints, motor_from_joint=gear, name="log", **options)  # type: ignore[arg-type]


def refused(*arguments: object, **options: object) -> tuple[Fault, ...]:
    with pytest.raises(BadLog) as caught:
        one(*arguments, **options)  # type: ignore[arg-type]
    return caught.value.faults


@pytest.mark.parametrize(
    ("channel", "unit", "one_is"),
    [
        ("q.a", "deg", np.pi / 180),
        ("q.a", "°", np.pi / 180),
        ("q.a", "mm", 1e-3),
        ("dq.a", "rpm", 2 * np.pi / 60),
        ("dq.a", "deg/s", np.pi / 180),
        ("i.a", "mA", 1e-3),
        ("tau.a", "N·m", 1.0),
        ("tau.a", "mNm", 1e-3),
        ("tau.a", "N*mm", 1e-3),
        ("acc.x", "g", 9.80665),
        ("acc.x", "m/s²", 1.0),
        ("ft.foot.fx", "kN", 1e3),
        ("ft.foot.mx", "Nmm", 1e-3),
        ("ft.foot.fz", "lbf", 4.4482216152605),
        ("ft.foot.my", "lbf-in", 0.1129848290276167),
        ("temp.a", "K", 1.0 - 273.15),
    ],
)
def test_a_unit_becomes_si(channel: str, unit: str, one_is: float, tmp_path: Path) -> None:
    path = table(tmp_path, {"x": np.ones(T)})
    assert np.allclose(one(path, column("x", channel, unit)).channels[channel], one_is, rtol=1e-12)


@pytest.mark.parametrize(("channel", "unit"), [("q.a", "A"), ("tau.a", "rad"), ("acc.x", "kg"), ("ft.foot.fx", "Nm")])
def test_a_unit_of_another_quantity_is_refused_and_the_right_ones_are_named(
    channel: str, unit: str, tmp_path: Path
) -> None:
    (found,) = refused(table(tmp_path, {"x": np.ones(T)}), column("x", channel, unit))
    assert found.rule == "unknown_unit"
    assert "Known:" in found.advice


def test_sign_scale_and_unit_come_before_the_offset(tmp_path: Path) -> None:
    path = table(tmp_path, {"x": np.full(T, 90.0)})
    log = one(path, column("x", "q.a", "deg", sign=-1.0, scale=0.5, offset=1.0))
    assert np.allclose(log.channels["q.a"], 1.0 - np.pi / 4)


def test_a_couple_first_wrench_is_put_force_first(tmp_path: Path) -> None:
    values = {name: np.full(T, float(k)) for k, name in enumerate(["cx", "cy", "cz", "fx", "fy", "fz"], 1)}
    rule = Wrench(Source(tuple(values)), "foot", "couple_first", "N", "mNm", sign=-1.0)
    log = one(table(tmp_path, values), rule)
    found = log.stack([f"ft.foot.{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz")])[0]
    assert np.allclose(found, [-4.0, -5.0, -6.0, -1e-3, -2e-3, -3e-3])


def test_a_rotation_takes_logged_vectors_into_the_contract_frame(tmp_path: Path) -> None:
    turn = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    path = table(tmp_path, {"ax": np.full(T, 1.0), "ay": np.full(T, 2.0), "az": np.full(T, 3.0)})
    log = one(path, Vector(Source(("ax", "ay", "az")), "acc", "m/s^2", rotation=turn))
    assert np.allclose(log.stack(["acc.x", "acc.y", "acc.z"]), [2.0, -1.0, 3.0])


@pytest.mark.parametrize(
    "rows", [[[1, 0, 0], [0, 1, 0], [0, 0, -1]], [[2, 0, 0], [0, 2, 0], [0, 0, 2]], [[1, 0]], [[]]]
)
def test_what_is_no_rotation_is_refused(rows: list[list[float]]) -> None:
    with pytest.raises(BadLog):
        check_rotation(rows)


def test_motor_side_values_come_out_joint_side_and_do_the_same_work(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    M = np.array([[45.0, 0.0], [32.0, -32.0]])
    q, dq, tau_motor = rng.normal(size=(3, T, 2))
    motor = {"p1": (q @ M.T)[:, 0], "p2": (q @ M.T)[:, 1], "v1": (dq @ M.T)[:, 0], "v2": (dq @ M.T)[:, 1]}
    motor |= {"c1": tau_motor[:, 0], "c2": tau_motor[:, 1], "i1": np.ones(T), "i2": np.ones(T)}
    rules = [
        column(f"{letter}{k}", f"{kind}.{joint}", unit, side="motor", offset=0.1 if kind == "q" else 0.0)
        for letter, kind, unit in (("p", "q", "rad"), ("v", "dq", "rad/s"), ("c", "tau", "Nm"), ("i", "i", "A"))
        for k, joint in ((1, "a"), (2, "b"))
    ]
    log = one(table(tmp_path, motor), *rules, gear=M)
    assert np.allclose(log.stack(["q.a", "q.b"]), q + 0.1)
    power = np.sum(log.stack(["tau.a", "tau.b"]) * log.stack(["dq.a", "dq.b"]), axis=1)
    assert np.allclose(power, np.sum(tau_motor * (dq @ M.T), axis=1))
    assert log.channels["i.a"][0] == 1.0
    assert log.channels["i.b"][0] == -1.0


def test_motor_side_values_need_the_gear_and_every_coupled_motor(tmp_path: Path) -> None:
    path = table(tmp_path, {"p2": np.ones(T)})
    rule = column("p2", "q.b", "rad", side="motor")
    assert refused(path, rule)[0].rule == "no_transmission"
    (found,) = refused(path, rule, gear=np.array([[45.0, 0.0], [32.0, 32.0]]))
    assert found.rule == "coupling_incomplete"
    assert one(path, rule, gear=np.diag([1.0, 4.0])).channels["q.b"][0] == 0.25


def test_a_column_nobody_names_is_refused_unless_it_is_ignored(tmp_path: Path) -> None:
    path = table(tmp_path, {"x": np.ones(T), "y": np.ones(T)})
    rule = column("x", "q.a", "rad")
    assert refused(path, rule)[0].column == "y"
    for ignore in (("y",), None):
        assert list(one(path, rule, ignore=ignore).channels) == ["q.a"]
    assert refused(path, rule, ignore=("y", "z"))[0].rule == "missing_column"


def test_a_mapping_cannot_name_what_is_not_there_or_twice(tmp_path: Path) -> None:
    path = table(tmp_path, {"x": np.ones(T)})
    assert refused(path, column("z", "q.a", "rad"), ignore=None)[0].rule == "missing_column"
    assert refused(path, column("x", "q.c", "rad"))[0].rule == "unknown_joint"
    assert refused(path, column("x", "t", "s"))[0].rule == "time_as_channel"
    assert refused(path, column("x", "pos.a", "rad"))[0].rule == "unknown_channel"
    assert refused(path, column("x", "q.a", "rad"), column("x", "q.a", "rad"))[0].rule == "duplicate_channel"
    assert refused(path, column("x", "temp.a", "degC", side="motor"))[0].rule == "no_motor_side"


def test_a_headerless_file_is_read_by_column_number_from_one(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("# made by a logger\n" + "".join(f" {k / 100}  {k}  {2 * k}\n" for k in range(T)))
    layout = TextLayout(header=False, skip_lines=1)
    rules = (column("3", "q.a", "rad"), column("2", "q.b", "rad"))
    log = one(path, *rules, clock=Clock("1"), layout=layout)
    assert np.array_equal(log.channels["q.a"], 2.0 * log.channels["q.b"])
    assert log.rate_hz == pytest.approx(100.0)


def test_a_file_with_names_and_no_rows_is_told_as_that(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("ms,a\n")
    with pytest.raises(BadLog) as caught:
        one(path, column("a", "q.a", "rad"), clock=Clock("ms", "ms"), joints=("a",))
    assert {fault.rule for fault in caught.value.faults} == {"too_few_samples"}


def test_nanosecond_stamps_since_1970_keep_their_nanoseconds(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("stamp,x\n" + "".join(f"{1_708_857_503_931_759_123 + 200_001 * k},1\n" for k in range(T)))
    log = one(path, column("x", "q.a", "rad"), clock=Clock("stamp", "ns"))
    assert np.array_equal(log.time, np.arange(T) * 200_001 * 1e-9)


def test_the_faulty_cell_of_a_foreign_file_is_named_in_its_own_words(tmp_path: Path) -> None:
    values = np.ones(T)
    values[4] = np.nan
    path = table(tmp_path, {"x": values})
    (found,) = refused(path, column("x", "q.a", "rad"))
    assert (found.row, found.column) == (5, "x")
    assert np.isnan(one(path, column("x", "q.a", "rad"), allow_gaps=True).channels["q.a"][4])


def test_a_constant_fills_what_no_column_does_and_never_stands_in_for_one(tmp_path: Path) -> None:
    path = table(tmp_path, {"p": np.linspace(0.0, 1.0, T), "z": np.full(T, 330.0)})
    part = FileMapping(path.name, SAME, (column("p", "q.a", "rad"), column("z", "ft.foot.fz", "N")))

    def read(*constants: tuple[str, float]) -> Log:
        mapping = LogMapping.from_plain(json.loads(json.dumps(LogMapping((part,), None, constants).to_plain())))
        return read_mapped({path.name: path}, mapping, joints=("a",), motor_from_joint=None, name="log", rows=(5, 15))

    log = read(("ft.foot.fx", 0.0), ("ft.foot.my", -2.0))
    np.testing.assert_array_equal(log.stack(["ft.foot.fx", "ft.foot.fz", "ft.foot.my"]), [[0.0, 330.0, -2.0]] * 10)
    for name, value, rule in (
        ("ft.foot.fz", 0.0, "constant_and_column"),
        ("t", 0.0, "constant_and_column"),
        ("q.b", 0.0, "unknown_joint"),
        ("q.a.b", 0.0, "unknown_joint"),
        ("foot", 0.0, "unknown_channel"),
        ("acc.x", float("nan"), "not_finite"),
    ):
        with pytest.raises(BadLog) as caught:
            read((name, value))
        assert [fault.rule for fault in caught.value.faults] == [rule]


@pytest.mark.parametrize("packing", ["csv", "npz"])
def test_what_is_wrong_outside_the_chosen_rows_does_not_matter(tmp_path: Path, packing: str) -> None:
    columns = {"s": np.where(np.arange(T) == 1, -5.0, np.arange(T) * 0.01), "x": np.arange(float(T))}
    columns["x"][2] = np.nan
    path = table(tmp_path, columns)
    if packing == "npz":
        path = tmp_path / "log.npz"
        np.savez(path, **columns)
    rule, clock = column("x", "q.a", "rad"), Clock("s", "s")
    assert np.array_equal(one(path, rule, clock=clock, rows=(4, 18)).channels["q.a"], np.arange(4.0, 18.0))
    assert {fault.row for fault in refused(path, rule, clock=clock, rows=(2, 18))} == {3}


def test_rows_are_cut_after_time_is_counted(tmp_path: Path) -> None:
    log = one(table(tmp_path, {"x": np.arange(float(T))}), column("x", "q.a", "rad"), rows=(5, 18))
    assert log.samples == 13
    assert log.time[0] == pytest.approx(0.05)
    assert log.channels["q.a"][0] == 5.0


def two_files(tmp_path: Path, first: Clock, second: Clock, rows: int = T) -> tuple[dict[str, Path], LogMapping]:
    a = table(tmp_path, {"t": 5.0 + np.arange(T) * 0.01, "x": np.linspace(0.0, 1.0, T)}, "a.csv")
    b = table(tmp_path, {"t": 5.05 + np.arange(rows) * 0.01, "x": np.linspace(0.0, 1.0, rows)}, "b_17.csv")
    files = (
        FileMapping("a.csv", first, (column("x", "q.a", "rad"),), None),
        FileMapping("b_*.csv", second, (column("x", "q.b", "rad"),), None),
    )
    return {"a.csv": a, "runs/b_17.csv": b}, LogMapping(files)


def test_files_of_one_clock_are_put_side_by_side_untouched(tmp_path: Path) -> None:
    paths, mapping = two_files(tmp_path, SAME, SAME)
    log = read_mapped(paths, mapping, joints=("a", "b"), motor_from_joint=None, name="log")
    assert np.array_equal(log.channels["q.a"], np.linspace(0.0, 1.0, T))
    assert np.array_equal(log.channels["q.a"], log.channels["q.b"])


def test_files_of_two_clocks_meet_over_the_time_both_cover(tmp_path: Path) -> None:
    paths, mapping = two_files(tmp_path, Clock("t"), Clock("t", delay_s=0.02))
    log = read_mapped(paths, mapping, joints=("a", "b"), motor_from_joint=None, name="log")
    assert (log.time[0], log.time[-1]) == (pytest.approx(0.03), pytest.approx(0.19))
    assert np.allclose(log.channels["q.a"] - log.channels["q.b"], 3.0 / (T - 1), atol=1e-9)


def test_a_file_without_stamps_cannot_join_one_with_stamps(tmp_path: Path) -> None:
    paths, mapping = two_files(tmp_path, Clock("t"), SAME)
    with pytest.raises(BadLog) as caught:
        read_mapped(paths, mapping, joints=("a", "b"), motor_from_joint=None, name="log")
    assert (caught.value.faults[0].rule, caught.value.faults[0].file) == ("clocks_differ", "runs/b_17.csv")


def test_every_file_is_matched_by_one_part_of_the_mapping(tmp_path: Path) -> None:
    paths, mapping = two_files(tmp_path, SAME, SAME)
    for changed, rule in (
        ({"a.csv": paths["a.csv"]}, "file_not_matched"),
        ({**paths, "c.csv": paths["a.csv"]}, "file_not_mapped"),
        ({**paths, "b_18.csv": paths["a.csv"]}, "file_not_matched"),
    ):
        with pytest.raises(BadLog) as caught:
            read_mapped(changed, mapping, joints=("a", "b"), motor_from_joint=None, name="log")
        assert caught.value.faults[0].rule == rule


@pytest.mark.parametrize("version", [5, 73])
def test_fields_of_a_matlab_struct_are_columns(version: int, tmp_path: Path) -> None:
    t, q = np.arange(T) / 50.0, np.arange(2.0 * T).reshape(T, 2)
    path = tmp_path / "walk.mat"
    if version == 5:
        signals = np.zeros((1, 2), dtype=[("label", object), ("values", object)])
        signals["values"][0] = [q[:, 0], q[:, 1]]
        log = {"time": t, "arm": {"q": q, "name": "left"}, "signals": signals}
        scipy.io.savemat(path, {"log": log, "rate": 50.0}, do_compression=True)
    else:
        with h5py.File(path, "w", userblock_size=512) as target:
            target["log/time"], target["log/arm/q"], target["rate"] = t[None, :], q.T, [[50.0]]
        with path.open("r+b") as head:
            head.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    assert {"log.time", "log.arm.q", "rate"} <= set(open_table(path, "walk.mat").names)
    rule = Values(Source((), "log.arm.q"), ("q.a", "q.b"), "rad")
    log = one(path, rule, clock=Clock("log.time"), ignore=None)
    assert np.array_equal(log.stack(["q.a", "q.b"]), q)
    np.testing.assert_allclose(log.time, t)
    if version == 5:
        third = one(path, column("log.signals(2).values", "q.b", "rad"), clock=Clock("log.time"), ignore=None)
        assert np.array_equal(third.channels["q.b"], q[:, 1])
        (found,) = refused(path, column("log.arm.name", "q.b", "rad"), clock=Clock("log.time"), ignore=None)
        assert found.rule == "not_a_number"


def save_mat(path: Path, arrays: dict[str, Array], version: int) -> None:
    if version == 5:
        scipy.io.savemat(path, arrays | {"note": np.array(["text"])})
    else:
        with h5py.File(path, "w", userblock_size=512) as target:
            for name, values in arrays.items():
                target[name] = values


@pytest.mark.parametrize("version", [5, 7])
@pytest.mark.parametrize("across", [False, True])
def test_a_matlab_matrix_gives_one_channel_per_joint_either_way_round(
    version: int, across: bool, tmp_path: Path
) -> None:
    q = np.arange(2.0 * T).reshape(T, 2)
    path = tmp_path / "walk.mat"
    save_mat(path, {"q": q.T if across else q, "time": np.arange(T)[None, :] / 50.0}, version)
    log = one(path, Values(Source((), "q"), ("q.a", "q.b"), "rad"), clock=Clock("time"), ignore=None)
    assert np.array_equal(log.stack(["q.a", "q.b"]), q)


def test_a_square_matrix_needs_its_time_axis_named(tmp_path: Path) -> None:
    q = np.arange(100.0).reshape(10, 10)
    joints = tuple(f"j{k}" for k in range(10))
    np.savez(tmp_path / "a.npz", q=q)
    rule = Values(Source((), "q"), tuple(f"q.{joint}" for joint in joints), "rad")
    (found,) = refused(tmp_path / "a.npz", rule, joints=joints)
    assert "time_axis" in found.advice
    for axis, expected in (("first", q), ("last", q.T)):
        stated = dataclasses.replace(rule, source=Source((), "q", axis))  # type: ignore[arg-type]
        log = one(tmp_path / "a.npz", stated, joints=joints)
        assert np.array_equal(log.stack(list(log.channels)), expected)


def test_arrays_of_different_lengths_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", q=np.ones(T), i=np.ones(T + 1))
    (found,) = refused(tmp_path / "a.npz", column("q", "q.a", "rad"), column("i", "i.a", "A"))
    assert (found.rule, found.column) == ("length_differs", "i")
