"""A short-lived child process that opens what users uploaded, with limits on memory and time."""
