"""docs/effects.md says what the code says, and its example is one that works."""

import re

import numpy as np
import pytest
from tests.effects.tables import DOCUMENT, OF_DEVICES, tables, with_tables

from exogauge.effects.catalogue import missing_effects, shaped_effects

MOST_WORDS = 1500  # beside the tables: what is read in ten minutes


@pytest.mark.parametrize("document", [DOCUMENT, OF_DEVICES], ids=lambda path: path.name)
def test_the_tables_of_the_documents_are_those_of_the_catalogue(document):
    written = document.read_text(encoding="utf-8")
    assert written == with_tables(written), "make tables"


def test_every_place_has_its_table():
    marked, of_devices = (
        set(re.findall(r"<!-- table: (\w+) -->", each.read_text(encoding="utf-8"))) for each in (DOCUMENT, OF_DEVICES)
    )
    assert marked | of_devices == tables().keys()
    assert {each.place for each in missing_effects()} | {"model", "band"} == marked


def test_the_document_stays_short():
    text = re.sub(r"<!-- table.*?<!-- end -->", "", DOCUMENT.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(text.split()) <= MOST_WORDS


@pytest.fixture
def example(folder_of_effects, docs_section):
    """The effect of the worked example, in the catalogue as long as the test runs."""
    lines = docs_section("An effect of your own, in one file")
    start = lines.index("```python")
    source = lines[start + 1 : lines.index("```", start)]
    (folder_of_effects.path / "cogging.py").write_text("\n".join(source) + "\n", encoding="utf-8")
    folder_of_effects.look_again()
    return shaped_effects()["cogging"]


def test_the_examples_file_is_all_that_is_needed_to_name_the_effect(example, swing, seen, ranking):
    joint = swing("rich", 0)
    cogging = 0.3 * np.sin(30.2 * joint.q + 0.7) + 0.25 * np.sin(60.4 * joint.q - 1.0)
    first, second = ranking(seen(joint, joint.load + 1.5 * joint.v + 1.2 * joint.direction + cogging))[:2]
    assert (first.effect, second.effect) == ("cogging", "torque_ripple")  # which knows one harmonic
    assert first.evidence > 1.2 * second.evidence


def test_the_examples_columns_are_what_its_text_says(example, swing, seen):
    joint = swing("slow", 0)
    columns = example.columns(seen(joint, joint.load), (30.0,))
    waves = [np.sin(30.0 * joint.q), np.cos(30.0 * joint.q), np.sin(60.0 * joint.q), np.cos(60.0 * joint.q)]
    np.testing.assert_allclose(columns, np.stack(waves, axis=1))
