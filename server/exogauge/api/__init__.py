"""The HTTP API, a thin skin: parse, call, shape."""
