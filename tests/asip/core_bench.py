# SPDX-License-Identifier: Apache-2.0
"""Bench of the core: programs of single bundles, runs on the RTL clock by clock and on the model.

A `CoreRun` holds what a run leaves: status, counters, the cycle in which each bundle issued
(counted from the first), and the words written per register or output in order ('a3', 'o0').
"""

from __future__ import annotations

import functools
import hashlib
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.disassemble import decode_bundle, disassemble
from asip_asm.encode import encode_bundle
from asip_asm.image import ConstantEntry, Image, OutputEntry, StateEntry
from asip_asm.ir import Bundle, Operation, Output, Register
from asip_asm.isa import default_isa
from asip_asm.machine import OPERAND_READ, REFETCH, Machine, load_machine
from sim.core.iss import Iss, RunResult, arithmetic
from sim.core.iss.stepped import SteppedRun
from sim.rtl.asip_bus import BLOCK, CLEAR, CSR, FAULT_NAMES, START, STATUS, register_address
from sim.rtl.asip_rtl import AsipRtl
from tests.asip import resilient_bench

ROOT = Path(__file__).parents[2]
ISA = default_isa()
CONFIGURATIONS = ("fast", "small")
STALLS = ("STALL_OPERAND", "STALL_PORT", "STALL_UNIT", "STALL_FETCH", "DRAIN")
RUN_LIMIT = 20_000  # cycles after which a run of the bench is taken for hanging
REDIRECT = REFETCH  # cycles from a redirect to the bundle in stage D (contract of asip_fetch)
CMP = load_machine("fast").units["cmp"].latency
EMPTY = ()  # a bundle of an image without operations
HALT = Operation("halt")  # among the operations of a bundle of an image: its halt bit
Item = Operation | Sequence[Operation] | str
PIPELINE = OPERAND_READ + CMP + 1  # cycles in which a move leaves it: D, R1, R2, E1, E2, W

# Words that have tripped floating-point hardware before: zeros, subnormals, neighbours of powers of
# two, largest, infinities, quiet and signalling NaNs, integers.
CORNER_WORDS = """
    00000000 80000000 00000001 80000001 007FFFFF 807FFFFF 00800000 80800000
    00800001 00FFFFFF 33800000 34000000 3EAAAAAB 3F000000 3F7FFFFF 3F800000
    3F800001 BF800000 3FC00000 C0000000 40490FDB 42C80000 437FFFFF C3800000
    4AFFFFFF 4B800000 4EFFFFFF 4F000000 CF000000 CF000001 5F000000 1F800000
    7F7FFFFF FF7FFFFF 7F800000 FF800000 7FC00000 FFC12345 7F800001 FFBFFFFF
    00000007 FFFFFFFF 7FFFFFFF
"""
CORNERS = tuple(int(word, 16) for word in CORNER_WORDS.split())


def core(configuration: str) -> AsipRtl:
    """The one core of a configuration; every run of the bench loads all that it needs."""
    streams = ISA.configurations[configuration].stream_words
    return resilient_bench.stream_core(configuration) if streams else _core(configuration)


@functools.cache
def _core(configuration: str) -> AsipRtl:
    return AsipRtl(configuration)


@functools.cache
def machine(configuration: str) -> Machine:
    """Machine description of a configuration."""
    return load_machine(configuration)


# ---------------------------------------------------------------------- programs


def register(name: str) -> Register:
    """Register of 'a3', 'k100' or 'zero'."""
    return Register("zero", 0) if name == "zero" else Register(name[0].upper(), int(name[1:]))


def op(
    mnemonic: str,
    *operands: str,
    imm: int | None = None,
    target: str | None = None,
    pipe: int | None = None,
) -> Operation:
    """Operation with operands in assembly order; 'o3' as the destination is an output.

    Of loads and stores only the registers are operands (`ld dst, index`, `st src, index`).
    """
    record = ISA.operations[mnemonic]
    names = [name for name in record.operands if name in ("dst", "a", "b", "c")]
    names += ["b"] if "address" in record.operands else []
    result = Operation(mnemonic, imm=imm, target=target, lanes_of=pipe)
    for name, operand in zip(names, operands, strict=True):
        if name == "dst" and operand[0] == "o":
            result.dst = Output(int(operand[1:]))
        else:
            setattr(result, name, register(operand))
    return result


def is_fma(mnemonic: str) -> bool:
    """Whether the operation is in a multiply-add pipe."""
    return ISA.unit_of(mnemonic).bank == "pipe"


def bundle(configuration: str, *operations: Operation) -> Bundle:
    """Bundle with each operation in the slot of its destination (b registers: second pipe)."""
    slots: dict[int, Operation] = {}
    for operation in operations:
        if operation is HALT:
            continue
        if configuration == "small":
            slot = 0
        elif is_fma(operation.mnemonic):
            slot = int(isinstance(operation.dst, Register) and operation.dst.bank == "B")
        else:
            slot = 2
        assert slot not in slots, "two operations for one slot"
        slots[slot] = operation
    return machine(configuration).bundle(slots, any(each is HALT for each in operations))


def image(
    configuration: str,
    bundles: Iterable[Item],
    registers: Mapping[str, int] = {},
    outputs: int = 1,
    data: Sequence[int] = (),
    labels: Mapping[str, int] = {},
    **changes: object,
) -> Image:
    """Image of bundles with preset registers; k registers are constants.

    A bundle is given as its operation or operations, HALT among them if it halts, or as its word.
    Output i is 'oi' with the safe value i + 0.5; the mask asks for those that a bundle writes.
    """
    digits = ISA.bundle_width(configuration) // 4
    encoded: list[str] = []
    mask = 0
    for item in bundles:
        if isinstance(item, str):
            encoded.append(item)
            continue
        operations = (item,) if isinstance(item, Operation) else item
        word = encode_bundle(bundle(configuration, *operations), ISA, dict(labels))
        encoded.append(f"{word:0{digits}x}")
        for operation in operations:
            if isinstance(operation.dst, Output):
                mask |= 1 << operation.dst.index
    result = Image(
        title="bench",
        configuration=configuration,
        bundles=encoded,
        sources=[[] for _ in encoded],
        constants=[
            ConstantEntry(f"v{name[1:]}", int(name[1:]), "int", f"{bits & 0xFFFFFFFF:08x}")
            for name, bits in registers.items()
            if name[0] == "k"
        ],
        states=[
            StateEntry(f"s_{name}", name, "int", f"{bits & 0xFFFFFFFF:08x}")
            for name, bits in registers.items()
            if name[0] != "k"
        ],
        outputs=[OutputEntry(f"out{i}", i, f"{safe_word(i):08x}") for i in range(outputs)],
        data=[f"{word & 0xFFFFFFFF:08x}" for word in data],
        labels={k: v for k, v in labels.items() if v < len(encoded)},
        output_mask=mask,
    )
    for name, value in changes.items():
        setattr(result, name, value)
    return result


def safe_word(index: int) -> int:
    """Safe value of output `index` in images of the bench: index + 0.5."""
    return arithmetic.bits_of(arithmetic.from_float(index + 0.5))


def assembled(text: str, configuration: str | None = None, optimise: bool = False) -> Image:
    """Image of a source text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.s"
        path.write_text(text, encoding="utf-8")
        return assemble(path, configuration=configuration, optimise=optimise)


def decoded(program: Image) -> list[Bundle]:
    """Bundles of an image."""
    return [_bundle(word, program.configuration) for word in program.bundles]


@functools.lru_cache(maxsize=1 << 14)
def _bundle(word: str, configuration: str) -> Bundle:
    return decode_bundle(int(word, 16), configuration, ISA)


# ---------------------------------------------------------------------- runs


@dataclass(frozen=True)
class CoreRun:
    """What one run on the RTL left over; see the module's text."""

    status: int
    fault: str
    info: int
    flags: int
    cycles: int
    stalls: dict[str, int]
    issued: list[tuple[int, int]]
    outputs: dict[str, int]
    writes: dict[str, list[int]] = field(default_factory=dict)

    @property
    def issue_cycles(self) -> list[int]:
        return [cycle for cycle, _ in self.issued]

    @property
    def bundle_order(self) -> list[int]:
        return [address for _, address in self.issued]


def load(program: Image, csr: Mapping[str, int] = {}) -> AsipRtl:
    """Load an image into its core; the bundle after the program is empty memory.

    `csr`: registers with values that no image has.
    """
    dut = core(program.configuration)
    dut.load(program)
    for name, value in csr.items():
        dut.write(CSR[name], value)
    if len(program.bundles) < ISA.program_bundles:
        for lane in range(ISA.lanes(program.configuration)):
            dut.write(BLOCK["program"] + 4 * len(program.bundles) + lane, 0)
    return dut


def traced_writes(dut: AsipRtl) -> dict[str, list[int]]:
    """The words written to each register or output since `dut.trace()`, in order."""
    writes: dict[str, list[int]] = {}
    for bank, index, word in dut.traced_writes():
        writes.setdefault(f"{bank.lower()}{index}", []).append(word)
    return writes


def output_words(dut: AsipRtl, count: int = 2) -> list[int]:
    """The first output words as the host reads them."""
    return [dut.read(BLOCK["outputs"] + index) for index in range(count)]


def run(program: Image, csr: Mapping[str, int] = {}, *, loaded: bool = False) -> CoreRun:
    """Load an image and run it once, clock by clock; `csr` as for `load`."""
    dut = core(program.configuration) if loaded else load(program, csr)
    dut.write(CSR["CONTROL"], CLEAR)
    dut.trace()
    span = min(len(program.bundles) + 4, ISA.program_bundles)
    before = dut.issued(span)
    total, origin = int(before.sum()), None
    issued: list[tuple[int, int]] = []
    dut.write(CSR["CONTROL"], START)
    for _ in range(RUN_LIMIT):
        if dut.irq:
            break
        dut.clock()
        now = dut.issued(span)
        if int(now.sum()) != total:
            total += 1
            origin = dut.cycles if origin is None else origin
            issued.append((dut.cycles - origin, int((now - before).argmax())))
            before = now
    else:
        raise AssertionError(f"no end of the run\n{dump(program)}")
    writes = traced_writes(dut)
    dut.trace(False)
    status = dut.read(CSR["STATUS"])
    return CoreRun(
        status=status,
        fault=FAULT_NAMES[STATUS["cause"].of(status)],
        info=dut.read(CSR["FAULT_INFO"]),
        flags=STATUS["flags"].of(status),
        cycles=dut.read(CSR["CYCLES"]),
        stalls={name: dut.read(CSR[name]) for name in STALLS},
        issued=issued,
        outputs={o.name: dut.read(BLOCK["outputs"] + o.index) for o in program.outputs},
        writes=writes,
    )


@functools.cache
def rtl_sincos(bits: int, cosine: bool) -> tuple[int, int]:
    """The hardware's sine or cosine and flags, checked against the correctly rounded one.

    Both are single operations on the `small` core, so that the sine in a program under test is an
    ordinary word for the model. Allowed: 1 ulp, the same flags.
    """
    constants = BLOCK["constants"]
    result = _sincos_probe().run(
        [constants, constants + 1],
        np.array([[bits, int(cosine)]], dtype=np.uint32),
        [register_address("c0")],
    )
    got, flags = int(result.words[0, 0]), STATUS["flags"].of(int(result.status[0]))
    want, want_flags = arithmetic.sincos_rounded(bits, cosine)
    name = "fcos" if cosine else "fsin"
    assert flags == want_flags and ulps(got, want) <= 1, (
        f"{name} {bits:08x}: got {got:08x} flags {flags:05b}, want {want:08x} {want_flags:05b}"
    )
    return got, flags


@functools.cache
def _sincos_probe() -> AsipRtl:
    labels = {"cosine": 3}
    program = image(
        "small",
        [
            op("bnz", "k1", target="cosine"),
            op("fsin", "c0", "k0"),
            HALT,
            op("fcos", "c0", "k0"),
            HALT,
        ],
        outputs=0,
        labels=labels,
    )
    probe = AsipRtl("small")
    probe.load(program)
    return probe


def ulps(x: int, y: int) -> int:
    """Distance of two binary32 words of any sign in units in the last place; 0 for equal NaNs."""

    def order(bits: int) -> int:
        return -(bits & 0x7FFFFFFF) if bits >> 31 else bits

    return abs(order(x) - order(y))


def iss_run(program: Image) -> tuple[Iss, RunResult]:
    """The same run on the instruction-set model, with the hardware's sine and cosine."""
    model = Iss(program.to_json(), sincos=rtl_sincos, trace=True)
    return model, model.run()


# ---------------------------------------------------------------------- checks


def expected_cycles(program: Image) -> tuple[list[int], int, dict[str, int]]:
    """Issue cycles, CYCLES and counters of a program without branches, by the machine description
    for the bundles in the order in which the instruction-set model executes them.
    """
    target = machine(program.configuration)
    bundles = decoded(program)
    order = executed(program)
    issues = target.issue_cycles([bundles[i] for i in order])
    cycles = target.run_cycles(bundles)
    counters = {
        "STALL_OPERAND": sum(issue.operand + issue.waw for issue in issues),
        "STALL_PORT": sum(issue.port for issue in issues),
        "STALL_UNIT": sum(issue.unit for issue in issues),
        "STALL_FETCH": 0,
        "DRAIN": cycles - issues[-1].cycle - 1,
    }
    return [issue.cycle for issue in issues], cycles, counters


def executed(program: Image) -> list[int]:
    """Bundles in the order in which the instruction-set model executes them."""
    if not any(bundle.ends for bundle in decoded(program)):
        return list(range(len(program.bundles)))
    run = SteppedRun(Iss(program.to_json(), sincos=rtl_sincos))
    order = []
    while run.position is not None:
        order.append(run.position)
        run.step()
    return order


def verify(program: Image, where: str = "", *, timing: bool = True) -> CoreRun:
    """Run an image: words, flags and outputs as the model has them, every cycle accounted for.

    With `timing` (programs without branches) also issue cycles and counters of the machine
    description. A failure says `where`, and how to replay.
    """
    got = run(program)
    try:
        _check_values(program, got)
        assert len(got.issued) + sum(got.stalls.values()) == got.cycles, f"{got.stalls}"
        if timing:
            assert got.bundle_order == executed(program)
            issues, cycles, counters = expected_cycles(program)
            assert got.issue_cycles == issues
            assert (got.cycles, got.stalls) == (cycles, counters)
    except AssertionError as error:
        raise AssertionError(f"{where}: {error}{dump(program)}") from None
    return got


def _check_values(program: Image, got: CoreRun) -> None:
    _, want = iss_run(program)
    assert (got.fault, want.fault.name) == ("NONE", "NONE"), "fault"
    assert set(got.writes) == set(want.writes), "registers written"
    for name, values in want.writes.items():
        assert texts(got.writes[name]) == texts(values), f"words written to {name}"
    assert f"{got.flags:05b}" == f"{want.flags:05b}", "flags"
    for output in program.outputs:
        if program.output_mask >> output.index & 1:
            assert got.outputs[output.name] == want.output_bits[output.name], "outputs"


def texts(values: Iterable[int]) -> list[str]:
    """Words as hexadecimal text."""
    return [f"{value:08x}" for value in values]


def dump(program: Image, name: str | None = None) -> str:
    """Write the program's source below build/ for a replay with asip-run; returns a hint."""
    text = disassemble(program)
    name = name or hashlib.sha256(text.encode()).hexdigest()[:12]
    path = ROOT / "build" / "asip" / f"{name}.s"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return f"\nreplay: asip-run {path.relative_to(ROOT)} --config {program.configuration}"
