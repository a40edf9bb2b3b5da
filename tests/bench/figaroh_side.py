"""figaroh's own steps from a log to base parameters. Runs in an environment of its own, which has no exogauge.

Called with an npz (urdf, held, q, v, a, tau); reads `full` or `decimated` from stdin, line by line, answers with CPU
seconds and writes an npz per mode: phi_base, M and columns, with phi_base = M @ phi[columns].
"""

from __future__ import annotations

import logging
import sys
import time
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
from figaroh.identification.base_identification import BaseIdentification


class Identification(BaseIdentification):  # type: ignore[misc]  # not installed beside the product
    """The steps of `BaseIdentification.initialize` and `solve` without files, plots and reports."""

    def __init__(self, model: pin.Model, q: np.ndarray, v: np.ndarray, a: np.ndarray, tau: np.ndarray) -> None:
        self.model, self.data = model, model.createData()
        self.robot = SimpleNamespace(model=self.model, data=self.data)
        self.num_samples = len(q)
        self.identif_config = {"act_idxv": list(range(model.nv)), "is_joint_torques": True}
        self.processed_data = {"positions": q, "velocities": v, "accelerations": a, "torques": tau}

    def identify(self, decimate: bool) -> np.ndarray:
        self.calculate_full_regressor()
        self.initialize_standard_parameters()
        reduced, active = self._eliminate_zero_columns(0.001)
        tau, W = self._apply_decimation(reduced, 10) if decimate else self._prepare_undecimated_data(reduced)
        return np.asarray(self._calculate_base_parameters(tau, W, active)["phi_base"])

    def load_trajectory_data(self, data_source: object = None) -> None:
        """Abstract in figaroh; the log is given."""


def main() -> None:
    logging.disable(logging.CRITICAL)
    log = np.load(sys.argv[1])
    model = pin.buildModelFromUrdf(str(log["urdf"]))
    model = pin.buildReducedModel(model, [model.getJointId(str(joint)) for joint in log["held"]], pin.neutral(model))
    identification = Identification(model, log["q"], log["v"], log["a"], log["tau"])
    for line in sys.stdin:
        mode = line.strip()
        start = time.process_time()
        phi_base = identification.identify(mode == "decimated")
        print(time.process_time() - start, flush=True)
        kept = np.setdiff1d(np.arange(10 * model.nv), identification._idx_eliminated)
        np.savez(f"{sys.argv[1]}.{mode}.npz", phi_base=phi_base, M=identification._M_matrix, columns=kept)


if __name__ == "__main__":
    main()
