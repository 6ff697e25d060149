# SPDX-License-Identifier: Apache-2.0
"""Errors of a program that is wrong, and the place where programs of the tests begin."""

from typing import Any

import pytest

from sim.motion.gcode.errors import GcodeError
from sim.motion.gcode.interpreter import GcodeErrors, parse

ZERO = (0.0,) * 5


def check_error(
    error: GcodeError, line: int, column: int, text: str, what: str, expected: str, help: str = ""
) -> None:
    """Its place, the text that it shows, and parts of what else it prints."""
    assert (error.line, error.column, error.text) == (line, column, text)
    assert what in error.what
    assert expected in error.expected
    assert error.help and help in error.help


def refused(text: str, file: str = "part.ngc", **options: Any) -> GcodeErrors:
    """How `parse` refuses a text."""
    with pytest.raises(GcodeErrors) as caught:
        parse(text, file, **options)
    return caught.value


def errors_of(text: str, file: str = "part.ngc") -> tuple[GcodeError, ...]:
    return refused(text, file).errors
