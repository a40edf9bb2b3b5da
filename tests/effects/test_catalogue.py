"""Effects are found by looking; what is not there is named."""

import sys

import pytest

import exogauge.effects as package
from exogauge.effects.catalogue import all_effects, choose
from exogauge.errors import BadInput

CREAK = '''
"""Extra friction at the start of motion."""
import numpy as np
from exogauge.effects.effect import Quantity

class Creak:
    name = "creak"
    sentence = "Friction is larger at the start of motion."
    coefficient = Quantity("tau_x", "N·m", low=0.0)

    def column(self, signals):
        return -signals.direction * np.exp(-np.abs(signals.velocity) / 0.1)

EFFECT = Creak()
'''


@pytest.fixture
def folder_of_effects(tmp_path, monkeypatch):
    """A folder that counts as part of the package while a test runs."""
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    all_effects.cache_clear()
    yield tmp_path
    all_effects.cache_clear()
    for path in tmp_path.glob("*.py"):
        sys.modules.pop(f"{package.__name__}.{path.stem}", None)
        vars(package).pop(path.stem, None)


def test_adding_one_file_is_all_it_takes(folder_of_effects):
    assert "creak" not in all_effects()
    (folder_of_effects / "creak.py").write_text(CREAK, encoding="utf-8")
    all_effects.cache_clear()
    assert all_effects()["creak"].coefficient.name == "tau_x"
    assert [effect.name for effect in choose(["viscous", "creak"])] == ["viscous", "creak"]


def test_a_file_without_an_effect_is_no_effect(folder_of_effects):
    before = set(all_effects())
    (folder_of_effects / "notes.py").write_text('"""Nothing here."""\n', encoding="utf-8")
    all_effects.cache_clear()
    assert set(all_effects()) == before


def test_effects_come_in_the_order_asked_for():
    names = ["rotor_inertia", "viscous", "motor_gain"]
    assert [effect.name for effect in choose(names)] == names
    assert choose([]) == ()


def test_an_unknown_effect_is_named_and_the_known_ones_offered():
    with pytest.raises(BadInput) as caught:
        choose(["viscous", "viscuos", "magic"])
    assert [fault.rule for fault in caught.value.faults] == ["unknown_effect", "unknown_effect"]
    assert "'viscuos'" in caught.value.faults[0].detail
    assert "'magic'" in caught.value.faults[1].detail
    assert "viscous" in caught.value.faults[0].advice


def test_nobody_can_change_the_catalogue_in_passing():
    with pytest.raises(TypeError):
        all_effects()["magic"] = object()
