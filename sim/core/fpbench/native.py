# SPDX-License-Identifier: Apache-2.0
"""The C++ bench of one arithmetic unit as Python functions: build, run cases, ask the reference.

`Unit("fp_mul").run("mul", "random", count=10**6)` builds `fpbench.sv` around the unit (once per
content of the sources) and returns a `Report`. Words are raw 32-bit patterns, flags the five bits
{nv,dz,of,uf,nx} of `fp_pkg::flags_t`.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from asip_asm.isa import default_isa
from sim.core.backends import flag_text
from sim.rtl.build import ROOT, build_library
from sim.rtl.sources import sources_of
from sim.rtl.waves import load_model

HERE = Path(__file__).parent
RTL = ROOT / "rtl/fpu"
TOP_SOURCES = (HERE / "fp_lane.sv", HERE / "fpbench.sv")
HARNESS = HERE / "fpbench.cpp"
HEADERS = tuple(
    HERE / name
    for name in (
        *("angles.h", "cases.h", "gen/compare_codes.h", "hard_cases.h", "numbers.h"),
        *("operations.h", "reference.h"),
    )
)
TABLE = HERE / "operations.h"
SHOWN, BINS = 16, 64  # as in fpbench.cpp and angles.h; the library's report size is compared

# Lanes per simulator call: more share its cost until the code leaves the instruction cache.
LANES = {
    "fp_add": 4,
    "fp_mul": 4,
    "fp_fma": 4,
    "fp_divsqrt": 4,
    "fp_cmp": 8,
    "fp_i2f": 8,
    "fp_f2i": 8,
    "fp_sincos": 4,
}
ITERATIVE = ("fp_sincos",)


class BenchError(ValueError):
    """A request that the bench cannot run; the text names the cause and what would work."""


class _Failure(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_uint32) for name in ("a", "b", "c", "got", "want")),
        ("got_flags", ctypes.c_uint8),
        ("want_flags", ctypes.c_uint8),
        ("pad", ctypes.c_uint8 * 2),
    )


class _Angles(ctypes.Structure):
    _fields_ = (
        *((n, ctypes.c_uint64) for n in ("in_range", "beyond", "symmetric_pairs", "not_nearest")),
        ("worst", ctypes.c_double),
        ("worst_at", ctypes.c_uint32),
        ("pad", ctypes.c_uint32),
        ("histogram", ctypes.c_uint64 * (BINS + 1)),
    )


class _Report(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_uint64) for name in ("cases", "mismatches", "cycles")),
        ("seconds", ctypes.c_double),
        ("protocol", ctypes.c_char * 96),
        ("shown", ctypes.c_uint32),
        ("pad", ctypes.c_uint32),
        ("failures", _Failure * SHOWN),
        ("angles", _Angles),
    )


@dataclass(frozen=True)
class Mismatch:
    """One case in which the unit and the reference differ."""

    op: str
    operands: tuple[int, ...]
    got: int
    want: int
    got_flags: int
    want_flags: int

    @property
    def arguments(self) -> str:
        """`mul 00ffffff 3f000000`, what `microtick fp case` takes."""
        return " ".join((self.op, *(f"{word:08x}" for word in self.operands)))

    def __str__(self) -> str:
        return (
            f"FAIL microtick fp case {self.arguments}"
            f"  # got {self.got:08x} {flag_text(self.got_flags)}"
            f"  want {self.want:08x} {flag_text(self.want_flags)}"
        )


@dataclass
class AngleStatistics:
    """Errors of sine or cosine; `histogram` has 64 bins per ulp and one for all above one ulp."""

    in_range: int = 0
    beyond: int = 0
    symmetric_pairs: int = 0
    not_nearest: int = 0
    worst: float = 0.0  # ulp
    worst_at: int = 0  # operand bits
    histogram: list[int] = field(default_factory=lambda: [0] * (BINS + 1))


@dataclass
class Report:
    """What a run did. `seconds` is processor time, `protocol` a violation of the handshake."""

    op: str
    kind: str
    cases: int
    mismatches: int
    cycles: int
    seconds: float
    protocol: str
    failures: list[Mismatch]
    angles: AngleStatistics | None = None
    seed: int = 1

    @property
    def rate(self) -> float:
        """Checked operations per second of processor time."""
        return self.cases / self.seconds if self.seconds else 0.0

    @property
    def good(self) -> bool:
        """Every case agreed and the handshake held."""
        return not self.mismatches and not self.protocol

    def as_json(self) -> dict:
        """The fields, with each failure as its pasteable line."""
        return asdict(self) | {"failures": [str(failure) for failure in self.failures]}


@functools.cache
def operations() -> dict[str, tuple[str, int]]:
    """Operation -> (unit, operand count) in the order of the table in operations.h."""
    isa = default_isa()
    row = re.compile(
        r'^    (?:\{"(\w+)", "(\w+)", (\d),|COMPARE\((\w+),|(COMPARE_SPARES))', re.MULTILINE
    )
    table: dict[str, tuple[str, int]] = {}
    for unit, op, count, compare, spares in row.findall(TABLE.read_text()):
        if compare:
            table[compare.lower()] = ("fp_cmp", len(isa.comparisons[compare].sources))
        elif spares:
            table |= {name.lower(): ("fp_cmp", 1) for name in isa.spare_comparisons}
        else:
            table[op] = (unit, int(count))
    return table


def unit_of(op: str) -> str:
    """Module that executes an operation; BenchError with the known names if there is none."""
    if op not in operations():
        raise BenchError(f"no operation '{op}'; known are {', '.join(operations())}")
    return operations()[op][0]


def sources(unit: str, rtl: Path = RTL) -> list[Path]:
    """RTL files of a unit in a folder with the files of rtl/fpu, fp_pkg first."""
    try:
        return sources_of(unit, (rtl,))
    except (FileNotFoundError, KeyError) as error:
        raise BenchError(f"{rtl}: {error}; give a folder with the files of rtl/fpu") from error


def fingerprint(unit: str, rtl: Path = RTL) -> str:
    """Hash of what decides a unit's results: its RTL and the bench.

    Latencies of other units in fp_pkg.sv are left out, since this one cannot depend on them.
    """
    files = sources(unit, rtl)
    package_text = next(path for path in files if path.stem == "fp_pkg").read_text()
    texts = [path.read_text() for path in files if path.stem != "fp_pkg"]
    lane = TOP_SOURCES[0].read_text()
    own = re.search(rf"FPBENCH_{unit.upper()}\n(.*?)`el", lane, re.DOTALL)
    named = " ".join([*texts, own[1] if own else lane])
    package = [
        line
        for line in package_text.splitlines()
        if not (m := re.search(r"\b(FP_\w+_LATENCY)\s*=", line)) or m[1] in named
    ]
    digest = hashlib.sha256("\n".join(package).encode())
    for text in texts:
        digest.update(text.encode())
    for path in (*TOP_SOURCES, HARNESS, *HEADERS):
        digest.update(path.read_bytes())
    digest.update(repr((LANES[unit], [])).encode())
    return digest.hexdigest()[:16]


def angle_bound(rtl: Path = RTL) -> float:
    """Error bound of sine and cosine in ulp, as the contract in fp_sincos.sv states it."""
    match = re.search(r"error below ([0-9.]+) ulp", (rtl / "fp_sincos.sv").read_text())
    if match is None:
        raise BenchError(f"{rtl / 'fp_sincos.sv'}: no 'error below <number> ulp' in its contract")
    return float(match[1])


class Unit:
    """The Verilated lanes of one unit; built on first use.

    `rtl` is a folder with the files of rtl/fpu (a copy with a fault, for example), `defines` macros
    for its RTL, `top` the sources above the unit if not all lanes are to be the same.
    """

    def __init__(
        self,
        name: str,
        rtl: Path = RTL,
        defines: Mapping[str, str] | None = None,
        lanes: int | None = None,
        top: Sequence[Path] = TOP_SOURCES,
    ) -> None:
        if name not in LANES:
            raise BenchError(f"no unit '{name}'; known are {', '.join(LANES)}")
        self.name = name
        self.library = build_library(
            "fpbench",
            [*sources(name, rtl), *top],
            HARNESS,
            {"Lanes": lanes or LANES[name], "Iterative": int(name in ITERATIVE)},
            jobs=1,
            headers=HEADERS,
            defines={f"FPBENCH_{name.upper()}": "", **(defines or {})},
            harness_flags=("-ffp-contract=off", f'-DFPBENCH_UNIT="{name}"'),
        )
        self._bound = angle_bound(rtl) if name == "fp_sincos" else 0.0
        lib = self._lib = load_model(self.library)
        text, u64, pointer = ctypes.c_char_p, ctypes.c_uint64, ctypes.c_void_p
        integer, real = ctypes.c_int, ctypes.c_double
        lib.fpbench_size.restype = lib.fpbench_operands.restype = u64
        lib.fpbench_report_size.restype = ctypes.c_size_t
        lib.fpbench_exact.restype = real
        lib.fpbench_exact.argtypes = [integer, ctypes.c_uint32]
        lib.fpbench_size.argtypes = [text, text]
        lib.fpbench_run.argtypes = [text, text, u64, u64, u64, integer, real, pointer]
        lib.fpbench_run_list.argtypes = [text, pointer, u64, real, *[pointer] * 3]
        lib.fpbench_operands.argtypes = [text, text, u64, u64, u64, pointer]
        lib.fpbench_reference.argtypes = [text, pointer, u64, pointer, pointer]
        if lib.fpbench_report_size() != ctypes.sizeof(_Report):
            raise BenchError(f"{HARNESS.name}: Report differs from the structure in {__name__}")

    def table(self) -> dict[str, tuple[str, int]]:
        """The operations as the library has them, in the form of `operations()`."""
        name, unit = ctypes.c_char_p(), ctypes.c_char_p()
        found, index = {}, 0
        while count := self._lib.fpbench_operation(index, ctypes.byref(name), ctypes.byref(unit)):
            found[(name.value or b"").decode()] = ((unit.value or b"").decode(), count)
            index += 1
        return found

    def size(self, op: str, kind: str) -> int:
        """Cases of an enumerated kind of the operation; 0 if it has no such kind."""
        return self._lib.fpbench_size(op.encode(), kind.encode())

    def run(
        self,
        op: str,
        kind: str,
        start: int = 0,
        count: int | None = None,
        seed: int = 1,
        gaps: bool = False,
    ) -> Report:
        """Run cases `start` .. `start + count - 1` of a kind.

        Kinds: random, level1, level2, hard (div, sqrt, fused), exhaustive (one operand).
        `count` defaults to the rest of an enumerated kind. `gaps` leaves idle clocks with random
        operands between the cases.
        """
        size = self.size(op, kind)
        if not size:
            raise BenchError(f"operation '{op}' has no cases of kind '{kind}'")
        if count is None:
            if kind == "random":
                raise BenchError("random cases have no end; give a count")
            count = size - start
        if start < 0 or count < 1 or start + count > size:
            raise BenchError(f"{op} {kind} has {size} cases; {start} + {count} is beyond")
        raw = _Report()
        status = self._lib.fpbench_run(
            op.encode(), kind.encode(), start, count, seed, gaps, self._bound, ctypes.byref(raw)
        )
        report = self._report(op, kind, status, raw)
        report.seed = seed
        return report

    def run_list(self, op: str, rows: Sequence[Sequence[int]] | np.ndarray) -> Report:
        """Run given operands, rows of one to three words."""
        return self.answers(op, rows)[0]

    def answers(
        self, op: str, rows: Sequence[Sequence[int]] | np.ndarray
    ) -> tuple[Report, np.ndarray, np.ndarray]:
        """As `run_list`, with the unit's result bits and flags of every row."""
        words = _rows(rows)
        raw = _Report()
        bits, flags = np.zeros(len(words), np.uint32), np.zeros(len(words), np.uint8)
        status = self._lib.fpbench_run_list(
            op.encode(),
            words.ctypes.data,
            len(words),
            self._bound,
            bits.ctypes.data,
            flags.ctypes.data,
            ctypes.byref(raw),
        )
        return self._report(op, "list", status, raw), bits, flags

    def operands(self, op: str, kind: str, start: int, count: int, seed: int = 1) -> np.ndarray:
        """The operands that `run` would use, uint32 of shape (cases, 3)."""
        rows = np.zeros((count, 3), dtype=np.uint32)
        made = self._lib.fpbench_operands(
            op.encode(), kind.encode(), start, count, seed, rows.ctypes.data
        )
        return rows[:made]

    def reference(self, op: str, rows: Sequence[Sequence[int]] | np.ndarray) -> tuple:
        """(result bits, flags) of the host reference, for every operation but sine and cosine."""
        words = _rows(rows)
        bits, flags = np.zeros(len(words), np.uint32), np.zeros(len(words), np.uint8)
        status = self._lib.fpbench_reference(
            op.encode(), words.ctypes.data, len(words), bits.ctypes.data, flags.ctypes.data
        )
        if status:
            raise BenchError(f"operation '{op}' has no exact reference")
        return bits, flags

    def exact(self, op: str, operand: int) -> float:
        """Double-precision sine or cosine that the error is measured against."""
        return self._lib.fpbench_exact(int(op == "cos"), operand)

    def _report(self, op: str, kind: str, status: int, raw: _Report) -> Report:
        if status:
            raise BenchError(f"unit {self.name} does not execute operation '{op}'")
        count = operations()[op][1]
        failures = [
            Mismatch(op, (f.a, f.b, f.c)[:count], f.got, f.want, f.got_flags, f.want_flags)
            for f in raw.failures[: raw.shown]
        ]
        angles = None
        if self.name == "fp_sincos":
            names = ("in_range", "beyond", "symmetric_pairs", "not_nearest", "worst", "worst_at")
            values = {name: getattr(raw.angles, name) for name in names}
            angles = AngleStatistics(**values, histogram=list(raw.angles.histogram))
        return Report(
            op,
            kind,
            raw.cases,
            raw.mismatches,
            raw.cycles,
            raw.seconds,
            raw.protocol.decode(),
            failures,
            angles,
        )


def _rows(rows: Sequence[Sequence[int]] | np.ndarray) -> np.ndarray:
    given = np.atleast_2d(np.asarray(rows, dtype=np.uint32))
    words = np.zeros((len(given), 3), dtype=np.uint32)
    words[:, : given.shape[1]] = given
    return words
