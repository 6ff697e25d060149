# SPDX-License-Identifier: Apache-2.0
"""The reference of a proof for a CasADi function: `Function.__call__` on the user's own object.

A file's function is loaded again and evaluated in a confined process; signals are read again from
the text of the interface file. What is shared with the compiler is the arithmetic of expressions in
that file (`scale = "2*pi/65536"`), no names, order or sizes.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import casadi as ca
import msgspec
import numpy as np

from asip_asm.interface import load_interface
from asip_asm.model.law import Law, Model, load_function
from asip_asm.model.onnx_file import OnnxPolicy
from asip_asm.model.saved import SavedFunction
from asip_asm.signals import Interface, evaluate
from sim.laws.prove_reference import Reference, Shape, Truth, Values, Wire

POINTS = 2000
"""Points of one call."""
SECONDS = 60
MEMORY = 1 << 31
KINDS = ("parameter", "input", "state", "output", "export")


class CasadiReference:
    """A `Reference` by a function of CasADi in double precision."""

    def __init__(self, function: ca.Function | SavedFunction) -> None:
        self.function = function
        self.arguments: dict[str, Shape]
        self.results: dict[str, Shape]
        if isinstance(function, SavedFunction):
            data = function.use(lambda f: msgspec.msgpack.encode(_shapes(f)))
            self.arguments, self.results = msgspec.msgpack.decode(
                data, type=tuple[dict[str, Shape], dict[str, Shape]]
            )
        else:
            self.arguments, self.results = _shapes(function)

    def __call__(self, arguments: Mapping[str, Values]) -> dict[str, Values]:
        points = len(next(iter(arguments.values()))) if arguments else 1
        parts = [
            self._call({name: values[at : at + POINTS] for name, values in arguments.items()})
            for at in range(0, points, POINTS)
        ]
        return {name: np.concatenate([part[name] for part in parts]) for name in self.results}

    def _call(self, arguments: dict[str, Values]) -> dict[str, Values]:
        if not isinstance(self.function, SavedFunction):
            return _evaluate(self.function, arguments)
        data = self.function.use(
            lambda function: _packed(_evaluate(function, arguments)), SECONDS, MEMORY
        )
        points = len(next(iter(arguments.values()))) if arguments else 1
        values = np.frombuffer(data, np.float64)
        found: dict[str, Values] = {}
        at = 0
        for name, (rows, columns) in self.results.items():
            size = points * rows * columns
            found[name] = values[at : at + size].reshape(points, rows, columns)
            at += size
        return found


def _shapes(function: ca.Function) -> tuple[dict[str, Shape], dict[str, Shape]]:
    arguments = {function.name_in(i): function.size_in(i) for i in range(function.n_in())}
    results = {function.name_out(i): function.size_out(i) for i in range(function.n_out())}
    return arguments, results


def _evaluate(function: ca.Function, arguments: Mapping[str, Values]) -> dict[str, Values]:
    """Results at each point, by name. CasADi takes the points as blocks of columns."""
    points = len(next(iter(arguments.values()))) if arguments else 1
    given = {
        name: ca.DM(values.transpose(1, 0, 2).reshape(values.shape[1], points * values.shape[2]))
        for name, values in arguments.items()
    }
    results = function.call(given)  # what `function(**given)` does, for any name
    found = {}
    for name in function.name_out():
        full = np.asarray(results[name].full(), np.float64)
        rows, columns = function.size_out(name)
        full = full.reshape(rows, -1, columns) if full.size else np.zeros((rows, points, columns))
        found[name] = np.broadcast_to(full.transpose(1, 0, 2), (points, rows, columns))
    return found


def _packed(results: Mapping[str, Values]) -> bytes:
    return b"".join(np.ascontiguousarray(values).tobytes() for values in results.values())


def truth_of(law: Law) -> Truth:
    """Truth of a law that was made in Python: its function, and its ports by their names."""
    wires = [
        Wire(
            port.kind,
            port.name,
            port.vector,
            port.scale if port.type == "int" or port.kind == "rate" else 1.0,
            port.offset if port.type == "int" else 0.0,
            port.limits,
            port.rate_of,
            f"{port.rate_of}_before" if port.rate_of else "",
            port.initial,
            port.safe,
        )
        for port in law.ports
    ]
    return Truth(_reference(law.function), wires)


def truth_of_files(function: Path, record: Path) -> Truth:
    """Truth of a function or policy file and its interface file.

    Raises ModelError, InterfaceError.
    """
    model = load_function(function)
    return Truth(_reference(model), read_wires(record))


def _reference(model: Model) -> Reference:
    if isinstance(model, OnnxPolicy):
        from sim.laws.prove_onnx import OnnxReference

        return OnnxReference(model)
    return CasadiReference(model)


def read_wires(path: Path) -> list[Wire]:
    """Signals as the text of an interface file has them, in its order.

    The file was accepted by `load_interface` before: what it refuses is not checked again.
    """
    interface = load_interface(path)
    names = interface.names()
    entries = _entries(path)
    wires: list[Wire] = []
    for kind in KINDS:
        for entry in entries[kind]:
            wires += _wires(kind, entry, interface, names)
    counts = {
        input_: last
        for entry in entries["state"]
        if entry["unit"] == "count"
        for last, input_ in zip(entry["names"], entry.get("starts_from", []), strict=False)
    }
    lasts = set(counts.values())
    rates = [
        Wire(
            "rate",
            f"{wire.name}_rate",
            f"{wire.vector}_rate" if wire.vector else "",
            wire.scale / names["T_s"],
            rate_of=wire.name,
            last=f"{wire.name}_before",
        )
        for wire in wires
        if wire.kind == "input" and wire.name in counts
    ]
    return [wire for wire in wires if wire.name not in lasts] + rates


def _entries(path: Path) -> dict[str, list[dict[str, Any]]]:
    """The tables of a file by kind, those of a file that it includes after its own."""
    content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    found = {kind: list(content.get(kind, [])) for kind in KINDS}
    if "include" in content:
        for kind, more in _entries(path.parent / content["include"]).items():
            found[kind] += more
    for k, entry in enumerate(found["output"]):
        if other := entry.get("set_points_of"):
            inputs = _entries(path.parent / other)["input"]
            points = [x for x in inputs if x.get("source") == "set-point"]
            names = [name for x in points for name in x["names"]]
            found["output"][k] = {"names": names, "safe": entry["safe"]}
    return found


def _wires(
    kind: str, entry: Mapping[str, Any], interface: Interface, names: Mapping[str, float]
) -> list[Wire]:
    def number(key: str, default: float = 0.0) -> float:
        value = entry.get(key, default)
        return bound(value)

    def bound(value: Any) -> float:
        return evaluate(value, names, interface.file, 0)

    limits = entry.get("limits")
    return [
        Wire(
            kind,
            name,
            entry.get("vector", ""),
            number("scale", 1.0),
            number("offset"),
            (bound(limits[0]), bound(limits[1])) if limits else None,
            initial=number("value") if kind == "parameter" else number("initial"),
            safe=number("safe"),
        )
        for name in entry["names"]
    ]
