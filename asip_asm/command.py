# SPDX-License-Identifier: Apache-2.0
"""What the console commands have in common: one line and an exit status for what goes wrong."""

from __future__ import annotations

import argparse
import contextlib
import errno
import functools
import math
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from pathlib import Path
from typing import ParamSpec

from asip_asm.diagnostics import AssemblyError, visible
from asip_asm.project import BUILD, CHECKOUT, ROOT

Arguments = ParamSpec("Arguments")
INTERRUPTED = 130
"""Exit status after Ctrl-C, 128 + SIGINT as shells give it."""
_CALLED: ContextVar[str | None] = ContextVar("called", default=None)
"""Name by which the user called the command, if it is not the command's own."""


@contextlib.contextmanager
def called_as(name: str) -> Iterator[None]:
    """Within this context, help and messages of a command name it so, as in `microtick run`."""
    before = _CALLED.set(name)
    try:
        yield
    finally:
        _CALLED.reset(before)


def _renamed(text: str, own: str) -> str:
    """The text with the name by which the user called the command in place of the command's own."""
    called = _CALLED.get()
    if called is None:
        return text
    return re.sub(rf"(?<![\w.-]){re.escape(own)}(?![\w-])", called, text)


def command_parser(
    prog: str, description: str, epilog: str | None = None, add_help: bool = True
) -> argparse.ArgumentParser:
    """Parser of a command whose help prints description and epilog with their own line breaks."""
    return argparse.ArgumentParser(
        prog=_CALLED.get() or prog,
        description=_renamed(description, prog),
        epilog=_renamed(epilog, prog) if epilog else None,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        add_help=add_help,
    )


def script_parser(text: str, example: str, prog: str | None = None) -> argparse.ArgumentParser:
    """Parser of a script that the first line of its text describes; example: a way to call it."""
    description = text.splitlines()[0]
    epilog = f"example: {_renamed(example, prog) if prog else example}"
    return argparse.ArgumentParser(_CALLED.get() or prog, description=description, epilog=epilog)


def command(name: str) -> Callable[[Callable[Arguments, int]], Callable[Arguments, int]]:
    """Decorator of a command's main function, which then ends as `run_command` says."""

    def decorated(main: Callable[Arguments, int]) -> Callable[Arguments, int]:
        @functools.wraps(main)
        def whole(*arguments: Arguments.args, **named: Arguments.kwargs) -> int:
            return run_command(name, lambda: main(*arguments, **named))

        return whole

    return decorated


def cause_of(error: OSError) -> str:
    """One line: the file, what is wrong with it, and the cure for what cannot be written."""
    where = f"{error.filename}: " if error.filename else ""
    return f"{where}{error.strerror or error}{_cure(error)}"


def _cure(error: OSError) -> str:
    if error.errno not in (errno.EROFS, errno.EACCES) or not isinstance(error.filename, str | Path):
        return ""
    file = Path(error.filename).absolute()
    there = next(folder for folder in (file, *file.parents) if folder.exists())
    if os.access(there, os.W_OK):
        return ""
    if CHECKOUT and file.is_relative_to(ROOT):
        return "; copy the checkout to a folder of your own, or make it writable"
    if file.is_relative_to(BUILD):
        return "; set XDG_CACHE_HOME to a folder that you can write"
    return ""


def run_command(name: str, body: Callable[[], int], *errors: type[Exception]) -> int:
    """Exit status of a command's body; 1 with one line for files that cannot be read or written and
    for these errors, whose `status` counts if they have one; 1 with the report of an AssemblyError.
    """
    name = _CALLED.get() or name
    for stream in (sys.stdout, sys.stderr):
        # Names in files may hold characters that the terminal's encoding has not.
        getattr(stream, "reconfigure", lambda **_: None)(errors="backslashreplace")
    try:
        status = _status(name, body, errors)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # The reader of a pipe went away: no error of ours. Keeps Python from flushing at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
    except OSError as error:
        return _failed(name, cause_of(error))
    except MemoryError:
        return _failed(name, "not enough memory")
    except KeyboardInterrupt:
        print(f"{name}: stopped", file=sys.stderr)
        return INTERRUPTED


def _status(name: str, body: Callable[[], int], errors: tuple[type[Exception], ...]) -> int:
    try:
        return body()
    except AssemblyError as error:
        print(error.report(), file=sys.stderr)
        return 1
    except errors as error:
        sys.stdout.flush()
        _failed(name, str(error))
        return getattr(error, "status", 1)


def _failed(name: str, message: str) -> int:
    print(visible(f"{name}: error: {message}"), file=sys.stderr)
    return 1


def count(text: str) -> int:
    """Option of a command: a number of things, 1 or more."""
    if not text.isascii() or not text.isdecimal() or len(text) > 9 or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number 1..999999999")
    return int(text)


def duration(text: str) -> float:
    """Option of a command: a time above 0 [s]."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is no time above 0 in seconds")
    return value
