# SPDX-License-Identifier: Apache-2.0
"""Loader of the published figures (tables 1-4 of the reference paper), `sim/published.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

PUBLISHED_TOML = Path(__file__).resolve().parent.parent / "published.toml"


@dataclass(frozen=True)
class Published:
    """The four tables, keyed as in the file.

    operations: operation -> count (table 1); time: platform -> description, clock_mhz, time_us,
    cycles (table 2); error: column -> row name -> largest error in SI units, absent where the paper
    prints none (table 3); resources: system -> resource -> count (table 4).
    """

    operations: dict[str, int]
    time: dict[str, dict[str, int | str]]
    error: dict[str, dict[str, float]]
    resources: dict[str, dict[str, int]]

    @classmethod
    def load(cls) -> Published:
        """Read the tables."""
        return cls(**tomllib.loads(PUBLISHED_TOML.read_text(encoding="utf-8")))
