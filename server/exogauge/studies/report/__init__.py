"""The report, the summary page and its PDF."""
