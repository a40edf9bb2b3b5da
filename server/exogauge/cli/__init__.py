"""The command line: each command is a few lines that call what does the work, imported when it is needed."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Sequence

from exogauge import __version__
from exogauge.blas_threads import one_thread
from exogauge.cli import accounts, at_service, blind, labs, motion, payload, sample, service, study, upkeep
from exogauge.cli.endings import ending_of
from exogauge.errors import ExogaugeError
from exogauge.logbook import keep


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. 0: done. 1: not all of it. 2: input or installation not usable, and the message says why. With a
    service, 3: it does not answer or has not ended, the same later goes on; 4: it does not let this caller do it."""
    os.environ.update(one_thread(os.environ))  # before NumPy is there: processors are for logs (`side_by_side`)
    options = parser().parse_args(arguments)
    level = logging.INFO if options.verbose else logging.WARNING
    keep("json" if os.environ.get("EXOGAUGE_LOG") == "json" else "words", level)
    try:
        code: int = options.command(options)
    except ExogaugeError as error:
        print(f"exogauge {options.verb}: {error}", file=sys.stderr)
        return ending_of(error)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # whoever read along has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return code


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(
        prog="exogauge", description="Say with numbers what an assistive wear does to a body."
    )
    top.add_argument("--version", action="version", version=f"exogauge {__version__}")
    top.add_argument("-v", "--verbose", action="store_true", help="log what happens to stderr")
    commands = top.add_subparsers(dest="verb", required=True, metavar="COMMAND")
    for each in (study, payload, motion, sample, blind, service, accounts, at_service, labs, upkeep):
        each.add_commands(commands)
    return top
