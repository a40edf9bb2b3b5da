"""Devices and robots as resources: content, changes, pictures, what-if."""
