"""A study: the files a user hands in, and what comes out (results.json, series, report.html)."""
