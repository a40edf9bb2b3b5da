"""What the sensors said: reading, clocks, filters, derivatives, and the doctor who examines a log."""
