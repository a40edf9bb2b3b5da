"""results.json and the files beside it."""
