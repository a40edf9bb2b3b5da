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
from exogauge.cli.endings import BAD_INPUT, ending_of, told_by_system
from exogauge.errors import ExogaugeError, no_room
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
        if sys.stdout is not None:
            sys.stdout.flush()  # what cannot be written is told here, and not by Python when it ends
    except ExogaugeError as error:
        print(f"exogauge {options.verb}: {error}", file=sys.stderr)
        return ending_of(error)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # whoever read along has seen enough
        drop_output()
        return 0
    except EOFError:
        print(f"exogauge {options.verb}: something was asked for, and the input had ended", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        if error.filename is None and not no_room(error):
            raise
        print(f"exogauge {options.verb}: {told_by_system(error)}", file=sys.stderr)
        if error.filename is None:
            drop_output()
        return BAD_INPUT
    return code


def drop_output() -> None:
    """What was not written yet would fail once more when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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
