"""Effects are found by looking; what is not there is named."""

from types import SimpleNamespace

import pytest

from exogauge.effects.catalogue import all_effects, apart, choose, shaped_effects
from exogauge.errors import BadInput, ExogaugeError

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


def test_adding_one_file_is_all_it_takes(folder_of_effects):
    assert "creak" not in all_effects()
    (folder_of_effects.path / "creak.py").write_text(CREAK, encoding="utf-8")
    folder_of_effects.look_again()
    assert all_effects()["creak"].coefficient.name == "tau_x"
    assert "creak" not in shaped_effects()
    assert [effect.name for effect in choose(["viscous", "creak"])] == ["viscous", "creak"]


def test_a_file_without_an_effect_is_no_effect(folder_of_effects):
    before = set(all_effects()) | set(shaped_effects())
    (folder_of_effects.path / "notes.py").write_text('"""Nothing here."""\n', encoding="utf-8")
    folder_of_effects.look_again()
    assert set(all_effects()) | set(shaped_effects()) == before


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


def test_what_a_model_is_fitted_with_and_what_it_may_miss_are_told_apart():
    assert not set(all_effects()) & set(shaped_effects())
    with pytest.raises(BadInput):
        choose(["torque_ripple"])


@pytest.mark.parametrize("place", ["joint", "sensor"])
def test_two_effects_of_one_name_are_refused_with_both_files(place):
    """Wherever they sit: results tell effects apart by their names."""
    viscous = all_effects()["viscous"]
    other = SimpleNamespace(name="viscous", place=place)
    with pytest.raises(ExogaugeError, match=r"effects\.every_model and types both offer an effect named 'viscous'"):
        apart([viscous, other])
