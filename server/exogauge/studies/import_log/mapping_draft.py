"""A mapping.yaml drafted by looking at the files: what is suggested, and as comments what a person has to see to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from exogauge.robots.description import Robot
from exogauge.studies.import_log.log_preview import preview

HEAD = "# Drafted from names, ranges and the robot. Check what is marked ?; name or ignore what is marked !."


def draft(paths: Sequence[Path], robot: Robot | None) -> str:
    """The mapping of all files together, those of a file one after the other. Raises BadLog."""
    looks = [preview(path, path.name, robot) for path in paths]
    lines = [HEAD]
    for look in looks:
        for column in look["columns"]:
            found = column["suggestion"]
            if found is not None and not found["sure"]:
                lines.append(
                    f"# ? {look['file']}: {column['name']} as {found['channel']} [{found['unit']}]: {found['why']}"
                )
            elif column["advice"]:
                lines.append(f"# ! {look['file']}: {column['name']}: {column['advice']}")
    content = {"version": 1, "files": [part for look in looks for part in look["proposal"]["files"]]}
    comments = [" ".join(line.split()) for line in lines]
    return "\n".join([*comments, yaml.safe_dump(content, allow_unicode=True, sort_keys=False, width=120)])
