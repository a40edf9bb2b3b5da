"""A folder that counts as part of the catalogue, and one swinging joint on which effects can be hidden and found."""

import itertools
import sys
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.signal import butter, sosfiltfilt

import exogauge.effects as package
from exogauge.effects.band_laws import all_laws
from exogauge.effects.catalogue import all_effects, band_effects, shaped_effects
from exogauge.effects.shaped import AxisSignals

RATE = 100.0  # [Hz]
DURATION = 90.0  # [s]
INERTIA = 0.8  # [kg·m²]
NOISE = 0.3  # [N·m] of each sample of the drive
SAMPLES_THAT_COUNT_AS_ONE = 8  # after the low-pass
BORDER = 0.98  # of the low-passed direction: below, the joint turns or rests
DOCS = Path(__file__).parents[2] / "docs"
SAID = (DOCS / "effects.md", DOCS / "measured" / "effects-on-one-joint.md")


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


designed = cache(partial(butter, fs=RATE, output="sos"))


def low_pass(values, cutoff_hz=10.0, order=4):
    return sosfiltfilt(designed(order, cutoff_hz), values, axis=0)


def waves(rng, phase, frequencies, size):
    each = [np.sin(2.0 * np.pi * f * phase + rng.uniform(0.0, 2.0 * np.pi)) for f in frequencies]
    return size / np.sqrt(len(each)) * np.sum(each, axis=0)


@pytest.fixture
def folder_of_effects(tmp_path, monkeypatch):
    """A folder that counts as part of the package while a test runs."""

    def forget():
        all_effects.cache_clear()
        shaped_effects.cache_clear()
        band_effects.cache_clear()
        all_laws.cache_clear()

    before = set(sys.modules)
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    forget()
    yield SimpleNamespace(path=tmp_path, look_again=forget)
    forget()
    for path in tmp_path.glob("*.py"):
        if (name := f"{package.__name__}.{path.stem}") not in before:
            sys.modules.pop(name, None)
            vars(package).pop(path.stem, None)


@pytest.fixture
def docs_section():
    """heading -> the lines below it in either document on effects, up to the next of its rank."""

    def read(heading):
        text = "\n".join(each.read_text(encoding="utf-8") for each in SAID)
        return text.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0].splitlines()

    return read


@pytest.fixture
def docs_table(docs_section):
    """heading -> first row and the others of the table below it, as cells without their backticks at both ends."""

    def read(heading):
        lines = [line for line in docs_section(heading) if line.startswith("|")]
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
        return rows[0], [[row[0].strip("`"), *row[1:]] for row in rows[2:]]

    return read


@pytest.fixture
def swing():
    """(motion, seed) -> a joint of 0.8 kg·m² that carries a link and, by it, another one that swings by itself.

    rich: fast and slow, short rests, loads of both signs. slow: never faster than about 0.3 rad/s. one speed: to and
    fro at constant speed. one load: near 1 rad, where gravity always pulls the same way.
    """

    def made(motion, seed=0):
        rng = np.random.default_rng(seed)
        t = np.arange(int(DURATION * RATE)) / RATE
        phase = np.cumsum(1.9 * (0.5 + 0.5 * np.sin(2.0 * np.pi * t / 23.0 + rng.uniform(0.0, 6.0))) ** 1.5) / RATE
        if motion == "rich":
            q = waves(rng, phase, [0.11, 0.23, 0.41, 0.67], 1.4) - 0.2
            other = waves(rng, phase, [0.13, 0.29, 0.37], 1.6) + 0.5
        elif motion == "slow":
            q, other = waves(rng, t, [0.03, 0.05, 0.08], 0.8), waves(rng, t, [0.04, 0.06], 1.6) + 0.5
        elif motion == "one speed":
            q = 0.9 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * 0.13 * t + rng.uniform(0.0, 6.0))) - 0.2
            other = waves(rng, t, [0.13, 0.29, 0.37], 1.6) + 0.5
        else:
            q, other = waves(rng, phase, [0.06, 0.11, 0.23], 0.4) + 1.0, waves(rng, phase, [0.05, 0.09], 0.2)
        q, other = low_pass(q, 4.0, 3), low_pass(other, 4.0, 3)
        v = np.gradient(q, 1.0 / RATE)
        a = np.gradient(v, 1.0 / RATE)
        load = INERTIA * a + 12.0 * np.sin(q) + 8.0 * np.sin(q + other)
        direction = np.where(np.abs(v) < 2e-3, 0.0, np.sign(v))
        return SimpleNamespace(
            t=t, q=q, other=other, v=v, a=a, direction=direction, load=load, noise=NOISE * rng.normal(size=len(t))
        )

    return made


@pytest.fixture
def seen():
    """(joint, drive, temperature) -> what an effect sees of it; the drive gets its noise here."""

    def made(joint, drive, temperature=None):
        return AxisSignals(
            joint.t, joint.q, joint.v, joint.a, joint.direction, drive + joint.noise, joint.load, temperature,
            rms(joint.v), rms(joint.load), float(np.ptp(joint.q)),
        )  # fmt: skip

    return made


def beyond_the_plain(signals):
    """A function that low-passes columns and takes out, in steady motion, what body, motor and plain friction explain.

    It returns what is left, and what there was without its mean.
    """
    steady = np.abs(low_pass(signals.direction)) > BORDER
    steady &= (signals.time > 1.0) & (signals.time < signals.time[-1] - 1.0)
    plain = [
        signals.velocity, signals.direction, np.ones_like(signals.time), signals.drive,
        np.sin(signals.position), np.cos(signals.position), signals.acceleration,
    ]  # fmt: skip
    Q, _ = np.linalg.qr(low_pass(np.stack(plain, axis=1))[steady])

    def left(values):
        kept = low_pass(values)[steady]
        return kept - Q @ (Q.T @ kept), kept - kept.mean(axis=0)

    return left


def grid(effect):
    return list(itertools.product(*(one.grid for one in effect.shapes)))


@pytest.fixture
def ranking():
    """signals -> effects in order of evidence, each with its evidence, shape and coefficients.

    Each is fitted within its ranges, at every point of its grid, to what the plain model leaves. Evidence: gain in BIC.
    among: names; all of the catalogue where none are given.
    """

    def made(signals, among=()):
        left = beyond_the_plain(signals)
        gap, _ = left(signals.load - signals.drive)
        n = len(gap) / SAMPLES_THAT_COUNT_AS_ONE
        best = {}
        for effect in shaped_effects().values():
            if (among and effect.name not in among) or not effect.applies(signals):
                continue
            for shape in grid(effect):
                columns, _ = left(effect.columns(signals, shape))
                size = np.linalg.norm(columns, axis=0) + 1e-12
                ranges = ([each.low for each in effect.coefficients], [each.high for each in effect.coefficients])
                theta = lsq_linear(columns / size, gap, bounds=[np.array(end) * size for end in ranges]).x
                rest = gap - columns / size @ theta
                evidence = n * np.log(gap @ gap / (rest @ rest)) - (len(theta) + len(shape)) * np.log(n)
                if effect.name not in best or evidence > best[effect.name].evidence:
                    best[effect.name] = SimpleNamespace(
                        effect=effect.name, evidence=evidence, shape=shape, coefficients=theta / size
                    )
        return sorted(best.values(), key=lambda each: -each.evidence)

    return made


@pytest.fixture
def likeness():
    """signals -> (least share of each effect that the plain model takes, share of one that another one leaves)."""

    def made(signals, among):
        left = beyond_the_plain(signals)
        effects = {name: effect for name, effect in shaped_effects().items() if name in among}
        effects = {name: effect for name, effect in effects.items() if effect.applies(signals)}
        both = {name: [left(each.columns(signals, shape)) for shape in grid(each)] for name, each in effects.items()}
        taken = {
            name: min(1.0 - (np.linalg.norm(rest) / np.linalg.norm(whole)) ** 2 for rest, whole in parts)
            for name, parts in both.items()
        }
        leaves = {}
        for one, other in itertools.permutations(effects, 2):
            y = both[one][len(both[one]) // 2][0][:, 0]
            rests = [y - B @ np.linalg.lstsq(B, y, rcond=None)[0] for B, _ in both[other]]
            leaves[one, other] = min(float(rest @ rest) for rest in rests) / float(y @ y)
        return taken, leaves

    return made
