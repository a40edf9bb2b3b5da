from exogauge.client import Client as Client
from exogauge.client import ClientProblem as ClientProblem

__version__: str
