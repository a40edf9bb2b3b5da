"""Every study made of recordings of real robots: what tests evaluate, and what two trees are compared on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType

from tests.real.recordings import double_pendulum, icub_walking, staubli_tx40, ur10, z1
from tests.real.recordings.placing import is_there, place


@dataclass(frozen=True)
class RealStudy:
    recording: ModuleType
    write: Callable[[Path], None]
    study_file: str

    @property
    def is_there(self) -> bool:
        return is_there(self.recording.RECORDING)

    def make(self, folder: Path) -> Path:
        """The study file, written into the folder beside all it names."""
        place(self.recording.RECORDING, self.recording.FILES, folder)
        self.write(folder)
        return folder / self.study_file


STUDIES = {
    "tx40": RealStudy(staubli_tx40, staubli_tx40.write, "missing.yaml"),
    "tx40_uncoupled": RealStudy(staubli_tx40, staubli_tx40.write_uncoupled, "uncoupled.yaml"),
    "tx40_currents": RealStudy(staubli_tx40, partial(staubli_tx40.write_as_currents, doubt=0.1), "currents.yaml"),
    "ur10_forward": RealStudy(ur10, ur10.write, "forward.yaml"),
    "ur10_reverse": RealStudy(ur10, ur10.write, "reverse.yaml"),
    "z1_by_turns": RealStudy(z1, z1.write, "by_turns.yaml"),
    "z1_slow_part": RealStudy(z1, z1.write, "slow_part.yaml"),
    "icub": RealStudy(icub_walking, icub_walking.write, "study.yaml"),
    "pendulum_swing": RealStudy(double_pendulum, double_pendulum.write, "swing.yaml"),
    "pendulum_gentle": RealStudy(double_pendulum, double_pendulum.write, "gentle.yaml"),
}
