"""Work that takes time: one recipe per job kind, and the engine that runs them in workers."""
