# SPDX-License-Identifier: Apache-2.0
"""From parsed statements to the IR: names, regions, data flow between regions, renaming.

Errors that concern more than one statement are found here too: registers read before they are
written, outputs written twice or not at all, labels, code that is never reached.
"""

from __future__ import annotations

from asip_asm.blocks import build_blocks
from asip_asm.diagnostics import Reporter
from asip_asm.flow_checks import check_flow
from asip_asm.ir import Program
from asip_asm.isa import Configuration, Isa
from asip_asm.lint import lint
from asip_asm.operands import Operands
from asip_asm.rename import rename
from asip_asm.source import Source
from asip_asm.stream_checks import check_streams

DEFAULT_CONFIGURATION = "fast"


def resolve(
    source: Source, isa: Isa, reporter: Reporter, configuration: str | None = None
) -> Program:
    """Program of the source in the given configuration; errors go to the reporter.

    Without `configuration` the file's own one or `fast` is taken. The result is complete only if
    the reporter has no error.
    """
    chosen = _choose(source, isa, reporter, configuration)
    program = Program(title=source.title, configuration=chosen.name, files=source.files)
    operands = Operands(source, isa, reporter, chosen, program)
    operands.declare()
    blocks, loops = build_blocks(source, operands.step, chosen.loops, reporter)
    if blocks:
        check_flow(source, program, blocks, loops, operands, reporter)
        check_streams(source, blocks, loops, reporter)
        rename(program, blocks, operands, reporter)
    program.parameters = [
        constant.name
        for constant in program.constants
        if (d := source.names.get(constant.name)) and d.replaceable and not d.folded
    ]
    if not reporter.diagnostics:
        lint(source, program, [step for block in blocks for step in block.steps()], reporter)
    program.warnings = reporter.warnings
    return program


def _choose(
    source: Source, isa: Isa, reporter: Reporter, configuration: str | None
) -> Configuration:
    insisted = source.configuration
    if insisted is not None and configuration is not None and insisted[0] != configuration:
        reporter.add(
            insisted[1],
            f"the file insists on configuration '{insisted[0]}', the command line says "
            f"'{configuration}'",
            f"use --config {insisted[0]} or change .config",
        )
    name = insisted[0] if insisted else configuration or DEFAULT_CONFIGURATION
    return isa.configurations[name]
