"""The 3D view: a robot in its recorded motion with what it wears, drawn by viser's client from files of our own."""
