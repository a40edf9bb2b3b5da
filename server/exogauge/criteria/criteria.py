"""Numbers that decide, for one run: the defaults, or those that
`dataclasses.replace` puts in their place."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from exogauge.criteria.detecting import Contradicting, StoredFilter, Touching
from exogauge.criteria.examining import Comparing, Examining
from exogauge.criteria.following import Following
from exogauge.criteria.identifying import DECLARED, Declaring, Identifying, Resting
from exogauge.criteria.judging import Carrying, Judging
from exogauge.criteria.logs import LOGS, Logs
from exogauge.criteria.payload_doctor import Complaining
from exogauge.criteria.payload_dynamic import Moving
from exogauge.criteria.payload_live import Streaming
from exogauge.criteria.payload_static import Standing
from exogauge.criteria.planning import Planning, Telling
from exogauge.criteria.searching import Searching
from exogauge.criteria.supporting import DEVICES, MOTIONS, Described, Motions, Supporting, Wearing


@final
@dataclass(frozen=True)
class Criteria:
    """One part for each subject. logs, devices, motions, declared: the same for every run."""

    logs: Logs = field(default=LOGS, init=False)
    devices: Described = field(default=DEVICES, init=False)
    motions: Motions = field(default=MOTIONS, init=False)
    resting: Resting = field(default_factory=Resting)
    identifying: Identifying = field(default_factory=Identifying)
    judging: Judging = field(default_factory=Judging)
    search: Searching = field(default_factory=Searching)
    stored_filter: StoredFilter = field(default_factory=StoredFilter)
    contact: Touching = field(default_factory=Touching)
    nominal: Contradicting = field(default_factory=Contradicting)
    telling: Telling = field(default_factory=Telling)
    support: Supporting = field(default_factory=Supporting)
    device: Wearing = field(default_factory=Wearing)
    planning: Planning = field(default_factory=Planning)
    doctor: Examining = field(default_factory=Examining)
    following: Following = field(default_factory=Following)
    comparison: Comparing = field(default_factory=Comparing)
    declared: Declaring = field(default=DECLARED, init=False)
    payload: Carrying = field(default_factory=Carrying)
    payload_doctor: Complaining = field(default_factory=Complaining)
    payload_static: Standing = field(default_factory=Standing)
    payload_dynamic: Moving = field(default_factory=Moving)
    payload_live: Streaming = field(default_factory=Streaming)


USUAL = Criteria()
