"""Tiles hold every extreme, wherever it is, and say nothing that no sample says."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
import pytest

from exogauge.errors import BadInput
from exogauge.studies.series.file import SeriesFile, window
from exogauge.studies.series.tiles import BLOCK, BlockCache, Blocks, Tiles, make_blocks, tiles
from exogauge.studies.series.write import Columns

SAMPLES, RATE = 100_000, 200.0
WORDS = ("lowering", "holding", "raising")
T = np.arange(SAMPLES) / RATE


def write(path: Path, values: np.ndarray, group: int = 12_000) -> SeriesFile:
    columns = Columns(T[: values.size])
    columns.add("measured.tau.waist", values, "N·m")
    columns.add_truth("support_rest.waist", values > 0.0)
    columns.add_words("phase", np.arange(values.size) // 40_000, WORDS)
    pq.write_table(columns.table({"log": "lift"}), path, row_group_size=group, use_dictionary=["phase"])
    return SeriesFile(path)


@pytest.fixture
def values() -> np.ndarray:
    return np.random.default_rng(3).standard_normal(SAMPLES)


@pytest.fixture
def series(tmp_path: Path, values: np.ndarray) -> SeriesFile:
    return write(tmp_path / "lift.parquet", values)


def seen(series: SeriesFile, start: float, end: float, width: int, channel: str = "measured.tau.waist") -> Tiles:
    return tiles(series, make_blocks(series), [channel], start, end, width)


@pytest.mark.parametrize("width", [1, 7, 300, 2000])
@pytest.mark.parametrize(("start", "end"), [(0.0, 1e9), (100.0, 350.0), (40.001, 40.5), (-5.0, 60.0)])
def test_no_extreme_of_the_window_is_missed_and_none_is_invented(
    series: SeriesFile, values: np.ndarray, start: float, end: float, width: int
) -> None:
    found = seen(series, start, end, width)
    inside = (start <= T) & (end >= T)
    low, high = found.low["measured.tau.waist"], found.high["measured.tau.waist"]
    assert low.min() <= values[inside].min()
    assert high.max() >= values[inside].max()
    near = (start - (2 * BLOCK / RATE) <= T) & (end + (2 * BLOCK / RATE) >= T)
    assert low.min() >= values[near].min()
    assert high.max() <= values[near].max()
    assert found.t.size <= max(2 * width, width)
    assert (np.diff(found.t) > 0.0).all()
    assert inside.sum() <= found.samples <= near.sum()


@pytest.mark.parametrize("group", [12_000, 7_777, 1_000_000])
def test_a_spike_of_one_sample_is_seen_in_its_own_stretch(tmp_path: Path, group: int) -> None:
    values = np.zeros(SAMPLES)
    values[[54_321, 99_999]] = 9.0, -4.0
    found = seen(write(tmp_path / "spike.parquet", values, group), 0.0, T[-1], 400)
    low, high = found.low["measured.tau.waist"], found.high["measured.tau.waist"]
    at = int(np.argmax(high))
    assert high[at] == 9.0
    assert found.t[at] <= T[54_321] < found.t[at + 1]
    assert (low[-1], np.count_nonzero(high), np.count_nonzero(low)) == (-4.0, 1, 1)


def test_few_samples_are_given_as_they_are_with_one_beyond_each_end(series: SeriesFile, values: np.ndarray) -> None:
    found = seen(series, T[12_000], T[12_005], 1200)
    assert found.t.tolist() == T[11_999:12_007].tolist()
    assert found.low["measured.tau.waist"].tolist() == values[11_999:12_007].tolist()
    assert found.high["measured.tau.waist"].tolist() == values[11_999:12_007].tolist()


def test_a_gap_is_a_gap_and_what_is_missing_hides_nothing(tmp_path: Path, values: np.ndarray) -> None:
    values[30_000:60_000] = np.nan
    values[::7] = np.nan
    found = seen(write(tmp_path / "gap.parquet", values), 0.0, T[-1], 100)
    low = found.low["measured.tau.waist"]
    assert np.isnan(low[31:59]).all()
    assert np.isfinite(low[:29]).all()
    assert np.nanmin(low) == np.nanmin(values)


def test_words_and_truths_are_drawn_as_numbers(series: SeriesFile) -> None:
    phase = series.channel("phase")
    assert (phase.kind, phase.words) == ("words", WORDS)
    found = seen(series, 0.0, T[-1], 50, "phase")
    assert set(found.low["phase"]) == {0.0, 1.0, 2.0}
    assert series.channel("support_rest.waist").kind == "truth"
    assert set(seen(series, 0.0, 0.1, 50, "support_rest.waist").low["support_rest.waist"]) == {0.0, 1.0}
    assert series.channel("measured.tau.waist").unit == "N·m"


def test_outside_of_the_series_there_is_nothing_but_its_last_sample(series: SeriesFile) -> None:
    assert seen(series, -20.0, -10.0, 100).t.size == 0
    assert seen(series, 1e6, 2e6, 100).t.tolist() == [T[-1]]


def test_an_unknown_channel_is_refused_with_those_there_are(series: SeriesFile) -> None:
    with pytest.raises(BadInput, match=r"Did you mean 'measured.tau.waist'.*There are: .*phase"):
        series.checked(["measured.tau.wast"])


def test_a_window_holds_every_sample_and_every_digit(series: SeriesFile, values: np.ndarray) -> None:
    names = ["measured.tau.waist", "phase"]
    start, end = T[5_000], T[70_000]
    parquet = pq.read_table(io.BytesIO(b"".join(window(series, names, start, end, "parquet"))))
    text = b"".join(window(series, names, start, end, "csv"))
    csv = pacsv.read_csv(io.BytesIO(text))
    for table in (parquet, csv):
        assert table.column_names == ["t", *names]
        assert table.column("t").to_pylist() == T[5_000:70_001].tolist()
        assert table.column("measured.tau.waist").to_pylist() == values[5_000:70_001].tolist()
        assert table.column("phase").to_pylist()[-1] == WORDS[1]
    assert parquet.schema.field("measured.tau.waist").metadata == {b"unit": "N·m".encode()}
    assert b"".join(window(series, names, -2.0, -1.0, "csv")) == b'"t","measured.tau.waist","phase"\n'
    assert pq.read_table(io.BytesIO(b"".join(window(series, names, -2.0, -1.0, "parquet")))).num_rows == 0


def test_a_missing_value_is_an_empty_cell(tmp_path: Path) -> None:
    series = write(tmp_path / "short.parquet", np.array([1.0, np.nan, -3.5]))
    text = b"".join(window(series, ["measured.tau.waist"], 0.0, 1.0, "csv")).decode()
    assert text.splitlines()[1:] == ["0,1", "0.005,", "0.01,-3.5"]


def test_the_blocks_asked_for_least_recently_go_when_room_runs_short() -> None:
    one = Blocks(np.arange(101), np.zeros(100))
    cache = BlockCache(kept_bytes=2 * one.nbytes)
    made = [cache.get(key, lambda: Blocks(np.arange(101), np.zeros(100))) for key in ("a", "b")]
    assert cache.get("a", lambda: one) is made[0]
    cache.get("c", lambda: one)
    assert len(cache) == 2
    assert cache.get("b", lambda: one) is one
