"""What [Evaluator] publishes for HRP-4 in a suit, for comparison in the demonstration: another robot, another suit."""

from __future__ import annotations

from exogauge.terminal import text_table

SUPPORT = (  # motion, suit, RMSE [N·m] of A, B and a-priori values against the band simulation: captions of Figs 12, 13
    ("bending, torso pitch", "normal", "1.97", "2.65", "7.42"),
    ("bending, torso pitch", "modified", "2.56", "3.32", "7.66"),
    ("twisting, torso yaw", "normal", "1.84", "2.51", "5.08"),
    ("twisting, torso yaw", "modified", "1.73", "2.17", "4.71"),
)
STIFFNESS = (  # suit, stiffness [N/m]: truth, A, B, a-priori values: Tables 2 and 3
    ("normal", "197.8", "185.8 (6.1 %)", "181.3 (8.3 %)", "65.8 (66.7 %)"),
    ("modified", "395.6", "364.6 (7.9 %)", "331.5 (16.2 %)", "207.1 (47.8 %)"),
)


def published() -> str:
    return "\n".join(
        [
            "PUBLISHED for HRP-4, measured on the real robot in a real suit; not this sample, whose data are synthetic",
            "",
            text_table(("RMSE, N·m", "suit", "A", "B", "maker's"), SUPPORT),
            "",
            text_table(("stiffness, N/m", "truth", "A", "B", "maker's"), STIFFNESS),
        ]
    )
