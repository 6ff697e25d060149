# SPDX-License-Identifier: Apache-2.0
"""C of a law: its bits on this machine and on FPGA2 are those of the core's operations."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from asip_asm.model import c_helpers
from asip_asm.model.c_code import c_literal, struct_members, to_c_code
from asip_asm.model.compiler import Compiled, compile_law
from asip_asm.model.law import Law, Port
from asip_asm.model.program import build
from sim.bench.platforms.nios import build_elf, run_elf
from sim.core.api import Core
from sim.laws.catalogue import robot
from sim.laws.laws import LAWS, Settings
from sim.laws.native import law as native
from sim.laws.native.bits import first_difference, prove_c, separate
from sim.laws.native.law import CompilerError, NativeLaw
from sim.laws.prove_program import draw_ticks, unit_sine
from sim.rtl.nios_image import read_elf
from tests.bench.commands import output
from tests.bench.needs import needs
from tests.model_compiler.law_image import IMAGE, ROWS
from tests.model_compiler.laws import mixed, sample
from tests.model_compiler.proof import FAST

TICKS = 300


def check_bits(compiled: Compiled, ran, inputs, states, sine) -> None:
    assert not ran.results.any()
    assert first_difference(compiled, ran, inputs, states, sine) == ""


PROGRAMS = {
    "sample": lambda: compile_law(sample()),
    "mixed": lambda: compile_law(mixed()),
    "iiwa14": lambda: compile_law(LAWS["computed_torque"](robot("iiwa14"), Settings()), FAST),
    "scara": lambda: compile_law(
        LAWS["computed_torque"](robot("scara"), Settings(integral=True, friction=True)), FAST
    ),
}


@pytest.mark.quick("sample", "mixed", "scara")
@pytest.mark.parametrize("name", PROGRAMS)
def test_c_on_this_machine_has_the_bits_of_the_program(name):
    assert prove_c(PROGRAMS[name](), TICKS, seed=2) == ""


def test_c_that_differs_is_found(monkeypatch):
    monkeypatch.setitem(c_helpers.FORMS, "fsub", "{1} - {0}")
    assert "tick 0: got" in prove_c(PROGRAMS["sample"](), TICKS, seed=2)


def test_products_with_alternating_signs_are_rounded_apart():
    """GCC 12 makes one instruction of them, with one rounding, against its option."""
    names = [f"{name}{k}" for name in ("one", "two", "sum") for k in range(4)]
    values = dict(zip(names, map(ca.SX.sym, names), strict=True))
    terms = [
        values[f"one{k}"] * values[f"two{k}"] + (-1) ** (k + 1) * values[f"sum{k}"]
        for k in range(4)
    ]
    function = ca.Function("law", list(values.values()), terms, names, [f"y{k}" for k in range(4)])
    ports = [Port("input", name, limits=(-2.0, 2.0)) for name in names]
    ports += [Port("export", f"y{k}") for k in range(4)]
    assert prove_c(compile_law(Law("signs", function, ports, rate=1.0)), TICKS, seed=2) == ""


def test_c_does_not_need_its_option_against_contraction():
    compiled = compile_law(mixed())
    inputs, states = draw_ticks(compiled.law, TICKS, np.random.default_rng(3))
    law = NativeLaw(compiled, False, ("-O3", "-march=native"))
    check_bits(separate(compiled), law.run(inputs, states), inputs, states, law.sine)


def test_image_on_fpga2_the_core_and_this_machine_have_the_same_bits(tmp_path):
    compiled = compile_law(sample())
    inputs, states = draw_ticks(compiled.law, ROWS, np.random.default_rng(4))
    on_nios = run_elf(read_elf(IMAGE), compiled, inputs, states)
    check_bits(separate(compiled), on_nios, inputs, states, unit_sine)
    here = NativeLaw(compiled, False).run(inputs, states)
    with Core(build(separate(compiled), tmp_path / "law.s").image) as core:
        core.preset({name: value[0].item() for name, value in states.items()})
        ticks = core.batch(inputs, read=list(states))
    for name, values in (on_nios.outputs | on_nios.states).items():
        words = values.view(np.uint32)
        assert np.array_equal(words, (here.outputs | here.states)[name].view(np.uint32)), name
        assert np.array_equal(words, ticks[name].view(np.uint32)), name


@needs("nios-gcc")
@pytest.mark.parametrize("name", PROGRAMS)
def test_c_on_fpga2_has_the_bits_of_the_program_and_the_sine_of_the_core(name, tmp_path):
    compiled = PROGRAMS[name]()
    inputs, states = draw_ticks(compiled.law, 40, np.random.default_rng(5))
    ran = run_elf(read_elf(build_elf(compiled, tmp_path, 40)), compiled, inputs, states)
    check_bits(separate(compiled), ran, inputs, states, unit_sine)
    assert ran.cycles.min() > 100


@needs("nios-gcc")
def test_committed_image_is_built_from_its_law(tmp_path):
    built = build_elf(compile_law(sample()), tmp_path, ROWS)
    assert read_elf(built).memories == read_elf(IMAGE).memories, (
        "microtick nios-sw renews the image"
    )


def one(function: ca.Function, ports: list[Port]) -> Compiled:
    return compile_law(Law("one", function, ports))


def test_infinite_output_gives_the_safe_values_and_keeps_the_states():
    x, s = ca.SX.sym("x"), ca.SX.sym("s")
    function = ca.Function("f", [x, s], [1 / x, s + x], ["x", "s"], ["y", "s_next"])
    ports = [Port("input", "x"), Port("state", "s", initial=2.0), Port("output", "y", safe=-7.5)]
    ran = NativeLaw(one(function, ports)).run(
        {"x": np.array([4, 0, 1], np.float32)}, {"s": np.array([2], np.float32)}
    )
    assert ran.results.tolist() == [0, 1, 0]
    assert ran.outputs["y"].tolist() == [0.25, -7.5, 1.0]
    assert ran.states["s"].tolist() == [6.0, 6.0, 7.0]


def test_names_that_c_knows_are_given_others_and_parameters_are_macros(tmp_path):
    names = ["double", "double_", "state", "in", "Size", "INT", "signbit"]
    x = ca.SX.sym("x", len(names))
    gain = ca.SX.sym("gain")
    function = ca.Function("f", [x, gain], [gain * x], ["x", "gain"], ["y"])
    ports = [Port("input", name, vector="x") for name in names]
    ports.append(Port("parameter", "gain", initial=3.0, unit="V", meaning="*/ of the motor"))
    ports += [Port("output", f"int{k}", vector="y") for k in range(len(names) - 1)]
    ports.append(Port("output", "int", vector="y"))
    compiled = one(function, ports)
    values = {name: np.array([k], np.float32) for k, name in enumerate(names)}
    ran = NativeLaw(compiled).run(values, {})
    assert [v[0] for v in ran.outputs.values()] == [3.0 * k for k in range(len(names))]
    doubled = NativeLaw(compiled, flags=(*native.FLAGS, "-DONE_GAIN=6.0f")).run(values, {})
    assert doubled.outputs["int"][0] == 36.0


def test_parameters_that_differ_in_case_or_are_named_like_ours_have_their_own_macros():
    names = ("gain", "Gain", "fused")
    x, *gains = (ca.SX.sym(name) for name in ("x", *names))
    function = ca.Function("f", [x, *gains], [x * gains[0] + gains[1] - gains[2]], ["x", *names],
                           ["y"])  # fmt: skip
    ports = [Port("input", "x"), Port("output", "y")]
    ports += [
        Port("parameter", name, initial=v) for name, v in zip(names, (2.0, 10.0, 3.0), strict=True)
    ]
    ran = NativeLaw(one(function, ports)).run({"x": np.array([1.5], np.float32)}, {})
    assert ran.outputs["y"].tolist() == [10.0]


def test_header_is_read_by_a_c_plus_plus_compiler_too(tmp_path):
    header, _ = native.write_c(compile_law(mixed()), tmp_path / "law")
    text = '#include "law.tick.h"\nint main() { return (int)mixed_safe.a; }\n'
    (tmp_path / "main.cpp").write_text(text)
    output("g++", "-Wall", "-Werror", "-fsyntax-only", tmp_path / "main.cpp")
    assert "[rad], -3 .. 3; value = 9.58737992e-05*count + 0.25" in header.read_text()


def test_literals_are_the_binary32_numbers():
    for value in (0.1, -2.5, 1e-45, 3.4e38, -0.0, 16777216.0, 1 / 3):
        text = c_literal(value).strip("()").removesuffix("f")
        assert np.float32(text).view(np.uint32) == np.float32(value).view(np.uint32)


def test_compiler_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setenv("CC", "no-such-cc")
    with pytest.raises(CompilerError, match="no C compiler 'no-such-cc'"):
        NativeLaw(compile_law(sample()), flags=("-O1",))


def test_program_for_the_core_and_c_have_the_same_signals():
    law = mixed()
    words = struct_members(law)
    assert [name for name, _ in words["states"]] == ["s", "q_before"]
    header, source = to_c_code(compile_law(law), "x.tick.h")
    assert "struct mixed_inputs" in header and '#include "x.tick.h"' in source
