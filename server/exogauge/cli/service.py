"""Commands of the service: server, workers, database, demonstration."""

from __future__ import annotations

import argparse
import math
import os
from pathlib import Path

from exogauge.cli.endings import Commands
from exogauge.cli.sample import add_realism
from exogauge.garbage import left_while_loading


def add_commands(commands: Commands) -> None:
    """Server, workers, database, demonstration."""
    serve = commands.add_parser("serve", help="the service: API, page and workers, on this machine only by default")
    serve.add_argument("--host", help="address to listen on (EXOGAUGE_HOST)")
    serve.add_argument("--port", type=int, help="port; 0 takes a free one (EXOGAUGE_PORT)")
    serve.add_argument("--workers", type=int, help="worker processes; 0: none here (EXOGAUGE_WORKERS)")
    serve.add_argument("--data-dir", type=Path, help="where everything is kept (EXOGAUGE_DATA_DIR)")
    serve.add_argument("--with-parent", action="store_true", help="stop when stdin ends")
    serve.set_defaults(command=start_server)

    work = commands.add_parser("work", help="one more worker for the same database and blobs")
    work.add_argument("--with-parent", action="store_true", help="stop when stdin ends")
    work.add_argument(
        "--until-idle", type=float, default=math.inf, metavar="S", help="leave when there was nothing to do for so long"
    )
    work.set_defaults(command=start_worker)

    migrate = commands.add_parser("migrate", help="bring the database to this version; back it up before")
    migrate.set_defaults(command=upgrade_database)

    demo = commands.add_parser("demo", help="evaluate the sample study through the service, and print the result")
    add_realism(demo)
    capture = "a person's motion (C3D, TRC, TSV, CSV, MVNX, BVH, AMC) that the sample's robot plays in place of its own"
    demo.add_argument("--motion", type=Path, metavar="FILE", help=capture)
    demo.add_argument("--skeleton", type=Path, metavar="FILE.asf", help="the bones of an AMC")
    demo.add_argument("--to", dest="end", type=float, metavar="S", help="end of what is played of it")
    demo.add_argument(
        "--slow", type=float, metavar="FACTOR", help="times the time (default: the least at which it stands)"
    )
    demo.set_defaults(command=show_demo)


def start_server(options: argparse.Namespace) -> int:
    import exogauge.jobs.code_version  # noqa: F401 (files are hashed before they are used)
    from exogauge.settings import Settings, refuse_open_house

    given = {key: getattr(options, key) for key in ("host", "port", "workers", "data_dir")}
    for key, value in given.items():
        if value is not None:  # by the environment, so that the workers see it too
            os.environ[f"EXOGAUGE_{key.upper()}"] = str(value)
    settings = Settings()
    refuse_open_house(settings)  # at once: before all that serves is loaded
    with left_while_loading():
        from exogauge.serving import serve

    serve(settings, with_parent=options.with_parent)
    return 0


def start_worker(options: argparse.Namespace) -> int:
    import exogauge.jobs.code_version  # noqa: F401 (files are hashed before they are used)

    with left_while_loading():
        from exogauge.jobs.worker import work
        from exogauge.settings import Settings

    work(Settings(), with_parent=options.with_parent, idle_s=options.until_idle)
    return 0


def upgrade_database(_: argparse.Namespace) -> int:
    from exogauge.jobs.schema import upgrade
    from exogauge.settings import Settings

    print(f"the database is at revision {upgrade(Settings())}")
    return 0


def show_demo(options: argparse.Namespace) -> int:
    from exogauge.demo import Captured, demo
    from exogauge.settings import Settings

    captured = None
    if options.motion is not None:
        captured = Captured(options.motion, options.skeleton, options.end, options.slow)
    demo(Settings(), options.realism, captured)
    return 0
