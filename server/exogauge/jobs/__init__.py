"""Work that takes time: one file per job kind, and the engine that runs them in workers."""
