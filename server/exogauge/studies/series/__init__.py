"""Series over time, stored and asked for by window."""
