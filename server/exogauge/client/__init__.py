"""The typed Python client of the HTTP API.

>>> client = Client("http://127.0.0.1:8765")            # doctest: +SKIP
>>> study = client.upload_study("my_study")              # doctest: +SKIP
>>> job = client.wait(client.submit(study))              # doctest: +SKIP
>>> client.results(job)["identification"]["summary"]     # doctest: +SKIP
"""

from exogauge.client.client import Client
from exogauge.client.problems import ClientProblem
from exogauge.client.things import Artifact, Device, Job, Log, Motion, Payload, Plan, Robot, Study, WhatIf

__all__ = [
    "Artifact", "Client", "ClientProblem", "Device", "Job", "Log", "Motion", "Payload", "Plan", "Robot", "Study",
    "WhatIf",
]  # fmt: skip
