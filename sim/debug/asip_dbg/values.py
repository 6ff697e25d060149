# SPDX-License-Identifier: Apache-2.0
"""Values by their names in the source: read and set where the debug map says they are."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from asip_asm.debug_map import Where
from asip_asm.diagnostics import closest, shortened
from asip_asm.isa import default_isa
from sim.core.backends import Backend, number
from sim.debug.asip_dbg.program import DebuggedProgram
from sim.rtl.asip_bus import AsipError, LinkError

_PLACE = re.compile(r"\$?([abcko])([0-9]{1,3})")
CONSTANT = "ks"
"""First letters of places that a program cannot write: bank K, streams."""
_ELEMENT = re.compile(r"([A-Za-z_][A-Za-z0-9_.]*)(?:\[([0-9]{1,9})\])?")
_BITS = re.compile(r"0[xX]([0-9a-fA-F]{8})|0[bB]([01]{32})|0[fF]([0-9a-fA-F]{8})")


class ValueMissing(ValueError):
    """The name has no value here, or there is no such name; the message says why."""


@dataclass(frozen=True)
class Reading:
    """A value: name, 'float' or 'int', its bits, its place ('a3'), what is to know about it, and
    the words of all lanes of a vector whose target shows them.
    """

    name: str
    type: str
    word: int
    place: str
    note: str = ""
    lanes: tuple[int, ...] = ()

    @property
    def number(self) -> float | int:
        """The value by its type."""
        return number(self.word, self.type)


def format_word(word: int, type_name: str, form: str = "") -> str:
    """Text of a word: form 'x' hexadecimal, 'd' int32, 'u' unsigned, 't' binary, 'f' float, empty
    by its type. Floats are the shortest text that reads back as the same binary32.
    """
    if form == "x":
        return f"0x{word:08x}"
    if form == "t":
        return f"0b{word:032b}"
    if form == "u":
        return str(word)
    if form == "d" or (not form and type_name == "int"):
        return str(number(word, "int"))
    return short_float(word)


def text_of(reading: Reading, form: str = "") -> str:
    """A reading in a form as `format_word` has them; of a vector all lanes that are there."""
    if reading.lanes:
        return f"[{', '.join(format_word(word, reading.type, form) for word in reading.lanes)}]"
    return format_word(reading.word, reading.type, form)


def short_float(word: int) -> str:
    """Shortest decimal text of a binary32."""
    value = number(word, "float")
    for digits in range(6, 10):
        text = f"{value:.{digits}g}"
        if value != value or struct.pack(">f", float(text)) == word.to_bytes(4, "big"):
            return text
    return text


def bits_of(text: str) -> int | None:
    """Word that a text gives as its bits: eight hexadecimal digits after 0x or 0f, or 32 binary
    ones after 0b, as the forms x and t show them. None for any other text.
    """
    match = _BITS.fullmatch(text.strip())
    if match is None:
        return None
    return int(match[2], 2) if match[2] else int(match[1] or match[3], 16)


@contextmanager
def _refusals() -> Iterator[None]:
    """What the target refuses has no value; that it is gone stays an error of its own."""
    try:
        yield
    except LinkError:
        raise
    except AsipError as error:
        raise ValueMissing(str(error)) from None


class Values:
    """Names of a program on a target; `position` is where the program is.

    `inputs` are the words of the next run by name; bank K cannot be read back from a core.
    """

    def __init__(
        self, program: DebuggedProgram, target: Backend, position: Callable[[], int]
    ) -> None:
        self.program = program
        self.target = target
        self.position = position
        image = program.image
        self.inputs = {entry.name: 0 for entry in image.inputs}
        in_k = [(entry.name, f"k{entry.index}", entry.type) for entry in image.inputs]
        in_k += [(entry.name, f"k{entry.index}", entry.type) for entry in image.constants]
        self._places = {entry.name: entry.register for entry in image.exports}
        self._places |= {name: place for name, place, _ in in_k}
        self._types = {place: kind for _, place, kind in in_k}
        self._constants = {f"k{entry.index}": int(entry.bits, 16) for entry in image.constants}
        self._input_of = {f"k{entry.index}": entry.name for entry in image.inputs}

    def names(self) -> list[str]:
        """Every name that `read` knows, without plain registers."""
        image = self.program.image
        names = [*self.program.map.names(), *(entry.name for entry in image.inputs)]
        names += [output.name for output in image.outputs]
        names += [state.name for state in image.states]
        names += [constant.name for constant in image.constants]
        names += [export.name for export in image.exports]
        names += image.data_names
        names += [block.name for block in image.streams]
        plain = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")
        return list(dict.fromkeys(name for name in names if plain.fullmatch(name)))

    # ------------------------------------------------------------------ read
    def read(self, name: str) -> Reading:
        """The value of a name here. Raises ValueMissing, LinkError."""
        if name in self.inputs:
            return self._register(name, self._places[name])
        where = self.program.finder.find(name, self.position())
        if where is not None:
            return self._found(name, where)
        if name in self._places or self._is_place(name):
            return self._register(name, self._places.get(name, name.lstrip("$")))
        address = self.data_address(name)
        if address is not None:
            return Reading(name, "float", self.target_word(f"d{address}"), f"d{address}", "data")
        element = self._stream_word(name) or self._lane(name)
        if element is None:
            raise ValueMissing(self._unknown(name))
        return element

    def _stream_word(self, name: str) -> Reading | None:
        """A word of a block of a stream, which is that of the program; None if the name is none.

        The words of a block of vectors have the order of the source: all lanes of a vector first.
        Raises ValueMissing.
        """
        match = _ELEMENT.fullmatch(name)
        block = match and next(
            (each for each in self.program.image.streams if each.name == match.group(1)), None
        )
        if not match or not block:
            return None
        lanes, element = (block.words, *block.lanes), int(match.group(2) or 0)
        count = len(lanes) * len(block.words)
        if element >= count:
            raise ValueMissing(f"{name}: {block.name} has {count} words, 0 to {count - 1}")
        at, lane = divmod(element, len(lanes))
        note = f"stream of pipe {block.pin}" + (f", lane {lane}" if block.lanes else "")
        place = f"s{block.pin.lower()}{block.address + at}"
        return Reading(name, "float", int(lanes[lane][at], 16), place, note)

    def _lane(self, name: str) -> Reading | None:
        """A lane of a vector, as `v[2]`; None if the name is none. Raises ValueMissing."""
        match = _ELEMENT.fullmatch(name)
        where = match and match.group(2) and self._vector(match.group(1))
        if not match or not where:
            return None
        lane, lanes = int(match.group(2)), default_isa().lanes_of_a_vector
        if lane >= lanes:
            raise ValueMissing(f"{name}: a vector has lanes 0 to {lanes - 1}")
        if not where.place:
            raise ValueMissing(f"{match.group(1)}: {where.text}")
        place = where.place + (f".{lane}" if lane else "")
        return Reading(name, "float", self.target_word(place), place, f"lane {lane} of {lanes}")

    def _vector(self, name: str) -> Where | None:
        """Where a vector is now; None if the name is none."""
        where = self.program.finder.find(name, self.position())
        return where if where is not None and self.program.is_vector(where.value) else None

    def data_address(self, name: str) -> int | None:
        """Address of a word of a table, None if the name is none. Raises ValueMissing."""
        match = _ELEMENT.fullmatch(name)
        tables = self.program.image.data_names
        if match is None or match.group(1) not in tables:
            return None
        table, element = match.group(1), int(match.group(2) or 0)
        first = tables[table]
        end = min(
            (other for other in tables.values() if other > first),
            default=len(self.program.image.data),
        )
        if first + element >= end:
            raise ValueMissing(f"{name}: {table} has {end - first} words, 0 to {end - first - 1}")
        return first + element

    def check(self, name: str) -> None:
        """Refuse a name that no place of the program has. Raises ValueMissing."""
        if name in self.inputs or self.program.map.named(name) or self._is_place(name):
            return
        if name in self._places or self.data_address(name) is not None:
            return
        match = _ELEMENT.fullmatch(name)
        if self._stream_word(name) or (match and self._named_vector(match.group(1))):
            return
        raise ValueMissing(self._unknown(name))

    def _named_vector(self, name: str) -> bool:
        """Whether a name of the source is that of a vector."""
        return any(map(self.program.is_vector, self.program.map.named(name)))

    def _own_input(self, name: str) -> None:
        """Inputs are known where the debugger writes them. Raises ValueMissing elsewhere."""
        if self.target.driven:
            raise ValueMissing(
                f"{name} is an input, which the machine's host writes and nobody can read back"
            )

    def _found(self, name: str, where: Where) -> Reading:
        value = where.value
        if not where.place:
            raise ValueMissing(f"{name}: {where.text}")
        notes = [where.text] if where.text else []
        done = [w.bundle for w in value.writes if w.bundle < self.position()]
        if done:
            notes.append(f"from bundle {done[-1]}")
        elif not value.writes or value.version < 1:
            notes.append("from the run before")
        if value.line:
            equation = f" ({value.equation})" if value.equation else ""
            notes.append(f"{value.file}:{value.line}{equation}")
        word, lanes = self.target_word(where.place), tuple[int, ...]()
        if self.program.is_vector(value):
            lanes = self._lanes(where.place)
            if not lanes:
                notes.insert(0, "lane 0 of a vector, the others only with --iss")
        return Reading(name, value.type, word, where.place, ", ".join(notes), lanes)

    def _lanes(self, place: str) -> tuple[int, ...]:
        """Words of a vector by lane; none where the target shows the first lane alone."""
        count = default_isa().lanes_of_a_vector
        try:
            further = [self.target_word(f"{place}.{lane}") for lane in range(1, count)]
        except ValueMissing:
            return ()
        return (self.target_word(place), *further)

    def _is_place(self, name: str) -> bool:
        match = _PLACE.fullmatch(name)
        if match is None:
            return False
        bank, index = match.group(1), int(match.group(2))
        isa = default_isa()
        return index < (isa.outputs if bank == "o" else isa.banks[bank.upper()].size)

    def _register(self, name: str, place: str) -> Reading:
        if place[0] == "k":
            if place not in self._types:
                raise ValueMissing(f"{name}: the program has nothing in {place}")
            kind = self._types[place]
            if place in self._constants:
                return Reading(name, kind, self._constants[place], place, "constant")
            self._own_input(name)
            return Reading(name, kind, self.inputs[self._input_of[place]], place, "input")
        value = self.program.finder.holder(place, self.position())
        note = f"{value.name}" if value and value.name != name else ""
        return Reading(name, value.type if value else "float", self.target_word(place), place, note)

    def target_word(self, place: str) -> int:
        """Word of a place of the target. Raises ValueMissing, LinkError."""
        with _refusals():
            return self.target.read(place)

    def _unknown(self, name: str) -> str:
        known = self.names()
        return f"the program has no value '{shortened(name)}'; " + (
            closest(name, known) or "info values lists them"
        )

    # ------------------------------------------------------------------ write
    def set(self, name: str, word: int | None, value: float = 0.0) -> Reading:
        """Give a name another value: `word` as bits, or a number by the type. Raises ValueMissing,
        LinkError.
        """
        if name in self.inputs:
            self._own_input(name)
            kind = self._types[self._places[name]]
            self.inputs[name] = self.word(name, kind, value) if word is None else word
            return self.read(name)
        reading = self.read(name)
        if reading.place[0] in CONSTANT:
            raise ValueMissing(
                f"{name} is a constant of the program; change it in the source, or with -D"
            )
        bits = self.word(name, reading.type, value) if word is None else word
        with _refusals():
            self.target.write(reading.place, bits)
        return self.read(name)

    @staticmethod
    def word(name: str, kind: str, value: float) -> int:
        """Bits of a number as a value of a type. Raises ValueMissing."""
        if kind == "int":
            if value != value or value not in (int(value) if abs(value) < 1 << 33 else None,):
                raise ValueMissing(f"{name} is an int32, {value} is not")
            if not -(1 << 31) <= value < 1 << 32:
                raise ValueMissing(f"{name}: {value:.0f} does not fit in 32 bits")
            return int(value) & 0xFFFFFFFF
        try:
            return int.from_bytes(struct.pack(">f", value), "big")
        except OverflowError:
            raise ValueMissing(f"{name}: {value:g} is too large for binary32") from None
