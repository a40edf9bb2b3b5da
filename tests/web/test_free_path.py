"""Files of one name that are dropped one after the other are both kept."""

from __future__ import annotations

from tests.web import page_code


def test_a_file_under_a_name_that_is_taken_gets_the_next_one() -> None:
    cases = {
        ("logs/run.csv", ()): "logs/run.csv",
        ("logs/run.csv", ("run.csv",)): "logs/run.csv",
        ("logs/run.csv", ("logs/RUN.csv",)): "logs/run-2.csv",
        ("logs/run.csv.gz", ("logs/run.csv.gz", "logs/run-2.csv.gz")): "logs/run-3.csv.gz",
        ("a.b/run", ("a.b/run",)): "a.b/run-2",
    }
    calls = [("freePath", (path, [*taken])) for path, taken in cases]
    assert page_code.by_the_page("parts/freePath.ts", calls) == [*cases.values()]
