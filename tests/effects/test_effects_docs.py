"""docs/effects.md says what the code says, and its example is one that works."""

import numpy as np
import pytest

from exogauge.effects.catalogue import all_effects, base_effects, pair_effects, sensor_effects, shaped_effects


def test_every_effect_is_in_the_docs_with_its_own_words(docs_table):
    _, rows = docs_table("What a model may miss")
    documented = {row[0]: row[1:] for row in rows}
    assert documented.keys() == shaped_effects().keys()
    for name, effect in shaped_effects().items():
        sentence, needs, confused = documented[name]
        assert sentence == effect.sentence
        assert needs == effect.needs
        assert all(f"`{other}`" in confused for other in effect.confounds)


@pytest.mark.parametrize(
    ("heading", "effects"),
    [
        ("What two joints may do together", pair_effects()),
        ("What a sensor inside the robot may do", sensor_effects()),
        ("What the base and its IMU may do", base_effects()),
    ],
)
def test_every_effect_of_pairs_sensors_and_the_base_is_in_the_docs_with_its_own_words(docs_table, heading, effects):
    _, rows = docs_table(heading)
    documented = {row[0]: row[1:] for row in rows}
    assert documented.keys() == effects.keys()
    for name, effect in effects.items():
        sentence, needs, confused = documented[name]
        assert sentence == effect.sentence
        assert needs == effect.needs
        assert [each.strip().strip("`") for each in confused.split(",")] == list(effect.confounds)


def test_every_effect_that_a_model_has_is_in_the_docs(docs_table):
    _, rows = docs_table("What every model has")
    assert {row[0]: row[1] for row in rows} == {name: effect.sentence for name, effect in all_effects().items()}


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
