# SPDX-License-Identifier: Apache-2.0
"""The record of a controller program's interface: inputs, states, outputs, exports, their units and
limits (`<program>.interface.toml`; format: docs/assembly.md).

The assembler reads it (`.interface`), and C headers, simulations, tests and documents are made from
it. An entry of the file describes one signal or several that differ in nothing but their names.
Numbers may be expressions of the parameters and constants, evaluated in double precision.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec

from asip_asm.diagnostics import closest
from asip_asm.files import FileRefused
from asip_asm.parameters import ParameterFileError, read_toml
from asip_asm.signals import COUNT, KINDS, Interface, InterfaceError, Number, Signal
from asip_asm.source import is_reserved

SUFFIX = ".interface.toml"
PROGRAMS = Path(__file__).with_name("programs")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_UNIT = re.compile(r"1|[A-Za-z%]+(\^-?[0-9]+)?([ /][A-Za-z%]+(\^-?[0-9]+)?)*")
_PATH = re.compile(r"\$?((?:\.\w+|\[[^\]]*\])*)")
_STEP = re.compile(r"\.(\w+)|\[([0-9]+)\]")
_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`")
_MISSING = re.compile(r"Object missing required field `(.*)`")
_HEAD = re.compile(r"\s*\[(\[)?\s*([A-Za-z_]\w*)")
_KEY = re.compile(r"\s*[\"']?(\w+)[\"']?\s*=")


class _Entry(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """What every entry has. `vector`: name of the array that the signals are in C and in Python."""

    names: list[str]
    unit: str
    meaning: str
    vector: str = ""
    limits: tuple[Number, Number] | None = None


class _Parameter(_Entry, frozen=True, kw_only=True):
    value: Number


class _Input(_Entry, frozen=True, kw_only=True):
    type: Literal["float", "int"] = "float"
    source: Literal["set-point", "measurement", "host"] = "host"
    rate: bool = False
    scale: Number | None = None
    offset: Number | None = None


class _State(_Entry, frozen=True, kw_only=True):
    type: Literal["float", "int"] = "float"
    initial: Number = 0.0
    starts_from: list[str] | None = None


class _Output(_Entry, frozen=True, kw_only=True):
    safe: Number


class _Set(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Outputs that are the set-points of another interface."""

    set_points_of: str
    safe: Number


class _Export(_Entry, frozen=True, kw_only=True):
    """Without unit and meaning the names are inputs or states, which have them."""

    unit: str = ""
    meaning: str = ""


class _Record(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    title: str
    include: str | None = None
    parameters: str | None = None
    parameter_names: list[str] = []
    constants: dict[str, Number] = {}
    parameter: list[_Parameter] = []
    input: list[_Input] = []
    state: list[_State] = []
    output: list[dict[str, Any]] = []
    export: list[_Export] = []


def load_interface(path: Path) -> Interface:
    """Interface record of a file, with what it includes. Raises InterfaceError, OSError."""
    return _load(path, ())


@functools.cache
def program_interface(name: str) -> Interface:
    """Record `<name>.interface.toml` of asip_asm/programs, read once."""
    return load_interface(PROGRAMS / f"{name}{SUFFIX}")


def _load(path: Path, including: tuple[Path, ...]) -> Interface:
    if path.resolve() in including:
        raise InterfaceError(f"{path}:1: error: the file includes itself; remove an 'include'")
    try:
        content, _ = read_toml(path)
        text = path.read_text(encoding="utf-8-sig")
    except (ParameterFileError, FileRefused) as error:
        raise InterfaceError(str(error)) from None
    return _Loader(path, text, (*including, path.resolve())).interface(content)


_T = TypeVar("_T", bound=msgspec.Struct)


class _Loader:
    """Turns the content of one file into an `Interface`; knows the line of each entry and key."""

    def __init__(self, path: Path, text: str, including: tuple[Path, ...]) -> None:
        self.path = path
        self.including = including
        self.lines = _lines(text)
        self.files: list[Path] = [path]

    def fail(self, where: Sequence[str | int], cause: str, cure: str) -> InterfaceError:
        """Error at a key such as ('input', 3, 'unit')."""
        where = tuple(where)
        while where and where not in self.lines:
            where = where[:-1]
        return InterfaceError(f"{self.path}:{self.lines.get(where, 1)}: error: {cause}; {cure}")

    def convert(self, content: object, kind: type[_T], base: Sequence[str | int] = ()) -> _T:
        """The content as a `kind`. Raises InterfaceError."""
        try:
            return msgspec.convert(content, kind)
        except msgspec.ValidationError as error:
            cause, _, place = str(error).partition(" - at `")
            found = _PATH.match(place)
            steps = _STEP.findall(found.group(1)) if found else []
            where = [*base, *(name or int(index) for name, index in steps)]
            unknown, missing = _UNKNOWN.match(cause), _MISSING.match(cause)
            named: type[msgspec.Struct] = kind
            if where and where[0] in KINDS and kind is _Record:
                named = _ENTRIES[str(where[0])]
            fields = [field.name for field in msgspec.structs.fields(named)]
            subject = _subject(where)
            if unknown:
                key = unknown.group(1)
                near = closest(key, fields) or f"known are {', '.join(fields)}"
                raise self.fail([*where, key], f"{subject}no key '{key}' is known", near) from None
            if missing:
                key = missing.group(1)
                cure = f"add '{key} = ...'"
                raise self.fail(where, f"{subject}'{key}' is missing", cure) from None
            cure = "write it as the format says (docs/assembly.md)"
            raise self.fail(where, f"{subject}{cause[:1].lower()}{cause[1:]}", cure) from None

    # ------------------------------------------------------------------ the record
    def interface(self, content: dict[str, Any]) -> Interface:
        record = self.convert(content, _Record)
        base = self._other(record.include, ("include",)) if record.include else None
        parameter_file = base.parameter_file if base else None
        parameter_names = base.parameter_names if base else ()
        if record.parameters is not None:
            parameter_file = self.path.parent / record.parameters
            if not parameter_file.exists():
                raise self.fail(
                    ["parameters"],
                    f"there is no file '{record.parameters}'",
                    f"give its path from {self.path.parent}",
                )
            parameter_names = tuple(record.parameter_names)
        elif record.parameter_names:
            raise self.fail(
                ["parameter_names"], "parameter_names without parameters", "name the file"
            )
        self._check_text(record.title, ("title",))
        constants = dict(base.constants) if base else {}
        for name, value in record.constants.items():
            where = ("constants", name)
            self._check_name(name, where)
            constants[name] = (value, self.path, self.lines.get(where, 1))
        signals = self._signals(record, base.signals if base else ())
        interface = Interface(
            self.path,
            record.title,
            parameter_file,
            parameter_names,
            constants,
            tuple(signals),
            tuple(dict.fromkeys(self.files)),
        )
        self._check(interface)
        return interface

    def _other(self, name: str, where: Sequence[str | int]) -> Interface:
        path = self.path.parent / name
        try:
            other = _load(path, self.including)
        except OSError as error:
            cause = f"cannot read '{name}': {error.strerror}"
            raise self.fail(where, cause, f"give its path from {self.path.parent}") from None
        self.files += other.files
        return other

    def _signals(self, record: _Record, included: Sequence[Signal]) -> list[Signal]:
        """All signals; those of the included file follow this file's own."""
        signals: list[Signal] = []
        for kind in KINDS:
            for i, entry in enumerate(getattr(record, kind)):
                if kind == "output" and "set_points_of" in entry:
                    signals += self._set(i, self.convert(entry, _Set, ("output", i)))
                    continue
                if kind == "output":
                    entry = self.convert(entry, _Output, ("output", i))
                signals += self._entry(kind, i, entry, [*signals, *included])
            signals += [signal for signal in included if signal.kind == kind]
        return signals

    def _set(self, i: int, entry: _Set) -> list[Signal]:
        other = self._other(entry.set_points_of, ("output", i, "set_points_of"))
        line = self.lines[("output", i)]
        return [
            Signal("output", s.name, s.unit, s.meaning, self.path, line, safe=entry.safe)
            for s in other.inputs
            if s.source == "set-point"
        ]

    def _entry(self, kind: str, i: int, entry: Any, known: Sequence[Signal]) -> list[Signal]:
        where = (kind, i)
        if not entry.names:
            raise self.fail([*where, "names"], "names is empty", "name a signal")
        if kind == "export" and not entry.unit and not entry.meaning:
            return [self._again(name, where, known) for name in entry.names]
        if not _UNIT.fullmatch(entry.unit):
            raise self.fail(
                [*where, "unit"],
                f"'{entry.unit}' is not a unit",
                "write it as 'm/s^2', 'kg m^2', '1' (a plain number) or 'count'",
            )
        self._check_text(entry.meaning, (*where, "meaning"))
        if not entry.meaning.strip():
            raise self.fail([*where, "meaning"], "meaning is empty", "say what the signal is")
        if entry.vector:
            self._check_name(entry.vector, (*where, "vector"))
        scaled = getattr(entry, "scale", None) is not None
        if not scaled and getattr(entry, "offset", None) is not None:
            raise self.fail([*where, "offset"], "an offset without a scale", "add 'scale = 1'")
        if scaled and entry.type != "int":
            raise self.fail(
                [*where, "scale"], "a float input has no scale", "it is in its unit already"
            )
        if scaled and entry.scale == 0:
            raise self.fail([*where, "scale"], "scale is 0", "give the unit of one count")
        limits = entry.limits
        numbers = [bound for bound in limits or () if not isinstance(bound, str)]
        if len(numbers) == 2 and not numbers[0] <= numbers[1]:
            raise self.fail(
                [*where, "limits"],
                f"the lower limit {limits[0]:g} is above the upper {limits[1]:g}",
                "write limits = [lowest, highest]",
            )
        shared = msgspec.structs.asdict(entry)
        shared |= {"file": self.path, "line": self.lines.get(where, 1)}
        names, starts = shared.pop("names"), shared.pop("starts_from", None)
        if starts is not None and len(starts) != len(names):
            raise self.fail(
                [*where, "starts_from"],
                f"{len(starts)} inputs for {len(names)} states",
                "name one input for each state",
            )
        if kind == "parameter":
            shared["initial"] = shared.pop("value")
        signals = []
        for j, name in enumerate(names):
            self._check_name(name, (*where, "names"))
            start = starts[j] if starts else None
            signals.append(Signal(kind=kind, name=name, starts_from=start, **shared))
        return signals

    def _again(self, name: str, where: Sequence[str | int], known: Sequence[Signal]) -> Signal:
        """Export of an input or state that has unit and meaning already."""
        signals = {s.name: s for s in known if s.kind in ("input", "state")}
        if name not in signals:
            cause = f"export '{name}' is no input or state and has no unit and meaning"
            near = closest(name, signals)
            raise self.fail(where, cause, near or "add unit = '...' and meaning = '...'")
        line = self.lines.get(tuple(where), 1)
        return replace(signals[name], kind="export", vector="", file=self.path, line=line)

    # ------------------------------------------------------------------ checks
    def _check_text(self, text: str, where: Sequence[str | int]) -> None:
        if not text.isprintable():
            odd = next(c for c in text if not c.isprintable())
            raise self.fail(
                where,
                f"{where[-1]} has the character {odd!r}",
                "write it as one line of printed characters",
            )

    def _check_name(self, name: str, where: Sequence[str | int]) -> None:
        if not _NAME.fullmatch(name):
            raise self.fail(
                where, f"{name!r} is not a name", "use letters, digits and _, no digit first"
            )
        if is_reserved(name):
            raise self.fail(
                where,
                f"the name '{name}' is reserved",
                "a0.., b0.., c0.., k0.., o0.., zero and pi have fixed meanings",
            )

    def _check(self, interface: Interface) -> None:
        """What concerns several signals."""
        seen: dict[str, Signal] = {}
        for signal in interface.signals:
            before = seen.setdefault(signal.name, signal)
            if before is signal:
                continue
            # The host may read back an input; everything else has one name.
            if signal.kind == "export" and before.kind in ("input", "state"):
                continue
            raise InterfaceError(
                f"{signal.file}:{signal.line}: error: '{signal.name}' appears twice; it is "
                f"{before.kind} in {before.file.name}:{before.line}"
            )
        inputs = {signal.name: signal for signal in interface.inputs}
        for state in interface.states:
            if state.starts_from is None:
                continue
            where = f"{state.file}:{state.line}: error: state '{state.name}'"
            start = inputs.get(state.starts_from)
            if start is None:
                near = closest(state.starts_from, inputs) or f"inputs are {', '.join(inputs)}"
                raise InterfaceError(
                    f"{where} starts from '{state.starts_from}', which is no input; {near}"
                )
            if state.unit not in (start.unit, COUNT):
                raise InterfaceError(
                    f"{where} has the unit {state.unit}, input '{start.name}' has {start.unit}; "
                    f"make them equal, or the state's '{COUNT}' for the raw number"
                )


_ENTRIES: Mapping[str, type] = {
    "parameter": _Parameter,
    "input": _Input,
    "state": _State,
    "output": _Output,
    "export": _Export,
}


def _subject(where: Sequence[str | int]) -> str:
    """'input 3, unit: ' of ('input', 2, 'unit')."""
    words = [str(step + 1) if isinstance(step, int) else step for step in where]
    joined = " ".join(words[:2]) + "".join(f", {word}" for word in words[2:])
    return f"{joined}: " if joined else ""


def _lines(text: str) -> dict[tuple[str | int, ...], int]:
    """Line of each table and key of a TOML text: ('title',), ('input', 0), ('input', 0, 'unit')."""
    found: dict[tuple[str | int, ...], int] = {}
    counts: dict[str, int] = {}
    table: tuple[str | int, ...] = ()
    for number, row in enumerate(text.splitlines(), 1):
        head, key = _HEAD.match(row), _KEY.match(row)
        if head:
            name = head.group(2)
            index = counts.get(name, -1) + 1
            counts[name] = index
            table = (name, index) if head.group(1) else (name,)
            found.setdefault(table, number)
        elif key:
            found.setdefault((*table, key.group(1)), number)
    return found
