"""All effects there are: what every model has, and every module of this package that offers an `EFFECT`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

import exogauge.effects as package
from exogauge.effects.band import BandEffect
from exogauge.effects.effect import JointEffect
from exogauge.effects.every_model import EFFECTS
from exogauge.effects.places import BaseEffect, EncoderEffect, LinkEffect, PairEffect, SensorEffect, WholeSensorEffect
from exogauge.effects.shaped import MissingEffect, ShapedEffect
from exogauge.errors import BadInput, ExogaugeError, Fault


@cache
def all_effects() -> Mapping[str, JointEffect]:
    """Identifier -> effect that a model is fitted with: it has one `column`."""
    found: list[JointEffect] = [effect for effect in _offered() if hasattr(effect, "column")]
    return MappingProxyType({effect.name: effect for effect in sorted(found, key=lambda each: each.name)})


@cache
def shaped_effects() -> Mapping[str, ShapedEffect]:
    """Identifier -> effect of a joint that may be missing, found likewise: adding one file is all it takes."""
    found: list[ShapedEffect] = _placed("joint")
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def pair_effects() -> Mapping[str, PairEffect]:
    """Identifier -> effect of two neighbouring joints."""
    found: list[PairEffect] = _placed("pair")
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def encoder_effects() -> Mapping[str, EncoderEffect]:
    """Identifier -> effect of what a joint's encoder reads."""
    found: list[EncoderEffect] = _placed("encoder")
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def sensor_effects() -> Mapping[str, SensorEffect]:
    """Identifier -> effect of a force/torque sensor."""
    found: list[SensorEffect] = _placed("sensor")
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def whole_sensor_effects() -> Mapping[str, WholeSensorEffect]:
    """Identifier -> effect of a force/torque sensor that all its components have."""
    found: list[WholeSensorEffect] = _placed("whole_sensor")
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def base_effects() -> Mapping[str, BaseEffect]:
    """File -> effect of the base and its IMU. Two may have one identifier: a base leans if it is fixed, its IMU if it
    floats; the robot decides which one applies."""
    found: list[BaseEffect] = _placed("base")
    return MappingProxyType({type(effect).__module__.rpartition(".")[2]: effect for effect in found})


@cache
def band_effects() -> Mapping[str, BandEffect]:
    """Identifier -> effect of a band that the model of the wear may miss (it has `added_tension`), found likewise."""
    found: list[BandEffect] = [effect for effect in _offered() if hasattr(effect, "added_tension")]
    return MappingProxyType({effect.name: effect for effect in found})


@cache
def link_effects() -> Mapping[str, LinkEffect]:
    """Identifier -> effect of a link that is not there from the first log on."""
    found: list[LinkEffect] = _placed("link")
    return MappingProxyType({effect.name: effect for effect in found})


def missing_effects() -> tuple[
    ShapedEffect | PairEffect | EncoderEffect | SensorEffect | WholeSensorEffect | BaseEffect | LinkEffect, ...
]:
    """Every effect of joints, sensors, links and the base that a model may miss."""
    of_sensors = (sensor_effects(), whole_sensor_effects())
    every = (shaped_effects(), pair_effects(), encoder_effects(), *of_sensors, link_effects(), base_effects())
    return tuple(effect for placed in every for effect in placed.values())


def every_effect() -> tuple[JointEffect | MissingEffect | BandEffect, ...]:
    """All of the catalogue: those that a model has, those that it may miss, those of bands."""
    return (*all_effects().values(), *missing_effects(), *band_effects().values())


def choose(names: Sequence[str]) -> tuple[JointEffect, ...]:
    """The named effects, in the order asked for."""
    known = all_effects()
    unknown = [name for name in names if name not in known]
    if unknown:
        advice = f"Known effects: {', '.join(sorted(known))}."
        raise BadInput([Fault(f"there is no effect {name!r}", "unknown_effect", advice) for name in unknown])
    return tuple(known[name] for name in names)


def _placed(place: str) -> list[Any]:
    return [effect for effect in _offered() if getattr(effect, "place", "") == place]


def _offered() -> list[Any]:
    modules = (importlib.import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__))
    return apart([*EFFECTS, *(module.EFFECT for module in modules if hasattr(module, "EFFECT"))])


def apart(found: list[Any]) -> list[Any]:
    """Raises ExogaugeError where two have one name: one would hide the other. Effects of the base may."""
    known = dict[str, Any]()
    for effect in found:
        other = known.setdefault(effect.name, effect)
        if other is not effect and {getattr(each, "place", "") for each in (other, effect)} != {"base"}:
            files = " and ".join(type(each).__module__ for each in (other, effect))
            raise ExogaugeError(f"{files} both offer an effect named {effect.name!r}: give one of them another name")
    return found
