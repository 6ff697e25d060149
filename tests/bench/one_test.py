# SPDX-License-Identifier: Apache-2.0
"""One test in this process, by the name that a table of planted faults gives it."""

from __future__ import annotations

from pathlib import Path

import pytest

OPTIONS = ("-q", "-x", "-p", "no:cacheprovider", "-p", "no:randomly", "--no-header")


def exit_status(folder: Path, name: str) -> int:
    """Exit status of pytest for `file.function`, or one case of it, of the tests in a folder."""
    file, _, test = name.partition(".")
    return int(pytest.main([*OPTIONS, f"{folder / file}.py::{test}"]))
