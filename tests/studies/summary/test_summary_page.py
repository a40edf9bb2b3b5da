"""One page, twice: HTML and PDF say the same, nothing but what the results hold, whatever things are called."""

from __future__ import annotations

import io
import re
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pypdf import PdfReader

from exogauge.studies.report import summary_page as made_by
from exogauge.studies.report.page_model import Page, Table, plain
from exogauge.studies.report.summary_content import DETAILS, summary_content
from exogauge.studies.report.summary_figure import units_of
from exogauge.studies.report.summary_page import SCALES, SummaryPage, summary_page
from exogauge.studies.report.summary_pdf import Sheet, lay_out
from exogauge.studies.report.summary_text import DETAIL, summary_text

Evaluated = Callable[..., dict[str, Any]]
A4 = (595.28, 841.89)  # [pt]
TAGS = re.compile(r"<style>.*?</style>|<[^>]*>", re.S)


@pytest.fixture(scope="module")
def made(whole: dict[str, Any]) -> SummaryPage:
    return summary_page(whole)


def printed(page: SummaryPage) -> str:
    """Text of the PDF, without any space: where lines break is the renderer's matter."""
    reader = PdfReader(io.BytesIO(page.pdf))
    assert len(reader.pages) == 1
    return re.sub(r"\s+", "", reader.pages[0].extract_text())


def shown(page: SummaryPage) -> str:
    import html

    return re.sub(r"\s+", "", html.unescape(TAGS.sub(" ", page.html.decode())))


def every_text(page: Page) -> Iterator[str]:
    yield from (page.title, page.kicker, page.footer)
    for block in (block for row in page.rows for block in row.blocks):
        yield from (block.title, *block.sentences, *block.points, *(word for fact in block.facts for word in fact))
        if block.table is not None:
            yield from (block.table.caption, *(column.title for column in block.table.columns))
            yield from (cell for cells in block.table.rows for cell in cells)


def tables(page: Page) -> dict[str, Table]:
    blocks = [block for row in page.rows for block in row.blocks]
    return {block.title: block.table for block in blocks if block.table is not None}


def test_it_is_one_sheet_of_a4(made: SummaryPage) -> None:
    (sheet,) = PdfReader(io.BytesIO(made.pdf)).pages
    assert made.fits
    assert [float(length) for length in sheet.mediabox[2:]] == pytest.approx(A4, abs=0.02)


def test_both_say_every_word_of_the_content(made: SummaryPage) -> None:
    in_pdf, in_html = printed(made), shown(made)
    for text in every_text(made.content):
        bare = re.sub(r"\s+", "", text)
        assert bare in in_pdf
        assert bare in in_html


def test_the_terminal_says_every_word_and_the_evidence_of_what_was_named(whole: dict[str, Any]) -> None:
    said = summary_text(whole)
    assert max(map(len, said.splitlines())) <= 140
    for text in every_text(summary_content(whole, DETAIL)):
        assert "".join(text.casefold().split()) in "".join(said.casefold().split())
    evidence = "j2: friction falls with speed."
    finding = {"title": "x at j2", "evidence": evidence, "motion": "Move it.", "planned": [{"file": "plan.csv"}]}
    finding |= {"also_possible": [{"title": "y at j2"}]}
    found = {"sentence": "x is missing.", "left_sentence": "", "findings": [finding]}
    text = summary_text(whole | {"discrepancy": found})
    assert f"X AT J2\n{evidence}\nThese data cannot tell it from y at j2. Move it. (plan.csv)" in text


def test_scope_and_label_stand_on_both(made: SummaryPage, whole: dict[str, Any]) -> None:
    for text in (whole["scope"]["sentence"], "SYNTHETIC DATA"):
        bare = re.sub(r"\s+", "", text)
        assert bare in printed(made)
        assert bare in shown(made)


def test_measured_data_carry_no_such_label(evaluated: Evaluated, record: Any) -> None:
    import dataclasses

    content = evaluated(name="Lumbar wear", record=dataclasses.replace(record, synthetic=()))
    made = summary_page(content)
    assert "SYNTHETIC" not in printed(made).upper()
    assert "synthetic" not in shown(made).lower()


def numbers(cell: str) -> list[tuple[float, float]]:
    """Each with half of its last digit."""
    found = re.findall(r"\d+(?:\.(\d+))?", cell)
    values = [float(each) for each in re.findall(r"\d+(?:\.\d+)?", cell)]
    return [(value, 0.5000001 * 10.0 ** -len(places)) for value, places in zip(values, found, strict=True)]


def test_every_number_of_the_support_table_is_in_the_results(made: SummaryPage, whole: dict[str, Any]) -> None:
    table = tables(made.content)["Supporting torque"]
    entries = {(f"{each['motion']}, {each['joint']}", each["device"]): each for each in whole["support"]}
    assert table.rows
    for place, device, *cells in table.rows:
        entry = entries[place, device]
        peaks = [entry["approaches"][approach]["peak"] for approach in ("A", "B", "paired")]
        truth = [number for peak in peaks for number in (peak["value"], peak["std"])]
        truth += [
            entry["approaches"]["band_model"]["peak"]["value"],
            entry["rmse_a"],
            entry["rmse_b"],
            entry["rmse_paired"],
        ]
        said = [pair for cell in cells for pair in numbers(cell)]
        assert len(said) == len(truth)
        for (value, half), true in zip(said, truth, strict=True):
            assert abs(value - abs(true)) <= half
        assert ("−" in cells[0]) == (peaks[0]["value"] < 0.0)


def test_every_number_of_the_stiffness_table_is_in_the_results(made: SummaryPage, whole: dict[str, Any]) -> None:
    table = tables(made.content)["Stiffness of the bands"]
    assert len(table.rows) == len({(each["device"], each["group"]) for each in whole["stiffness"]})
    for name, a, _, _, stated, truth in table.rows:
        device, group = name.split(", ")
        (entry, *_) = (
            e for e in whole["stiffness"] if (e["device"], e["group"], e["approach"]) == (device, group, "A")
        )
        (value, half), *_ = numbers(a)
        assert abs(value - entry["stiffness_n_per_m"]["value"]) <= half
        assert a.startswith("(") != entry["identifiable"]
        assert truth == ("–" if entry["truth_n_per_m"] is None else str(entry["truth_n_per_m"]))
        assert stated == ("–" if group == "B" else str(entry["truth_n_per_m"]))


def test_the_record_tells_what_was_stated_and_what_was_not(made: SummaryPage) -> None:
    text = "\n".join(every_text(made.content))
    assert "model SSL-2, serial 0042. Not stated: size, straps, pretension, garment." in text
    assert "date of recording 2026-03-01, robot cover none. Not stated: place, temperature, payload." in text
    assert "A_left 0.612 m" in text
    assert "worn in bend_normal ×2, twist_normal ×2" in text


def test_software_and_inputs_are_named(made: SummaryPage, whole: dict[str, Any]) -> None:
    text = printed(made)
    for package, version in whole["software"].items():
        assert f"({package}){version}" in text or f"{package}{version}" in text
    for each in whole["inputs"]:
        assert each["file"] + each["sha256"][:8] in text
    assert whole["configuration"]["inputs_sha256"] in text


def test_equal_results_give_equal_bytes_at_any_time(made: SummaryPage, content: dict[str, Any]) -> None:
    time.sleep(1.1)  # clocks in PDF count seconds
    again = summary_page(content)
    assert again.pdf == made.pdf
    assert again.html == made.html


@pytest.mark.slow
def test_letters_beyond_latin_print_and_what_the_font_lacks_is_said(content: dict[str, Any]) -> None:
    content["name"] = "Γιάννης τ ± 3° · Łódź Ж"
    content["robot"] = "로봇-1"
    made = summary_page(content)
    text = printed(made)
    assert "Γιάννηςτ±3°·ŁódźЖ" in text
    assert "U+B85C" in text
    assert "□□-1" in text
    assert "로봇-1" in shown(made)
    assert "U+B85C" not in shown(made)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["人型ロボット 1", "人形機器人 1"], ids=["japanese", "chinese"])
def test_east_asian_names_print_in_every_place(content: dict[str, Any], name: str) -> None:
    made = summary_page(renamed(content, name))
    text = printed(made)
    assert text.count(name.replace(" ", "")) > 3
    assert "□" not in text
    assert len(made.pdf) < 300_000  # of the font what is used, not all of its 6 MB


HOSTILE = (
    "<script>alert(1)</script>",
    ") Tj ET /JS (app.alert(1)) /URI",
    '"><img src=x onerror=alert(1)>',
    "{{ 7*7 }}$x_1$",
)


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_are_text(content: dict[str, Any], name: str) -> None:
    made = summary_page(renamed(content, name))
    html = made.html.decode()
    assert not re.search(r"<(script|img|iframe|object|link)\b", html)
    assert re.sub(r"\s+", "", name)[:20] in shown(made)
    assert re.sub(r"\s+", "", name)[:20] in printed(made)
    reader = PdfReader(io.BytesIO(made.pdf))
    assert not {"/AA", "/Annots"} & set(reader.pages[0].keys())
    assert not {"/Names", "/AcroForm", "/AA", "/URI"} & set(reader.trailer["/Root"].keys())
    assert "/S" not in reader.trailer["/Root"].get("/OpenAction", {})  # a place on the page, no action


def renamed(content: dict[str, Any], name: str) -> dict[str, Any]:
    """The study, the robot and a suit take this name, wherever it stands."""

    def walk(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: walk(item) for key, item in value.items()}
        if isinstance(value, list):
            return [walk(item) for item in value]
        return name if value == "Normal suit" else value

    return {**walk(content), "name": name, "robot": name}


def test_text_cannot_turn_round_what_follows_it(content: dict[str, Any]) -> None:
    content["name"] = "abc\u202edef\u2066"
    made = summary_page(content)
    assert made.content.title == "abc□def□"


def test_the_page_asks_nothing_of_the_world(made: SummaryPage) -> None:
    html = made.html.decode()
    assert not re.search(r"\b(src|href|srcset|action)=|url\(|@import", html)
    assert "default-src 'none'" in html
    assert html.count("<caption>") == html.count("<table>")


@pytest.mark.slow
def test_a_study_of_any_size_stays_on_one_sheet(content: dict[str, Any]) -> None:
    """Many suits, bands, logs, joints and findings, each with the longest name that there may be."""
    long = "W" * 199
    content["name"] = content["robot"] = long
    content["scope"]["devices"] = [f"{k}{long}" for k in range(40)]
    clauses = ["On and on it goes with no end in sight " * 100, "nothing is claimed beyond."]
    content["scope"] |= {"clauses": clauses, "sentence": "; ".join(clauses)}
    content["scope"]["not_said"] = [f"{k} {long} {long}" for k in range(30)]
    content["support"] = [{**each, "device": f"{k}{long}", "joint": long, "motion": long, "main": True}
                          for k in range(40) for each in content["support"]]  # fmt: skip
    content["stiffness"] = [{**each, "device": f"{k}{long}", "group": long}
                            for k in range(40) for each in content["stiffness"]]  # fmt: skip
    wear = content["configuration"]["devices"][0]
    bands = [{**band, "band": f"{k}{long}", "group": f"{k}{long}"} for k in range(60) for band in wear["bands"]]
    told = dict.fromkeys(wear["record"], long)
    content["configuration"]["devices"] = [{**wear, "device": f"{k}{long}", "bands": bands, "record": told}
                                           for k in range(40)]  # fmt: skip
    content["configuration"]["conditions"] = dict.fromkeys(content["configuration"]["conditions"], long)
    content["inputs"] = [{"file": f"logs/{k}{long}", "sha256": "0" * 64, "bytes": 1} for k in range(1000)]
    content["discrepancy"]["findings"] *= 10
    made = summary_page(content)
    assert made.fits
    assert "nothingisclaimedbeyond." in printed(made)


def test_what_is_left_out_is_counted(content: dict[str, Any]) -> None:
    content["inputs"] = [{"file": f"logs/{k}.csv", "sha256": "0" * 64, "bytes": 1} for k in range(100)]
    page = summary_content(content, DETAILS[-1])
    text = "\n".join(every_text(page))
    assert f"{100 - DETAILS[-1].files} more in results.json" in text


def test_without_a_wear_there_is_a_page_too(evaluated: Evaluated) -> None:
    made = summary_page(evaluated(support=None, stiffness=(), discrepancy=None))
    assert made.fits
    assert tables(made.content) == {}
    assert "RMSE" in shown(made)


@pytest.mark.slow
def test_a_page_that_fits_is_laid_out_once_and_of_several_the_largest_that_fits_is_taken(
    evaluated: Evaluated, content: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    laid = list[float]()

    def counted(page: Page, scale: float) -> Sheet:
        laid.append(scale)
        return lay_out(page, scale)

    monkeypatch.setattr(made_by, "lay_out", counted)
    summary_page(evaluated())
    assert laid == [SCALES[0]]
    laid.clear()
    page = summary_page(renamed(content, "a joint whose name is long " * 8))
    assert len(laid) > 1
    found = [lay_out(page.content, scale) for scale in SCALES]
    assert page.pdf == next((sheet for sheet in found if sheet.fits), found[-1]).bytes()
    for sheet in found:
        sheet.put_away()


def test_a_joint_that_slides_is_told_in_newtons(content: dict[str, Any]) -> None:
    entries = [{**each, "approaches": {name: {**effort, "peak": {**effort["peak"], "unit": "N"}}
                                       for name, effort in each["approaches"].items()}}
               for each in content["support"]]  # fmt: skip
    assert units_of(content["support"]) == "N·m"
    assert units_of(entries) == "N"
    assert units_of([content["support"][0], entries[1]]) == "N·m, N"


@pytest.mark.parametrize("most", range(40, 90))
def test_a_sentence_that_is_cut_ends_with_a_word(most: int) -> None:
    text = "Cannot judge: a knee stands above the noise; take zeros hanging; measure via points to 2 mm; state it."
    cut = plain(text, most)
    assert len(cut) <= most
    assert cut.endswith("…")
    assert text.startswith(kept := cut.removesuffix("…").rstrip())
    assert not text[len(kept)].isalnum(), "cut within a word"
    assert 2 * len(cut) > most


def test_what_has_no_words_is_cut_where_it_is_full() -> None:
    assert plain("left_shoulder_pitch_joint", 10) == "left_shou…"
