# SPDX-License-Identifier: Apache-2.0
"""Where the project's files stand: in a checkout, or in the packages that its wheel installs.

ROOT holds `rtl` and `nios_sw`: the checkout, or the folder `microtick` beside the packages.
PACKAGES holds `asip_asm` and `sim`. BUILD takes what is made and can be made again: `build` in a
checkout, else a folder of the user's cache ($XDG_CACHE_HOME, ~/.cache).
"""

from __future__ import annotations

import os
from pathlib import Path


def _cache() -> Path:
    """The user's cache as the XDG Base Directory Specification has it: a relative path is void."""
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return named if named.is_absolute() else Path.home() / ".cache"


PACKAGES = Path(__file__).resolve().parents[1]
CHECKOUT = (PACKAGES / "pyproject.toml").is_file()
ROOT = PACKAGES if CHECKOUT else PACKAGES / "microtick"
BUILD = ROOT / "build" if CHECKOUT else _cache() / "microtick"
