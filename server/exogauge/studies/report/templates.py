"""The templates of reports, as they lay beside this code when it was loaded: an installation that is upgraded beneath
a running job gives it no template that asks for what its own code does not know."""

from __future__ import annotations

from importlib.resources import files

import jinja2

from exogauge.studies.words.remark_words import sentence

_FOLDER = files("exogauge.studies") / "templates"

TEMPLATES = jinja2.Environment(
    loader=jinja2.DictLoader(
        {each.name: each.read_text(encoding="utf-8") for each in _FOLDER.iterdir() if each.name.endswith(".j2")}
    ),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["sentence"] = sentence
