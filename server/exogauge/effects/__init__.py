"""Why a measured torque differs from rigid-body dynamics: one file per effect, collected by `catalogue`."""
