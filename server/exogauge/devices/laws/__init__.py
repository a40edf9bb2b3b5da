"""How a band pulls: one file per force law, collected by `catalogue`."""

from exogauge.devices.laws.catalogue import all_laws, check_values, law_faults, law_named

__all__ = ["all_laws", "check_values", "law_faults", "law_named"]
