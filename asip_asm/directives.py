# SPDX-License-Identifier: Apache-2.0
"""Directives of a source file: each declares names, constants or data of the `Source`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from asip_asm.diagnostics import Line, Place, SourceError, closest, counted
from asip_asm.expression import INT_RANGE, Evaluator, word_bits
from asip_asm.ir import Register, StreamBlock
from asip_asm.isa import STREAM_BITS, STREAM_PINS, Isa
from asip_asm.lexer import Cursor, Token, tokenize
from asip_asm.source import (
    NOUNS,
    Declaration,
    Source,
    is_reserved,
    physical_register,
    span,
    stream_words,
    where,
)

TYPES = ("float", "int")


class Directives:
    """Carries directives out. `table` gives the method of each, `evaluator` and `addresses` the
    values of expressions with the names declared so far, `defines` what replaces parameters.
    """

    def __init__(self, source: Source, isa: Isa, defines: Mapping[str, str]) -> None:
        self.source = source
        self.isa = isa
        self.defines = defines
        self.used_defines: set[str] = set()
        self.titled = False
        self.data_names: list[str] = []
        self.stream_pins: dict[str, str] = {}
        self.evaluator = Evaluator(self._constant, self._constant_names)
        self.addresses = Evaluator(self._address, self._address_names)
        self.places = Evaluator(self._place, self._place_names)
        self.table: dict[str, Callable[[Cursor], None]] = {
            ".program": self._program,
            ".config": self._config,
            ".input": self._input,
            ".const": partial(self._constant_declaration, replaceable=False),
            ".param": partial(self._constant_declaration, replaceable=True),
            ".state": self._state,
            ".output": self._output,
            ".export": self._export,
            ".data": self._data,
            ".space": self._space,
            ".stream": partial(self._stream, lanes=1),
            ".vectors": partial(self._stream, lanes=isa.lanes_of_a_vector),
            ".reg": self._reg,
            ".watchdog": self._watchdog,
        }

    def address(self, cursor: Cursor) -> tuple[float, str]:
        """Value of the address expression at the cursor, and the block of data memory that it
        names, empty without one or with several. Raises SourceError.
        """
        self.data_names = []
        value = self.addresses.expression(cursor)
        return value, self.data_names[0] if len(self.data_names) == 1 else ""

    def stream_place(self, cursor: Cursor) -> tuple[str, int, str]:
        """Pipe and address of the place in a stream at the cursor, and the block that it names, ''
        where it names the pipe. Raises SourceError.
        """
        self.stream_pins = {}
        token = cursor.token
        value = self.places.expression(cursor)
        place = span(token, cursor)
        if len(self.stream_pins) != 1:
            raise SourceError(
                place,
                "a place in a stream names one block of it",
                "seek W, or seek W+3 for its fourth word, where .stream declares W",
            )
        ((name, pin),) = self.stream_pins.items()
        block = next((b for b in self.source.streams if b.name == name), None)
        first = block.address if block else 0
        words = len(block.words) if block else stream_words(self.source.streams, pin)
        if not value.is_integer() or not first <= value < first + words:
            raise SourceError(
                place,
                f"'{name}' has {counted(words, 'word')}, there is no word {value - first:g}",
                f"words are {name}+0 to {name}+{words - 1}" if words else "declare it with .stream",
            )
        return pin, int(value), name if block else ""

    # ------------------------------------------------------------------ names

    def _constant(self, name: str) -> float | None:
        declaration = self.source.names.get(name)
        if declaration is None and name in self.source.doubtful:
            return 1.0
        if declaration is None or declaration.kind != "constant":
            return None
        self.source.used.add(name)
        declaration.folded = True
        return declaration.value

    def _address(self, name: str) -> float | None:
        declaration = self.source.names.get(name)
        if declaration is not None and declaration.kind == "data":
            self.data_names.append(name)
            return declaration.value
        return self._constant(name)

    def _place(self, name: str) -> float | None:
        declaration = self.source.names.get(name)
        if declaration is not None and declaration.kind == "stream":
            self.stream_pins[name] = str(declaration.pin)
            self.source.used.add(name)
            return declaration.value
        if name in tuple(STREAM_PINS) and declaration is None:
            self.stream_pins[name] = name
            return 0.0
        return self._constant(name)

    def _place_names(self) -> list[str]:
        return [d.name for kind in ("constant", "stream") for d in self.source.of_kind(kind)]

    def _constant_names(self) -> list[str]:
        return [d.name for d in self.source.of_kind("constant")]

    def _address_names(self) -> list[str]:
        return [d.name for kind in ("constant", "data") for d in self.source.of_kind(kind)]

    def _declare(self, declaration: Declaration) -> Declaration:
        name, place = declaration.name, declaration.place
        if is_reserved(name):
            raise SourceError(
                place,
                f"'{name}' cannot be declared: the name is reserved",
                "a0.., b0.., c0.., k0.., o0.., zero and pi have fixed meanings",
            )
        before = self.source.names.get(name)
        if before is not None:
            raise SourceError(
                place,
                f"'{name}' is declared twice",
                f"it is {NOUNS[before.kind]}, declared at {where(before.place)}",
            )
        self.source.names[name] = declaration
        return declaration

    def _type(self, cursor: Cursor) -> str:
        if not cursor.accept(":"):
            return "float"
        token = cursor.expect_kind("name", "a type: float or int")
        if token.text not in TYPES:
            raise SourceError(
                token.place,
                f"unknown type '{token.text}'",
                closest(token.text, TYPES) or "types are float and int",
            )
        return token.text

    def _value(self, cursor: Cursor) -> tuple[float, Place]:
        token = cursor.token
        value = self.evaluator.expression(cursor)
        return value, span(token, cursor)

    def _pin(self, cursor: Cursor) -> Token | None:
        if not cursor.accept(","):
            return None
        word = cursor.expect_kind("name", "'pin'")
        if cursor.token.text in ("=", ":"):
            raise SourceError(
                word.place,
                f"'{word.text}' is a second name; this directive declares one",
                f"write {cursor.tokens[0].text} {word.text} ... in a line of its own",
            )
        if word.text != "pin":
            raise SourceError(word.place, f"expected 'pin', found '{word.text}'")
        return cursor.expect_kind("name", "a bank or register to pin to")

    # ------------------------------------------------------------------ directives

    def _program(self, cursor: Cursor) -> None:
        directive = cursor.tokens[cursor.position - 1]
        title = cursor.expect_kind("string", 'a title in quotes: .program "title"')
        if self.titled:
            raise SourceError(directive.place, "second .program", "a file has one title")
        self.titled = True
        self.source.title = title.text

    def _config(self, cursor: Cursor) -> None:
        token = cursor.expect_kind("name", "a configuration")
        known = self.isa.configurations
        if token.text not in known:
            raise SourceError(
                token.place,
                f"unknown configuration '{token.text}'",
                closest(token.text, known) or f"configurations are {', '.join(known)}",
            )
        before = self.source.configuration
        if before is not None and before[0] != token.text:
            raise SourceError(
                token.place,
                f".config {token.text} contradicts .config {before[0]}",
                f"first at {where(before[1])}",
            )
        self.source.configuration = (token.text, token.place)

    def _input(self, cursor: Cursor) -> None:
        for name in cursor.names("the name of an input", "between inputs"):
            declaration = Declaration("input", name.text, name.place, self._type(cursor))
            declaration.value = len(self.source.of_kind("input"))
            self._declare(declaration)
            if declaration.value >= self.isa.banks["K"].size:
                raise SourceError(
                    name.place, f"too many inputs: bank K has {self.isa.banks['K'].size} words"
                )

    def _constant_declaration(self, cursor: Cursor, replaceable: bool) -> None:
        name = cursor.expect_kind("name", "the name of a constant")
        cursor.expect("=", "after the name")
        value, place = self._value(cursor)
        if replaceable and name.text in self.defines:
            self.used_defines.add(name.text)
            line = Line(f"-D {name.text}", 1, self.defines[name.text])
            value, place = self._value(whole := Cursor(tokenize(line)))
            whole.expect_end()
        type_name = self._type(cursor)
        declaration = Declaration(
            "constant", name.text, name.place, type_name, value, replaceable=replaceable
        )
        declaration.bits = word_bits(value, type_name, place)
        register = physical_register(name.text)
        pin = self._pin(cursor)
        if register is not None and register.bank == "K":
            declaration.name = ""
            declaration.pin = register
        else:
            self._declare(declaration)
            if pin is not None:
                declaration.pin = physical_register(pin.text)
        in_bank_k = isinstance(declaration.pin, Register) and declaration.pin.bank == "K"
        if pin is not None and not (declaration.name and in_bank_k):
            raise SourceError(
                pin.place, f"a constant cannot be pinned to '{pin.text}'", "pin k0..k127"
            )
        if isinstance(declaration.pin, Register):
            self._place_constant(declaration, pin or name)

    def _place_constant(self, declaration: Declaration, token: Token) -> None:
        assert isinstance(declaration.pin, Register)
        index = declaration.pin.index
        if index >= self.isa.banks["K"].size:
            raise SourceError(
                token.place, f"there is no register '{token.text}'", "bank K is k0..k127"
            )
        for before in self.source.placed:
            same = (before.bits, before.type) == (declaration.bits, declaration.type)
            if before.pin == declaration.pin and not same:
                raise SourceError(
                    token.place,
                    f"k{index} holds another constant",
                    f"declared at {where(before.place)}",
                )
        self.source.placed.append(declaration)

    def _state(self, cursor: Cursor) -> None:
        name = cursor.expect_kind("name", "the name of a state")
        type_name = self._type(cursor)
        cursor.expect("=", "and the initial value after the name of a state")
        value, place = self._value(cursor)
        declaration = Declaration("state", name.text, name.place, type_name)
        declaration.bits = word_bits(value, type_name, place)
        self._declare(declaration)
        pin = self._pin(cursor)
        if pin is None:
            return
        declaration.pin = pin.text if pin.text in ("A", "B", "C") else physical_register(pin.text)
        chosen = declaration.pin
        wrong = isinstance(chosen, Register) and chosen.bank not in ("A", "B", "C")
        if chosen is None or wrong:
            declaration.pin = None
            raise SourceError(
                pin.place,
                f"a state cannot be pinned to '{pin.text}'",
                "pin A, B or C, or a register of these banks",
            )

    def _output(self, cursor: Cursor) -> None:
        name = cursor.expect_kind("name", "the name of an output")
        cursor.expect(",", "and the safe value: .output name, safe = value")
        word = cursor.expect_kind("name", "'safe'")
        if word.text != "safe":
            raise SourceError(word.place, f"expected 'safe', found '{word.text}'")
        cursor.expect("=", "after safe")
        value, place = self._value(cursor)
        declaration = Declaration("output", name.text, name.place)
        declaration.bits = word_bits(value, "float", place)
        declaration.value = len(self.source.of_kind("output"))
        self._declare(declaration)
        if declaration.value >= self.isa.outputs:
            raise SourceError(name.place, f"too many outputs: the core has {self.isa.outputs}")

    def _export(self, cursor: Cursor) -> None:
        for name in cursor.names("the name of a register", "between exports"):
            place = name.place
            for other, first, _ in self.source.exports:
                if other == name.text:
                    raise SourceError(
                        place, f"'{name.text}' is exported twice", f"first at {where(first)}"
                    )
            register = None
            if cursor.accept("="):
                token = cursor.expect_kind("name", "a physical register")
                register, place = token.text, token.place
            self.source.exports.append((name.text, place, register))

    def _data(self, cursor: Cursor) -> None:
        type_name = "float"
        if cursor.token.kind == "name" and cursor.peek().text in ("=", ":"):
            name = cursor.take()
            type_name = self._type(cursor)
            cursor.expect("=", "after the name")
            self._declare(
                Declaration("data", name.text, name.place, value=float(len(self.source.data)))
            )
        elif cursor.at(":"):
            type_name = self._type(cursor)
            cursor.expect("=", "after the type")
        while True:
            value, place = self._value(cursor)
            self._append_data([word_bits(value, type_name, place)], place)
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between data words")

    def _space(self, cursor: Cursor) -> None:
        name = cursor.expect_kind("name", "the name of a block of data memory")
        cursor.expect(",", "and the number of words after the name")
        value, place = self._value(cursor)
        if not value.is_integer() or value < 1:
            raise SourceError(place, f"{value:g} is not a number of words")
        self._declare(
            Declaration("data", name.text, name.place, value=float(len(self.source.data)))
        )
        words = min(int(value), self.isa.data_words + 1)
        self._append_data([0] * words, place)

    def _append_data(self, words: list[int], place: Place) -> None:
        if len(self.source.data) + len(words) > self.isa.data_words:
            raise SourceError(place, f"too many data words: data memory has {self.isa.data_words}")
        self.source.data += words

    def _stream(self, cursor: Cursor, lanes: int) -> None:
        """A block of words, or of vectors whose words are given lane after lane."""
        streams = self.source.streams
        directive = ".stream" if lanes == 1 else ".vectors"
        name, comma, word = (cursor.tokens + cursor.tokens[-1:] * 2)[cursor.position :][:3]
        if name.kind == "name" and (comma.text, word.text) == (",", "pin"):
            cursor.take()
            pin = self._pin(cursor)
            assert pin is not None
            if pin.text not in tuple(STREAM_PINS):
                raise SourceError(
                    pin.place,
                    f"there is no stream of '{pin.text}'",
                    "pin A or B, a multiply-add pipe",
                )
            cursor.expect("=", "and the words after the pipe")
            if name.text in tuple(STREAM_PINS):
                raise SourceError(
                    name.place, f"a block of a stream cannot be named '{name.text}', as a pipe is"
                )
            address = stream_words(streams, pin.text)
            declared = Declaration(
                "stream", name.text, name.place, value=float(address), pin=pin.text
            )
            self._declare(declared)
            further: list[list[int]] = [[] for _ in range(1, lanes)]
            streams.append(StreamBlock(name.text, pin.text, address, lanes=further))
        elif not streams or (name.kind == "name" and comma.text == "="):
            raise SourceError(
                name.place,
                "a stream needs a name and its pipe",
                f"{directive} name, pin A = words; only a second {directive} after it goes on "
                "without",
            )
        block = streams[-1]
        if len(block.lanes) != lanes - 1:
            raise SourceError(
                name.place,
                f"'{block.name}' has {'vectors' if block.lanes else 'words'}",
                f"{directive} name, pin A = words begins another block",
            )
        while True:
            for i, lane in enumerate((block.words, *block.lanes)):
                if i:
                    cursor.expect(",", f"a vector has {lanes} words")
                value, place = self._value(cursor)
                lane.append(word_bits(value, "float", place))
            if stream_words(streams, block.pin) > 1 << STREAM_BITS:
                raise SourceError(place, f"too many words: a stream has at most {1 << STREAM_BITS}")
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between words of a stream")

    def _reg(self, cursor: Cursor) -> None:
        for name in cursor.names("the name of a register", "between registers"):
            self._declare(Declaration("register", name.text, name.place))

    def _watchdog(self, cursor: Cursor) -> None:
        value, place = self._value(cursor)
        if not value.is_integer() or not 1 <= value <= INT_RANGE[1]:
            raise SourceError(
                place, f"{value:g} is not a number of cycles", f"an integer 1..{INT_RANGE[1]}"
            )
        self.source.watchdog = int(value)
