# SPDX-License-Identifier: Apache-2.0
"""The core in every state: operands at each distance, faults and host accesses in run and drain.

Each check hits a bin of tests/cocotb/functional.py. The state is that of the trace: `drain` begins
when the bundle that halts has issued. test_asip.py starts the tests.
"""

from __future__ import annotations

import cocotb
import numpy as np

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from asip_asm.ir import Operation
from sim.cocotb import bins, golden
from sim.cocotb.asip import Asip
from sim.cocotb.clocked import word
from sim.rtl.asip_bus import BLOCK, CSR, IRQ_ALL, register_address
from tests.asip.core_bench import EMPTY, HALT, image, is_fma, op, safe_word
from tests.bench.seed import SEED
from tests.cocotb.asip_tb import OPERATIONS

DISTANCES = (1, 2, 3, 4)  # bundles from the producer to the consumer
FLOATS = (0x40200000, 0x3FA00000, 0x3F400000, 0x40E00000)  # k0 .. k3: 2.5, 1.25, 0.75, 7.0
INTEGERS = {"k4": 3, "k5": 2, "k6": 5}
DATA = [0x3F800000 + 0x100000 * i for i in range(16)]
CONSUMERS = OPERATIONS | {"mov {}, p": lambda p, q, r, n: (p, 0)}
STATES = ("idle", "run", "drain")
LONG = 30  # bundles without an operation
FAULTS = {
    ("NOT_FINITE", "run"),
    ("NOT_FINITE", "drain"),
    ("ADDRESS", "run"),
    ("ADDRESS", "drain"),
    ("ILLEGAL", "run"),
    ("WATCHDOG", "run"),
    ("WATCHDOG", "drain"),
    ("OUTPUT_MISSING", "drain"),
}
ACCESSES = ["read csr", "write csr", "write constants", "read outputs", "write safe"]
ACCESSES += ["read registers", "write registers", "read data", "write data", "write program"]


class Issues:
    """The bundles that issue, in order: what these tests need of the trace, in little time."""

    def __init__(self, core: Asip) -> None:
        self.issued: list[int] = []
        cocotb.start_soon(self._watch(core))

    async def _watch(self, core: Asip) -> None:
        dut = core.dut
        while True:
            await core.next()
            if dut.trace_issue_o.value:
                self.issued.append(word(dut.trace_pc_o))


async def started(dut) -> tuple[Asip, Issues]:
    """The core out of reset, watched."""
    core = Asip(dut, seed=SEED)
    await core.reset()
    return core, Issues(core)


def quotient(output: str = "") -> Operation:
    """A division, which is under way long after its bundle; 2.5 / 1.25."""
    return op("fdiv", output or "c9", "k0", "k1")


def constants() -> dict[str, int]:
    """The presets of every program here."""
    return {f"k{i}": bits for i, bits in enumerate(FLOATS)} | INTEGERS


# ---------------------------------------------------------------- operands
def float_producer(turn: int) -> tuple[Operation, np.ndarray]:
    """Writes a5, another value each turn: a stale one would show."""
    k = [np.array([bits], np.uint32) for bits in FLOATS]
    factor = ("k1", "k3")[turn & 1]
    value = golden.fma(k[0], k[int(factor[1])], k[2])[0]
    return op("fmadd", "a5", "k0", factor, "k2"), value


def integer_producer(turn: int) -> tuple[Operation, int]:
    """Writes c5."""
    other = ("k4", "k5")[turn & 1]
    return op("iadd", "c5", "k4", other), 3 + INTEGERS[other]


@cocotb.test()
@cocotb.parametrize(distance=DISTANCES)
async def hazard__operand_of_every_operation__is_the_last_one_written(dut, distance):
    """Results are those of numpy on the value written so many bundles before."""
    core, monitor = await started(dut)
    configuration = await core.configuration()
    names = {"p": "a5", "q": "k1", "r": "k2", "n": "c5", "m": "k6"}
    bundles, want, pairs = [], {}, []
    q, r = (np.array([FLOATS[i]], np.uint32) for i in (1, 2))
    for turn, (line, model) in enumerate(CONSUMERS.items()):
        mnemonic, rest = line.split(None, 1)
        wanted = [names[name] for name in rest.replace("{},", "").replace(",", " ").split()]
        reads_float = "a5" in wanted
        producer, value = (float_producer if reads_float else integer_producer)(turn)
        place = f"{'a' if is_fma(mnemonic) else 'c'}{10 + turn}"
        bundles += [producer, *[EMPTY] * (distance - 1), op(mnemonic, place, *wanted)]
        pairs.append((mnemonic, len(bundles) - 1 - distance, len(bundles) - 1))
        p = value if reads_float else r
        n = np.array([0 if reads_float else value], np.uint32)
        want[mnemonic] = place, int(np.asarray(model(p, q, r, n)[0])[0])
    producer, value = integer_producer(0)
    bundles += [producer, *[EMPTY] * (distance - 1), op("ld", "c50", "c5", imm=0)]
    pairs.append(("ld", len(bundles) - 1 - distance, len(bundles) - 1))
    want["ld"] = "c50", DATA[value]
    producer, value = float_producer(1)
    bundles += [producer, *[EMPTY] * (distance - 1), op("st", "a5", "zero", imm=12)]
    pairs.append(("st", len(bundles) - 1 - distance, len(bundles) - 1))
    stored = int(value[0])
    waves = {}
    for turn, name in enumerate(("fsin", "fcos")):
        producer, value = float_producer(turn)
        bundles += [producer, *[EMPTY] * (distance - 1), op(name, f"c{52 + turn}", "a5")]
        pairs.append((name, len(bundles) - 1 - distance, len(bundles) - 1))
        waves[name] = f"c{52 + turn}", value
    labels = {}
    for turn, name in enumerate(("bz", "bnz")):
        # Before the branch the register has the other kind of value.
        producer = op("fmul", "a6", "k0", "zero" if name == "bz" else "k1")
        bundles += [producer, *[EMPTY] * (distance - 1), op(name, "a6", target=name)]
        pairs.append((name, len(bundles) - 1 - distance, len(bundles) - 1))
        bundles.append(op("fmul", f"a{60 + turn}", "k0", "k1"))
        labels[name] = len(bundles)
    bundles += [quotient("o0"), HALT]
    registers = constants() | {"a60": 1, "a61": 1}
    await core.load(
        image(configuration, bundles, registers, data=DATA, labels=labels, watchdog=5000)
    )
    got = await core.tick()
    assert got.fault == "NONE", got
    for name, (place, bits) in want.items():
        found = await core.register(place)
        assert found == bits, f"{name} at {distance}: {found:08x}, numpy {bits:08x}"
    assert await core.read(BLOCK["data"] + 12) == stored
    for name, (place, value) in waves.items():
        found = np.array([await core.register(place)], np.uint32)
        assert golden.sine_error(value, found, name == "fcos")[0] < golden.SINE_ULP, name
    assert [await core.register(f"a{60 + turn}") for turn in (0, 1)] == [1, 1], "not taken"
    order = monitor.issued
    for name, first, second in pairs:
        assert order.index(second) - order.index(first) == distance, name
        bins.hit("hazard", name, distance)


# ---------------------------------------------------------------- faults
def faulty_program(configuration: str, cause: str, state: str) -> Image:
    """A program whose fault comes in a state."""
    rest = [EMPTY] * LONG if state == "run" else []
    infinite, beyond = op("fdiv", "o0", "k0", "zero"), op("ld", "c9", "k0", imm=0)  # index 2.5
    bundles: dict[str, list] = {
        "NOT_FINITE": [infinite, *rest, HALT],
        "ADDRESS": [quotient("o0"), *([beyond, *rest, HALT] if rest else [(beyond, HALT)])],
        "ILLEGAL": [quotient("o0"), EMPTY, HALT],
        "WATCHDOG": [*rest, quotient("o0"), HALT],
        "OUTPUT_MISSING": [quotient(), HALT],
    }
    watchdog = 12 if cause == "WATCHDOG" else 5000
    program = image(configuration, bundles[cause], constants(), watchdog=watchdog)
    if cause == "ILLEGAL":
        program.bundles[1] = "f" * len(program.bundles[1])
    if cause == "OUTPUT_MISSING":
        program.output_mask = 1
    return program


@cocotb.test()
async def fault__in_run_and_in_drain__is_reported_and_the_outputs_are_safe(dut):
    core, monitor = await started(dut)
    configuration = await core.configuration()
    good = image(configuration, [quotient("o0"), HALT], constants(), watchdog=5000)
    for cause, state in sorted(FAULTS):
        program = faulty_program(configuration, cause, state)
        await core.load(program)
        monitor.issued.clear()
        got = await core.tick()
        assert got.fault == cause, got
        halted = len(program.bundles) - 1 in monitor.issued
        assert halted == (state == "drain"), f"{cause} came in the other state"
        assert got.words == {"out0": safe_word(0)}
        bins.hit("fault", cause, state)
        await core.load(good)
        assert (await core.tick()).outputs == {"out0": 2.0}


# ---------------------------------------------------------------- host
async def until(core: Asip, monitor: Issues, state: str, bundle: int) -> None:
    """Start a run, and wait until the core is in a state, and some clocks more in run."""
    if state == "idle":
        return
    await core.start()
    if state == "run":
        await core.cycles(core.random.randrange(8, 8 + LONG // 2))
        return
    while bundle not in monitor.issued:
        await core.next()


@cocotb.test()
@cocotb.parametrize(state=STATES)
async def host__access_of_each_block_in_each_state__is_as_in_idle(dut, state):
    """A read gives what is there at the end of the run; a write counts for the next run."""
    core, monitor = await started(dut)
    configuration = await core.configuration()
    bundles = [op("st", "k4", "zero", imm=7), *[EMPTY] * LONG, quotient("o0"), HALT]
    registers = constants() | {"c41": 0x1234}
    await core.load(image(configuration, bundles, registers, data=DATA, watchdog=5000))
    assert (await core.tick()).outputs == {"out0": 2.0}
    cycles = await core.register("CYCLES")
    reads = {
        "csr": (CSR["ID"], REGMAP.registers["ID"].reset),
        "outputs": (BLOCK["outputs"], 0x40000000),
        "registers": (register_address("c41"), 0x1234),
        "data": (BLOCK["data"] + 7, 3),
    }
    writes = {
        "csr": (CSR["IRQ_ENABLE"], IRQ_ALL),
        "constants": (BLOCK["constants"] + 20, 0x41200000),
        "safe": (BLOCK["safe"] + 3, 0x41200001),
        "registers": (register_address("c40"), 0x41200002),
        "data": (BLOCK["data"] + 9, 0x41200003),
        "program": (BLOCK["program"] + 4 * 200, 0),
    }
    for access in ACCESSES:
        kind, block = access.split()
        monitor.issued.clear()
        await until(core, monitor, state, len(bundles) - 1)
        assert (state == "idle") == word(dut.irq_o), "the run ended before the access"
        place, data = (reads if kind == "read" else writes)[block]
        if kind == "read":
            assert await core.read(place) == data, access
        else:
            await core.write(place, data)
        if state != "idle":
            await core.wait()
        assert await core.register("CYCLES") == cycles, f"{access} changed the run"
        assert (await core.result()).outputs == {"out0": 2.0}, access
        if kind == "write" and block in reads and block != "csr":
            assert await core.read(place) == data, access
        bins.hit("host", kind, block, state)
