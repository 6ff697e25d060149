# SPDX-License-Identifier: Apache-2.0
"""Platform Designer component: evaluated by a Tcl interpreter whose tool commands are recorded, and
compared with the ports and parameters of rtl/asip/asip.sv as Verilator elaborates them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.isa import default_isa
from sim.rtl.build import ROOT, WAIVERS, file_list, verilator_driver
from tests.bench.commands import output
from tests.bench.tcl import Component

SCRIPT = ROOT / "scripts/platform_designer/asip_hw.tcl"

OPEN = ("trace_", "hook_")  # ports that the component leaves out


@pytest.fixture(scope="module")
def module(tmp_path_factory) -> tuple[dict[str, tuple[str, int]], set[str]]:
    """Ports (direction, width) and parameter names of module asip."""
    return ports_and_parameters("asip", file_list("asip/asip.f"), tmp_path_factory.mktemp("tree"))


def ports_and_parameters(name: str, sources: list[Path], folder: Path):
    """Ports (direction, width) and parameter names of module `name` as Verilator sees it."""
    tree = folder / "tree.json"
    options = ["--json-only", "--json-only-output", tree, "--top-module", name]
    options += ["--json-only-meta-output", folder / "meta.json", WAIVERS]
    output(verilator_driver(), *options, *sources, cwd=folder)
    types = {}
    variables = []

    def walk(node, top: bool) -> None:
        if isinstance(node, list):
            for item in node:
                walk(item, top)
        elif isinstance(node, dict):
            if node.get("type", "").endswith("DTYPE"):
                types[node["addr"]] = node
            if node.get("type") == "MODULE":
                top = node["name"] == name
            if node.get("type") == "VAR" and top:
                variables.append(node)
            for value in node.values():
                if isinstance(value, (list, dict)):
                    walk(value, top)

    walk(json.loads(tree.read_text()), False)

    def width(address: str) -> int:
        node = types[address]
        if node["type"] == "PACKARRAYDTYPE":
            high, low = map(int, node["declRange"].strip("[]").split(":"))
            return (high - low + 1) * width(node["refDTypep"])
        if "range" not in node:
            return 1
        high, low = map(int, node["range"].split(":"))
        return high - low + 1

    ports = {
        v["name"]: (v["direction"].capitalize(), width(v["dtypep"]))
        for v in variables
        if v.get("direction", "NONE") != "NONE"
    }
    parameters = {v["name"] for v in variables if v.get("varType") == "GPARAM"}
    return ports, parameters


def test_ports__those_of_the_module_by_name_direction_and_width(module):
    ports, _ = module
    mapped = {
        name: (direction, int(width))
        for _, name, _, direction, width in Component(SCRIPT).of("add_interface_port")
    }
    assert mapped["address_i"][1] == REGMAP.address_width
    host = {name: port for name, port in ports.items() if not name.startswith(OPEN)}
    assert mapped == host
    assert set(ports) - set(mapped), "the trace ports are still there"


def test_parameters__those_of_the_module_with_the_isa_s_limits(module):
    _, parameters = module
    parameters = parameters - {"Debug"}  # its hooks are for debug_asip
    component, isa = Component(SCRIPT), default_isa()
    assert set(component.parameters) == parameters
    fast = isa.configurations["fast"]
    assert component.parameters == {
        "FmaPipes": fast.fma_pipes,
        "Slots": len(fast.slots),
        "Bundles": isa.program_bundles,
        "DataWords": isa.data_words,
        "Resilience": 0,
        "Plausible": 1,
        "StreamWords": 0,
        "Loops": 0,
        "Lanes": 0,
    }
    generics = {
        words[0] for words in component.of("set_parameter_property") if words[1] == "HDL_PARAMETER"
    }
    assert generics == parameters


@pytest.mark.parametrize("kind", ["QUARTUS_SYNTH", "SIM_VERILOG"])
def test_fileset__files_of_the_list_in_order(kind):
    component = Component(SCRIPT)
    callback = {words[0]: words[2] for words in component.of("add_fileset")}[kind]
    assert (kind, "TOP_LEVEL", "asip") in component.of("set_fileset_property")
    added = Component(SCRIPT, f"{callback} asip").of("add_fileset_file")
    want = [path.resolve() for path in file_list("asip/asip.f")]
    assert [(SCRIPT.parent / words[3]).resolve() for words in added] == want
    assert all(words[1:3] == ("SYSTEM_VERILOG", "PATH") for words in added)
    assert len({words[0] for words in added}) == len(added)


@pytest.mark.parametrize(
    ("pipes", "slots", "messages"),
    [
        (2, 3, []),
        (1, 1, []),
        (1, 3, ["FmaPipes = 1 needs Slots = 1, not 3."]),
        (2, 1, ["FmaPipes = 2 needs Slots = 3, not 1."]),
    ],
)
def test_elaboration__only_the_configurations_there_are(pipes, slots, messages):
    component = Component(SCRIPT, "elaborate", FmaPipes=pipes, Slots=slots)
    assert component.of("send_message") == [("error", text) for text in messages]
    if not messages:
        known = {(c.fma_pipes, len(c.slots)) for c in default_isa().configurations.values()}
        assert (pipes, slots) in known


def test_agent__word_addresses_and_interrupt_of_the_agent():
    properties = set(Component(SCRIPT).of("set_interface_property"))
    assert ("s0", "addressUnits", "WORDS") in properties
    assert ("irq", "associatedAddressablePoint", "s0") in properties
    assert ("reset", "synchronousEdges", "DEASSERT") in properties
