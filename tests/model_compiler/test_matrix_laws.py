# SPDX-License-Identifier: Apache-2.0
"""Laws with more constants than bank K holds and more states than bank C holds."""

from __future__ import annotations

import re

import casadi as ca
import numpy as np
import pytest

from asip_asm import pace
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law, Port
from asip_asm.model.program import build
from sim.bench.matrix_law_goals import LAWS
from sim.laws.asip_model.effects import Forms
from sim.laws.matrix_laws import MASSES, lqg, lqg_gains, policy
from sim.laws.prove_program import prove

SEED = 7


def states(count: int, after) -> Law:
    """A law of so many states: `after(x, y)` is their next value, their sum is the output."""
    x, y = ca.SX.sym("x", count), ca.SX.sym("y")
    function = ca.Function("f", [y, x], [ca.sum1(x), after(x, y)], ["y", "x"], ["u", "x_next"])
    ports = [Port("input", "y", limits=(-1.0, 1.0)), Port("output", "u")]
    ports += [Port("state", f"x{i}", vector="x", limits=(-1.0, 1.0)) for i in range(count)]
    return Law("states", function, ports)


def test_gains_of_the_lqg_law_hold_chain_and_estimate_still():
    made = lqg_gains()
    for matrix in (made.a - made.b @ made.k, made.a - made.l @ made.c):
        assert np.abs(np.linalg.eigvals(matrix)).max() < 0.999
    assert np.array_equal(made.c @ np.arange(2 * MASSES), np.arange(MASSES))


def test_lqg_law_is_as_short_as_its_goal_and_keeps_its_bits(monkeypatch, capsys):
    monkeypatch.setattr(pace, "PACE_SECONDS", 0.0)
    built = Forms(lqg()).build(Options())
    assert built
    # A search that takes long reports how far it is.
    assert re.search(r"lqg: schedules: [1-9]\d* of \d+, about", capsys.readouterr().err)
    assert built.cycles <= LAWS["LQG 12/4/6"][1]
    assert prove(built.compiled, built.image, count=40, seed=SEED).passed


def test_constants_without_a_place_in_bank_k_are_in_registers():
    forms = Forms(policy((6, 8, 3), SEED))
    held, loaded = (forms.build(Options(constants=0, registers=on)) for on in (True, False))
    assert held and loaded
    assert held.cycles < loaded.cycles
    banks = re.findall(r"^[.]state +held_\w+ = [^,]*, pin (\w)$", held.compiled.text, re.M)
    assert set(banks) == {"A", "B"}
    assert "held" not in loaded.compiled.text
    words = [len(re.findall(r"^ +ld ", b.compiled.text, re.M)) for b in (held, loaded)]
    assert words[0] + len(banks) == words[1]
    assert prove(held.compiled, held.image, count=40, seed=SEED).passed


def test_names_of_signals_may_be_those_of_constants(tmp_path):
    x = ca.SX.sym("x", 3)
    function = ca.Function("f", [x], [0.3 * x[0] + 0.7 * x[1] - 0.9 * x[2]], ["x"], ["u"])
    names = ("held_a0", "data_0", "cdata_0")
    ports = [Port("input", name, vector="x", limits=(-1.0, 1.0)) for name in names]
    law = Law("f", function, [*ports, Port("output", "u")])
    for registers in (True, False):
        made = compile_law(law, Options(constants=0, registers=registers))
        built = build(made, tmp_path / "law.s")
        assert prove(built.compiled, built.image, count=20, seed=SEED).passed


@pytest.mark.parametrize(
    "after",
    [
        lambda x, y: 0.5 * x + 0.25 * y,
        lambda x, y: ca.vertcat(y, x[:-1]),
        lambda x, y: ca.vertcat(x[-1], x[:-1]),
    ],
    ids=["computed", "delayed", "in a ring"],
)
def test_eighty_states_are_kept(after, tmp_path):
    law = states(80, after)
    built = build(compile_law(law, Options(reassociate=True)), tmp_path / "law.s")
    banks = {state.register[0] for state in built.image.states}
    assert len(built.image.states) == 80
    assert {"a", "b"} <= banks
    assert prove(built.compiled, built.image, count=60, seed=SEED).passed
    if "ring" in str(tmp_path):
        moves = [line for line in built.compiled.text.splitlines() if "old_" in line]
        assert len(moves) == 2  # one state is held while the others move
