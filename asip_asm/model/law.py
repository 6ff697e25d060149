# SPDX-License-Identifier: Apache-2.0
"""A control law as the compiler takes it: a function and the signals that it connects.

Arguments and results of the function go by name. A signal belongs to the argument of its name, or,
one of several, to the argument that its `vector` names: the signals are its elements at its full
shape, column by column, structural zeros included. The function sees physical
values: an encoder is an int32 input with `scale` and `offset`, and an argument named by a `rate_of`
signal is the difference of two successive counts, taken as integers, times scale: exact where a
difference of floats is not. A state's next value is the result `<state>_next` (`<vector>_next`).
"""

from __future__ import annotations

import functools
import itertools
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from asip_asm.diagnostics import closest
from asip_asm.interface import load_interface
from asip_asm.isa import default_isa
from asip_asm.machine import Machine
from asip_asm.model.graph import Graph
from asip_asm.model.onnx_file import SUFFIX as ONNX
from asip_asm.model.onnx_file import OnnxPolicy, load_onnx
from asip_asm.model.read import Entry, ModelError, Scalars, read_function, scalars
from asip_asm.model.saved import SavedFunction, load_saved
from asip_asm.signals import COUNT, Interface, Signal
from asip_asm.source import is_reserved

Model = ca.Function | SavedFunction | OnnxPolicy
"""What a law is made of."""


@dataclass(frozen=True)
class Port:
    """One signal of a law; kind: 'input', 'state', 'parameter', 'output', 'export' or 'rate'.

    type 'int': an encoder count, whose physical value is scale * count + offset [unit]. A 'rate' is
    no word of the program but scale * (count - count before) of the int input `rate_of`. limits:
    smallest and largest value: test inputs are drawn from them, an output is saturated to them.
    initial: of a state, or a parameter's value; safe: what an output takes after a fault. change:
    largest difference of an input of type float and that of the last tick [unit].
    """

    kind: str
    name: str
    unit: str = "1"
    meaning: str = ""
    type: str = "float"
    vector: str = ""
    limits: tuple[float, float] | None = None
    scale: float = 1.0
    offset: float = 0.0
    initial: float = 0.0
    safe: float = 0.0
    rate_of: str = ""
    change: float = math.inf


@dataclass(frozen=True)
class Law:
    """A function with its ports. `title` names the program, `doc` describes it in one line."""

    title: str
    function: Model
    ports: Sequence[Port]
    doc: str = ""
    rate: float = 10_000.0
    """Ticks per second."""

    def of_kind(self, kind: str) -> list[Port]:
        return [port for port in self.ports if port.kind == kind]

    def port(self, name: str) -> Port:
        return next(port for port in self.ports if port.name == name)

    @property
    def in_casadi(self) -> ca.Function:
        """The function of a law that was made in Python. Raises ModelError for a file's."""
        if not isinstance(self.function, ca.Function):
            raise ModelError(f"{self.title}: the function of a file is not evaluated here")
        return self.function

    @functools.cached_property
    def scalars(self) -> Scalars:
        """The function in scalar instructions. Raises ModelError."""
        function = self.function
        return scalars(function) if isinstance(function, ca.Function) else function.scalars

    def arguments(self) -> list[tuple[str, list[Port]]]:
        """Name and ports of each of the function's arguments, a port for each element.

        Raises ModelError.
        """
        return self.matched("argument", self.scalars.arguments)

    def results(self) -> list[tuple[str, list[Port]]]:
        """The same for its results."""
        return self.matched("result", self.scalars.results)

    def matched(self, what: str, entries: Sequence[Entry]) -> list[tuple[str, list[Port]]]:
        """Names and ports of arguments, or of results. Raises ModelError."""
        if what == "argument":
            kinds = ("input", "state", "parameter", "rate")
            return _match(what, self, entries, [p for p in self.ports if p.kind in kinds], "")
        targets = [p for p in self.ports if p.kind in ("output", "state", "export")]
        return _match(what, self, entries, targets, NEXT)


_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
NEXT = "_next"
"""Suffix of the name of a state, or of its vector: the result with its next value."""


def load_function(source: Model | Path | str, whole: bool = True) -> Model:
    """A function as it is, or that of an ONNX file or one of `Function.save`. Raises ModelError."""
    if not isinstance(source, Path | str):
        return source
    path = Path(source)
    return load_onnx(path, whole) if path.suffix.lower() == ONNX else load_saved(path)


def load_law(
    function: Model | Path | str, record: Interface | Path | str, whole: bool = True
) -> Law:
    """Law of a function, an ONNX file or one of `Function.save`, and an interface record. whole:
    scalar instructions of an ONNX file are read now, not where they are needed.

    An argument `<input>_rate` is the speed of an encoder: the record has a state of unit 'count'
    that starts from the input, and the constant or parameter `T_s`, seconds between ticks. Raises
    ModelError, InterfaceError, OSError.
    """
    function = load_function(function, whole)
    interface = record if isinstance(record, Interface) else load_interface(Path(record))
    names = interface.names()
    period = names.get("T_s", 1e-4)
    ports: list[Port] = []
    counts = {s.starts_from: s for s in interface.states if s.unit == COUNT and s.starts_from}
    for signal in interface.signals:
        if signal in counts.values():
            continue
        if signal.kind == "state" and signal.type == "int":
            raise ModelError(
                f"{signal.file}:{signal.line}: error: state '{signal.name}' is an int, which a law "
                f"has for the last count of an input alone; add unit = '{COUNT}' and starts_from, "
                "one state for each input, or make it a float"
            )
        ports.append(_port(signal, interface, names))
        if signal.kind == "input" and signal.name in counts:
            if "T_s" not in names:
                raise ModelError(f"{interface.file}: rates need the constant T_s [s] of a tick")
            ports.append(_rate(ports[-1], period))
    known = {port.name: port.kind for port in ports if port.kind != "export"}
    for signal in interface.exports:
        if known.get(signal.name) in ("input", "parameter"):
            raise ModelError(
                f"{signal.file}:{signal.line}: error: [[export]] '{signal.name}' is an "
                f"{known[signal.name]}, which the host has written; leave it out"
            )
    ports = [port for port in ports if port.kind != "export" or port.name not in known]
    return Law(interface.title, function, ports, rate=1.0 / period)


def _port(signal: Signal, interface: Interface, names: dict[str, float]) -> Port:
    def number(value: float | str | None, default: float = 0.0) -> float:
        return default if value is None else interface.value(value, signal, names)

    limits = None
    if signal.limits is not None:
        limits = (number(signal.limits[0]), number(signal.limits[1]))
    return Port(
        kind=signal.kind,
        name=signal.name,
        unit=signal.unit,
        meaning=signal.meaning,
        type=signal.type,
        vector=signal.vector,
        limits=limits,
        scale=number(signal.scale, 1.0),
        offset=number(signal.offset),
        initial=number(signal.initial),
        safe=number(signal.safe),
    )


def _rate(count: Port, period: float) -> Port:
    """Port of the speed of an encoder; test inputs go through its range in 100 ticks."""
    scale = count.scale / period
    low, high = count.limits or (-1.0, 1.0)
    most = (high - low) / (100 * period)
    return Port(
        kind="rate",
        name=f"{count.name}_rate",
        unit=f"{count.unit}/s" if count.unit != "1" else "1/s",
        vector=f"{count.vector}_rate" if count.vector else "",
        limits=(-most, most),
        scale=scale,
        rate_of=count.name,
    )


def _match(
    what: str, law: Law, entries: Sequence[Entry], ports: Sequence[Port], suffix: str
) -> list[tuple[str, list[Port]]]:
    known: dict[str, Port] = {}
    vectors: dict[str, list[Port]] = {}
    for port in ports:
        end = suffix if port.kind == "state" else ""
        known[port.name + end] = port
        if port.vector:
            vectors.setdefault(port.vector + end, []).append(port)
    return [(entry.name, _ports_of(what, law, entry, known, vectors)) for entry in entries]


def _ports_of(
    what: str, law: Law, entry: Entry, known: dict[str, Port], vectors: dict[str, list[Port]]
) -> list[Port]:
    """Signals of an argument or result, one for each element."""
    name, shape = entry.name, f"{entry.rows} by {entry.columns}"
    if name in known and name in vectors and [known[name]] != vectors[name]:
        raise ModelError(
            f"{law.title}: {what} '{name}' of the function is both a signal and the vector of "
            f"{', '.join(port.name for port in vectors[name])}; rename one"
        )
    found = vectors.get(name) or ([known[name]] if name in known else [])
    if len(found) == entry.elements:
        return found
    if not found:
        names = [*known, *vectors]
        near = closest(name, names) or f"signals are {', '.join(names) or 'none'}"
        size = "" if entry.elements == 1 else f" ({shape})"
        raise ModelError(
            f"{law.title}: {what} '{name}'{size} of the function has no signal; {near}"
        )
    raise ModelError(
        f"{law.title}: {what} '{name}' of the function is {shape}, the interface gives it "
        f"{len(found)} signals ({', '.join(port.name for port in found[:4])}"
        f"{', ...' if len(found) > 4 else ''}); give vector = '{name}' a signal for each of its "
        f"{entry.elements} elements, column by column, zeros too"
    )


def check_ports(law: Law) -> None:
    """Raises ModelError for what the program could not say."""
    seen: set[str] = set()
    for port in law.ports:
        if port.name in seen:
            raise ModelError(f"{law.title}: signal '{port.name}' appears twice; rename one")
        if is_reserved(port.name) or not _NAME.fullmatch(port.name):
            raise ModelError(
                f"{law.title}: {port.name!r} cannot name a signal; a name has letters, digits and "
                "'_' of ASCII and is no word of the assembler"
            )
        seen.add(port.name)
        if port.rate_of and (port.rate_of not in seen or law.port(port.rate_of).type != "int"):
            raise ModelError(
                f"{law.title}: rate '{port.name}' is of '{port.rate_of}', which is no int input "
                "above it"
            )
    for port in law.of_kind("rate"):
        if before(port.rate_of) in seen:
            raise ModelError(
                f"{law.title}: '{before(port.rate_of)}' is the name of the last count of "
                f"'{port.rate_of}'; rename the signal"
            )
        seen.add(before(port.rate_of))
    for name, found in (("arguments", law.scalars.arguments), ("results", law.scalars.results)):
        for entry, times in Counter(entry.name for entry in found).items():
            if times > 1:
                raise ModelError(f"{law.title}: {times} {name} are named '{entry}'; rename one")
    law.arguments()
    given: dict[tuple[bool, str], str] = {}
    for result, ports in law.results():
        for port in ports:
            key = (port.kind == "state", port.name)
            if key in given:
                raise ModelError(
                    f"{law.title}: the results '{given[key]}' and '{result}' both give "
                    f"'{port.name}'; leave one out"
                )
            given[key] = result
    missing = [p.name for p in law.ports if p.kind in ("output", "export")
               and (False, p.name) not in given]  # fmt: skip
    if missing:
        raise ModelError(
            f"{law.title}: no result of the function gives {', '.join(missing)}; name a result so"
        )
    held = [p.name for p in law.of_kind("state") if (True, p.name) not in given]
    if held:
        raise ModelError(
            f"{law.title}: no result of the function gives the next value of "
            f"{', '.join(held)}; name a result '{held[0]}{NEXT}' (or that of its vector), or make "
            "it a [[parameter]]"
        )


WORK = 24
"""Registers of each bank that states leave to the values of a run."""


def room_for_states(machine: Machine) -> dict[str, int]:
    """States that bank C and the banks of the multiply-add pipes may hold."""
    sizes = {bank: max(0, machine.bank_sizes[bank] - WORK) for bank in "ABC"}
    return {"pipes": sizes["A"] + sizes["B"], "C": sizes["C"]}


def check_limits(law: Law, machine: Machine) -> None:
    """Raises ModelError for more signals than the core has places."""
    isa = default_isa()
    rates = len(law.of_kind("rate"))
    states = len(law.of_kind("state")) + rates
    room = room_for_states(machine)
    words = sum(p.kind in ("input", "parameter") for p in law.ports)
    outputs = len(law.of_kind("output"))
    most, registers = isa.banks["K"].size, sum(room.values())
    if words > most:
        raise ModelError(
            f"{law.title}: {words} inputs and parameters, bank K holds {most} words; "
            + ("make parameters [constants]" if law.of_kind("parameter") else "take fewer inputs")
        )
    if rates > room["C"]:
        raise ModelError(
            f"{law.title}: {rates} rates, the core has {room['C']} registers for the last counts; "
            "take fewer, or divide the law into several functions"
        )
    if states > registers:
        raise ModelError(
            f"{law.title}: {states} states (each rate has one), the core has {registers} registers "
            f"for them, {WORK} of each bank left to other values; take fewer, or divide the law "
            "into several functions"
        )
    if outputs > isa.outputs:
        raise ModelError(
            f"{law.title}: {outputs} outputs, the core has {isa.outputs}; make those that no "
            "drive takes an [[export]], which the host reads from its register"
        )


def build_graph(law: Law) -> Graph:
    """Graph of real operations of the law, conversions and saturation of outputs included.

    Raises ModelError.
    """
    check_ports(law)
    graph = Graph()
    values = {p.name: _source(graph, law, p) for p in law.ports if p.kind != "output"}
    arguments = [[values[port.name] for port in ports] for _, ports in law.arguments()]
    nodes = read_function(law.scalars, graph, arguments)
    ports = [port for _, found in law.results() for port in found]
    for port, node in zip(ports, itertools.chain(*nodes), strict=True):
        if port.kind == "state":
            graph.next_states[port.name] = node
            continue
        if port.limits is not None and port.kind == "output":
            low, high = port.limits
            node = graph.add("sat", node, graph.const(low), graph.const(high))
        graph.outputs[port.name] = node
    for rate in law.of_kind("rate"):
        graph.next_states[before(rate.rate_of)] = graph.add("int_input", value=rate.rate_of)
    return graph


def before(name: str) -> str:
    """Name of the state that holds an encoder's last count."""
    return f"{name}_before"


def _source(graph: Graph, law: Law, port: Port) -> int:
    if port.kind == "rate":
        count = graph.add("int_input", value=port.rate_of)
        last = graph.add("int_state", value=before(port.rate_of))
        difference = graph.add("i2f", graph.add("isub", count, last))
        return graph.add("mul", difference, graph.const(port.scale))
    if port.kind == "input" and port.type == "int":
        count = graph.add("i2f", graph.add("int_input", value=port.name))
        scaled = graph.add("mul", count, graph.const(port.scale))
        return graph.add("add", scaled, graph.const(port.offset))
    if port.kind in ("input", "state"):
        return graph.add(port.kind, value=port.name)
    return graph.add("param", value=port.name) if port.kind == "parameter" else -1
