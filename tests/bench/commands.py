# SPDX-License-Identifier: Apache-2.0
"""Commands that a test expects to succeed."""

from __future__ import annotations

import shlex
import subprocess
from typing import Any


def output(*words: object, **options: Any) -> str:
    """Standard output of a command; `options` are those of `subprocess.run`.

    Raises AssertionError with all that the command said if it fails.
    """
    command = [str(word) for word in words]
    done = subprocess.run(command, capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout
