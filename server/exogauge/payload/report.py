"""report.html, and the same on one sheet of A4 (summary.html, summary.pdf), of a payload's results."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exogauge.payload.schema import MissingResults, PayloadResults, Value
from exogauge.payload.tables import CHANNELS, STATES, WAYS
from exogauge.studies.report.page_model import Block, Column, Page, Row, Table, plain
from exogauge.studies.report.summary_content import LABEL
from exogauge.studies.report.summary_page import SCALES, render_html
from exogauge.studies.report.summary_pdf import Sheet, lay_out
from exogauge.studies.results.configuration import says_synthetic
from exogauge.studies.words.rounding import between, significant, with_std

METHODS = ("ls", "tls", "gtls")
NAMES = {
    "m": "mass m", "mx": "m c_x", "my": "m c_y", "mz": "m c_z", "cx": "centre c_x", "cy": "centre c_y",
    "cz": "centre c_z", "fx0": "zero f_x", "fy0": "zero f_y", "fz0": "zero f_z", "mx0": "zero τ_x", "my0": "zero τ_y",
    "mz0": "zero τ_z", "U": "inclination U", "V": "inclination V",
}  # fmt: skip
MOST_LOGS, MOST_CONTACTS, MOST_WARNINGS = 4, 6, 5  # on the sheet; the report has all
LONGEST = 200  # characters of a warning on the sheet


def write_report(found: PayloadResults, out: Path) -> Path:
    """report.html, summary.html and summary.pdf in `out`."""
    report = out / "report.html"
    report.write_text(render_html(_page(found, whole=True), 1.0, "payload"), encoding="utf-8")
    page = _page(found, whole=False)
    tried = list[Sheet]()
    while not (tried and tried[-1].fits) and len(tried) < len(SCALES):
        tried.append(lay_out(page, SCALES[len(tried)]))
    (out / "summary.pdf").write_bytes(tried[-1].bytes())
    (out / "summary.html").write_text(render_html(page, tried[-1].scale), encoding="utf-8")
    for each in tried:
        each.put_away()
    return report


def _page(found: PayloadResults, *, whole: bool) -> Page:
    rows = [Row((_head(found),)), Row((_values(found, whole=whole),))]
    if found.tests:
        rows.append(Row((_left(found, whole=whole),)))
        rows += [Row((_left_by_axis(found),))] if whole else []
    if found.contacts:
        rows.append(Row((_contacts(found, whole=whole),)))
    rows.append(Row((_missing(found.missing, whole=whole),)))
    rows.append(Row((_facts(found), _warnings(found, whole=whole)), (0.5, 0.5)))
    return Page(
        title=plain(found.name, 90), kicker="exogauge · payload behind a wrist force/torque sensor",
        label=LABEL if says_synthetic(found.name) else "", rows=tuple(rows),
        footer=f"exogauge {found.exogauge}. ± is one standard deviation. All numbers with all digits: results.json.",
    )  # fmt: skip


def _head(found: PayloadResults) -> Block:
    values = {each.name: each for each in (found.dynamic or found.static).values}  # type: ignore[union-attr]
    said = [f"{_uncertain(values['m'])} kg. Vectors and moments in the {plain(found.frame, 90)}."]
    if found.mass_error_kg is not None:
        value, std = with_std(1e3 * found.mass_error_kg, 1e3 * values["m"].std)
        said.append(f"Against the weighed mass: {value} ± {std} g.")
    open_ones = [NAMES.get(each.name, each.name) for each in values.values() if not each.identified]
    if open_ones:
        said.append(f"Not decided by these data: {', '.join(open_ones)}.")
    if found.dynamic is None:
        said.append("No excitation was recorded: the inertia is not known.")
    elif found.dynamic.possible:
        cost = significant(found.dynamic.cost_of_possible, 2)
        said.append(f"No body has all of these values; the likeliest one that can exist costs χ² = {cost}.")
    return Block("", tuple(said))


def _values(found: PayloadResults, *, whole: bool) -> Block:
    """Of everything that was told; on the sheet without the zeros, which belong to the sensor and its day."""
    moved, still = found.dynamic, found.static
    tilt = [each for each in still.values if each.name in "UV"] if still else []
    told = [*moved.values, *tilt] if moved else list(still.values if still else ())
    shown = [each for each in told if whole or not each.name.endswith("0")]
    rows = []
    for each in shown:
        by_method = moved.by_method if moved and each in moved.values else still.by_method if still else {}
        methods = [
            with_std(by_method[method][each.name], each.std)[0] if method in by_method else "–" for method in METHODS
        ]
        interval = between(each.low, each.high)
        remark = "" if each.identified else "not decided"
        name = NAMES.get(each.name, each.name)
        rows.append((name, each.unit, *methods, _uncertain(each), interval, remark))
    shares = (0.14, 0.07, 0.11, 0.11, 0.11, 0.18, 0.2, 0.08)
    heads = ("Quantity", "Unit", "LS", "TLS", "GTLS", "Used ± std", "95 % interval", "")
    columns = tuple(Column(head, share, 1 < k < 7) for k, (head, share) in enumerate(zip(heads, shares, strict=True)))
    used = f"used: {moved.method.upper()}" if moved else "used: LS"
    caption = f"I about the sensor’s origin; {used}. TLS, GTLS: total least squares, plain and with the pose’s noise."
    return Block("What was identified", table=Table(caption, columns, tuple(rows)))


def _left(found: PayloadResults, *, whole: bool) -> Block:
    logs = list(found.tests.items())
    rows = []
    for log, ways in logs if whole else logs[:MOST_LOGS]:
        for way, words in WAYS.items():
            if (left := ways.get(way)) is None:
                continue
            for after, each in (("", left), ("; after (44)", left.after_zero))[: 2 if whole else 1]:
                cells = [x for k in (0, 1) for x in (each.first[k], each.mean[k], each.std[k])]
                rows.append((plain(log, 30), words + after, *(significant(cell) for cell in cells)))
    heads = ("Log", "Compensated by", "|f| at t = 0", "mean", "std", "|τ| at t = 0", "mean", "std")
    shares = (0.14, 0.26, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1)
    columns = tuple(Column(head, share, k > 1) for k, (head, share) in enumerate(zip(heads, shares, strict=True)))
    more = "" if whole or len(logs) <= MOST_LOGS else f" {len(logs) - MOST_LOGS} more logs: results.json."
    caption = f"Length of what is left of the wrench where nothing touches [N], [N·m].{more}"
    return Block("What is left", table=Table(caption, columns, tuple(rows)))


def _left_by_axis(found: PayloadResults) -> Block:
    rows = [
        (plain(log, 30), WAYS[way], state, *(f"{significant(mean, 2)} ± {significant(std, 2)}" for mean, std in
                                             zip(each.axes[1], each.axes[2], strict=True)))
        for log, ways in found.tests.items() for way in WAYS if way in ways
        for state, each in zip(STATES, (ways[way], ways[way].after_zero), strict=True)
    ]  # fmt: skip
    heads = ("Log", "Compensated by", "(44)", *CHANNELS)
    shares = (0.1, 0.22, 0.08, *(0.1,) * 6)
    columns = tuple(Column(head, share, k > 2) for k, (head, share) in enumerate(zip(heads, shares, strict=True)))
    caption = "Mean ± std of every axis [N], [N·m]; after: the secondary zero (44), where gravity is within 60° of it."
    return Block("What is left, per axis", table=Table(caption, columns, tuple(rows)))


def _missing(missing: MissingResults, *, whole: bool) -> Block:
    """What the rigid body behind an ideal sensor lacks; on the sheet the first ones."""
    most_effects = 2  # on the sheet
    effects = [*missing.found, *missing.suspected]
    said = [missing.said, *(each.said for each in (effects if whole else effects[:most_effects]))]
    return Block("What the model lacks", tuple(plain(each, 400 if whole else LONGEST) for each in said))


def _contacts(found: PayloadResults, *, whole: bool) -> Block:
    touches = [(log, touch) for log, each in found.contacts.items() for touch in each]
    rows = [
        (plain(log, 30), f"{touch.start_s:.2f}", f"{touch.end_s:.2f}", *map(significant, touch.force_n),
         significant(float(np.linalg.norm(touch.force_n))))
        for log, touch in (touches if whole else touches[:MOST_CONTACTS])
    ]  # fmt: skip
    heads = ("Log", "from [s]", "to [s]", "f_x [N]", "f_y [N]", "f_z [N]", "|f| [N]")
    columns = tuple(Column(head, 1 / len(heads), k > 0) for k, head in enumerate(heads))
    told = "; ".join(f"{plain(log, 30)} from {significant(x)} N on" for log, x in found.contact_threshold_n.items())
    more = "" if whole or len(touches) <= MOST_CONTACTS else f" {len(touches) - MOST_CONTACTS} more: results.json."
    return Block("Contacts", table=Table(f"Largest force on the payload. Told in {told}.{more}", columns, tuple(rows)))


def _facts(found: PayloadResults) -> Block:
    facts: list[tuple[str, str]] = [("Sensor sees", found.sees.replace("_", " "))]
    if found.static is not None:
        still = found.static
        level, inclined = (
            "cannot be told" if each is None else f"{significant(each.force_n)} N"
            for each in (still.left_out_level, still.left_out_inclined)
        )
        condition = f"{significant(still.condition_force, 2)} and {significant(still.condition_moment, 2)}"
        facts += [
            ("Postures", f"{still.postures}; condition of force and moment {condition}"),
            ("Left-out error", f"base level {level}, inclined {inclined}"),
            ("Inclination", "taken" if still.inclined else "left out"),
        ]
    if found.dynamic is not None and found.dynamic.mu is not None and found.dynamic.mu_std is not None:
        value, std = with_std(found.dynamic.mu, found.dynamic.mu_std)
        enough = "LS would have done" if found.dynamic.least_squares_would_do else "LS differs by more than its scatter"
        facts += [("μ", f"{value} ± {std}: residual over what the stated noise explains"), ("Method", enough)]
    if found.calibration is not None:
        facts.append(("± holds", found.calibration.said.replace("`", "")))
    if found.imu is not None:
        facts.append(("IMU", f"{found.imu.angle_deg:.1f}° off the sensor’s axes, {found.imu.lag_ms:.1f} ms late"))
    return Block("How", facts=tuple(facts))


def _warnings(found: PayloadResults, *, whole: bool) -> Block:
    shown = found.warnings if whole else found.warnings[:MOST_WARNINGS]
    points = [plain(each.replace("`", ""), 10 * LONGEST if whole else LONGEST) for each in shown]
    if len(shown) < len(found.warnings):
        points.append(f"{len(found.warnings) - len(shown)} more: report.html")
    return Block("Read with care", points=tuple(points)) if points else Block("")


def _uncertain(value: Value) -> str:
    return " ± ".join(with_std(value.value, value.std))
