# SPDX-License-Identifier: Apache-2.0
"""Command asip-run: run a program on the Verilated core or on the instruction-set model."""

from __future__ import annotations

import argparse
import csv
import struct
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TextIO

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError, closest
from asip_asm.gantt import gantt_page
from asip_asm.image import Image, ImageError
from asip_asm.isa import default_isa
from asip_asm.konata import konata_log
from asip_asm.profile import ProfileError, profile_run
from asip_asm.profile import Trace as CoreTrace
from asip_asm.regmap import default_register_map

IMAGE_SUFFIX = ".json"
FLAGS = ("NV", "DZ", "OF", "UF", "NX")  # bit 4 .. 0
COUNTERS = ("CYCLES", "STALL_OPERAND", "STALL_PORT", "STALL_UNIT", "STALL_FETCH", "DRAIN")
NO_FAULT = "NONE"

EPILOG = """examples:
  asip-run leg.s --set x=0.3 --set y=0.1
  asip-run build/leg.asip.json --iss --inputs path.csv --print F1,l1 > forces.csv
  asip-run leg.s --set x=0.3 --profile --konata build/leg.konata --gantt build/leg.html
  asip-run leg.s --config small --ticks 3 --state sum=1.5 --trace build/writes.txt

Floats may be written as bits (0f3f800000). Inputs that are not given are 0. With --inputs the
result is a CSV table, one row per run; a run after the last row repeats it.

exit status: 0 all runs done, 1 a fault, or an error in a file, 2 wrong command line
"""


class UserError(Exception):
    """What the user gave cannot be run; `status` is the command's exit status."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True)
class Fault:
    """Cause by name, the bundle it names (None: an output), and the output's index."""

    cause: str
    bundle: int | None = None
    output: int | None = None


@dataclass(frozen=True)
class Run:
    """Result of one run: fault, flags {nv, dz, of, uf, nx}, counters by name, words by name.

    writes: (register or output, word), on the core in the order of time, on the model by register.
    trace: issues and writes by clock cycle, of a traced run on the core.
    """

    fault: Fault
    flags: int
    counters: dict[str, int]
    words: dict[str, int]
    writes: list[tuple[str, int]]
    trace: CoreTrace | None = None


class Runner(Protocol):
    """A loaded program. `run` writes inputs (words by name), runs once and reads `names`."""

    def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run: ...


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    try:
        image = load_image(options.program, options.config)
        types = {word.name: word.type for word in image.inputs}
        fixed = dict.fromkeys(types, 0) | assignments(options.set, types, "input")
        state_types = {state.name: state.type for state in image.states}
        states = assignments(options.state, state_types, "state")
        names = printed_names(image, options.print)
        rows = read_inputs(options.inputs, types) if options.inputs else [{}]
        ticks = len(rows) if options.ticks is None else options.ticks
        profile = options.profile or options.konata or options.gantt
        if profile and options.iss:
            raise UserError("the model has no clock cycles to profile; use --rtl", 2)
        trace_on = bool(options.trace or profile)
        runner = (iss_runner if options.iss else rtl_runner)(image, states, trace_on)
        table = bool(options.inputs)
        with Trace(options.trace) as trace:
            for tick in range(ticks):
                result = runner.run(fixed | rows[min(tick, len(rows) - 1)], names)
                write = write_row if table else write_text
                write(sys.stdout, image, tick, names, result)
                trace.write(tick, result)
                if result.fault.cause != NO_FAULT:
                    raise UserError(f"run {tick + 1}: {fault_text(image, result.fault)}")
        if profile and result.trace:
            file = sys.stderr if table else sys.stdout
            write_profile(file, image, result.trace, options.konata, options.gantt)
    except AssemblyError as error:
        print(error.report(), file=sys.stderr)
        return 1
    except OSError as error:
        print(f"asip-run: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    except (UserError, ImageError) as error:
        sys.stdout.flush()
        print(f"asip-run: error: {error}", file=sys.stderr)
        return getattr(error, "status", 1)
    return 0


# ---------------------------------------------------------------------- what to run


def load_image(path: Path, configuration: str | None) -> Image:
    """Image of a source text, or an image file (*.json)."""
    if path.suffix != IMAGE_SUFFIX:
        return assemble(path, configuration=configuration)
    image = Image.load(path)
    if configuration not in (None, image.configuration):
        raise UserError(
            f"{path} is for configuration '{image.configuration}', not '{configuration}'; "
            "assemble it again"
        )
    return image


def assignments(pairs: Sequence[str], types: Mapping[str, str], what: str) -> dict[str, int]:
    """Words of 'name=value' texts."""
    words = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            raise UserError(f"'{pair}' is not NAME=VALUE", 2)
        if name not in types:
            raise UserError(unknown(what, name, types), 2)
        try:
            words[name] = parse_word(text, types[name])
        except ValueError as error:
            raise UserError(f"{what} {name}: {error}", 2) from None
    return words


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Message for a name that the program does not have."""
    known = list(known)
    help_text = closest(name, known) or (f"it has {', '.join(known)}" if known else "it has none")
    return f"the program has no {what} '{name}'; {help_text}"


def parse_word(text: str, type_name: str) -> int:
    """32-bit word of a number. Raises ValueError saying what is wrong."""
    text = text.strip()
    if text[:2].lower() == "0f" and type_name == "float":
        try:
            return _word(int(text[2:], 16), text)
        except ValueError:
            raise ValueError(f"'{text}' is not 0f and 8 hexadecimal digits") from None
    if type_name == "int":
        try:
            value = int(text, 0)
        except ValueError:
            raise ValueError(f"'{text}' is not an integer") from None
        return _word(value, text)
    try:
        return int.from_bytes(struct.pack(">f", float(text)), "big")
    except ValueError:
        raise ValueError(f"'{text}' is not a number") from None
    except OverflowError:
        raise ValueError(f"{text} is too large for single precision") from None


def _word(value: int, text: str) -> int:
    if not -(1 << 31) <= value < 1 << 32:
        raise ValueError(f"{text} does not fit in 32 bits")
    return value & 0xFFFFFFFF


def read_inputs(path: Path, types: Mapping[str, str]) -> list[dict[str, int]]:
    """Words of every row of a CSV file whose header names inputs."""
    rows = []
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.reader(file, skipinitialspace=True)
        try:
            header = [name.strip() for name in next(reader, [])]
            if not header:
                raise UserError(f"{path}: empty, expected a header with names of inputs")
            for name in header:
                if name not in types:
                    raise UserError(f"{path}:1: {unknown('input', name, types)}")
            for row in reader:
                if not row:
                    continue
                where = f"{path}:{reader.line_num}"
                if len(row) != len(header):
                    raise UserError(f"{where}: {len(row)} values for {len(header)} names")
                words = {}
                for name, text in zip(header, row, strict=True):
                    try:
                        words[name] = parse_word(text, types[name])
                    except ValueError as error:
                        raise UserError(f"{where}: {name}: {error}") from None
                rows.append(words)
        except (csv.Error, UnicodeDecodeError) as error:
            raise UserError(f"{path}: not a CSV text: {error}") from None
    if not rows:
        raise UserError(f"{path}: no row below the header")
    return rows


def printed_names(image: Image, text: str | None) -> list[str]:
    """Names to print: those asked for, or all outputs and exports."""
    outputs = [output.name for output in image.outputs]
    known = [*outputs, *(export.name for export in image.exports)]
    if text is None:
        return known
    known += [state.name for state in image.states]
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in known and not is_register(name):
            raise UserError(unknown("output, export, state or register", name, known), 2)
    return names


def is_register(name: str) -> bool:
    """Whether the name is a register that a host can read ('a3', 'c12')."""
    banks = {bank.lower(): default_isa().banks[bank].size for bank in "ABC"}
    return name[:1] in banks and name[1:].isdecimal() and int(name[1:]) < banks[name[0]]


# ---------------------------------------------------------------------- where to run


def rtl_runner(image: Image, states: Mapping[str, int], trace: bool) -> Runner:
    """The program on the Verilated core, which is built on first use."""
    # Verilator is needed here only, not by the instruction-set model.
    from sim.harness.asip_rtl import BLOCK, CSR, STATUS, AsipError, AsipRtl, register_address
    from sim.harness.build import BuildError

    try:
        core = AsipRtl(image.configuration)
    except BuildError as error:
        raise UserError(str(error)) from None
    core.load(image)
    core.preset(states)
    outputs = {output.name: output.index for output in image.outputs}
    places = {entry.name: entry.register for entry in (*image.exports, *image.states)}

    constants = {f"k{entry.index}": int(entry.bits, 16) for entry in image.constants}
    input_names = {f"k{entry.index}": entry.name for entry in image.inputs}

    def read(name: str, inputs: Mapping[str, int]) -> int:
        if name in outputs:
            return core.read(BLOCK["outputs"] + outputs[name])
        register = places.get(name, name)
        if register in input_names:  # the host cannot read bank K
            return inputs[input_names[register]]
        if register in constants:
            return constants[register]
        return core.read(register_address(register))

    class RtlRunner:
        def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
            for name, address in zip(inputs, core.input_addresses(list(inputs)), strict=True):
                core.write(address, inputs[name])
            core.trace(trace)
            try:
                result = core.run([], np.zeros((1, 0), dtype=np.uint32), [])
            except AsipError as error:
                raise UserError(str(error)) from None
            counters = {name: core.read(CSR[name]) for name in COUNTERS}
            info = core.read(CSR["FAULT_INFO"])
            if result.fault == NO_FAULT:
                fault = Fault(NO_FAULT)
            elif result.fault == "NOT_FINITE":
                fault = Fault(result.fault, output=info)
            else:
                fault = Fault(result.fault, bundle=info)
            return Run(
                fault=fault,
                flags=STATUS["flags"].of(int(result.status[-1])),
                counters=counters,
                words={name: read(name, inputs) for name in names},
                writes=[(f"{b.lower()}{i}", word) for b, i, word in core.traced_writes()],
                trace=CoreTrace(core.traced_issues(), core.timed_writes(), counters)
                if trace
                else None,
            )

    return RtlRunner()


def iss_runner(image: Image, states: Mapping[str, int], trace: bool) -> Runner:
    """The program on the instruction-set model."""
    from sim.iss import Iss

    model = Iss(image.to_json(), trace=trace)
    types = {entry.name: entry.type for entry in (*image.inputs, *image.states)}

    def values(words: Mapping[str, int]) -> dict[str, float]:
        return {name: number(word, types[name]) for name, word in words.items()}

    model.set_state(values(states))

    class IssRunner:
        def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
            model.set_inputs(values(inputs))
            result = model.run()
            return Run(
                fault=Fault(result.fault.name, bundle=result.fault_bundle),
                flags=result.flags,
                counters={"BUNDLES": result.bundles},
                words={
                    name: result.output_bits[name]
                    if name in result.output_bits
                    else model.read_bits(name)
                    for name in names
                },
                writes=[(name, word) for name, words in result.writes.items() for word in words],
            )

    return IssRunner()


# ---------------------------------------------------------------------- what to show


def number(word: int, type_name: str) -> float | int:
    """Value of a word."""
    data = word.to_bytes(4, "big")
    if type_name == "int":
        return int.from_bytes(data, "big", signed=True)
    return struct.unpack(">f", data)[0]


def value_text(word: int, type_name: str) -> str:
    """Shortest decimal text that gives the word again; integers as such."""
    value = number(word, type_name)
    if type_name == "int" or value != value:
        return str(value)
    return str(np.float32(value)).removesuffix(".0")


def flag_text(flags: int) -> str:
    """Names of the raised exceptions, '-' for none."""
    return " ".join(n for i, n in enumerate(FLAGS) if flags >> (len(FLAGS) - 1 - i) & 1) or "-"


def types_of(image: Image) -> Callable[[str], str]:
    """Type by name; outputs, exports without a declaration and registers are floats."""
    types = {entry.name: entry.type for entry in (*image.inputs, *image.states)}
    return lambda name: types.get(name, "float")


def write_text(file: TextIO, image: Image, tick: int, names: Sequence[str], result: Run) -> None:
    """One run for people."""
    type_of = types_of(image)
    width = max(map(len, names), default=0)
    counters = ", ".join(f"{name.lower()} {count}" for name, count in result.counters.items())
    state = "done" if result.fault.cause == NO_FAULT else f"fault {result.fault.cause}"
    file.write(f"run {tick + 1}: {state}, {counters}, flags {flag_text(result.flags)}\n")
    for name in names:
        word = result.words[name]
        file.write(f"  {name:{width}s} = {value_text(word, type_of(name)):14s} {word:08x}\n")


def write_row(file: TextIO, image: Image, tick: int, names: Sequence[str], result: Run) -> None:
    """One run as a row of the CSV table, the header before the first."""
    type_of = types_of(image)
    counters = [name.lower() for name in result.counters]
    out = csv.writer(file, lineterminator="\n")
    if tick == 0:
        out.writerow(["run", *names, "fault", "flags", *counters])
    values = [value_text(result.words[name], type_of(name)) for name in names]
    row = [tick + 1, *values, result.fault.cause, flag_text(result.flags)]
    out.writerow([*row, *result.counters.values()])


def write_profile(
    file: TextIO, image: Image, trace: CoreTrace, konata: Path | None, gantt: Path | None
) -> None:
    """Profile of a run for people, and the files that show it clock by clock."""
    try:
        profile = profile_run(image, trace)
    except ProfileError as error:
        raise UserError(f"profile: {error}") from None
    file.write(profile.render())
    for path, text in ((konata, konata_log), (gantt, gantt_page)):
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text(profile), encoding="utf-8")


def fault_text(image: Image, fault: Fault) -> str:
    """Cause, place and source lines of a fault."""
    meaning = default_register_map().faults[fault.cause].doc
    rows = [f"{fault.cause}: {meaning}"]
    bundles: list[int] = []
    if fault.output is not None:
        name = {o.index: o.name for o in image.outputs}.get(fault.output, f"o{fault.output}")
        rows[0] += f", output {name}"
        names = (name, f"o{fault.output}")
        bundles = [
            address
            for address, entries in enumerate(image.sources)
            if any(destination(entry.text) in names for entry in entries)
        ]
    elif fault.bundle is not None:
        rows[0] += f", bundle {fault.bundle}"
        bundles = [fault.bundle] if fault.bundle < len(image.sources) else []
        if not bundles:
            rows[0] += " (outside the program)"
    for address in bundles:
        for entry in image.sources[address]:
            if fault.output is None or destination(entry.text) in names:
                rows.append(f"  {entry.file}:{entry.line}: {entry.text}")
    return "\n".join(rows)


def destination(text: str) -> str:
    """First operand of an operation's text."""
    words = text.split(None, 1)
    return words[1].split(",")[0].strip() if len(words) > 1 else ""


class Trace:
    """File of register and output writes, one per line: run, register, word, value as a float."""

    def __init__(self, path: Path | None) -> None:
        self._path = path

    def __enter__(self) -> Trace:
        self._file = self._path.open("w", encoding="utf-8") if self._path else None
        return self

    def __exit__(self, *_: object) -> None:
        if self._file:
            self._file.close()

    def write(self, tick: int, result: Run) -> None:
        """Append the writes of a run."""
        if self._file:
            for register, word in result.writes:
                value = value_text(word, "float")
                self._file.write(f"{tick + 1} {register} {word:08x} {value}\n")


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    """Options of the command line; exits with status 2 if they are wrong."""
    parser = argparse.ArgumentParser(
        prog="asip-run",
        description="Run a program on the Verilated core or on the instruction-set model.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "program", type=Path, help="source text, or image written by asip-as (*.json)"
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--rtl", action="store_true", help="run on the Verilated core (default)")
    place.add_argument("--iss", action="store_true", help="run on the instruction-set model")
    parser.add_argument(
        "--config", choices=tuple(default_isa().configurations), help="configuration of the core"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="input of every run"
    )
    parser.add_argument(
        "--inputs", type=Path, metavar="FILE", help="CSV file with a row of inputs for each run"
    )
    parser.add_argument("--ticks", type=_positive, metavar="N", help="number of runs")
    parser.add_argument(
        "--state",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="state before the first run",
    )
    parser.add_argument(
        "--print",
        metavar="NAME,...",
        help="outputs, exports, states, registers to show (default: all outputs and exports)",
    )
    parser.add_argument(
        "--trace", type=Path, metavar="FILE", help="write every register and output written"
    )
    parser.add_argument(
        "--profile",
        action="store_true",
        help="where the cycles of the last run went (with --inputs on standard error)",
    )
    parser.add_argument(
        "--konata",
        type=Path,
        metavar="FILE",
        help="profile, and a pipeline log for the Konata viewer",
    )
    parser.add_argument(
        "--gantt",
        type=Path,
        metavar="FILE",
        help="profile, and an HTML chart of units over clock cycles",
    )
    return parser.parse_args(arguments)


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of runs")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
