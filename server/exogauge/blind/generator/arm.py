"""`arm6`: an arm of our own with six joints on a fixed base.

As in `synthetic.robot_facts`, one table of links; at zero posture the arm points upwards and every link frame is
parallel to the base frame (x forward, y left, z up). Its tool sits on a force/torque sensor.
Shapes, masses and drives are our estimates.
"""

from __future__ import annotations

from dataclasses import replace

from exogauge.blind.generator.robot_kind import RobotKind, WristOrBase
from exogauge.synthetic.robot_facts import Drive, Joint, Link

WRIST_FRAME = "wrist_ft"  # of the force/torque sensor that carries the tool

_LARGE = Drive(k_T=12.0, k_d=9.0, tau_c=7.0, J_r=1.2, effort=160.0, velocity=3.0, stiffness=0.0, damping=0.0)
_MIDDLE = replace(_LARGE, k_T=9.0, k_d=5.0, tau_c=4.5, J_r=0.6, effort=100.0, gear_ratio=80.0)
_SMALL = replace(_LARGE, k_T=5.0, k_d=1.8, tau_c=1.8, J_r=0.15, effort=35.0, gear_ratio=60.0)
_LINKS = (
    Link("base", None, (0, 0, 0), 4.0, "cylinder", (0.16, 0.16, 0.12), (0, 0, 0.05)),
    Link("shoulder", "base", (0, 0, 0.12), 3.6, "cylinder", (0.14, 0.14, 0.16), (0.01, 0.02, 0.03),
         Joint("joint_1", "z", -2.4, 2.4, _LARGE)),
    Link("upper_arm", "shoulder", (0, 0.12, 0.06), 8.0, "box", (0.11, 0.10, 0.44), (0.01, 0.02, 0.19),
         Joint("joint_2", "y", -1.4, 1.4, _LARGE)),
    Link("forearm", "upper_arm", (0, -0.09, 0.42), 3.2, "box", (0.09, 0.08, 0.28), (0.01, -0.01, 0.11),
         Joint("joint_3", "y", -2.0, 2.0, _MIDDLE)),
    Link("forearm_roll", "forearm", (0, 0, 0.22), 1.6, "cylinder", (0.08, 0.08, 0.16), (0.005, 0.02, 0.07),
         Joint("joint_4", "z", -2.6, 2.6, _SMALL)),
    Link("wrist", "forearm_roll", (0, 0, 0.17), 1.3, "box", (0.08, 0.09, 0.11), (0.01, -0.01, 0.03),
         Joint("joint_5", "y", -1.9, 1.9, _SMALL)),
    Link("flange", "wrist", (0, 0, 0.09), 0.4, "cylinder", (0.07, 0.07, 0.04), (0, 0, 0.01),
         Joint("joint_6", "z", -2.8, 2.8, replace(_SMALL, k_T=4.0, k_d=1.0, tau_c=1.2, J_r=0.08))),
    Link(WRIST_FRAME, "flange", (0, 0, 0.03)),
    Link("tool", WRIST_FRAME, (0, 0, 0), 1.5, "box", (0.07, 0.10, 0.14), (0.06, 0.03, 0.07)),
)  # fmt: skip

ARM = RobotKind(
    "arm6",
    _LINKS,
    WristOrBase("wrist", WRIST_FRAME, force=0.1, moment=0.005),
    hands=("tool",),
    drawn={"tool": (0.5, 2.0)},
)
