# SPDX-License-Identifier: Apache-2.0
"""Statements of a source file: operations, bundles and labels, names not yet resolved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from asip_asm.diagnostics import Line, Place, Reporter, SourceError, closest, counted, shortened
from asip_asm.directives import Directives
from asip_asm.ir import SourceLine
from asip_asm.isa import IMMEDIATE_WIDTH, LOOP_BITS, STREAM_BITS, STREAM_PINS, Isa, OperationRecord
from asip_asm.lexer import Cursor, Token, equation
from asip_asm.limits import BUNDLE_LINES
from asip_asm.reader import READER_DIRECTIVES, Reader, display_path
from asip_asm.source import (
    Operand,
    RawOperation,
    Source,
    Statement,
    is_reserved,
    span,
    where,
)

_AFTER_OPERAND = (",", "|", "}")
"""Symbols that may follow an operand."""

OTHER_NAMES = {
    **dict.fromkeys(("load", "ldr", "lw"), "ld"),
    **dict.fromkeys(("store", "str", "sw"), "st"),
    **dict.fromkeys(("move", "copy"), "mov"),
    **dict.fromkeys(("jump", "goto", "b"), "jmp"),
    **dict.fromkeys(("end", "ret", "stop", "return", "exit"), "halt"),
    **dict.fromkeys(("repeat", "rept", "for", "do"), "loop"),
    **dict.fromkeys(("endrepeat", "endr", "endfor", "next"), "endloop"),
    **dict.fromkeys(("mac", "fma", "fmac"), "fmadd"),
}
"""What other assemblers call the operations."""
ALONE = ("halt", "endloop")
"""Statements that are no operations."""


class Parser:
    """Parser of one program; errors go to the reporter.

    `defines` replaces values of parameters, `params` the parameter files.
    """

    def __init__(
        self,
        isa: Isa,
        reporter: Reporter,
        defines: Mapping[str, str],
        include_path: Sequence[Path] = (),
        params: Path | None = None,
    ) -> None:
        self.isa = isa
        self.reporter = reporter
        self.defines = defines
        self.source = Source()
        self.labels: dict[str, Place] = {}
        self.most_operations = isa.program_bundles * max(
            len(each.slots) for each in isa.configurations.values()
        )
        self.operations = 0
        self.directives = Directives(self.source, isa, defines)
        self.reader = Reader(
            reporter,
            self.directives.evaluator.expression,
            lambda name: is_reserved(name) or name in ALONE or name in isa.operations,
            self._failed,
            include_path,
            params,
        )

    def parse(self, path: Path) -> Source:
        """A file with all it includes. Raises OSError for the file itself."""
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
            if name not in self.directives.used_defines:
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
                if token.text not in self.directives.table:
                    raise SourceError(
                        token.place,
                        f"unknown directive '{token.text}'",
                        closest(token.text, [*self.directives.table, *READER_DIRECTIVES]),
                    )
                self.directives.table[token.text](cursor)
            elif cursor.at("{"):
                statement = self._bundle(cursor)
            elif token.kind == "name" and token.text in ALONE:
                cursor.take()
                statement = Statement(token.text, token.place)
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
                f"first at {where(before)}",
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
            cursor.expect("|", "or '}' after an operation of a bundle")
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
                "shorten the program, or repeat parts of it with a branch or a loop",
            )
        record = self.isa.operations.get(token.text)
        if record is None:
            if token.text in ALONE:
                raise SourceError(
                    token.place,
                    f"'{token.text}' is no operation of a bundle",
                    "write it after the '}'"
                    if token.text == "halt"
                    else "write it in its own line",
                )
            raise SourceError(
                token.place, f"unknown operation '{shortened(token.text)}'", self._meant(cursor)
            )
        found = _operand_count(cursor)
        if found != len(record.operands):
            words = _words(cursor)
            cure = f"{record.name} {', '.join(record.operands)}".strip()
            if len(words) == len(record.operands):
                cure = f"commas separate operands: {record.name} {', '.join(words)}"
            raise SourceError(
                token.place,
                f"{record.name} takes {counted(len(record.operands), 'operand')}, found {found}",
                cure,
            )
        operands: dict[str, Operand] = {}
        for i, kind in enumerate(record.operands):
            if i:
                cursor.expect(",", f"between the operands of {record.name}")
            operands[kind] = self._operand(cursor, kind, record)
        if not (cursor.token.kind == "end" or cursor.at("|") or cursor.at("}")):
            raise SourceError(
                cursor.token.place,
                f"'{cursor.token.text}' after the operands of {record.name}",
                "an operand that is an expression is written in parentheses",
            )
        line = token.place.line
        last = cursor.tokens[cursor.position - 1]
        end = last.end if last.place.line is line else None
        text = line.text[token.place.column : end]
        source = SourceLine(
            line.file, line.number, " ".join(text.split()), equation(line.text), line.expansions
        )
        return RawOperation(record, token.place, operands, source)

    def _meant(self, cursor: Cursor) -> str:
        """What the unknown operation before the cursor may have been meant to be."""
        name = cursor.tokens[cursor.position - 1].text
        known = [*self.isa.operations, *ALONE, *self.reader.macros]
        lower = name.lower()
        if lower in known:
            return f"operations are written in lower case: {lower}"
        if f"f{lower}" in known:
            other = f", for integers '{integer}'" if (integer := f"i{lower}") in known else ""
            return f"did you mean 'f{lower}'{other}?"
        if lower[:1] == "i" and f"f{lower[1:]}" in known:
            theirs = [op for op in self.isa.operations if op[0] == "i"]
            return f"integers have no such operation; theirs are {', '.join(theirs)}"
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
        if kind == "lane":
            last = self.isa.lanes_of_a_vector - 1
            lane = self.directives.evaluator.expression(cursor)
            if not lane.is_integer() or not 0 <= lane <= last:
                raise SourceError(
                    span(token, cursor), f"there is no lane {lane:g}", f"lanes are 0..{last}"
                )
            return Operand("count", span(token, cursor), value=lane)
        if kind == "count":
            rounds = self.directives.evaluator.expression(cursor)
            if not rounds.is_integer() or not 1 <= rounds <= 1 << LOOP_BITS:
                raise SourceError(
                    span(token, cursor),
                    f"a loop of {rounds:g} rounds",
                    f"the number of rounds is an integer constant, 1..{1 << LOOP_BITS}",
                )
            return Operand("count", span(token, cursor), value=rounds)
        if kind == "stream":
            pin, address, block = self.directives.stream_place(cursor)
            value = float(STREAM_PINS.index(pin) << STREAM_BITS | address)
            return Operand("place", span(token, cursor), block, value)
        if kind in ("target", "dst"):
            what = "a label" if kind == "target" else f"the destination of {record.name}"
            return Operand("name", token.place, cursor.expect_kind("name", what).text)
        if token.kind == "name":
            cursor.take()
            if cursor.at("+") and (
                cursor.peek().kind == "end" or cursor.peek().text in _AFTER_OPERAND
            ):
                cursor.take()
                return Operand("stream", span(token, cursor), token.text)
            if cursor.at("("):
                raise SourceError(
                    token.place,
                    "an expression as an operand is written in parentheses",
                    f"({token.text}(...))",
                )
            return Operand("name", token.place, token.text)
        if token.kind == "number" or cursor.at("(") or cursor.at("-"):
            if cursor.at("-") and cursor.peek().kind != "number":
                name = cursor.peek().text
                if cursor.peek().kind == "name" and name not in self.directives.evaluator.known():
                    raise SourceError(
                        token.place,
                        f"'{name}' is not a constant: an operand cannot negate it",
                        f"subtract it instead, or negate it first: fsub negative, 0.0, {name}",
                    )
                raise SourceError(
                    token.place,
                    "an expression as an operand is written in parentheses",
                    f"(-{name})",
                )
            value = self.directives.evaluator.operand(cursor)
            return Operand("value", span(token, cursor), value=value)
        raise cursor.unexpected(f"operand {kind} of {record.name}: a register, a number or '('")

    def _address_operand(self, cursor: Cursor) -> Operand:
        token = cursor.token
        value, block = self.directives.address(cursor)
        place = span(token, cursor)
        index = None
        if cursor.accept("["):
            name = cursor.expect_kind("name", "the index register")
            index = Operand("name", name.place, name.text)
            cursor.expect("]", "after the index register")
        limit = (1 << IMMEDIATE_WIDTH) if index else self.isa.data_words
        if not value.is_integer() or not 0 <= value < limit:
            raise SourceError(
                place,
                f"data address {value:g} is out of range",
                f"{'offsets' if index else 'addresses'} are integers 0..{limit - 1}",
            )
        return Operand("address", place, block, value, index)


def _open_brace(tokens: list[Token]) -> bool:
    """Whether a bundle of these tokens goes on in the next line."""
    texts = [t.text for t in tokens if t.kind == "symbol"]
    return "{" in texts and "}" not in texts


def _words(cursor: Cursor) -> list[str]:
    """Names and numbers of an operation that has nothing else but commas, else none."""
    words, position = [], cursor.position
    while (token := cursor.tokens[position]).kind in ("name", "number") or token.text == ",":
        words += [token.text] if token.text != "," else []
        position += 1
    return words if token.kind == "end" else []


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
