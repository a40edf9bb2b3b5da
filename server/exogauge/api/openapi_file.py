"""The OpenAPI document as the file that the web app's types are made of: `python -m exogauge.api.openapi_file FILE`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from exogauge.api.app import create_app
from exogauge.settings import Settings


def openapi_file() -> str:
    """The document as text, the same on every machine; no server runs, and nothing is kept."""
    with TemporaryDirectory(prefix="exogauge-openapi-") as folder:
        settings = Settings(data_dir=Path(folder), database_url="", blob_dir=None, workers=0)
        app = create_app(settings)
        document = app.openapi()
        app.state.installation.close()
    return json.dumps(document, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(openapi_file(), encoding="utf-8")
