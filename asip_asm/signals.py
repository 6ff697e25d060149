# SPDX-License-Identifier: Apache-2.0
"""A controller program's interface: its signals with units and limits, and values of expressions.

`asip_asm.interface` reads it from a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from asip_asm.diagnostics import Line, SourceError
from asip_asm.expression import Evaluator
from asip_asm.lexer import Cursor, tokenize
from asip_asm.parameters import ParameterFileError, read_parameters

KINDS = ("parameter", "input", "state", "output", "export")
COUNT = "count"
"""Unit of the raw number of an encoder."""

Number = float | str
"""A number, or an expression of parameters and constants."""


class InterfaceError(ValueError):
    """An interface record has a mistake; the text is `file:line: error: cause; cure`."""


@dataclass(frozen=True)
class Signal:
    """One parameter, input, state, output or export.

    unit: of the physical value, which is scale * number + offset for an input of type 'int'.
    limits: smallest and largest physical value. initial: of a state, or a parameter's value; safe:
    what an output takes after a fault. starts_from: the input whose first value presets a state
    (its number where the state's unit is 'count', else its physical value). source: 'set-point',
    'measurement' or 'host'; rate: a speed or acceleration, zero at rest. line: in `file`.
    """

    kind: str
    name: str
    unit: str
    meaning: str
    file: Path
    line: int
    type: str = "float"
    vector: str = ""
    limits: tuple[Number, Number] | None = None
    scale: Number | None = None
    offset: Number | None = None
    initial: Number = 0.0
    starts_from: str | None = None
    safe: Number = 0.0
    source: str = "host"
    rate: bool = False


@dataclass(frozen=True)
class Interface:
    """A whole record. `parameter_file` and `parameter_names` (empty: all) state which file's
    parameters expressions may use; `constants` are expressions in order, with file and line.
    """

    file: Path
    title: str
    parameter_file: Path | None
    parameter_names: tuple[str, ...]
    constants: Mapping[str, tuple[Number, Path, int]]
    signals: tuple[Signal, ...]
    files: tuple[Path, ...]

    def of_kind(self, kind: str) -> tuple[Signal, ...]:
        """Signals of a kind of `KINDS` in order; for inputs and outputs that is their index."""
        return tuple(signal for signal in self.signals if signal.kind == kind)

    @property
    def inputs(self) -> tuple[Signal, ...]:
        return self.of_kind("input")

    @property
    def states(self) -> tuple[Signal, ...]:
        return self.of_kind("state")

    @property
    def outputs(self) -> tuple[Signal, ...]:
        return self.of_kind("output")

    @property
    def exports(self) -> tuple[Signal, ...]:
        return self.of_kind("export")

    @property
    def set_points(self) -> tuple[str, ...]:
        """Names of the inputs that come from a planner."""
        return tuple(signal.name for signal in self.inputs if signal.source == "set-point")

    @property
    def measurements(self) -> tuple[str, ...]:
        """Names of the inputs that come from encoders or sensors."""
        return tuple(signal.name for signal in self.inputs if signal.source == "measurement")

    def names(self, parameters: Mapping[str, float] | None = None) -> dict[str, float]:
        """Value of every parameter and constant. `parameters` replaces values of the parameter
        file and of the record. Raises InterfaceError, and OSError for the parameter file.
        """
        values: dict[str, float] = {}
        if self.parameter_file is not None:
            try:
                found = read_parameters(self.parameter_file)
            except ParameterFileError as error:
                raise InterfaceError(str(error)) from None
            values = {name: float(value) for name, (value, _) in found.items()}
        given = dict(parameters or {})
        for signal in self.of_kind("parameter"):
            if signal.name not in given:
                where = (signal.file, signal.line)
                values[signal.name] = evaluate(signal.initial, values | given, *where)
        values |= given
        for name, (expression, file, line) in self.constants.items():
            values[name] = evaluate(expression, values, file, line)
        return values

    def physical(self, signal: Signal, number: float, names: Mapping[str, float]) -> float:
        """Physical value of an input's number, in the input's unit."""
        scale = 1.0 if signal.scale is None else self.value(signal.scale, signal, names)
        return number * scale + self.value(signal.offset or 0.0, signal, names)

    def first_states(
        self, inputs: Mapping[str, float], parameters: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Values of the states that start from an input, from the inputs of the first tick."""
        names, signals = self.names(parameters), {signal.name: signal for signal in self.inputs}
        return {
            state.name: inputs[state.starts_from]
            if state.unit == COUNT
            else self.physical(signals[state.starts_from], inputs[state.starts_from], names)
            for state in self.states
            if state.starts_from is not None
        }

    def value(self, number: Number, signal: Signal, names: Mapping[str, float]) -> float:
        """Value of a number of the signal; `names` as `names()` gives them."""
        return evaluate(number, names, signal.file, signal.line)


def evaluate(number: Number, names: Mapping[str, float], file: Path, line: int) -> float:
    """Value of a number or expression in double precision. Raises InterfaceError."""
    if not isinstance(number, str):
        return float(number)
    try:
        cursor = Cursor(tokenize(Line(str(file), line, number)))
        value = Evaluator(names.get, lambda: list(names)).expression(cursor)
        cursor.expect_end()
        return value
    except SourceError as error:
        found = error.diagnostic
        help_text = f"; {found.help}" if found.help else ""
        raise InterfaceError(
            f"{file}:{line}: error: '{number}': {found.message}{help_text}"
        ) from None
