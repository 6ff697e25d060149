# SPDX-License-Identifier: Apache-2.0
"""Vector operations of the core `wide`: operands at each distance, in every lane, against numpy.

Each check hits a bin of tests/cocotb/functional.py. A register of a further lane is read by taking
it (`vout`). test_asip.py starts the tests.
"""

from __future__ import annotations

from collections.abc import Callable

import cocotb
import numpy as np

from asip_asm.image import StreamEntry
from asip_asm.isa import default_isa
from sim.cocotb import bins, golden
from tests.asip.core_bench import EMPTY, HALT, image, op
from tests.bench.seed import SEED
from tests.cocotb.states_tb import DISTANCES, constants, started

LANES = 1 + default_isa().configurations["wide"].lanes
VECTORS = 16  # of the stream
POWER = 0x4B400001  # 1.5 * 2^23 + 1: n = 1 of `vscale`, register k7, in all lanes of a6
Lanes = golden.Bits


def below(a: Lanes) -> Lanes:
    """max(min(a, 0), -32)"""
    x = golden.single(a)
    return golden.packed(np.where(x < 0, np.maximum(x, np.float32(-32)), np.float32(0)))


def above(a: Lanes) -> Lanes:
    """max(a, 0)"""
    return golden.packed(np.maximum(golden.single(a), np.float32(0)))


def same(word: np.uint32) -> Lanes:
    """A word that is the same in all lanes."""
    return np.full(LANES, word, np.uint32)


# Operands of each operation, with the value to look at in a5, and its lanes from that value and the
# stream's word. `vout` takes the last lane.
CONSUMERS: dict[str, tuple[tuple[str, ...], Callable[[Lanes, Lanes], Lanes]]] = {
    "vfmul": (("s0", "a5"), lambda v, s: golden.mul(s, same(v[0]))[0]),
    "vfmadd": (("s0", "k1", "a5"), lambda v, s: golden.fma(s, same(K[1]), v)[0]),
    "vout": (("zero", "a5"), lambda v, s: same(v[-1])),
    "vmadd": (("a5", "a5", "a5"), lambda v, s: golden.fma(v, v, v)[0]),
    "vscale": (("a5", "a6", "a5"), lambda v, s: golden.fma(v, same(TWO), v)[0]),
    "vbelow": (("a5", "a5"), lambda v, s: golden.mul(below(v), v)[0]),
    "vabove": (("a5", "a5", "a5"), lambda v, s: golden.fma(above(v), v, v)[0]),
}
K = [np.uint32(constants()[f"k{i}"]) for i in range(4)]
TWO = np.uint32(0x40000000)


@cocotb.test()
@cocotb.parametrize(distance=DISTANCES)
async def hazard__operand_of_every_vector_operation__is_the_last_one_written(dut, distance):
    """In every lane the result is that of numpy on the vector written so many bundles before."""
    core, monitor = await started(dut)
    values = np.random.default_rng(SEED).uniform(-50, 50, (VECTORS, LANES)).astype(np.float32)
    words = golden.packed(values)
    texts = [[f"{word:08x}" for word in words[:, lane]] for lane in range(LANES)]
    stream = StreamEntry("s", "A", 0, texts[0], texts[1:])
    following = iter(words)
    bundles: list = [op("vmadd", "a6", "s0", "zero", "k7"), op("seek", imm=0)]
    want, pairs = {}, []
    for turn, (name, (operands, model)) in enumerate(CONSUMERS.items()):
        factor = (1, 3)[turn & 1]
        bundles += [op("vfmul", "a5", "s0", f"k{factor}"), *[EMPTY] * (distance - 1)]
        vector = golden.mul(next(following), same(K[factor]))[0]
        last = {"imm": LANES - 1, "pipe": 0} if name == "vout" else {}
        bundles.append(op(name, f"a{10 + turn}", *operands, **last))
        pairs.append((name, len(bundles) - 1 - distance, len(bundles) - 1))
        word = next(following) if "s0" in operands else vector
        want[name] = model(vector, word)
    for turn, name in enumerate(CONSUMERS):
        for lane in range(1 if name == "vout" else LANES):
            place = f"a{20 + LANES * turn + lane}"
            bundles.append(op("vout", place, "zero", f"a{10 + turn}", imm=lane, pipe=0))
    presets = constants() | {"k7": POWER}
    await core.load(image("wide", [*bundles, HALT], presets, outputs=0, streams=[stream]))
    got = await core.tick()
    assert got.fault == "NONE", got
    for turn, (name, vector) in enumerate(want.items()):
        for lane in range(1 if name == "vout" else LANES):
            found = await core.register(f"a{20 + LANES * turn + lane}")
            note = f"{name} at {distance}, lane {lane}: {found:08x}, numpy {vector[lane]:08x}"
            assert found == vector[lane], note
    order = monitor.issued
    for name, first, second in pairs:
        assert order.index(second) - order.index(first) == distance, name
        bins.hit("hazard", name, distance)
