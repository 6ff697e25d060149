# SPDX-License-Identifier: Apache-2.0
"""Several laws in one image: proved one by one at their entries, and in turn on one core."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from asip_asm import link as linker
from asip_asm.ir import Register
from asip_asm.link import link
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.program import build
from sim.core.api import Core
from sim.laws.asip_model.__main__ import main
from sim.laws.prove_functions import prove_functions
from sim.laws.prove_program import draw_ticks, prove
from tests.model_compiler.laws import mixed, sample

LAWS = {"fast": mixed, "slow": sample}


@pytest.fixture
def built(tmp_path):
    return {n: build(compile_law(law()), tmp_path / f"{n}.s") for n, law in LAWS.items()}


def test_each_function_has_its_bits_and_the_cycles_that_it_has_alone(built):
    image = link("both", {name: one.image for name, one in built.items()})
    for name, one in built.items():
        proof = prove(one.compiled, image.function(name), count=200)
        assert proof.passed, (name, proof.first_difference, proof.worst_result)
        with Core(image) as core:
            core.select(name)
            inputs, _ = draw_ticks(one.compiled.law, 3, np.random.default_rng(1))
            assert set(core.batch(inputs).cycles.tolist()) == {one.cycles}


def test_functions_in_turn_do_not_disturb_each_other(built):
    image = link("both", {name: one.image for name, one in built.items()})
    compiled = {name: one.compiled for name, one in built.items()}
    assert prove_functions(compiled, image, ticks=200, seed=3) == ""


def test_states_that_another_function_writes_are_found(built, monkeypatch):
    place_registers = linker._own_registers

    def over_states(places, programs, decoded, isa):
        """The second function's values within a run are in the first one's states."""
        place_registers(places, programs, decoded, isa)
        own = {r for r in places[1].registers.values() if r.bank == "C" and r.index > 32}
        free = [Register("C", i) for i in range(63, 0, -1) if Register("C", i) not in own]
        for old, new in places[1].registers.items():
            if old.bank == "C" and new not in own:
                places[1].registers[old] = free.pop(0)

    monkeypatch.setattr(linker, "_own_registers", over_states)
    image = link("both", {name: one.image for name, one in built.items()})
    compiled = {name: one.compiled for name, one in built.items()}
    assert ", tick " in prove_functions(compiled, image, ticks=50, seed=3, backend="iss")


def test_fewer_constants_in_bank_k_are_loads_from_data(tmp_path):
    few = build(compile_law(sample(), Options(constants=3)), tmp_path / "few.s")
    assert len(few.image.constants) == 4 and len(few.image.data) > 3  # one is the parameter
    assert prove(few.compiled, few.image, count=100, backend="iss").passed


RECORD = """\
title = "law {name}"
[[input]]
names = ["x"]
unit = "1"
limits = [-2, 2]
meaning = "input"
[[state]]
names = ["s"]
unit = "1"
limits = [-1, 1]
meaning = "kept"
[[output]]
names = ["y"]
unit = "1"
limits = [-3, 3]
safe = 0.5
meaning = "result"
"""


def write_laws(folder, names):
    x, s = ca.SX.sym("x"), ca.SX.sym("s")
    for k, name in enumerate(names):
        after = ca.fmax(ca.fmin(s + (k + 1) * 0.1 * x, 1), -1)
        law = ca.Function(name, [x, s], [s * x + k, after], ["x", "s"], ["y", "s_next"])
        law.save(str(folder / f"{name}.casadi"))
        (folder / f"{name}.interface.toml").write_text(RECORD.format(name=name))
    return [str(folder / f"{n}{end}") for n in names for end in (".casadi", ".interface.toml")]


def test_command_compiles_and_proves_several(tmp_path, capsys):
    files = write_laws(tmp_path, ["quick", "slow"])
    stem = tmp_path / "build/both"
    assert main([*files, "--prove", "--c", "--inputs", "300", "-o", str(stem)]) == 0
    shown = capsys.readouterr().out
    assert shown.count("\nproved") == 2
    assert "300 ticks of 2 functions in turn: bits equal the interpreter's" in shown
    for end in (".asip.json", ".h", ".report.txt", ".quick.s", ".slow.tick.c", ".slow.tick.h"):
        assert (stem.parent / f"both{end}").stat().st_size > 100
    assert "static const asip_function both_slow" in (stem.parent / "both.h").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["law.casadi"], "a function needs its interface record, a URDF has none"),
        (["law.casadi", "arm.urdf"], "a function needs its interface record"),
        (["arm.urdf", "arm.toml"], "a function needs its interface record"),
        (["a.urdf", "b.urdf", "--loop", "1"], "--loop is for computed_torque of one URDF"),
    ],
)
def test_command_refuses_files_that_do_not_go_together(arguments, message, capsys):
    with pytest.raises(SystemExit, match="^2$"):
        main(arguments)
    assert message in capsys.readouterr().err


def test_command_refuses_two_functions_of_one_name(tmp_path, capsys):
    files = write_laws(tmp_path, ["quick"])
    assert main([*files, *files, "-o", str(tmp_path / "x")]) == 1
    assert "two functions are named quick, as their files; rename one" in capsys.readouterr().err
