"""What bands do to joints: MuJoCo's springs, virtual work, energy, and the sign a wearer feels."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.effects.band import WireMotion
from exogauge.effects.band_laws import all_laws
from exogauge.errors import BadInput

STIFFNESS = (150.0, 320.0, 80.0)


def postures(tree, samples=31, seed=0):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (samples, len(tree.joints)))


def motion(tree, samples=400):
    """A smooth motion of every joint at 100 Hz."""
    rng, time = np.random.default_rng(4), np.arange(samples) / 100.0
    rate, start = rng.uniform(0.2, 0.9, len(tree.joints)), rng.uniform(0.0, 6.0, len(tree.joints))
    return time, 0.8 * np.sin(2 * np.pi * rate * time[:, None] + start)


@pytest.fixture
def worn(pair, bands):
    """The bands with a stiffness, each slack in about half of the postures."""
    middle = np.median(Routing(pair.tree, bands).lengths(postures(pair.tree)), axis=0) + 1e-3
    return tuple(
        replace(band, stiffness=k, natural_length=float(l_0))
        for band, k, l_0 in zip(bands, STIFFNESS, middle, strict=True)
    )


def test_torque_is_the_generalised_force_of_mujocos_springs(pair, worn):
    q = postures(pair.tree)
    found = band_torque(Routing(pair.tree, worn), worn, q, np.arange(len(q)) / 100.0)
    model = pair.mjcf(worn)
    data = mujoco.MjData(model)
    places = [model.joint(name).qposadr[0] for name in pair.joints]
    columns = [model.joint(name).dofadr[0] for name in Routing(pair.tree, worn).joints]
    for row, torque in zip(q, found.torque, strict=True):
        data.qpos[places] = row
        mujoco.mj_forward(model, data)
        assert np.abs(data.qfrc_spring[columns] - torque).max() < 1e-8
        assert np.abs(np.delete(data.qfrc_spring, columns)).max(initial=0.0) < 1e-12
    assert 0.2 < np.mean(found.tension > 0.0) < 0.8


def test_torque_is_the_virtual_work_of_the_pulls_at_the_via_points(pair, worn):
    """Every segment pulls its two ends together: joint torques by pinocchio's Jacobians of the points."""
    model, q = pair.model, postures(pair.tree)
    data = model.createData()
    found = band_torque(Routing(pair.tree, worn), worn, q, np.arange(len(q)) / 100.0)
    place = [model.joints[model.getJointId(name)] for name in pair.joints]
    of_band = [place[pair.joints.index(name)].idx_v for name in Routing(pair.tree, worn).joints]
    for t, row in enumerate(q):
        full = pin.neutral(model)
        for joint, value in zip(place, row, strict=True):
            full[joint.idx_q] = value
        pin.computeJointJacobians(model, data, full)
        pin.updateFramePlacements(model, data)
        work = np.zeros(model.nv)
        for band, tension in zip(worn, found.tension[t], strict=True):
            p, jacobians = zip(*(point(model, data, via) for via in band.via_points), strict=True)
            for a in range(len(p) - 1):
                pull = tension * (p[a + 1] - p[a]) / np.linalg.norm(p[a + 1] - p[a])
                work += jacobians[a].T @ pull - jacobians[a + 1].T @ pull
        assert np.abs(work[of_band] - found.torque[t]).max() < 1e-10
        assert np.abs(np.delete(work, of_band)).max(initial=0.0) < 1e-10


def point(model, data, via):
    frame = model.getFrameId(via.link)
    T, J = data.oMf[frame], pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    x = T.rotation @ np.array(via.xyz)
    return T.translation + x, J[:3] - pin.skew(x) @ J[3:]


def energy(routing, bands, q):
    """(T,) [J] held by springs."""
    k, l_0 = np.array([(band.stiffness, band.natural_length) for band in bands]).T
    return 0.5 * np.maximum(routing.lengths(q) - l_0, 0.0) ** 2 @ k


def test_torque_is_the_falling_slope_of_the_energy(pair, worn):
    routing, q, step = Routing(pair.tree, worn), postures(pair.tree), 1e-6
    torque = band_torque(routing, worn, q, np.arange(len(q)) / 100.0).torque
    for d, column in enumerate(routing.columns):
        ahead, behind = q.copy(), q.copy()
        ahead[:, column] += step
        behind[:, column] -= step
        slope = (energy(routing, worn, ahead) - energy(routing, worn, behind)) / (2 * step)
        assert np.abs(torque[:, d] + slope).max() < 1e-5


def test_a_band_over_the_back_raises_a_trunk_that_bends_forward(talos, suit):
    worn = [replace(band, stiffness=200.0, natural_length=1.06) for band in suit[::2]]
    routing, q = Routing(talos, worn), np.zeros((21, len(talos.joints)))
    q[:, talos.joints.index("torso_2_joint")] = bend = np.linspace(-0.3, 0.7, 21)  # forward is positive
    found = band_torque(routing, worn, q, np.arange(21) / 10.0)
    torque = found.torque[:, routing.joints.index("torso_2_joint")]
    taut = found.tension.min(axis=1) > 0.0
    assert taut[bend > 0.2].all()
    assert not taut[bend < -0.1].any()
    assert np.all(torque[taut] < 0.0)
    assert not torque[~taut].any()
    assert torque[-1] < -2.0
    assert abs(found.torque[-1, routing.joints.index("torso_1_joint")]) < 1e-10  # both sides alike: no yaw


def test_slack_bands_do_nothing(pair, worn):
    slack = tuple(replace(band, natural_length=99.0) for band in worn)
    q = postures(pair.tree)
    found = band_torque(Routing(pair.tree, worn), slack, q, np.arange(len(q)) / 100.0)
    assert not found.torque.any()
    assert not found.tension.any()


@pytest.mark.parametrize("name", list(all_laws()))
def test_power_into_the_bands_is_what_the_joints_lose(name, pair, worn):
    """∫ τ·dq = -∫ T·dl, whatever the law: the torque neither adds energy nor drops any. By the trapezoidal rule."""
    law = all_laws()[name]
    chosen = tuple(replace(b, law=name, law_values={v.name: v.stated.typical for v in law.values}) for b in worn)
    routing = Routing(pair.tree, chosen)
    time, q = motion(pair.tree, 3000)
    q = q * np.sin(np.pi * time / time[-1])[:, None] ** 2  # from rest to rest
    found = band_torque(routing, chosen, q, time)
    work = integral(found.torque, q[:, routing.columns])
    if law.per_segment:
        pulls = [law_tension(law, routing, w, band, q, time) for w, band in enumerate(chosen)]
        into = sum(integral(tension, length) for length, tension in pulls)
        largest = np.stack([tension.max(axis=1) for _, tension in pulls], axis=1)
        np.testing.assert_allclose(found.tension, largest, atol=1e-9)
    else:
        into = integral(found.tension, found.length)
    assert abs(work + into) < 2e-3 * np.abs(np.diff(found.length, axis=0) * found.tension[1:]).sum()


def law_tension(law, routing, w, band, q, time):
    segments = routing.segments(q, w)
    length = segments.length.sum(axis=1)
    seen = WireMotion(time, length, np.gradient(length, time), segments.length, segments.wrap)
    return segments.length, law.tension(seen, band.stiffness, band.natural_length, band.law_values)


def integral(force, way):
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(way, axis=0)))


@pytest.mark.parametrize("name", list(all_laws()))
def test_with_its_own_values_at_zero_every_law_gives_the_linear_torque(name, pair, worn):
    values = {v.name: 0.0 if v.stated.low == 0.0 else v.stated.typical for v in all_laws()[name].values}
    time, q = motion(pair.tree)
    routing = Routing(pair.tree, worn)
    linear = band_torque(routing, worn, q, time)
    other = band_torque(routing, tuple(replace(b, law=name, law_values=values) for b in worn), q, time)
    assert np.abs(linear.torque - other.torque).max() < 1e-9
    assert np.abs(linear.tension - other.tension).max() < 1e-9


def test_chunks_do_not_show(talos, suit, monkeypatch):
    names = list(all_laws())
    worn = tuple(
        replace(band, stiffness=200.0, natural_length=0.9, law=name,
                law_values={v.name: v.stated.typical for v in all_laws()[name].values})
        for band, name in zip(suit, ["linear", "via_friction", "maxwell", "kelvin_voigt"], strict=True)
    )  # fmt: skip
    assert set(names) >= {band.law for band in worn}
    routing = Routing(talos, worn)
    time, q = motion(talos, 300)
    whole = band_torque(routing, worn, q, time)
    monkeypatch.setattr("exogauge.devices.torque.CHUNK", 70)
    parts = band_torque(routing, worn, q, time)
    assert np.abs(whole.torque - parts.torque).max() < 1e-10


@pytest.mark.parametrize("samples", [0, 1])
def test_a_log_of_one_sample_or_none_has_no_rate_but_an_answer(pair, worn, samples):
    chosen = tuple(
        replace(band, law=name, law_values={v.name: v.stated.typical for v in all_laws()[name].values})
        for band, name in zip(worn, ["kelvin_voigt", "maxwell", "via_friction"], strict=True)
    )
    routing = Routing(pair.tree, chosen)
    found = band_torque(routing, chosen, postures(pair.tree, samples), np.zeros(samples))
    assert found.torque.shape == (samples, len(routing.columns))
    assert np.isfinite(found.torque).all()


def test_a_missing_stiffness_is_asked_for_by_the_bands_name(pair, bands, worn):
    routing, q = Routing(pair.tree, bands), postures(pair.tree, 3)
    with pytest.raises(BadInput) as caught:
        band_torque(routing, (worn[0], bands[1], replace(worn[2], natural_length=None)), q, np.arange(3.0))
    assert [(fault.rule, fault.column) for fault in caught.value.faults] == [
        ("value_missing", "stiffness"), ("value_missing", "natural_length"), ("value_missing", "natural_length"),
    ]  # fmt: skip
    assert "'over'" in caught.value.faults[0].detail


def test_bands_of_another_device_are_refused(pair, worn):
    stranger = Band("stranger", "s", (ViaPoint("arm", (0, 0, 0)), ViaPoint("head", (0, 0, 0))), 100.0, 0.1)
    with pytest.raises(ValueError, match="not those of the routing"):
        band_torque(Routing(pair.tree, worn), (stranger,), postures(pair.tree, 2), np.arange(2.0))
