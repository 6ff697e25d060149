# SPDX-License-Identifier: Apache-2.0
"""Random programs: the image computes what the source says, and survives disassembly.

The reference runs the source statement by statement on names, one operation after the other. The
image is decoded and run bundle by bundle on physical registers. Operations are not interpreted: a
result is a digest of mnemonic and operand values, so equal results mean equal data flow. Branches
test a bit of the digest. Nothing but the parser and the word layout is shared.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError, Reporter
from asip_asm.disassemble import decode_bundle, disassemble
from asip_asm.image import Image
from asip_asm.ir import Register
from asip_asm.isa import default_isa
from asip_asm.parser import Parser
from asip_asm.source import Operand, RawOperation, Source, physical_register

from .interpret import Result, digest, read, run, taken

ISA = default_isa()
STEPS = 300
FMA = ("fmadd d, s, s, s", "fmul d, s, s", "fadd d, s, s")
AUX = ("fdiv d, s, s", "fsqrt d, s", "mov d, s", "sel d, s, s, s", "fabs d, s")
NAMES = ("p", "q", "r", "u", "v", "w")
SOURCES = (*NAMES, "x", "y", "half", "1.5", "s1", "s2", "zero")


class Endless(Exception):
    """The run does not end within the step limit."""


def run_source(source: Source) -> Result:
    """Run the statements in order; names are variables."""
    values: dict[str, int] = {"zero": 0}
    for declaration in source.names.values():
        if declaration.kind == "input":
            values[declaration.name] = digest("K", int(declaration.value or 0))
        elif declaration.kind in ("constant", "state"):
            values[declaration.name] = declaration.bits
    outputs = {d.name: i for i, d in enumerate(source.of_kind("output"))}
    outcome = Result(data=list(source.data))

    def value_of(operand: Operand) -> int:
        if operand.kind == "value":
            return {1.5: 0x3FC00000}[operand.value]
        return values[operand.text]

    def step(raw: RawOperation) -> tuple[str, int] | str | None:
        operands = raw.operands
        if raw.record.name in ("jmp", "bz", "bnz"):
            value = value_of(operands["a"]) if "a" in operands else 0
            return operands["target"].text if taken(raw.record.name, value) else None
        if raw.record.name == "st":
            outcome.data[int(operands["address"].value)] = value_of(operands["a"])
            return None
        if raw.record.name == "ld":
            result = outcome.data[int(operands["address"].value)]
        else:
            words = [value_of(operands[n]) if n in operands else 0 for n in "abc"]
            result = digest(raw.record.name, *words)
        return operands["dst"].text, result

    labels = {s.label: i for i, s in enumerate(source.statements) if s.kind == "label"}
    position = 0
    for _ in range(STEPS):
        statement = source.statements[position]
        position += 1
        if statement.kind == "halt":
            break
        results = [step(raw) for raw in statement.operations]
        for result in results:
            if isinstance(result, str):
                position = labels[result]
            elif result is not None:
                name, value = result
                if name in outputs:
                    outcome.outputs[outputs[name]] = value
                else:
                    values[name] = value
        if statement.halt:
            break
    else:
        raise Endless
    outcome.states = {d.name: values[d.name] for d in source.of_kind("state")}
    outcome.exports = {name: values[name] for name, _, _ in source.exports}
    return outcome


def run_image(image: Image, words: int) -> Result:
    """Run the bundles of the image; all operations of a bundle read before any writes."""
    bundles = [decode_bundle(int(word, 16), image.configuration, ISA) for word in image.bundles]
    ends = {address for address, bundle in enumerate(bundles) if bundle.halt}
    registers = {Register("K", entry.index): int(entry.bits, 16) for entry in image.constants}
    registers |= {physical_register(s.register): int(s.bits, 16) for s in image.states}
    data = [int(word, 16) for word in image.data]
    outcome = run([bundle.operations for bundle in bundles], ends, {}, registers, data, words)
    outcome.states = {s.name: read(registers, physical_register(s.register)) for s in image.states}
    outcome.exports = {
        e.name: read(registers, physical_register(e.register)) for e in image.exports
    }
    return outcome


@st.composite
def operation(draw: st.DrawFn, destinations: tuple[str, ...], forms: tuple[str, ...]) -> str:
    mnemonic, _, operands = draw(st.sampled_from(forms)).partition(" ")
    texts = [
        draw(st.sampled_from(destinations if kind == "d" else SOURCES))
        for kind in operands.split(", ")
    ]
    return f"{mnemonic} {', '.join(texts)}"


@st.composite
def statement(draw: st.DrawFn, labels: int) -> str:
    kinds = ("linear", "linear", "linear", "linear", "bundle", "branch", "memory")
    kind = draw(st.sampled_from(kinds))
    # Names of one kind of unit more often than not, so that most programs are valid.
    multiply, auxiliary = (*NAMES[:3], "s1"), (*NAMES[3:], "s2", "p")
    if kind == "branch" and labels:
        target = f"L{draw(st.integers(0, labels - 1))}"
        name = draw(st.sampled_from(SOURCES[:8]))
        return draw(st.sampled_from((f"bz {name}, {target}", f"bnz {name}, {target}")))
    if kind == "memory":
        address = draw(st.integers(0, 3))
        if draw(st.booleans()):
            return f"st {draw(st.sampled_from(SOURCES))}, {address}"
        return f"ld {draw(st.sampled_from(auxiliary))}, {address}"
    if kind == "bundle":
        first = draw(operation(multiply, FMA))
        second = draw(operation(auxiliary, AUX))
        return f"{{ {first} | {second} }}"
    if draw(st.booleans()):
        return draw(operation(multiply, FMA))
    return draw(operation(auxiliary, AUX))


@st.composite
def program(draw: st.DrawFn) -> str:
    labels = draw(st.integers(0, 2))
    body = draw(st.lists(statement(labels), min_size=1, max_size=14))
    for label in range(labels):
        body.insert(draw(st.integers(0, len(body))), f"L{label}:")
    start = [
        f"fadd {n}, x, {n_value}" for n, n_value in zip("pqr", ("y", "half", "1.5"), strict=True)
    ]
    start += [f"mov {n}, {v}" for n, v in zip("uvw", ("x", "y", "half"), strict=True)]
    head = [
        ".input x, y",
        ".const half = 0.5",
        ".data t = 1.0, 2.0, 3.0, 4.0",
        f".state s1 = 0.25{draw(st.sampled_from(('', ', pin A')))}",
        f".state s2 = 0.125{draw(st.sampled_from(('', ', pin C', ', pin c9')))}",
        ".output o, safe = 1.0",
        f".export {draw(st.sampled_from(('q', 'q, v, s1', 'x, r, w')))}",
    ]
    return "\n".join([*head, *start, *body, f"mov o, {draw(st.sampled_from(NAMES))}", "halt", ""])


SETTINGS = settings(
    max_examples=150,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much],
)


@pytest.mark.quick("O-fast")
@pytest.mark.parametrize("configuration", ["fast", "small"])
@pytest.mark.parametrize("optimise", [False, True], ids=["O0", "O"])
@SETTINGS
@given(text=program())
def test_random_program__image_computes_what_the_source_says(
    text: str, configuration: str, optimise: bool, tmp_path: Path
) -> None:
    if configuration == "small":
        text = "\n".join(row for row in text.splitlines() if not row.startswith("{")) + "\n"
    path = tmp_path / "x.s"
    path.write_text(text, encoding="utf-8")
    try:
        image = assemble(path, configuration=configuration, optimise=optimise)
    except AssemblyError as error:
        assert all("Traceback" not in str(d) for d in error.diagnostics)
        event("refused")
        assume(False)
    source = Parser(ISA, Reporter(), {}).parse(path)
    try:
        expected = run_source(source)
    except Endless:
        event("endless")
        assume(False)
    event("branches" if image.cycles is None else "straight")
    assert run_image(image, len(source.data)) == expected

    again = tmp_path / "again.s"
    again.write_text(disassemble(image), encoding="utf-8")
    copy = assemble(again)
    copy.sources = image.sources
    assert copy == image
