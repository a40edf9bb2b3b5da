"""How a band pulls: one file per force law, collected by `catalogue`."""
