# SPDX-License-Identifier: Apache-2.0
"""Debug maps: where each value of a source is at each bundle of its program (docs/debugger.md).

A *position* is the bundle that issues next: at position p all bundles before p on the way there are
done and p is not. The position after the last bundle is the end of the run. `asip-as` writes the
map next to the image; both hold the image's checksum, so that a map is never used for another
program.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from asip_asm.files import read_bytes
from asip_asm.flow import reachable
from asip_asm.image import Image, Type, json_rows

FORMAT = "microtick-asip-debug-map"
VERSION = 1
FILE_BYTES = 8 << 20
"""Largest map; a full program of 3072 operations takes about 1 MiB."""
SPANS = 64
"""Most spans of a value. Only a program of many branches has more; the last are then dropped."""

Position = Annotated[int, Meta(ge=0, le=1 << 16)]
Span = tuple[Position, Position]
Text = Annotated[str, Meta(max_length=16384)]


class DebugMapError(ValueError):
    """The file is no debug map of this program; the message names file, cause and cure."""


class Write(msgspec.Struct, frozen=True, forbid_unknown_fields=True, array_like=True):
    """Operation that writes a value: bundle, slot, and the first bundle that finds the value
    written when the run goes on without a halt.
    """

    bundle: Position
    slot: int
    lands: Position


class Value(msgspec.Struct, forbid_unknown_fields=True):
    """A value of the source: the name, and the number of its definition under this name.

    version: 0 for what a state holds at the start of a run, -1 for a name that passes its value
    from part to part of a program. place: register ('a3') or output ('o0'). held: positions, first
    and last, at which the place has this value on every path there; perhaps: on some paths.
    spilled: bundle from which on data memory has a copy, and its address.
    """

    name: Text
    version: int
    type: Type
    place: Text
    file: Text
    line: int
    equation: Text
    writes: list[Write]
    held: list[Span]
    perhaps: list[Span] = []
    spilled: tuple[Position, int] | None = None

    @property
    def first(self) -> int:
        """Bundle of the first write; -1 without one: the value is there when the run starts."""
        return min((write.bundle for write in self.writes), default=-1)


class DebugMap(msgspec.Struct, forbid_unknown_fields=True):
    """Map of an image with checksum `image`.

    files: SHA-256 of every source by its path as the image names it, the program's own first.
    cycles: issue cycle of each bundle when no branch is taken. follow: positions after a bundle
    where that is not the next bundle alone. calls: macro calls, innermost first, of the operation
    in 'bundle.slot'.
    """

    image: Text
    bundles: Position
    files: dict[Text, Text]
    cycles: list[int]
    follow: dict[str, list[Position]]
    calls: dict[str, list[Text]]
    values: list[Value]

    def dumps(self) -> str:
        """JSON text with one line per entry."""
        data = {"format": FORMAT, "version": VERSION} | msgspec.to_builtins(self)
        return json_rows(data, ["values"])

    @classmethod
    def load(cls, path: Path, image: Image) -> DebugMap:
        """Read the map of an image. Raises DebugMapError, OSError."""
        cure = "assemble the program again: asip-as writes image and map together"
        try:
            data: Any = msgspec.json.decode(read_bytes(path, FILE_BYTES, "a debug map"))
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
            raise DebugMapError(f"{path}: not a JSON file: {error}") from None
        if not isinstance(data, Mapping) or data.get("format") != FORMAT:
            raise DebugMapError(f"{path}: not a debug map (no format '{FORMAT}'); {cure}")
        if data.get("version") != VERSION:
            raise DebugMapError(
                f"{path}: map version {str(data.get('version')):.20}, this tool reads {VERSION}; "
                + cure
            )
        content = {k: v for k, v in data.items() if k not in ("format", "version")}
        try:
            found = msgspec.convert(content, cls)
        except msgspec.ValidationError as error:
            raise DebugMapError(f"{path}: damaged debug map: {error}; {cure}") from None
        if found.image != image.to_json()["checksum"]:
            raise DebugMapError(f"{path}: is the map of another program than the image; {cure}")
        if found.bundles != len(image.bundles):
            raise DebugMapError(f"{path}: damaged debug map: number of bundles; {cure}")
        return found

    # ------------------------------------------------------------------ questions
    def following(self, position: int) -> list[int]:
        """Positions that may come after a bundle."""
        return self.follow.get(str(position), [position + 1])

    def names(self) -> list[str]:
        """Names of all values, in the order of their first writes."""
        return list(dict.fromkeys(value.name for value in self.values))

    def named(self, name: str) -> list[Value]:
        """All values of a name, or one: 'name@version'."""
        base, at, version = name.partition("@")
        found = [value for value in self.values if value.name == base]
        return [v for v in found if str(v.version) == version] if at else found


@dataclass(frozen=True)
class Where:
    """Where a value is: `place` is its register, output or 'd12' (data word), '' if nowhere.

    text says it in words where the value is not plainly in its place.
    """

    value: Value
    place: str
    text: str = ""


def within(position: int, spans: Iterable[Span]) -> bool:
    """Whether one of the spans holds the position."""
    return any(first <= position <= last for first, last in spans)


class Finder:
    """Finds where values are, and caches what it found."""

    def __init__(self, debug_map: DebugMap) -> None:
        self.map = debug_map
        self._by_place: dict[str, list[Value]] = {}
        for value in debug_map.values:
            self._by_place.setdefault(value.place, []).append(value)
        self._reached: dict[int, set[int]] = {}

    def holder(self, place: str, position: int) -> Value | None:
        """The value that a register or output surely holds."""
        values = self._by_place.get(place, ())
        return next((value for value in values if within(position, value.held)), None)

    def find(self, name: str, position: int) -> Where | None:
        """The value of a name at a position: the one there that was written last, else the one to
        come next, or the last that was overwritten. None for a name that the map does not have.
        """
        values = self.map.named(name)
        if not values:
            return None
        found = [self.where(value, position) for value in values]
        there = [where for where in found if where.place]
        if there:
            return max(there, key=lambda where: (where.text == "", where.value.first))
        gone = [where for where in found if self._written(where.value, position)]
        return max(gone, key=lambda w: w.value.first) if gone else found[0]

    def where(self, value: Value, position: int) -> Where:
        """Where a value is at a position; the pipeline is empty there."""
        if within(position, value.held):
            return Where(value, value.place)
        if value.spilled and value.spilled[0] < position and self._written(value, position):
            address = value.spilled[1]
            return Where(value, f"d{address}", f"moved to data word {address}")
        if within(position, value.perhaps):
            return Where(value, value.place, "only on some of the ways to this bundle")
        if not self._written(value, position):
            return Where(value, "", self._not_yet(value, position))
        taker = self._taker(value, position)
        if taker is None:
            return Where(value, "", f"no longer in {value.place}")
        bundle, name = taker
        return Where(value, "", f"overwritten at bundle {bundle} by {name}")

    def _not_yet(self, value: Value, position: int) -> str:
        bundles = sorted(write.bundle for write in value.writes)
        coming = [bundle for bundle in bundles if bundle >= position] or bundles
        if position >= self.map.bundles:
            return f"not computed on this way; bundle {coming[0]} computes it"
        return f"not yet computed at bundle {position}; bundle {coming[0]} computes it"

    def _written(self, value: Value, position: int) -> bool:
        """Whether a way from a write of the value leads to the position."""
        if not value.writes:
            return True
        return any(position in self._reach(write.bundle) for write in value.writes)

    def _reach(self, bundle: int) -> set[int]:
        """Positions after a bundle."""
        if bundle not in self._reached:
            follow, end = self.map.following, self.map.bundles
            self._reached[bundle] = reachable(
                follow(bundle), lambda i: follow(i) if i < end else []
            )
        return self._reached[bundle]

    def _taker(self, value: Value, position: int) -> tuple[int, str] | None:
        """Bundle and name of the write that took the value's place away."""
        others = [
            (write.bundle, other.name)
            for other in self._by_place[value.place]
            if other is not value
            for write in other.writes
            if write.bundle > value.first and position in self._reach(write.bundle)
        ]
        return min(others, default=None)


def map_path(image: Path) -> Path:
    """Path of the map of an image file."""
    return image.with_name(image.name.removesuffix(".json") + ".map.json")
