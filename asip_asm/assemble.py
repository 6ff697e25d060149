# SPDX-License-Identifier: Apache-2.0
"""From a source file to a program image: parse, schedule, allocate registers, encode."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from asip_asm.allocate import AllocationError, allocate_registers
from asip_asm.diagnostics import AssemblyError, Diagnostic, Reporter, report_text
from asip_asm.encode import EncodeError, encode_program
from asip_asm.image import Image
from asip_asm.ir import Program
from asip_asm.isa import default_isa
from asip_asm.loops import mark_ends
from asip_asm.machine import BRANCHES, Machine, load_machine
from asip_asm.parser import Parser
from asip_asm.resolve import resolve
from asip_asm.schedule import (
    ScheduleError,
    SizeError,
    bundle_in_order,
    check_size,
    schedule_program,
)
from asip_asm.search import Progress


def assemble(
    path: Path | str,
    *,
    configuration: str | None = None,
    optimise: bool = True,
    defines: Mapping[str, str | float] | None = None,
    include_path: Sequence[Path] = (),
    params: Path | None = None,
) -> Image:
    """Image of the program in a source file; arguments and errors of `build_program`.

    Warnings go to the logger 'asip_asm', which shows them on standard error unless configured.
    """
    program, machine = build_program(
        path,
        configuration=configuration,
        optimise=optimise,
        defines=defines,
        include_path=include_path,
        params=params,
    )
    if program.warnings:
        logging.getLogger("asip_asm").warning("%s", report_text(program.warnings))
    return encode(program, machine, path)


def build_program(
    path: Path | str,
    *,
    configuration: str | None = None,
    optimise: bool = True,
    defines: Mapping[str, str | float] | None = None,
    include_path: Sequence[Path] = (),
    params: Path | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> tuple[Program, Machine]:
    """The program of a source file in bundles, with its registers, and its machine.

    `configuration`: 'fast', 'small', 'stream' or 'wide'; None leaves the choice to the file.
    `optimise`: False keeps one operation per bundle in the order written. `defines` replaces
    values of parameters (`.param`); `params` is read in place of the files that `.params` names;
    `progress` is called during the search for a schedule. Raises AssemblyError for errors of
    the source text, OSError if the file cannot be read.
    """
    program = parse_program(
        path,
        configuration=configuration,
        defines=defines,
        include_path=include_path,
        params=params,
    )
    machine = load_machine(program.configuration)
    try:
        check_size(program, machine, default_isa().program_bundles)
        if optimise:
            schedule_program(program, machine, progress=progress)
        else:
            bundle_in_order(program, machine)
        allocate_registers(program, machine)
        mark_ends(program, len(machine.slots))
    except SizeError as error:
        raise AssemblyError([Diagnostic(None, f"{path}: {error}", error.help)]) from None
    except ScheduleError as error:
        raise AssemblyError([Diagnostic(None, str(error))]) from None
    except AllocationError as error:
        raise AssemblyError([Diagnostic(None, f"{path}: {error}")]) from None
    return program, machine


def encode(program: Program, machine: Machine, path: Path | str) -> Image:
    """Image of a program of `build_program`; `path` is for messages. Raises AssemblyError."""
    cycles = straight_line_cycles(program, machine)
    if cycles is not None and cycles > program.watchdog:
        raise AssemblyError(
            [
                Diagnostic(
                    None,
                    f"{path}: a run takes {cycles} cycles, the watchdog stops it after "
                    f"{program.watchdog}",
                    f"allow them: .watchdog {2 * cycles}",
                )
            ]
        )
    try:
        return encode_program(program, default_isa(), cycles)
    except EncodeError as error:
        raise AssemblyError([Diagnostic(None, f"{path}: {error}")]) from None


def parse_program(
    path: Path | str,
    *,
    configuration: str | None = None,
    defines: Mapping[str, str | float] | None = None,
    include_path: Sequence[Path] = (),
    params: Path | None = None,
) -> Program:
    """The program before scheduling. Raises AssemblyError, OSError."""
    reporter = Reporter()
    isa = default_isa()
    values = {name: str(value) for name, value in (defines or {}).items()}
    source = Parser(isa, reporter, values, include_path, params).parse(Path(path))
    program = resolve(source, isa, reporter, configuration)
    reporter.stop()
    return program


def straight_line_cycles(program: Program, machine: Machine) -> int | None:
    """Cycles of a run; None for a program with branches."""
    if any(op.mnemonic in BRANCHES for _, _, op in program.placed()):
        return None
    return machine.run_cycles(program.bundles)
