# SPDX-License-Identifier: Apache-2.0
"""Breakpoints and watches: where they are, and when a hit stops the program or writes a message."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field

from sim.debug.asip_dbg.expressions import Expression, ExpressionError
from sim.debug.asip_dbg.locations import Location
from sim.debug.asip_dbg.values import ValueMissing

Read = Callable[[str], float | int]
_HIT = re.compile(r"\s*(==|=|>=|<=|>|<|%)?\s*([0-9]{1,9})\s*")
_RELATIONS: dict[str, Callable[[int, int], bool]] = {
    "==": operator.eq,
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
    "%": lambda hits, every: hits % every == 0,
}
_PIECE = re.compile(r"\{([^{}]*)\}")


@dataclass(frozen=True)
class Hits:
    """Which hits count: `5` or `== 5` the fifth, `>= 5` from the fifth on, `% 5` every fifth."""

    text: str
    relation: str
    number: int

    @staticmethod
    def parse(text: str) -> Hits | None:
        """None for an empty text. Raises ExpressionError."""
        if not text.strip():
            return None
        match = _HIT.fullmatch(text)
        if match is None or (match[1] == "%" and int(match[2]) == 0):
            raise ExpressionError(
                f"'{text.strip():.40}' is not a hit condition; write a number, or one after "
                "==, >=, >, <=, < or %"
            )
        relation = "==" if match[1] in (None, "=") else match[1]
        return Hits(text.strip(), relation, int(match[2]))

    def count(self, hits: int) -> bool:
        """Whether hit number `hits`, from 1, counts."""
        return _RELATIONS[self.relation](hits, self.number)


@dataclass(frozen=True)
class Message:
    """A text of a log point; an expression in braces is replaced by its value."""

    text: str
    pieces: tuple[Expression, ...] = field(compare=False)

    @staticmethod
    def parse(text: str) -> Message | None:
        """None for an empty text. Raises ExpressionError."""
        if not text:
            return None
        if re.search(r"[{}]", _PIECE.sub("", text)):
            raise ExpressionError(f"'{text:.60}': a brace without its partner")
        return Message(text, tuple(Expression(piece) for piece in _PIECE.findall(text)))

    def filled(self, read: Read) -> str:
        """The text with values; a name without a value says why in its place."""
        values = []
        for piece in self.pieces:
            try:
                value = piece.value(read)
                values.append(f"{value:.9g}" if isinstance(value, float) else str(value).lower())
            except (ExpressionError, ValueMissing) as error:
                values.append(f"<{error}>")
        found = iter(values)
        return _PIECE.sub(lambda match: next(found), self.text)


@dataclass
class Breakpoint:
    """A breakpoint before the bundles of a location, or with `place` a watch of a register, an
    output or a data word. `watch`: the value whose writes alone stop, as registers are shared.

    A data word is compared with `word`, its value before, in the bundles of the location, which
    follow stores that may write it.

    A hit is a pass with the condition true. `ignored` hits do nothing; of the others `counted`
    chooses, and those stop the program, or write `message` if there is one.
    """

    location: Location
    condition: Expression | None = None
    temporary: bool = False
    watch: str = ""
    place: str = ""
    word: int = 0
    counted: Hits | None = None
    message: Message | None = None
    enabled: bool = True
    hits: int = 0
    ignored: int = 0
    number: int = 0
    commands: list[str] = field(default_factory=list)

    @property
    def kind(self) -> str:
        return "watch" if self.place else "breakpoint"

    @property
    def in_data(self) -> bool:
        """Whether a data word is watched: by breakpoints, since the core cannot."""
        return self.place.startswith("d")

    def passed(self, read: Read) -> tuple[bool, str]:
        """Count a pass; whether it acts, and why the condition has no value if it has none.

        A condition without a value acts: the user sees the reason instead of a missed stop.
        """
        why = ""
        if self.condition is not None:
            try:
                if not self.condition.value(read):
                    return False, ""
            except (ExpressionError, ValueMissing) as error:
                why = f"; the condition has no value: {error}"
        self.hits += 1
        if self.ignored:
            self.ignored -= 1
            return False, ""
        return self.counted is None or self.counted.count(self.hits), why
