# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the assembler, its images and the three asip commands."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from random import Random
from typing import Any

from asip_asm import cli_as, cli_objdump
from asip_asm.assemble import assemble
from asip_asm.image import checksum
from asip_asm.isa import default_isa
from sim.debug.asip_run import __main__ as asip_run
from sim.rtl.asip_rtl import AsipRtl
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import command_lines, mutated_json, mutated_text

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "tests" / "asm"
PROGRAMS = ROOT / "asip_asm" / "programs"
MACROS = """\
.macro square dst, x
        fmul \\dst, \\x, \\x
.endm
.macro power dst, x, n
.if \\n
        fmul \\dst\\@, \\x, \\x
        power \\dst, \\dst\\@, (\\n - 1)
.else
        mov \\dst, \\x
.endif
.endm
.input x
.output F, safe = 0.0
        square q, x
        power r, q, 3
        mov F, r
        halt
"""
INPUTS = "x,y,z\n0.1,0.2,0.3\n1,2,3\n"
# Texts to mutate: the annotated sources of the tests, macros, and a real program.
TEXTS = [path.read_text(encoding="utf-8") for path in sorted(SOURCES.glob("*.s"))]
TEXTS += [MACROS, (PROGRAMS / "planner_sample.s").read_text(encoding="utf-8")]
DIRECTIVES = "program config input const param state output export data space reg include "
DIRECTIVES += "macro endm if else endif watchdog"
WORDS = (
    *default_isa().operations,
    *(f".{name}" for name in DIRECTIVES.split()),
    *("halt", "safe", "pin", "int", "float", "pi", "sqrt(", "sin(", "cos(", "abs(", "zero"),
    *("a0", "b63", "c64", "k127", "o0", "o31", "\\@", "\\a", "x", "y", "F1", "{", "}", "|"),
    *("0f7f800000", "0f3f800000", "1e38", "1.5", "65535", "300 * 300", "\n", "\n"),
)


@functools.cache
def images() -> list[dict[str, Any]]:
    """Images to mutate, as JSON data."""
    names = ("ok_leg_length.s", "ok_branches.s", "ok_states.s", "ok_bundles.s")
    return [assemble(SOURCES / name, optimise=False).to_json() for name in names]


def assembly(rng: Random) -> int | None:
    """One mutated source through asip-as, the program through asip-run on the model."""
    text = mutated_text(rng, rng.choice(TEXTS), WORDS)
    data = text.encode("utf-8", errors="surrogatepass")
    if rng.random() < 0.02:
        data = data[: rng.randrange(len(data) + 1)] + rng.randbytes(8)
    Path("square.inc").write_text((SOURCES / "square.inc").read_text(encoding="utf-8"))
    Path("x.s").write_bytes(data)
    level = rng.choice(("-O0", "-O0", "-O"))
    status = cli_as.main(["x.s", level, "-o", "x.asip.json", "--listing", "x.lst"])
    if status == 0:
        cli_objdump.main(["-d", "-h", "-t", "x.asip.json"])
        asip_run.main(["x.asip.json", "--iss", "--ticks", "2"])
    return status


def image(rng: Random) -> int | None:
    """One mutated image, mostly with a right checksum, disassembled and run on the model."""
    data = mutated_json(rng, rng.choice(images()))
    if isinstance(data, dict) and rng.random() < 0.9:
        data["checksum"] = checksum(data)
    text = json.dumps(data)
    if rng.random() < 0.3:
        text = mutated_text(rng, text, ["null", "true", "[]", "{}"])
    Path("x.json").write_text(text, encoding="utf-8", errors="surrogatepass")
    cli_objdump.main(["-d", "-h", "-t", "x.json"])
    return asip_run.main(["x.json", "--iss", "--ticks", "2"])


def files(rng: Random) -> None:
    """What a command line may name: program, image, inputs."""
    Path("x.s").write_text(MACROS, encoding="utf-8")
    Path("x.json").write_text(json.dumps(images()[0]), encoding="utf-8")
    Path("in.csv").write_text(mutated_text(rng, INPUTS, ["x", "y"]), errors="surrogatepass")


FILES = "x.s x.json in.csv empty folder zero pipe out.json x.asip.json"
AS_LINES = (
    "x.s -o out.json",
    "x.s -O0 --format c -o out.h --listing x.lst --symbols x.sym",
    "x.s -D gain=2 -I folder --config small --report",
    "x.s --format readmemh",
)
AS_OPTIONS = "-o -O -O0 -D -I --config fast small --format json c ihex mif --listing --symbols "
AS_OPTIONS += "--report gain=1e999 =1 x= -D=x"
OBJDUMP_LINES = ("-d x.json", "-h -t x.json", "-d -h -t in.csv")
OBJDUMP_OPTIONS = "-d -h -t --disassemble --header --symbols --help"
RUN_LINES = (
    "x.s --iss --set x=0.3",
    "x.json --iss --inputs in.csv --print F1,q",
    "x.s --iss --ticks 3 --trace writes.txt",
)
RUN_OPTIONS = "--iss --set --inputs --ticks --state --print --trace --config small x=1 x=nan "
RUN_OPTIONS += "x=0fzz F q c9 --profile --konata --gantt x=1e999 n=0x1g 100000"


def prepare_run() -> None:
    """Images, and the cores, which asip-run builds on first use."""
    images()
    for configuration in default_isa().without_streams:
        AsipRtl(configuration)


CAMPAIGNS = (
    Campaign("assembly", 20_000, assembly),
    Campaign("image", 20_000, image, images),
    *(
        command_lines(name, main, lines, f"{options} {FILES}", files, prepare_it)
        for name, main, lines, options, prepare_it in (
            ("asip-as", cli_as.main, AS_LINES, AS_OPTIONS, images),
            ("asip-objdump", cli_objdump.main, OBJDUMP_LINES, OBJDUMP_OPTIONS, images),
            ("asip-run", asip_run.main, RUN_LINES, RUN_OPTIONS, prepare_run),
        )
    ),
)
