# SPDX-License-Identifier: Apache-2.0
"""The LiteX system of docs/integration.md: its CPU loads a program and runs ticks of it.

The CPU is a PicoRV32. Its program is assembled by bronzebeard; expected words come from the
instruction-set model.
"""

from __future__ import annotations

import json
import re
import sys
from itertools import chain
from pathlib import Path

import pytest
from bronzebeard.asm import assemble as riscv
from litex.build.generic_platform import GenericPlatform, Pins
from litex.soc.cores.gpio import GPIOOut
from litex.soc.integration.soc_core import SoCCore
from migen.genlib.io import CRG

from asip_asm.assemble import assemble
from scripts.doc_blocks import code_blocks
from sim.cocotb.runner import Simulation, outcomes
from sim.rtl.asip_bus import CLEAR, CSR, START
from sim.rtl.build import ROOT
from sim.rtl.litex import Asip
from tests.asip import litex_tb
from tests.asip.test_axil import PROGRAM, plan

# An attribute of this old module takes 2 s, and hypothesis asks every loaded module for its file.
sys.modules.pop("litex.soc.interconnect.stream_sim", None)

PAGE = ROOT / "docs/integration.md"
PINS = [("clk", 0, Pins(1)), ("rst", 0, Pins(1)), ("result", 0, Pins(32)), ("count", 0, Pins(32))]
TABLES = 0x200  # where the program's tables begin
ROM = 0x2000
SYSTEMS = {"wishbone": "small", "axi-lite": "fast"}  # bus -> configuration of the core
OPTIONS = {
    "cpu_type": "picorv32",
    "cpu_variant": "minimal",
    "integrated_rom_size": ROM,
    "integrated_sram_size": 0x400,
    "with_uart": False,
    "with_timer": False,
}
# s0 walks through the tables: pairs of address and word to load, then for each tick such pairs
# of its inputs and the addresses of its outputs.
CODE = """
    li   s0, TABLES
    li   s1, TICKS
    li   s2, CONTROL
    li   s3, EVENT
    li   s4, RESULT
    li   s5, COUNT
    addi s6, zero, 0
load:
    lw   t0, 0(s0)
    lw   t1, 4(s0)
    sw   t1, 0(t0)
    addi s0, s0, 8
    bltu s0, s1, load
    li   s1, END
tick:
    addi t2, zero, INPUTS
input:
    lw   t0, 0(s0)
    lw   t1, 4(s0)
    sw   t1, 0(t0)
    addi s0, s0, 8
    addi t2, t2, -1
    bne  t2, zero, input
    addi t0, zero, START
    sw   t0, 0(s2)
wait:
    lw   t0, 0(s3)
    beq  t0, zero, wait
    addi t2, zero, OUTPUTS
output:
    lw   t0, 0(s0)
    lw   t1, 0(t0)
    sw   t1, 0(s4)
    addi s6, s6, 1
    sw   s6, 0(s5)
    addi s0, s0, 4
    addi t2, t2, -1
    bne  t2, zero, output
    addi t0, zero, CLEAR
    sw   t0, 0(s2)
    bltu s0, s1, tick
done:
    jal  zero, done
"""


def system(bus: str, configuration: str) -> SoCCore:
    """The page's system with a clock, a reset and the pins on which its CPU reports words."""
    (block,) = (block for block in code_blocks(PAGE) if block.title == "soc.py")
    names: dict[str, type] = {}
    exec(block.text.replace("microtick.", ""), names)  # a checkout's names
    platform = GenericPlatform("", PINS)
    soc = names["ControlSoC"](platform, configuration, bus_standard=bus, **OPTIONS)
    soc.crg = CRG(platform.request("clk"), platform.request("rst"))
    soc.result = GPIOOut(platform.request("result"))
    soc.count = GPIOOut(platform.request("count"))
    soc.finalize()
    return soc


def rom(soc: SoCCore, todo: dict) -> list[int]:
    """The CPU's program and its tables."""
    origin = soc.bus.regions["asip"].origin

    def place(address: int) -> int:
        return origin + 4 * address

    def pairs(rows: list) -> list[int]:
        return list(chain.from_iterable((place(address), word) for address, word in rows))

    load, ticks = pairs(todo["load"]), []
    for tick in todo["ticks"]:
        ticks += pairs(tick["inputs"]) + [place(address) for address, _ in tick["outputs"]]
    first = todo["ticks"][0]
    constants = {
        "TABLES": TABLES,
        "TICKS": TABLES + 4 * len(load),
        "END": TABLES + 4 * (len(load) + len(ticks)),
        "CONTROL": place(CSR["CONTROL"]),
        "EVENT": soc.csr.regions["asip"].origin,  # its first register is `ev_status`
        "RESULT": soc.csr.regions["result"].origin,
        "COUNT": soc.csr.regions["count"].origin,
        "INPUTS": len(first["inputs"]),
        "OUTPUTS": len(first["outputs"]),
        "START": START,
        "CLEAR": CLEAR,
    }
    code = riscv(CODE, constants=constants).ljust(TABLES, b"\0")
    assert len(code) == TABLES and constants["END"] <= ROM
    words = [int.from_bytes(code[i : i + 4], "little") for i in range(0, TABLES, 4)]
    return words + load + ticks


def write_verilog(soc: SoCCore, folder: Path, words: list[int]) -> list[Path]:
    """The system's sources; its ROM holds the words. LiteX's comments have the time of day."""
    found = soc.platform.get_verilog(soc, name="soc")
    top = folder / "soc.v"
    top.write_text(re.sub(r"(?m)^//.*\n", "", found.main_source))
    for name, text in found.data_files.items():
        (folder / name).write_text(text)
    (folder / "soc_rom.init").write_text("".join(f"{word:08x}\n" for word in words))
    return [Path(path) for path, *_ in soc.platform.sources] + [top]


@pytest.mark.parametrize("bus", ["wishbone", pytest.param("axi-lite", marks=pytest.mark.full)])
def test_litex__ticks_of_its_cpu__outputs_of_the_model(bus):
    configuration = SYSTEMS[bus]
    todo = plan(assemble(PROGRAM, configuration=configuration))
    folder = ROOT / "build/litex" / bus
    folder.mkdir(parents=True, exist_ok=True)
    soc = system(bus, configuration)
    sources = write_verilog(soc, folder, rom(soc, todo))
    wanted = [word for tick in todo["ticks"] for _, word in tick["outputs"]]
    assert len(set(wanted)) > len(wanted) / 2
    simulation = Simulation("soc", sources, folder)
    environment = {"WORDS": json.dumps(wanted)}
    found = outcomes(simulation.run(litex_tb.__name__, environment))
    assert found and not any(found.values()), found


def test_litex__unknown_configuration__names_the_known_ones():
    with pytest.raises(ValueError, match="no configuration 'quick'; there are .*fast"):
        Asip(GenericPlatform("", PINS), "quick")
