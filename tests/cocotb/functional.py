# SPDX-License-Identifier: Apache-2.0
"""Functional coverage of the cocotb tests: all bins, those that cannot be hit, and those hit.

    .venv/bin/python -m tests.cocotb.functional         run the tests, then list the holes
    .venv/bin/python -m tests.cocotb.functional report  of the last run

The bins are those that `sim.cocotb.bins` describes and that states_tb.py and vectors_tb.py hit.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence

from asip_asm.command import script_parser
from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.cocotb import bins
from sim.report.goals import Goal, at_least, not_measured
from tests.cocotb import states_tb, test_asip, test_units
from tests.cocotb.bench import FOLDER
from tests.cocotb.unit_tb import COMPARISONS

RUNS = [
    name
    for name in (*test_units.RUNS, *test_asip.RUNS)
    if name.startswith(("fp_", "fast-", "wide-"))
]
FILES = ["tests/cocotb/test_units.py", "tests/cocotb/test_asip.py"]
RESULTS = ("zero", "subnormal", "normal", "infinite", "nan")
ROUNDED = ("exact", "down", "up", "tie_down", "tie_up")
EXCEPTIONS = ("none", *bins.FLAGS)
DIVIDERS = ("fp_divsqrt", "fp_divsqrt_folded")
SINES = ("fp_sincos", "fp_sincos_overlapped")
ROUNDING = ("fp_add", "fp_mul", "fp_fma", *(f"{unit}.quotient" for unit in DIVIDERS))
FLOATS = (*ROUNDING, *(f"{unit}.root" for unit in DIVIDERS), *SINES, "fp_i2f")

# Bin -> why nothing can hit it.
IMPOSSIBLE: dict[str, str] = {
    "fault ILLEGAL drain": "Stage D holds no bundle after the one that halts.",
    "fault OUTPUT_MISSING run": "The mask is compared at the end of the drain.",
    "exception fp_add dz": "No division.",
    "exception fp_add uf": "A sum that is subnormal is exact.",
    "exception fp_mul dz": "No division.",
    "exception fp_fma dz": "No division.",
    "exception fp_i2f nv": "Every integer has a result.",
    "exception fp_i2f dz": "No division.",
    "exception fp_i2f of": "The largest integer is far below the largest number.",
    "exception fp_i2f uf": "The smallest result in size is 0 or 1.",
    "result fp_i2f subnormal": "The smallest result in size is 0 or 1.",
    "result fp_i2f infinite": "The largest integer is far below the largest number.",
    "result fp_i2f nan": "Every integer has a result.",
}
for _unit in DIVIDERS:
    IMPOSSIBLE |= {
        f"exception {_unit}.root dz": "A root has no division by zero.",
        f"exception {_unit}.root of": "A root is nearer to 1 than its operand.",
        f"exception {_unit}.root uf": "A root is nearer to 1 than its operand.",
        f"result {_unit}.root subnormal": "A root is nearer to 1 than its operand.",
    }
for _unit in SINES:
    IMPOSSIBLE |= {
        f"exception {_unit} dz": "No division.",
        f"exception {_unit} of": "A sine is 1 at most.",
        f"result {_unit} infinite": "A sine is 1 at most.",
    }


def readers() -> list[str]:
    """Operations that read a register."""
    records = default_isa().operations.items()
    return [n for n, record in records if {"a", "b", "c", "address"} & set(record.operands)]


def declared() -> set[str]:
    """Every bin, the impossible ones among them."""
    found = {f"hazard {name} {d}" for name in readers() for d in states_tb.DISTANCES}
    causes = {cause for cause, _ in states_tb.FAULTS}
    found |= {f"fault {cause} {state}" for cause in causes for state in ("run", "drain")}
    found |= {f"host {a} {state}" for a in states_tb.ACCESSES for state in states_tb.STATES}
    found |= {f"exception {unit} {name}" for unit in FLOATS for name in EXCEPTIONS}
    found |= {f"result {unit} {name}" for unit in FLOATS for name in RESULTS}
    found |= {f"rounding {unit} {name}" for unit in ROUNDING for name in ROUNDED}
    found |= {f"exception fp_f2i {name}" for name in ("none", "nv", "nx")}
    names = COMPARISONS.keys()
    found |= {f"exception fp_cmp.{name} none" for name in names}
    signalling = names - {"abs", "neg", "mov", "sel", "selge", "selgt", "iadd", "isub"}
    return found | {f"exception fp_cmp.{name} nv" for name in signalling}


def covered() -> set[str]:
    """Bins that the last run of the tests has hit."""
    return bins.read(path for name in RUNS if (path := FOLDER / name / "bins.txt").exists())


def report() -> tuple[set[str], set[str], set[str]]:
    """Bins hit, bins open, bins that are explained and yet hit."""
    every, seen = declared(), covered()
    explained = {name for name in every if name in IMPOSSIBLE}
    return every & seen, every - seen - explained, explained & seen


def run() -> None:
    """Run the tests. Raises CalledProcessError if one fails."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "1", *FILES]
    subprocess.run([*command, "-k", "fp_ or fast-states or wide-vectors"], cwd=ROOT, check=True)


def rows(full: bool) -> Iterator[Goal]:
    """The goal."""
    name = "functional coverage"
    if not full:
        yield not_measured(name, ">= 100", "%", "make goals T=hardware RUN=full")
        return
    run()
    seen, left, wrong = report()
    share = 100 * len(seen) / (len(seen) + len(left))
    note = ", ".join(sorted(left | wrong)) or f"{len(seen)} bins"
    yield at_least(name, share if not wrong else 0, 100, "%", note)


def main(words: Sequence[str] | None = None) -> int:
    """Command line; exit 1 if a bin is open, or one that is explained was hit."""
    parser = script_parser(__doc__, "python -m tests.cocotb.functional")
    parser.add_argument("what", nargs="?", choices=("run", "report"), default="run")
    if parser.parse_args(words).what == "run":
        run()
    seen, left, wrong = report()
    for name in sorted(left):
        print(f"open: {name}")
    for name in sorted(wrong):
        print(f"explained as impossible, but hit: {name}")
    print(f"{len(seen)} of {len(seen) + len(left)} bins hit, {len(IMPOSSIBLE)} are impossible")
    return int(bool(left or wrong))


if __name__ == "__main__":
    sys.exit(main())
