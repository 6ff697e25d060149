# SPDX-License-Identifier: Apache-2.0
"""Commands that a test expects to succeed."""

from __future__ import annotations

import subprocess
from typing import Any


def output(*words: object, **options: Any) -> str:
    """Standard output of a command; `options` are those of `subprocess.run`.

    Raises AssertionError with all that the command said if it fails.
    """
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
