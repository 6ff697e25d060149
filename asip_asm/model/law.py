# SPDX-License-Identifier: Apache-2.0
"""A control law as the compiler takes it: a function and the signals that it connects.

Arguments and results of the function go by name. A signal belongs to the argument of its name, or,
one of several, to the argument that its `vector` names, in order. The function sees physical
values: an encoder is an int32 input with `scale` and `offset`, and an argument named by a `rate_of`
signal is the difference of two successive counts, taken as integers, times scale: exact where a
difference of floats is not. A state's next value is the result `<state>_next` (`<vector>_next`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from asip_asm.diagnostics import closest
from asip_asm.interface import load_interface
from asip_asm.model.graph import Graph
from asip_asm.model.read import (
    ModelError,
    argument_names,
    load_function,
    read_function,
    result_names,
)
from asip_asm.signals import COUNT, Interface, Signal
from asip_asm.source import is_reserved


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
    function: ca.Function
    ports: Sequence[Port]
    doc: str = ""
    rate: float = 10_000.0
    """Ticks per second."""

    def of_kind(self, kind: str) -> list[Port]:
        return [port for port in self.ports if port.kind == kind]

    def port(self, name: str) -> Port:
        return next(port for port in self.ports if port.name == name)

    def arguments(self) -> list[tuple[str, Port]]:
        """Name and port of every entry of the function's arguments, in order."""
        sources = [p for p in self.ports if p.kind in ("input", "state", "parameter", "rate")]
        return list(_match("argument", self, argument_names(self.function), sources, ""))

    def results(self) -> list[tuple[str, Port]]:
        """The same for its results."""
        targets = [p for p in self.ports if p.kind in ("output", "state", "export")]
        return list(_match("result", self, result_names(self.function), targets, "_next"))


def load_law(function: ca.Function | Path | str, record: Interface | Path | str) -> Law:
    """Law of a function, or a file of `Function.save`, and an interface record.

    An argument `<input>_rate` is the speed of an encoder: the record has a state of unit 'count'
    that starts from the input, and the constant or parameter `T_s`, seconds between ticks. Raises
    ModelError, InterfaceError, OSError.
    """
    function = load_function(function)
    interface = record if isinstance(record, Interface) else load_interface(record)
    names = interface.names()
    period = names.get("T_s", 1e-4)
    ports: list[Port] = []
    counts = {s.starts_from: s for s in interface.states if s.unit == COUNT and s.starts_from}
    for signal in interface.signals:
        if signal in counts.values():
            continue
        ports.append(_port(signal, interface, names))
        if signal.kind == "input" and signal.name in counts:
            if "T_s" not in names:
                raise ModelError(f"{interface.file}: rates need the constant T_s [s] of a tick")
            ports.append(_rate(ports[-1], period))
    known = {port.name for port in ports if port.kind != "export"}
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
    what: str, law: Law, names: dict[tuple[int, int], str], ports: list[Port], suffix: str
) -> Iterator[tuple[str, Port]]:
    known: dict[str, Port] = {}
    counts: dict[str, int] = {}
    for port in ports:
        end = suffix if port.kind == "state" else ""
        known[port.name + end] = port
        if port.vector:
            index = counts.get(port.vector + end, 0)
            counts[port.vector + end] = index + 1
            known[f"{port.vector}{end}[{index}]"] = port
    for name, count in counts.items():
        if count == 1:
            known.setdefault(name, known[f"{name}[0]"])
    for name in names.values():
        if name not in known:
            near = closest(name, known) or f"signals are {', '.join(known) or 'none'}"
            raise ModelError(f"{law.title}: {what} '{name}' of the function has no signal; {near}")
        yield name, known[name]


def check_ports(law: Law) -> None:
    """Raises ModelError for what the program could not say."""
    seen: set[str] = set()
    for port in law.ports:
        if port.name in seen:
            raise ModelError(f"{law.title}: signal '{port.name}' stands twice; rename one")
        if is_reserved(port.name) or not port.name.isidentifier():
            raise ModelError(f"{law.title}: '{port.name}' cannot name a signal; rename it")
        seen.add(port.name)
        if port.rate_of and (port.rate_of not in seen or law.port(port.rate_of).type != "int"):
            raise ModelError(
                f"{law.title}: rate '{port.name}' is of '{port.rate_of}', which is no int input "
                "above it"
            )
    found = {port.name for _, port in law.results()}
    missing = [p.name for p in law.ports if p.kind in ("output", "export") and p.name not in found]
    if missing:
        raise ModelError(
            f"{law.title}: no result of the function gives {', '.join(missing)}; name a result so"
        )


def build_graph(law: Law) -> Graph:
    """Graph of real operations of the law, conversions and saturation of outputs included.

    Raises ModelError.
    """
    check_ports(law)
    function = load_function(law.function)
    graph = Graph()
    values = {p.name: _source(graph, law, p) for p in law.ports if p.kind != "output"}
    nodes = [values[port.name] for _, port in law.arguments()]
    arguments = dict(zip(argument_names(function), nodes, strict=True))
    results = read_function(function, graph, arguments)
    for (_, port), key in zip(law.results(), result_names(function), strict=True):
        node = results[key]
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
