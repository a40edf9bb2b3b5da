"""Stiffness and natural length of the bands as results.json and stiffness.csv hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from exogauge.devices.result import StiffnessResult
from exogauge.studies.csv_table import csv_table
from exogauge.studies.results.support_results import number
from exogauge.studies.words.finding_sentences import band_note


def stiffness_entries(found: Sequence[StiffnessResult]) -> list[dict[str, Any]]:
    """`stiffness[]`: one entry per device, approach and band."""
    return [
        {
            "device": each.device,
            "approach": each.approach,
            "band": band.band,
            "group": band.group,
            "stiffness_n_per_m": number(band.stiffness),
            "natural_length_m": number(band.natural_length),
            "interval_95": {
                "stiffness_n_per_m": list(band.stiffness_interval),
                "natural_length_m": list(band.natural_length_interval),
            },
            "truth_n_per_m": band.true_stiffness,
            "error_percent": band.error_percent,
            "identifiable": bool(band.identifiable),
            "length_identifiable": bool(band.length_identifiable),
            "note": band_note(band),
        }
        for each in found
        for band in each.bands
    ]


def stiffness_details(found: Sequence[StiffnessResult]) -> list[dict[str, Any]]:
    """`stiffness_details[]`: one entry per device and approach; rms [N·m] by joint."""
    return [
        {
            "device": each.device,
            "approach": each.approach,
            "parameters": list(each.parameters),
            "correlation": each.correlation,
            "rms": dict(each.rms),
            "samples": each.samples,
            "notes": list(each.notes),
        }
        for each in found
    ]


def stiffness_table(found: Sequence[StiffnessResult]) -> bytes:
    """stiffness.csv: one row per device, approach and band."""
    columns = (
        *("device", "approach", "band", "group", "stiffness_n_per_m", "stiffness_std", "stiffness_low"),
        *("stiffness_high", "natural_length_m", "natural_length_std", "natural_length_low", "natural_length_high"),
        *("truth_n_per_m", "error_percent", "identifiable", "length_identifiable", "note"),
    )
    rows = (
        [
            *(each.device, each.approach, band.band, band.group),
            *(band.stiffness.value, band.stiffness.std, *band.stiffness_interval),
            *(band.natural_length.value, band.natural_length.std, *band.natural_length_interval),
            *(band.true_stiffness, band.error_percent, bool(band.identifiable), bool(band.length_identifiable)),
            band_note(band),
        ]
        for each in found
        for band in each.bands
    )
    return csv_table(columns, rows)
