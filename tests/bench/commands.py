# SPDX-License-Identifier: Apache-2.0
"""Commands that a test expects to succeed."""

from __future__ import annotations

import shlex
from typing import Any

from sim.rtl.processes import run_group


def output(*words: object, **options: Any) -> str:
    """Standard output of a command; `options` are those of `run_group`.

    Raises AssertionError with all that the command printed if it fails.
    """
    command = [str(word) for word in words]
    done = run_group(command, **options)
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout
