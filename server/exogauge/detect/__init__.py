"""The detectors, in their order: stored filter, contact, missing effects, nominal values, the device."""
