"""The schema of results.json: checked when one is written, given out by the API, and what the page's types are of."""

from exogauge.studies.results.schema.document import StudyResults

__all__ = ["StudyResults"]
