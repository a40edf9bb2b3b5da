"""Parts of a body, of a person as of a robot."""

from __future__ import annotations

import re
from typing import Literal

LEFT = re.compile(r"(^|_)l(eft)?(_|$)|^l(?=[A-Z])|left", re.I)  # in the name of a link or joint of the left side

Segment = Literal[
    "pelvis", "thorax", "head",
    "l_upper_arm", "l_forearm", "l_hand", "r_upper_arm", "r_forearm", "r_hand",
    "l_thigh", "l_shank", "l_foot", "r_thigh", "r_shank", "r_foot",
]  # fmt: skip
SEGMENTS: tuple[Segment, ...] = (
    "pelvis", "thorax", "head",
    "l_upper_arm", "l_forearm", "l_hand", "r_upper_arm", "r_forearm", "r_hand",
    "l_thigh", "l_shank", "l_foot", "r_thigh", "r_shank", "r_foot",
)  # fmt: skip
