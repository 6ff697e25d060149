# SPDX-License-Identifier: Apache-2.0
"""Command nios-run: run a C program on the Verilated system FPGA1 or FPGA2.

Standard output is the program's console and nothing else; what the command itself has to say goes
to standard error.
"""

from __future__ import annotations

import argparse
import os
import sys
import threading
import time
from pathlib import Path

from rich.console import Console

from asip_asm.command import cause_of, command, command_parser
from asip_asm.files import write_text
from sim.debug.gdb.server import PIPE, ServerError, place_of, serve
from sim.rtl.build import BuildError
from sim.rtl.nios_image import ImageError, Program, read_elf
from sim.rtl.nios_profile import profile, tables
from sim.rtl.nios_rtl import PLATFORMS, NiosRtl
from sim.rtl.nios_trace import konata, timeline

MAX_CYCLES = 1_000_000_000
MOST_TRACED = 10_000_000
TRACED = 100_000  # instructions of a trace; a viewer takes some hundred bytes for each
CHUNK = 100_000  # cycles between two looks at console and keyboard, about a tenth of a second
LIMIT_STATUS, FILE_STATUS, INTERRUPT_STATUS, STRAY_STATUS, PIPE_STATUS = 124, 125, 130, 139, 141
TERMINAL_SECONDS, LOG_SECONDS = 1.0, 30.0  # between two lines of progress

EPILOG = f"""examples:
  nios-run hello.elf
  nios-run --system fpga1 --profile law.elf > law.txt
  nios-run --max-cycles 5000000 loop.elf
  nios-run --timeline law.json --konata law.konata --trace 2000:50000 law.elf
  nios-run --gdb :1234 hello.elf      and then in nios2-elf-gdb: target remote :1234

docs/own_c_program.md explains how to write, compile and debug such a program.

exit status: that of the program (its low 8 bits, 255 if only higher ones are set; 128 + cause
after an exception that nothing handles), {LIMIT_STATUS} after --max-cycles, {FILE_STATUS} a file
that cannot be run, {STRAY_STATUS} an access where there is neither memory nor a register,
{INTERRUPT_STATUS} Ctrl-C, 2 wrong command line
"""


@command("nios-run")
def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    say = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    try:
        program = read_elf(options.program) if options.program else None
        core = ready(options.system, say, options.gdb is not None)
        if options.gdb is not None:
            status = serve(core, program, options.gdb, lambda text: say.print(f"nios-run: {text}"))
            return shown(status)
        assert program is not None  # the command line has it, or --gdb
        ended, cycles = run(core, program, options, say)
        if options.trace:
            write_trace(core, program, options, say)
    except (ImageError, BuildError, ServerError) as error:
        say.print(f"nios-run: {error}")
        return FILE_STATUS
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_STATUS
    except OSError as error:
        say.print(f"nios-run: error: {cause_of(error)}")
        return FILE_STATUS
    except KeyboardInterrupt:
        say.print("nios-run: stopped by Ctrl-C")
        return INTERRUPT_STATUS
    if options.profile:
        result = profile(core, program, 1, cycles)
        for table in tables(result, program.name):
            say.print(table)
    if core.stray is not None:
        say.print(
            f"nios-run: {options.program}: {program.function_at(core.pc)} at 0x{core.pc:08x} "
            f"accesses 0x{core.stray:08x}, where there is neither memory nor a register"
        )
        return STRAY_STATUS
    if ended is None:
        say.print(
            f"nios-run: {options.program} did not end within {options.max_cycles} cycles, it is "
            f"in {program.function_at(core.pc)} at 0x{core.pc:08x}; --max-cycles raises the limit"
        )
        return LIMIT_STATUS
    clock = core.map.clock_mhz
    say.print(
        f"nios-run: {options.system}, {cycles} cycles "
        f"({cycles / clock:.2f} us at {clock} MHz), {core.retired} instructions, "
        f"exit status {ended}"
    )
    return shown(ended)


def shown(status: int) -> int:
    """Exit status of the command for that of a program; no failure looks like success."""
    return status & 255 or (255 if status else 0)


def ready(system: str, say: Console, debug: bool) -> NiosRtl:
    """The model, with a debug module or without; says so when it has to be built first."""
    text = f"nios-run: building the model of {system} (once, about a minute)"
    notice = threading.Timer(5.0, say.print, [text])
    notice.start()
    try:
        return NiosRtl(system, debug)
    finally:
        notice.cancel()


def write_trace(core: NiosRtl, program: Program, options: argparse.Namespace, say: Console) -> None:
    """Write the files of --konata and --timeline, and say what they hold. Raises OSError."""
    steps = core.traced()
    texts = {
        options.konata: lambda: konata(steps, program, core.platform),
        options.timeline: lambda: timeline(steps, program, core.map.clock_mhz),
    }
    files = [path for path in texts if path]
    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, texts[path]())
    skip, count = options.trace
    more = "; --trace FIRST:COUNT chooses others" if len(steps) == count else ""
    names = " and ".join(map(str, files))
    say.print(f"nios-run: {names}: {len(steps)} instructions from number {skip} on{more}")


def run(
    core: NiosRtl, program: Program, options: argparse.Namespace, say: Console
) -> tuple[int | None, int]:
    """Run a program with its console on standard output.

    Its status (None: it did not end within the limit of cycles, or `core.stray` says why) and the
    cycles from its reset on.
    """
    limit = options.max_cycles
    core.load(program)
    if options.profile:
        core.profile(whole=True)
    if options.trace:
        core.trace(options.trace[1], options.trace[0])
    core.guard()
    core.start()
    begin = core.cycles
    cycles, status = 0, None
    with Progress(limit, say) as progress:
        while status is None and core.stray is None and cycles < limit:
            status = core.advance(min(CHUNK, limit - cycles))
            cycles = core.cycles - begin
            progress.show(cycles, core.take_console())
    return status, cycles


class Progress:
    """Console of the program to standard output; a line on how far it is when it takes long."""

    def __init__(self, limit: int, say: Console) -> None:
        self._limit, self._say = limit, say
        self._period = TERMINAL_SECONDS if say.is_terminal else LOG_SECONDS
        self._began = self._last = time.monotonic()
        self._line = False  # a line of progress is on the terminal

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self._clear()

    def show(self, cycles: int, text: bytes) -> None:
        """Pass on what the program wrote; now and then say how far it is."""
        if text:
            self._clear()
            sys.stdout.buffer.write(text)
            sys.stdout.buffer.flush()
        now = time.monotonic()
        if now - self._last >= self._period:
            self._last = now
            rate = cycles / (now - self._began)
            line = (
                f"nios-run: {cycles / 1e6:.1f} M cycles, {rate / 1e6:.2f} M per second; "
                f"the limit is {self._limit / 1e6:.0f} M, "
                f"reached in {(self._limit - cycles) / rate:.0f} s"
            )
            self._clear()
            self._line = self._say.is_terminal
            self._say.print(line, end="" if self._line else "\n")

    def _clear(self) -> None:
        if self._line:
            self._say.file.write("\r\033[K")
            self._say.file.flush()
            self._line = False


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    """Options of the command line; exits with status 2 if they are wrong."""
    parser = command_parser(
        "nios-run", "Run a C program on the Verilated system FPGA1 or FPGA2.", EPILOG
    )
    parser.add_argument("program", type=Path, nargs="?", help="ELF file")
    parser.add_argument("--system", choices=PLATFORMS, default="fpga2", help="default: fpga2")
    parser.add_argument(
        "--max-cycles",
        type=_positive,
        default=MAX_CYCLES,
        metavar="N",
        help=f"end a program that does not end by itself (default: {MAX_CYCLES})",
    )
    parser.add_argument(
        "--profile", action="store_true", help="cycles by function and by kind of instruction"
    )
    parser.add_argument(
        "--konata", type=Path, metavar="FILE", help="pipeline log for the viewer Konata"
    )
    parser.add_argument(
        "--timeline",
        type=Path,
        metavar="FILE",
        help="functions over time, JSON for Perfetto (ui.perfetto.dev) or chrome://tracing",
    )
    parser.add_argument(
        "--trace",
        type=_window,
        metavar="FIRST:COUNT",
        help=f"instructions in these two files (default: 0:{TRACED})",
    )
    parser.add_argument(
        "--gdb",
        type=_place,
        metavar="[HOST]:PORT",
        help="wait for GDB there (port 0: a free one; a path with a slash: a Unix socket; -: "
        "standard input and output), halted before the first instruction; without a program GDB "
        "loads one",
    )
    options = parser.parse_args(arguments)
    if options.program is None and options.gdb is None:
        parser.error("the following arguments are required: program")
    if options.gdb is not None and options.profile:
        parser.error("--profile: not with --gdb, whose halts would count")
    files = options.konata or options.timeline
    if options.trace and not files:
        parser.error("--trace: needs --konata FILE or --timeline FILE")
    if files and options.gdb is not None:
        parser.error("--konata, --timeline: not with --gdb, whose halts would count")
    if files and not options.trace:
        options.trace = (0, TRACED)
    return options


def _window(text: str) -> tuple[int, int]:
    """First instruction and number of instructions of a trace."""
    first, colon, count = text.partition(":")
    known = all(part.isdecimal() and len(part) <= 15 for part in (first, count))
    if not (colon and known and 1 <= int(count) <= MOST_TRACED):
        raise argparse.ArgumentTypeError(
            f"'{text}': expected FIRST:COUNT, such as 0:{TRACED}, COUNT 1 to {MOST_TRACED}"
        )
    return int(first), int(count)


def _place(text: str) -> str:
    if text != PIPE and "/" not in text:
        try:
            place_of(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return text


def _positive(text: str) -> int:
    if not text.isdecimal() or len(text) > 18 or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of cycles")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
