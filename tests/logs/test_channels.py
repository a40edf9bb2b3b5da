"""Channel names."""

from __future__ import annotations

import pytest

from exogauge.errors import BadLog
from exogauge.logs.channels import parse_channel


@pytest.mark.parametrize(
    ("name", "kind", "subject", "axis", "unit"),
    [
        ("t", "t", "", "", "s"),
        ("q.torso_pitch", "q", "torso_pitch", "", "rad"),
        ("dq.left arm.1", "dq", "left arm.1", "", "rad/s"),
        ("tau.j", "tau", "j", "", "N·m"),
        ("acc.z", "acc", "", "z", "m/s²"),
        ("ft.l_foot.fz", "ft", "l_foot", "fz", "N"),
        ("ft.l.foot.mx", "ft", "l.foot", "mx", "N·m"),
        ("base.qw", "base", "", "qw", "1"),
    ],
)
def test_a_contract_name_says_kind_subject_axis_and_unit(
    name: str, kind: str, subject: str, axis: str, unit: str
) -> None:
    channel = parse_channel(name)
    assert (channel.kind, channel.subject, channel.axis, channel.unit) == (kind, subject, axis, unit)


@pytest.mark.parametrize(
    "name",
    ["", "q", "q.", "q. a", "acc.w", "ft.fx", "ft..fx", "base.w", "Q.a", "measured.q.a", "q.a\n", "q." + "a" * 300],
)
def test_any_other_name_is_refused_with_advice(name: str) -> None:
    with pytest.raises(BadLog) as caught:
        parse_channel(name, "a.csv")
    assert caught.value.faults[0].advice
    assert caught.value.faults[0].file == "a.csv"


@pytest.mark.parametrize(
    ("name", "meant"),
    [("time", "'t'"), ("pos.elbow", "'q.elbow'"), ("torque.elbow", "'tau.elbow'"), ("gyr.x", "'gyro.x|y|z'")],
)
def test_the_advice_names_what_was_probably_meant(name: str, meant: str) -> None:
    with pytest.raises(BadLog) as caught:
        parse_channel(name)
    assert meant in caught.value.faults[0].advice
