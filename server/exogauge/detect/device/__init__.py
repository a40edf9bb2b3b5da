"""What the model of the device lacks."""
