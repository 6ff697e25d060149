# SPDX-License-Identifier: Apache-2.0
"""From a CasADi function to a program: every opcode, names, files, the command."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import casadi as ca
import pytest

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.graph import Graph
from asip_asm.model.law import Law, Port, load_law
from asip_asm.model.program import build
from asip_asm.model.read import BINARY, NAMES, REFUSED, UNARY, ModelError, scalars
from sim.laws.asip_model.__main__ import main
from sim.laws.prove_program import prove
from tests.model_compiler.laws import mixed
from tests.model_compiler.proof import proved

FORMS = [
    Options(reassociate=a, reciprocal=b) for a, b in itertools.product((False, True), repeat=2)
]
RECORD = """
title = "one joint"
[constants]
T_s = 1e-4
[[input]]
names = ["goal"]
unit = "rad"
meaning = "set-point"
[[input]]
names = ["q"]
type = "int"
scale = "2*pi/65536"
unit = "rad"
limits = [-3, 3]
meaning = "encoder"
[[state]]
names = ["last"]
type = "int"
unit = "count"
starts_from = ["q"]
meaning = "count of the last tick"
[[output]]
names = ["torque"]
unit = "N m"
safe = 0
limits = [-5, 5]
meaning = "of the joint"
"""


def one_joint() -> ca.Function:
    goal, q, rate = (ca.MX.sym(name) for name in ("goal", "q", "q_rate"))
    torque = 40 * (goal - q) - 0.01 * rate + 3 * ca.sin(q)
    return ca.Function("one_joint", [goal, q, rate], [torque], ["goal", "q", "q_rate"], ["torque"])


@pytest.mark.parametrize("options", FORMS, ids=str)
def test_program_has_the_bits_of_the_interpreter_and_keeps_its_bound(tmp_path, options):
    _, proof = proved(mixed(), tmp_path, options, 300)
    assert proof.bits_equal, proof.first_difference
    assert 0.01 < proof.worst_fraction_of_bound < 1, proof.worst_result


def test_program_has_the_bits_of_the_interpreter_on_the_rtl(tmp_path):
    proved(mixed(), tmp_path, Options(reassociate=True), 1000, backend="rtl")


def test_a_wrong_operation_is_found(tmp_path):
    compiled = compile_law(mixed())
    wrong = compiled.text.replace("fmsub ", "fmadd ", 1)
    assert wrong != compiled.text
    built = build(replace(compiled, text=wrong), tmp_path / "law.s")
    proof = prove(compiled, built.image, count=50, backend="iss")
    assert not proof.bits_equal and not proof.passed
    assert proof.worst_fraction_of_bound > 1


def test_a_result_without_a_finite_bound_is_not_proved(tmp_path):
    x = ca.SX.sym("x")
    near_zero = (x + 1e6) - 1e6  # of numbers below its own rounding
    function = ca.Function("f", [x], [ca.fmin(ca.fmax(1 / near_zero, -1), 1)], ["x"], ["y"])
    law = Law("f", function, [Port("input", "x", limits=(0, 1e-3)), Port("output", "y")])
    built = build(compile_law(law), tmp_path / "law.s")
    proof = prove(built.compiled, built.image, count=50, backend="iss")
    assert proof.unbounded and not proof.passed


def test_every_scalar_opcode_is_compiled_or_refused():
    named = {
        "ASSIGN", "SQ", "TWICE", "INV", "NE", "IF_ELSE_ZERO", "CONST", "INPUT", "OUTPUT",
    }  # fmt: skip
    scalar = range(ca.OP_ASSIGN, ca.OP_CALL + 1)
    more = ca.OP_ERFINV, ca.OP_PRINTME, ca.OP_LIFT, ca.OP_LOG1P, ca.OP_EXPM1, ca.OP_HYPOT
    for op in (*scalar, *more, ca.OP_REMAINDER):
        known = op in UNARY or op in BINARY or op in REFUSED
        assert known != (NAMES[op].removeprefix("OP_") in named), NAMES[op]


def test_refused_opcode_is_named_with_its_place():
    x = ca.SX.sym("x")
    function = ca.Function("f", [x], [ca.erfinv(x) + 1], ["x"], ["y"])
    law = Law("f", function, [Port("input", "x"), Port("output", "y")])
    with pytest.raises(ModelError, match=r"f, instruction \d+ of \d+: OP_ERFINV is not compiled: "):
        compile_law(law)


def test_a_result_without_a_signal_is_refused_with_the_nearest_name():
    x = ca.SX.sym("x")
    law = Law("f", ca.Function("f", [x], [x], ["x"], ["torqe"]), [Port("input", "x")])
    with pytest.raises(ModelError, match="result 'torqe'"):
        compile_law(law)


def test_equal_operations_exist_once():
    graph = Graph()
    a, b = graph.add("input", value="a"), graph.add("input", value="b")
    assert graph.add("mul", a, b) == graph.add("mul", a, b)
    assert graph.const(0.0) != graph.const(-0.0)


def test_command_writes_a_program_that_a_person_can_read(tmp_path, capsys):
    one_joint().save(str(tmp_path / "law.casadi"))
    (tmp_path / "law.interface.toml").write_text(RECORD)
    arguments = [str(tmp_path / "law.casadi"), str(tmp_path / "law.interface.toml")]
    assert main([*arguments, "--reassociate", "-o", str(tmp_path / "out" / "law")]) == 0
    source = (tmp_path / "out" / "law.s").read_text()
    assert re.search(r"fsin +\w+, \w+ +; sin\(", source)
    assert ".state    q_before : int" in source and "isub" in source
    assert "ONE_JOINT" in (tmp_path / "out" / "law.h").read_text()
    assert "cycles" in (tmp_path / "out" / "law.report.txt").read_text()
    assert re.search(r"\d+ cycles, lower bound \d+", capsys.readouterr().out)


def test_record_and_saved_function_make_the_law(tmp_path):
    (tmp_path / "law.interface.toml").write_text(RECORD)
    law = load_law(one_joint(), tmp_path / "law.interface.toml")
    assert [(n, [p.name for p in ps]) for n, ps in law.arguments()] == [
        (n, [n]) for n in ("goal", "q", "q_rate")
    ]
    proved(law, tmp_path, count=200)


def test_command_names_the_file_that_is_no_function(tmp_path, capsys):
    (tmp_path / "law.casadi").write_text("nothing")
    (tmp_path / "law.interface.toml").write_text(RECORD)
    paths = [str(tmp_path / "law.casadi"), str(tmp_path / "law.interface.toml")]
    assert main(paths) == 1
    assert "not a file of casadi.Function.save" in capsys.readouterr().err


def test_mx_is_expanded():
    operations = {op for op, *_ in scalars(one_joint()).instructions}
    assert {ca.OP_INPUT, ca.OP_SIN, ca.OP_OUTPUT} <= operations


@pytest.mark.parametrize("arguments", (["law.casadi"], ["arm.urdf", "law.interface.toml"]))
def test_a_function_needs_a_record_and_a_urdf_has_none(arguments, capsys):
    with pytest.raises(SystemExit, match="^2$"):
        main(arguments)
    assert "a function needs its interface record" in capsys.readouterr().err


def test_constants_beyond_bank_k_are_loaded_from_data_memory(tmp_path):
    x = ca.SX.sym("x", 4)
    numbers = [0.5 + k / 7 for k in range(160)]
    terms = [number * ca.fabs(x[k % 4] + number) for k, number in enumerate(numbers)]
    function = ca.Function("many", [x], [ca.sum1(ca.vertcat(*terms))], ["x"], ["y"])
    ports = [Port("input", f"x{k}", vector="x") for k in range(4)]
    law = Law("many", function, [*ports, Port("output", "y")])
    built, _ = proved(law, tmp_path, count=20)
    assert built.compiled.text.count(".data ") == built.compiled.text.count("  ld ") > 30


def test_too_many_inputs_or_outputs_are_refused__exports_are_results_beyond_32(tmp_path):
    x = ca.SX.sym("x", 200)
    function = ca.Function("wide", [x], [x[:40] * 2], ["x"], ["y"])
    inputs = [Port("input", f"x{k}", vector="x") for k in range(200)]
    outputs = [Port("output", f"y{k}", vector="y") for k in range(40)]
    with pytest.raises(ModelError, match="200 inputs and parameters, bank K holds 128 words"):
        compile_law(Law("wide", function, [*inputs, *outputs]))
    narrow = ca.Function("wide", [x[:40]], [x[:40] * 2], ["x"], ["y"])
    with pytest.raises(ModelError, match="40 outputs, the core has 32; make those .* an .*export"):
        compile_law(Law("wide", narrow, [*inputs[:40], *outputs]))
    exports = [Port("export", port.name, vector="y") for port in outputs[32:]]
    law = Law("wide", narrow, [*inputs[:40], *outputs[:32], *exports])
    _, proof = proved(law, tmp_path, count=200)
    assert len(proof.largest_error) == 40, proof
