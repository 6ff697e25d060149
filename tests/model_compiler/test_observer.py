# SPDX-License-Identifier: Apache-2.0
"""Linear systems as programs: the observer of 24 states, its bits, bound and estimates."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from asip_asm.model.linear_program import LinearSystem, state_bounds
from asip_asm.model.read import ModelError
from sim.laws.observer import (
    RUN,
    build_observer,
    in_doubles,
    observer,
    prove_observer,
    recording,
    watch,
)

SEED = 38


@pytest.fixture(scope="module")
def system() -> LinearSystem:
    return observer()


def small(size: int = 5, inputs: int = 2, spread: float = 0.9) -> LinearSystem:
    """A drawn system with a row and a column of zeros."""
    rng = np.random.default_rng(SEED)
    a = rng.normal(size=(size, size))
    b = rng.normal(size=(size, inputs))
    a[2], b[2], a[:, 1] = 0.0, 0.0, 0.0
    a *= spread / np.abs(np.linalg.eigvals(a)).max()
    names = tuple(f"s{i}" for i in range(size)), tuple(f"w{i}" for i in range(inputs))
    limits = np.linspace(0.5, 2.0, inputs)
    return LinearSystem("small", a, b, *names, limits, 1e3, ("1",) * size, ("1",) * inputs)


@pytest.mark.parametrize("configuration", ["wide", "stream"])
def test_observer_has_the_interpreters_bits_within_its_bound(configuration, system, tmp_path):
    built = build_observer(system, tmp_path / "observer.s", configuration)
    assert built.cycles <= {"wide": 200, "stream": 300}[configuration]
    proof = prove_observer(system, built, RUN, "iss")
    assert proof.passed and proof.ticks == RUN, proof


@pytest.mark.parametrize("configuration", ["wide", "stream"])
def test_any_system_is_compiled(configuration, tmp_path):
    for size, inputs in ((5, 2), (3, 1), (9, 4)):
        made = small(size, inputs)
        built = build_observer(made, tmp_path / "small.s", configuration)
        assert prove_observer(made, built, RUN, "iss").passed


def test_rtl_takes_the_cycles_that_were_announced(system, tmp_path):
    built = build_observer(system, tmp_path / "observer.s")
    proof = prove_observer(system, built, RUN)
    assert proof.passed, proof


def test_a_wrong_word_of_a_stream_is_found(system, tmp_path):
    built = build_observer(system, tmp_path / "observer.s")
    first, *others = built.image.streams
    words = list(first.words)
    words[5] = f"{int(words[5], 16) ^ 1 << 20:0{len(words[5])}x}"
    image = msgspec.structs.replace(
        built.image, streams=[msgspec.structs.replace(first, words=words), *others]
    )
    assert prove_observer(system, replace(built, image=image), RUN, "iss").unequal


def test_bounds_hold_for_the_worst_inputs_and_are_not_idle():
    made = small()
    largest, bound = state_bounds(made)
    powers = [np.linalg.matrix_power(made.a, k) @ made.b for k in range(400)]
    reached = sum(np.abs(each) @ made.limits for each in powers)
    assert (reached <= largest * (1 + 1e-9)).all() and reached[0] > 0.2 * largest[0]
    rng = np.random.default_rng(SEED)
    w = rng.choice([-1.0, 1.0], (50, 300, 2)) * made.limits
    moved = replace(
        made,
        a=made.a.astype(np.float32).astype(float),
        b=made.b.astype(np.float32).astype(float),
    )
    error = np.abs(in_doubles(moved, w) - in_doubles(made, w)).max(axis=(0, 1))
    assert (error <= bound).all() and error.max() > 1e-3 * bound.max()


def test_a_system_that_is_not_stable_is_refused():
    with pytest.raises(ModelError, match="does not decay within"):
        state_bounds(small(spread=1.01))


def test_observer_estimates_the_nonlinear_chain_as_in_doubles(system, tmp_path):
    built = build_observer(system, tmp_path / "observer.s")
    seen = watch(system, built.image, 600, "iss")
    true, inputs = recording(600)
    assert (np.abs(inputs) <= system.limits).all()
    size = float(np.sqrt((true**2).mean()))
    assert seen.core < 0.1 * size and seen.core < 1.001 * seen.double
    assert seen.apart < 1e-4
    # The sensors alone do not give the states: without the gain the estimate is far off.
    blind = replace(system, b=np.hstack((system.b[:, :3], np.zeros((24, 5)))))
    far = in_doubles(blind, inputs) - true
    assert np.sqrt((far[60:] ** 2).mean()) > 2 * seen.core
