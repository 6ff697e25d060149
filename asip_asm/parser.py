# SPDX-License-Identifier: Apache-2.0
"""Statements of a source file: declarations and raw operations, names not yet resolved."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.diagnostics import Line, Place, Reporter, SourceError, closest, shortened
from asip_asm.expression import INT_RANGE, Evaluator, word_bits
from asip_asm.ir import Register, SourceLine
from asip_asm.isa import IMMEDIATE_WIDTH, Isa, OperationRecord
from asip_asm.lexer import Cursor, Token, equation, tokenize
from asip_asm.limits import BUNDLE_LINES
from asip_asm.reader import READER_DIRECTIVES, Reader, display_path

TYPES = ("float", "int")
NOUNS = {
    "input": "an input",
    "constant": "a constant",
    "state": "a state",
    "output": "an output",
    "data": "data memory",
    "register": "a symbolic register",
}

OTHER_NAMES = {
    **dict.fromkeys(("load", "ldr", "lw"), "ld"),
    **dict.fromkeys(("store", "str", "sw"), "st"),
    **dict.fromkeys(("move", "copy"), "mov"),
    **dict.fromkeys(("jump", "goto", "b"), "jmp"),
    **dict.fromkeys(("end", "ret", "stop", "return", "exit"), "halt"),
    **dict.fromkeys(("mac", "fma", "fmac"), "fmadd"),
}
"""What other assemblers call the operations."""

_PHYSICAL = re.compile(r"([abck])([0-9]+)")
_OUTPUT = re.compile(r"o([0-9]+)")


@dataclass(eq=False)
class Declaration:
    """A declared name. `value` is a constant's value in double precision or a data address; `bits`
    a constant's, state's or safe value's bits; `place_in` the bank or register it is pinned to.
    """

    kind: str
    name: str
    place: Place
    type: str = "float"
    value: float | None = None
    bits: int = 0
    pin: str | Register | None = None
    replaceable: bool = False


@dataclass(frozen=True)
class Operand:
    """Operand as written: kind 'name', 'value' or 'address' (value + index register name, text is
    the block of data memory that it names).
    """

    kind: str
    place: Place
    text: str = ""
    value: float = 0.0
    index: Operand | None = None


@dataclass(eq=False)
class RawOperation:
    """Operation as written."""

    record: OperationRecord
    place: Place
    operands: Mapping[str, Operand]
    source: SourceLine


@dataclass(eq=False)
class Statement:
    """One step of the program text: label, linear operation, bundle in braces, or halt."""

    kind: str
    place: Place
    label: str = ""
    operations: list[RawOperation] = field(default_factory=list)
    halt: bool = False


@dataclass(eq=False)
class Source:
    """A parsed file. `exports` holds (name, place, register name or None), `placed` the constants
    that the source puts at a word of bank K, unnamed ones too, `doubtful` the names in statements
    that have an error: what is missing about them is no error of its own; `incomplete` tells that
    an operation may be missing. `used` are the declared names that anything reads, `main_file` is
    the parsed file as messages show it, `files` are all files that were read.
    """

    title: str = ""
    configuration: tuple[str, Place] | None = None
    watchdog: int = 10000
    names: dict[str, Declaration] = field(default_factory=dict)
    placed: list[Declaration] = field(default_factory=list)
    exports: list[tuple[str, Place, str | None]] = field(default_factory=list)
    data: list[int] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    doubtful: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    main_file: str = ""
    files: list[Path] = field(default_factory=list)
    incomplete: bool = False
    last_place: Place | None = None

    def of_kind(self, kind: str) -> list[Declaration]:
        """Declarations of a kind in order."""
        return [d for d in self.names.values() if d.kind == kind]


def physical_register(name: str) -> Register | None:
    """Register that the name denotes, existing or not; None for any other name."""
    if name == "zero":
        return Register("zero", 0)
    match = _PHYSICAL.fullmatch(name)
    # Longer numbers are of no register, whatever their digits.
    return Register(match.group(1).upper(), int(match.group(2)[:6])) if match else None


def output_index(name: str) -> int | None:
    """Index of an output name `o<n>`; None for any other name."""
    match = _OUTPUT.fullmatch(name)
    return int(match.group(1)[:6]) if match else None


def is_reserved(name: str) -> bool:
    """Whether the language itself gives the name a meaning."""
    return name == "pi" or physical_register(name) is not None or output_index(name) is not None


def parse_file(
    path: Path,
    isa: Isa,
    reporter: Reporter,
    defines: Mapping[str, str] | None = None,
    include_path: Sequence[Path] = (),
    params: Path | None = None,
) -> Source:
    """Parse a file with all it includes; errors go to the reporter.

    `defines` replaces values of parameters, `params` the parameter files. Raises OSError for the
    file itself.
    """
    return _Parser(isa, reporter, defines or {}, include_path, params).parse(path)


class _Parser:
    def __init__(
        self,
        isa: Isa,
        reporter: Reporter,
        defines: Mapping[str, str],
        include_path: Sequence[Path],
        params: Path | None,
    ) -> None:
        self.isa = isa
        self.reporter = reporter
        self.defines = defines
        self.used_defines: set[str] = set()
        self.source = Source()
        self.titled = False
        self.labels: dict[str, Place] = {}
        self.data_names: list[str] = []
        self.most_operations = isa.program_bundles * max(
            len(each.slots) for each in isa.configurations.values()
        )
        self.operations = 0
        self.evaluator = Evaluator(self._constant, self._constant_names)
        self.addresses = Evaluator(self._address, self._address_names)
        self.reader = Reader(
            reporter,
            self.evaluator.expression,
            lambda name: is_reserved(name) or name == "halt" or name in isa.operations,
            self._failed,
            include_path,
            params,
        )
        self.directives: dict[str, Callable[[Cursor], None]] = {
            ".program": self._program,
            ".config": self._config,
            ".input": self._input,
            ".const": self._const,
            ".param": self._param,
            ".state": self._state,
            ".output": self._output,
            ".export": self._export,
            ".data": self._data,
            ".space": self._space,
            ".reg": self._reg,
            ".watchdog": self._watchdog,
        }

    def parse(self, path: Path) -> Source:
        pending: list[Token] = []
        pending_lines = 0
        self.source.main_file = display_path(path)
        self.source.last_place = Place(Line(self.source.main_file, 1, ""))
        for tokens in self.reader.read(path):
            self.source.last_place = tokens[-1].place
            if pending:
                tokens = [*pending[:-1], *tokens]
            pending_lines += 1
            if _open_brace(tokens):
                if pending_lines > BUNDLE_LINES:
                    break
                pending = tokens
                continue
            pending, pending_lines = [], 0
            self._statement(tokens)
        if pending:
            brace = next(t for t in pending if t.kind == "symbol" and t.text == "{")
            limit = f" within {BUNDLE_LINES} lines" if pending_lines > BUNDLE_LINES else ""
            self.reporter.add(brace.place, f"bundle without closing brace{limit}", "add }")
            self.source.incomplete |= bool(limit)
        for name in self.defines:
            if name not in self.used_defines:
                known = [d.name for d in self.source.of_kind("constant") if d.replaceable]
                self.reporter.add(
                    None,
                    f"-D {name}: the program has no parameter '{name}'",
                    closest(name, known) or "only names declared with .param can be replaced",
                )
        self.source.files = self.reader.files
        return self.source

    def _statement(self, tokens: list[Token]) -> None:
        cursor = Cursor(tokens)
        try:
            while cursor.token.kind == "name" and cursor.peek().text == ":":
                self._label(cursor)
            token = cursor.token
            statement: Statement | None = None
            if token.kind == "end":
                return
            if token.kind == "directive":
                cursor.take()
                if token.text not in self.directives:
                    raise SourceError(
                        token.place,
                        f"unknown directive '{token.text}'",
                        closest(token.text, [*self.directives, *READER_DIRECTIVES]),
                    )
                self.directives[token.text](cursor)
            elif cursor.at("{"):
                statement = self._bundle(cursor)
            elif token.kind == "name" and token.text == "halt":
                cursor.take()
                statement = Statement("halt", token.place)
            else:
                operation = self._operation(cursor)
                statement = Statement("operation", token.place, operations=[operation])
            cursor.expect_end()
            if statement is not None:
                self.source.statements.append(statement)
        except SourceError as error:
            self.reporter.take(error.diagnostic)
            self.source.doubtful.update(t.text for t in tokens if t.kind == "name")
            if tokens[0].kind != "directive":
                self.source.incomplete = True

    def _failed(self, names: list[str]) -> None:
        self.source.doubtful.update(names)
        self.source.incomplete = True

    def _label(self, cursor: Cursor) -> None:
        token = cursor.take()
        cursor.take()
        before = self.labels.setdefault(token.text, token.place)
        if before is not token.place:
            raise SourceError(
                token.place,
                f"label '{token.text}' is defined twice",
                f"first at {_where(before)}",
            )
        self.source.statements.append(Statement("label", token.place, token.text))

    # ------------------------------------------------------------------ operations

    def _bundle(self, cursor: Cursor) -> Statement:
        brace = cursor.take()
        statement = Statement("bundle", brace.place)
        while True:
            statement.operations.append(self._operation(cursor))
            if cursor.accept("}"):
                break
            cursor.expect("|", "or '}' behind an operation of a bundle")
        if cursor.token.kind == "name" and cursor.token.text == "halt":
            cursor.take()
            statement.halt = True
        return statement

    def _operation(self, cursor: Cursor) -> RawOperation:
        token = cursor.expect_kind("name", "an operation")
        self.operations += 1
        if self.operations > self.most_operations:
            self.reporter.fatal(
                token.place,
                f"more than {self.most_operations} operations: program memory holds "
                f"{self.isa.program_bundles} bundles",
                "shorten the program, or repeat parts of it with a branch",
            )
        record = self.isa.operations.get(token.text)
        if record is None:
            if token.text == "halt":
                raise SourceError(
                    token.place, "'halt' is no operation of a bundle", "write it behind the '}'"
                )
            raise SourceError(
                token.place, f"unknown operation '{shortened(token.text)}'", self._meant(cursor)
            )
        found = _operand_count(cursor)
        if found != len(record.operands):
            raise SourceError(
                token.place,
                f"{record.name} takes {_count(len(record.operands), 'operand')}, found {found}",
                f"{record.name} {', '.join(record.operands)}".strip(),
            )
        operands: dict[str, Operand] = {}
        for i, kind in enumerate(record.operands):
            if i:
                cursor.expect(",", f"between the operands of {record.name}")
            operands[kind] = self._operand(cursor, kind, record)
        if not (cursor.token.kind == "end" or cursor.at("|") or cursor.at("}")):
            raise SourceError(
                cursor.token.place,
                f"'{cursor.token.text}' behind the operands of {record.name}",
                "an operand that is an expression is written in parentheses",
            )
        line = token.line
        last = cursor.tokens[cursor.position - 1]
        text = (
            line.text[token.place.column : last.end]
            if last.line is line
            else line.text[token.place.column :]
        )
        source = SourceLine(line.file, line.number, " ".join(text.split()), equation(line.text))
        place = Place(line, token.place.column, token.place.length)
        return RawOperation(record, place, operands, source)

    def _meant(self, cursor: Cursor) -> str:
        """What an unknown operation, behind which the cursor stands, may have been meant to be."""
        name = cursor.tokens[cursor.position - 1].text
        known = [*self.isa.operations, "halt", *self.reader.macros]
        lower = name.lower()
        if lower in known:
            return f"operations are written in lower case: {lower}"
        if f"f{lower}" in known:
            other = f", for integers '{integer}'" if (integer := f"i{lower}") in known else ""
            return f"did you mean 'f{lower}'{other}?"
        if lower in OTHER_NAMES:
            return f"did you mean '{OTHER_NAMES[lower]}'?"
        near = closest(name, known)
        alone = cursor.token.kind == "end" or cursor.token.text in known
        if alone and not near:
            return f"a label is written with a colon: {shortened(name)}:"
        return near

    def _operand(self, cursor: Cursor, kind: str, record: OperationRecord) -> Operand:
        token = cursor.token
        if kind == "address":
            return self._address_operand(cursor)
        if kind == "target":
            cursor.expect_kind("name", "a label")
            return Operand("name", token.place, token.text)
        if kind == "dst":
            cursor.expect_kind("name", f"the destination of {record.name}")
            return Operand("name", token.place, token.text)
        if token.kind == "name":
            cursor.take()
            if cursor.at("("):
                raise SourceError(
                    token.place,
                    "an expression as an operand is written in parentheses",
                    f"({token.text}(...))",
                )
            return Operand("name", token.place, token.text)
        if token.kind == "number" or cursor.at("(") or cursor.at("-"):
            if cursor.at("-") and cursor.peek().kind != "number":
                raise SourceError(
                    token.place,
                    "an expression as an operand is written in parentheses",
                    f"(-{cursor.peek().text})",
                )
            value = self.evaluator.operand(cursor)
            return Operand("value", _span(token, cursor), value=value)
        raise cursor.unexpected(f"operand {kind} of {record.name}: a register, a number or '('")

    def _address_operand(self, cursor: Cursor) -> Operand:
        token = cursor.token
        self.data_names = []
        value = self.addresses.expression(cursor)
        place = _span(token, cursor)
        block = self.data_names[0] if len(self.data_names) == 1 else ""
        index = None
        if cursor.accept("["):
            name = cursor.expect_kind("name", "the index register")
            index = Operand("name", name.place, name.text)
            cursor.expect("]", "behind the index register")
        limit = (1 << IMMEDIATE_WIDTH) if index else self.isa.data_words
        if not value.is_integer() or not 0 <= value < limit:
            raise SourceError(
                place,
                f"data address {value:g} is out of range",
                f"{'offsets' if index else 'addresses'} are integers 0..{limit - 1}",
            )
        return Operand("address", place, block, value, index)

    # ------------------------------------------------------------------ names

    def _constant(self, name: str) -> float | None:
        declaration = self.source.names.get(name)
        if declaration is None and name in self.source.doubtful:
            return 1.0
        if declaration is None or declaration.kind != "constant":
            return None
        self.source.used.add(name)
        return declaration.value

    def _address(self, name: str) -> float | None:
        declaration = self.source.names.get(name)
        if declaration is not None and declaration.kind == "data":
            self.data_names.append(name)
            return declaration.value
        return self._constant(name)

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
                f"it is {NOUNS[before.kind]}, declared at {_where(before.place)}",
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
        return value, _span(token, cursor)

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
                f"first at {_where(before[1])}",
            )
        self.source.configuration = (token.text, token.place)

    def _input(self, cursor: Cursor) -> None:
        while True:
            name = cursor.expect_kind("name", "the name of an input")
            declaration = Declaration("input", name.text, name.place, self._type(cursor))
            declaration.value = len(self.source.of_kind("input"))
            self._declare(declaration)
            if declaration.value >= self.isa.banks["K"].size:
                raise SourceError(
                    name.place, f"too many inputs: bank K has {self.isa.banks['K'].size} words"
                )
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between inputs")

    def _const(self, cursor: Cursor) -> None:
        self._constant_declaration(cursor, replaceable=False)

    def _param(self, cursor: Cursor) -> None:
        self._constant_declaration(cursor, replaceable=True)

    def _constant_declaration(self, cursor: Cursor, replaceable: bool) -> None:
        name = cursor.expect_kind("name", "the name of a constant")
        cursor.expect("=", "behind the name")
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
        if pin is not None and (not declaration.name or not _is_bank(declaration.pin, "K")):
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
                    f"declared at {_where(before.place)}",
                )
        self.source.placed.append(declaration)

    def _state(self, cursor: Cursor) -> None:
        name = cursor.expect_kind("name", "the name of a state")
        type_name = self._type(cursor)
        cursor.expect("=", "and the initial value behind the name of a state")
        value, place = self._value(cursor)
        declaration = Declaration("state", name.text, name.place, type_name)
        declaration.bits = word_bits(value, type_name, place)
        self._declare(declaration)
        pin = self._pin(cursor)
        if pin is None:
            return
        declaration.pin = pin.text if pin.text in ("A", "B", "C") else physical_register(pin.text)
        register = isinstance(declaration.pin, Register)
        if declaration.pin is None or (register and declaration.pin.bank not in ("A", "B", "C")):
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
        cursor.expect("=", "behind safe")
        value, place = self._value(cursor)
        declaration = Declaration("output", name.text, name.place)
        declaration.bits = word_bits(value, "float", place)
        declaration.value = len(self.source.of_kind("output"))
        self._declare(declaration)
        if declaration.value >= self.isa.outputs:
            raise SourceError(name.place, f"too many outputs: the core has {self.isa.outputs}")

    def _export(self, cursor: Cursor) -> None:
        while True:
            name = cursor.expect_kind("name", "the name of a register")
            place = name.place
            for other, first, _ in self.source.exports:
                if other == name.text:
                    raise SourceError(
                        place, f"'{name.text}' is exported twice", f"first at {_where(first)}"
                    )
            register = None
            if cursor.accept("="):
                token = cursor.expect_kind("name", "a physical register")
                register, place = token.text, token.place
            self.source.exports.append((name.text, place, register))
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between exports")

    def _data(self, cursor: Cursor) -> None:
        type_name = "float"
        if cursor.token.kind == "name" and cursor.peek().text in ("=", ":"):
            name = cursor.take()
            type_name = self._type(cursor)
            cursor.expect("=", "behind the name")
            self._declare(
                Declaration("data", name.text, name.place, value=float(len(self.source.data)))
            )
        elif cursor.at(":"):
            type_name = self._type(cursor)
            cursor.expect("=", "behind the type")
        while True:
            value, place = self._value(cursor)
            self._append_data([word_bits(value, type_name, place)], place)
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between data words")

    def _space(self, cursor: Cursor) -> None:
        name = cursor.expect_kind("name", "the name of a block of data memory")
        cursor.expect(",", "and the number of words behind the name")
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

    def _reg(self, cursor: Cursor) -> None:
        while True:
            name = cursor.expect_kind("name", "the name of a register")
            self._declare(Declaration("register", name.text, name.place))
            if cursor.token.kind == "end":
                return
            cursor.expect(",", "between registers")

    def _watchdog(self, cursor: Cursor) -> None:
        value, place = self._value(cursor)
        if not value.is_integer() or not 1 <= value <= INT_RANGE[1]:
            raise SourceError(
                place, f"{value:g} is not a number of cycles", f"an integer 1..{INT_RANGE[1]}"
            )
        self.source.watchdog = int(value)


def _is_bank(pin: str | Register | None, bank: str) -> bool:
    return isinstance(pin, Register) and pin.bank == bank


def _open_brace(tokens: list[Token]) -> bool:
    """Whether a bundle of these tokens goes on in the next line."""
    texts = [t.text for t in tokens if t.kind == "symbol"]
    return "{" in texts and "}" not in texts


def _operand_count(cursor: Cursor) -> int:
    """Operands up to the end of the operation: top-level commas and one."""
    depth, commas, position = 0, 0, cursor.position
    while True:
        token = cursor.tokens[position]
        if token.kind == "end" or (token.kind == "symbol" and token.text in "|}"):
            break
        if token.kind == "symbol":
            depth += (token.text in "([") - (token.text in ")]")
            commas += token.text == "," and depth == 0
        position += 1
    return 0 if position == cursor.position else commas + 1


def _span(first: Token, cursor: Cursor) -> Place:
    """Characters from a token to the last one consumed."""
    last = cursor.tokens[max(cursor.position - 1, 0)]
    if last.line is not first.line:
        return first.place
    return Place(first.line, first.place.column, max(1, last.end - first.place.column))


def _where(place: Place) -> str:
    return f"{place.line.file}:{place.line.number}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
