# SPDX-License-Identifier: Apache-2.0
"""What the campaign runs: sections in order, cut into shards that are independent tasks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sim.core.fpbench.native import BenchError, operations

SEED = 20260101
EVERY_WORD = 1 << 32
# Sine and cosine: index 2 m and 2 m + 1 are the numbers +-m of magnitude bits m (cases.h).
SMALL_ANGLE = 2 * (115 << 23)  # 2^-12: below, the result rounded to nearest is the operand, or one
ANGLE_END = 2 * (0x43800000 + 1)  # 256 rad, included


@dataclass(frozen=True)
class Shard:
    """One task: cases `start` .. `start + count - 1` of a kind of an operation."""

    op: str
    kind: str
    start: int
    count: int
    seed: int
    gaps: bool
    unit: str  # that executes the operation

    @property
    def name(self) -> str:
        """File name of its result, unique among all shards of a unit."""
        gaps = "-gaps" if self.gaps else ""
        seed = f"-s{self.seed}" if self.kind in ("random", "hard") else ""
        return f"{self.op}-{self.kind}-{self.start}-{self.count}{seed}{gaps}"


@dataclass(frozen=True)
class Part:
    """A range of one kind of cases of one operation."""

    op: str
    kind: str
    start: int
    count: int
    gaps: bool = False
    instead: str = ""  # a unit that executes it in the place of the usual one

    def shards(self) -> Iterator[Shard]:
        """The range cut into pieces of some ten seconds to two minutes."""
        unit = operations()[self.op][0]
        step = {"fp_sincos": 1 << 24, "fp_divsqrt": 1 << 27}.get(unit, 1 << 28)
        unit = self.instead or unit
        for start in range(self.start, self.start + self.count, step):
            count = min(step, self.start + self.count - start)
            yield Shard(self.op, self.kind, start, count, SEED, self.gaps, unit)


@dataclass(frozen=True)
class Section:
    """Parts that the report shows together; `what` says what they cover."""

    name: str
    what: str
    parts: tuple[Part, ...]
    extended: bool = False  # longer than the rest together: only on request


def _every(ops: str, start: int = 0, end: int = EVERY_WORD, instead: str = "") -> tuple[Part, ...]:
    return tuple(Part(op, "exhaustive", start, end - start, instead=instead) for op in ops.split())


def _single() -> str:
    """Operations of fp_cmp with one operand."""
    return " ".join(op for op, where in operations().items() if where == ("fp_cmp", 1))


# Random cases per operation, at full rate and with idle clocks between.
RANDOM = {"fp_add": 150, "fp_mul": 200, "fp_fma": 150, "fp_divsqrt": 150, "fp_cmp": 20}
RANDOM_GAPS = 4_000_000
MILLION = 1_000_000


def _random() -> tuple[Part, ...]:
    parts = []
    for op, (unit, _) in operations().items():
        if unit in RANDOM:
            parts.append(Part(op, "random", 0, RANDOM[unit] * MILLION))
            parts.append(Part(op, "random", 1 << 40, RANDOM_GAPS, gaps=True))
    return tuple(parts)


def _cross(level: int, operands: tuple[int, ...], size) -> tuple[Part, ...]:
    return tuple(
        Part(op, f"level{level}", 0, size(op, f"level{level}"))
        for op, (_, count) in operations().items()
        if count in operands
    )


def _hard(size) -> tuple[Part, ...]:
    ops = [op for op in operations() if size(op, "hard")]
    return tuple(Part(op, "hard", 0, size(op, "hard")) for op in ops)


def sections(size) -> list[Section]:
    """Every section in running order; `size(op, kind)` is the number of cases (`Unit.size`)."""
    return [
        Section("sign", "every operand of the operations of fp_cmp with one", _every(_single())),
        Section("integer to float", "every integer, signed and unsigned", _every("i2f u2f")),
        Section("float to integer", "every operand, both roundings", _every("f2i f2i_nearest")),
        Section("square root", "every operand", _every("sqrt")),
        Section(
            "sine and cosine",
            "every operand of magnitude 2^-12 to 256 rad",
            _every("sin cos", SMALL_ANGLE, ANGLE_END),
        ),
        Section(
            "sine and cosine, overlapped",
            "the same by fp_sincos_overlapped",
            _every("sin cos", SMALL_ANGLE, ANGLE_END, instead="fp_sincos_overlapped"),
        ),
        Section("random", "exponent-correlated random operands", _random()),
        Section("hard", "quotients, roots, cancellations built from congruences", _hard(size)),
        Section("level 1", "cross product of special values", _cross(1, (1, 2, 3), size)),
        Section("level 2", "cross product, one and two operands", _cross(2, (1, 2), size)),
        Section("level 2, three operands", "cross product, complete", _cross(2, (3,), size)),
        Section(
            "small angles",
            "sine and cosine of every operand below 2^-12",
            _every("sin cos", 0, SMALL_ANGLE),
            extended=True,
        ),
        Section(
            "angles beyond 256 rad",
            "sine and cosine of every other word: larger, infinite, NaN",
            _every("sin cos", ANGLE_END, EVERY_WORD),
            extended=True,
        ),
    ]


def chosen(all_sections: list[Section], names: list[str], extended: bool) -> list[Section]:
    """Sections named, or all (with `extended` the long ones too); BenchError for other names."""
    known = {section.name: section for section in all_sections}
    for name in names:
        if name not in known:
            raise BenchError(f"no section '{name}'; known are {', '.join(known)}")
    if names:
        return [known[name] for name in names]
    return [section for section in all_sections if extended or not section.extended]
