# SPDX-License-Identifier: Apache-2.0
"""The compiler's options never lose: sums by slots, constants loaded again, `--best`."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from asip_asm.assemble import build_program
from asip_asm.diagnostics import AssemblyError, Diagnostic
from asip_asm.model import program
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law, Port, load_law
from asip_asm.model.program import build
from asip_asm.model.read import ModelError
from sim.laws.asip_model import __main__ as command
from sim.laws.asip_model.effects import Forms, allowed_sets, effects, words
from sim.laws.prove_program import prove

SEED = 20261126


def policy(*sizes: int) -> Law:
    """A policy with layers of these sizes and an activation x/(1 + |x|)."""
    rng = np.random.default_rng(SEED)
    first = value = ca.SX.sym("x", sizes[0])
    for rows, columns in zip(sizes[1:], sizes[:-1], strict=True):
        weights = ca.DM(rng.normal(0, 1 / np.sqrt(columns), (rows, columns)))
        value = ca.mtimes(weights, value) + ca.DM(rng.normal(0, 0.1, rows))
        value = value / (1 + ca.fabs(value))
    function = ca.Function("policy", [first], [value], ["x"], ["u"])
    ports = [Port("input", f"x{i}", vector="x", limits=(-1.0, 1.0)) for i in range(sizes[0])]
    ports += [Port("output", f"u{i}", vector="u", limits=(-1.0, 1.0)) for i in range(sizes[-1])]
    return Law("policy", function, ports)


@pytest.fixture(scope="module")
def small_policy() -> Law:
    return policy(6, 8, 3)


def test_reassociating_a_law_that_the_slots_bound_costs_no_cycle(small_policy):
    forms = Forms(small_policy)
    plain, joined = (forms.build(Options(reassociate=on)) for on in (False, True))
    assert plain and joined
    assert joined.cycles <= plain.cycles


def test_constant_in_memory_is_loaded_again_and_not_stored(tmp_path):
    """Registers are short while constants of data memory wait for their second reader."""
    x = ca.SX.sym("x", 66)
    weights = ca.DM(np.random.default_rng(SEED).normal(0, 1, 66))
    first = ca.sin(ca.sin(ca.dot(weights, x)))
    total = ca.dot(weights, x * first)
    function = ca.Function("f", [x], [total], ["x"], ["u"])
    ports = [Port("input", f"x{i}", vector="x", limits=(-1.0, 1.0)) for i in range(66)]
    law = Law("f", function, [*ports, Port("output", "u")])
    built = build(
        compile_law(law, Options(constants=0, sine="unit", registers=False)), tmp_path / "law.s"
    )
    proof = prove(built.compiled, built.image, count=100, seed=SEED)
    assert proof.bits_equal
    words_of_constants = set(range(len(built.compiled.text.split(".data ")) - 1))
    assert len(words_of_constants) >= 50
    program, _ = build_program(tmp_path / "law.s")
    stores, loads = (
        [op.imm for _, _, op in program.placed() if op.mnemonic == name] for name in ("st", "ld")
    )
    assert len(loads) > len(words_of_constants), "no value was loaded again: the test is too easy"
    again = [address for address in loads if loads.count(address) > 1]
    assert words_of_constants & set(again)
    constants_stored = [a for a in stores if a in words_of_constants]
    assert not constants_stored


def test_effects_are_those_of_built_programs(small_policy, tmp_path):
    built = build(compile_law(small_policy, Options(reassociate=True)), tmp_path / "law.s")
    text = effects(built, seed=1)
    rows = {line[:24].strip(): line[24:].split() for line in text.splitlines()[1:5]}
    assert int(rows["this program"][0]) == built.cycles
    other = build(compile_law(small_policy, Options()), tmp_path / "plain.s")
    assert int(rows["without --reassociate"][0]) == other.cycles


def test_best_is_no_slower_than_any_set_that_is_allowed(small_policy):
    forms = Forms(small_policy)
    allowed = allowed_sets(Options(), None, None, None)
    assert len(allowed) == 12
    assert len({words(one) for one in allowed}) == 12
    best = forms.ranked(allowed)[0]
    assert all(best.cycles <= one.cycles for one in forms.built.values())


def test_option_that_changes_nothing_builds_no_program_of_its_own():
    """A law without a quotient and without a sine has two programs, not twelve."""
    forms = Forms(products(20))
    made = []
    forms._program = lambda options, make=forms._program: made.append(options) or make(options)
    ranked = forms.ranked(allowed_sets(Options(), None, None, None))
    assert made == [Options(), Options(reassociate=True)]
    assert {one.compiled.options for one in ranked} == set(
        allowed_sets(Options(), None, None, None)
    )
    for one in (Options(reciprocal=True), Options(reassociate=True, sine="pipes")):
        assert compile_law(forms.law, one).text == forms.built[one].compiled.text


def test_given_option_stays_as_given():
    assert allowed_sets(Options(), False, True, "unit") == [Options(reciprocal=True, sine="unit")]


def test_best_takes_the_next_program_if_the_shortest_is_not_proved(
    tmp_path, monkeypatch, capsys, scalar_law
):
    tried = []

    def fails_once(built, *_):
        tried.append(built.compiled.options)
        return int(len(tried) == 1)

    monkeypatch.setattr(command, "_prove", fails_once)
    arguments = [*map(str, scalar_law), "--best", "--prove", "-o", str(tmp_path / "out")]
    assert command.main(arguments) == 0
    assert len(tried) == 2 and tried[0] != tried[1]
    assert f"next with {words(tried[1])}" in capsys.readouterr().out


@pytest.fixture
def scalar_law(tmp_path):
    """Files of a law with a sum and a quotient."""
    q, goal = ca.SX.sym("q"), ca.SX.sym("goal")
    law = ca.Function("law", [q, goal], [40 * (goal - q) / 3], ["q", "goal"], ["torque"])
    law.save(str(tmp_path / "law.casadi"))
    (tmp_path / "law.interface.toml").write_text(
        'title = "law"\n'
        '[[input]]\nnames = ["q", "goal"]\nunit = "m"\nlimits = [-1, 1]\nmeaning = "place"\n'
        '[[output]]\nnames = ["torque"]\nunit = "N m"\nsafe = 0\nlimits = [-100, 100]\n'
        'meaning = "torque"\n'
    )
    return tmp_path / "law.casadi", tmp_path / "law.interface.toml"


def test_export_of_an_input_is_refused(scalar_law):
    file, record = scalar_law
    with record.open("a") as text:
        text.write('[[export]]\nnames = ["goal"]\nunit = "m"\nmeaning = "read back"\n')
    with pytest.raises(
        ModelError, match=r"interface.toml:\d+: error: \[\[export\]\] 'goal' is an input"
    ):
        load_law(file, record)


def products(count: int) -> Law:
    """A law whose result is a sum of this many products of 70 inputs."""
    x = ca.SX.sym("x", 70)
    pairs = [(i, j) for i in range(70) for j in range(i)][:count]
    total = sum(x[i] * x[j] for i, j in pairs)
    ports = [Port("input", f"x{i}", vector="x", limits=(-1.0, 1.0)) for i in range(70)]
    function = ca.Function("products", [x], [total], ["x"], ["u"])
    return Law("products", function, [*ports, Port("output", "u")])


@pytest.mark.parametrize("reassociate", [False, True])
def test_law_beyond_the_program_memory_is_refused_before_it_is_searched_for(reassociate):
    with pytest.raises(
        ModelError,
        match=r"^products: its operations take 1150 bundles or more "
        r"\(2300 for 2 slots of a bundle\),"
        r" the core's program memory holds 1024; divide the law",
    ):
        compile_law(products(2300), Options(reassociate=reassociate))


def test_limit_that_the_assembler_meets_is_told_of_the_law(tmp_path, monkeypatch):
    compiled = compile_law(products(3))
    file = tmp_path / "law.s"

    def full(*_, **__):
        raise AssemblyError([Diagnostic(None, f"{file}: too many bundles: 1030")])

    monkeypatch.setattr(program, "build_program", full)
    with pytest.raises(ModelError, match=r"^products: too many bundles: 1030; divide the law into"):
        build(compiled, file)
