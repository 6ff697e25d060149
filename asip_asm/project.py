# SPDX-License-Identifier: Apache-2.0
"""Where the project's files are: in a checkout, or in the package that its wheel installs.

ROOT holds `asip_asm`, `sim`, `rtl` and `nios_sw`: the checkout, or the package `microtick`.
BUILD takes what is made and can be made again: `build` in a checkout, else a folder of the user's
cache ($XDG_CACHE_HOME, ~/.cache).
"""

from __future__ import annotations

import os
from pathlib import Path


def _cache() -> Path:
    """The user's cache as the XDG Base Directory Specification has it: a relative path is void."""
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return named if named.is_absolute() else Path.home() / ".cache"


ROOT = Path(__file__).resolve().parents[1]
CHECKOUT = (ROOT / "pyproject.toml").is_file()
BUILD = ROOT / "build" if CHECKOUT else _cache() / "microtick"
