# SPDX-License-Identifier: Apache-2.0
"""Errors of a program that is wrong, and the place where programs of the tests begin."""

import pytest

from sim.gcode.errors import GcodeError
from sim.gcode.interpreter import GcodeErrors, parse

ZERO = (0.0,) * 5


def errors_of(text: str, file: str = "part.ngc") -> list[GcodeError]:
    with pytest.raises(GcodeErrors) as caught:
        parse(text, file=file)
    return caught.value.errors
