# SPDX-License-Identifier: Apache-2.0
"""Parameters as tables of `sim/robot.toml`, with unit and limits: how they are read and checked.

A record is a frozen dataclass of `parameter`s; every field is one table of the file, with the same
name. A value that is missing, not finite, in another unit or outside its limits raises
`ParameterError` with name, value, limits and the reason for them.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Self

from asip_asm.parameters import ParameterFileError, read_toml

ROBOT_TOML = Path(__file__).resolve().parent.parent / "robot.toml"
RANGE = "products of parameters stay far inside the range of binary32"


class ParameterError(ValueError):
    """A parameter is missing, unknown or outside its limits."""


def parameter(unit: str, low: float, high: float, why: str = RANGE) -> Any:
    """A field of a record; `why` is the reason for its limits."""
    return field(metadata={"unit": unit, "low": low, "high": high, "why": why})


def _read(path: Path) -> tuple[dict[str, Any], dict[str, int]]:
    try:
        return read_toml(path)
    except ParameterFileError as error:
        raise ParameterError(str(error)) from None


def placed(
    error: ParameterError, path: Path, lines: Mapping[str, int] | None = None
) -> ParameterError:
    """The same error with file and line in front; its text begins with the parameter's name.

    lines: of the names, read from the file if not given. Raises ParameterError, OSError.
    """
    if lines is None:
        lines = _read(path)[1]
    line = lines.get(str(error).split(" ")[0].split(":")[0])
    place = f"{path}:{line}" if line else f"{path}"
    return ParameterError(f"{place}: error: {error}")


@dataclass(frozen=True)
class Record:
    """Base of the records. `others` are names of the file that belong to other ones; None: any."""

    others: ClassVar[Collection[str] | None] = None

    @classmethod
    def load(cls, path: Path | None = None) -> Self:
        """Read the parameters from `path`, by default `sim/robot.toml`.

        The text of a ParameterError begins with the file and, where there is one, the line.
        """
        path = path or ROBOT_TOML
        tables, lines = _read(path)
        try:
            return cls(**cls._values(tables))
        except ParameterError as error:
            raise placed(error, path, lines) from None

    @classmethod
    def _values(cls, tables: dict[str, Any]) -> dict[str, Any]:
        known = {entry.name: entry for entry in fields(cls)}
        for name in tables:
            if cls.others is not None and name not in known and name not in cls.others:
                close = difflib.get_close_matches(name, known, n=1)
                hint = f"; did you mean {close[0]}?" if close else ""
                raise ParameterError(f"{name}: unknown parameter{hint}")
        values = {}
        for name, entry in known.items():
            if name not in tables:
                raise ParameterError(f"{name}: missing parameter, unit {entry.metadata['unit']}")
            table = tables[name]
            if not isinstance(table, dict) or set(table) != {"value", "unit", "meaning"}:
                got = f"keys {sorted(table)}" if isinstance(table, dict) else f"no keys: {table!r}"
                raise ParameterError(f"{name}: has {got}, must be meaning, unit, value")
            if table["unit"] != entry.metadata["unit"]:
                raise ParameterError(
                    f"{name}: unit is {table['unit']!r}, must be {entry.metadata['unit']!r}"
                )
            values[name] = table["value"]
        return values

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, meta = getattr(self, entry.name), entry.metadata
            unit = "" if meta["unit"] == "1" else f" {meta['unit']}"
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise ParameterError(f"{entry.name} = {value!r}: must be a number")
            if not abs(value) < math.inf:
                raise ParameterError(f"{entry.name} = {value}{unit}: must be finite")
            if not meta["low"] <= value <= meta["high"]:
                raise ParameterError(
                    f"{entry.name} = {value}{unit}: must be within "
                    f"{meta['low']:g} .. {meta['high']:g}{unit}; {meta['why']}"
                )
            object.__setattr__(self, entry.name, float(value))
