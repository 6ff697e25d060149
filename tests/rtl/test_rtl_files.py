# SPDX-License-Identifier: Apache-2.0
"""The file list of the ASIP: complete, minimal, ordered, and the one that Quartus reads."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from sim.rtl.build import verilator_driver
from sim.rtl.sources import sources_of
from tests.bench.needs import find, needs
from tests.bench.tcl import calls

ROOT = Path(__file__).resolve().parents[2]
RTL = ROOT / "rtl"
TCL = ROOT / "scripts/quartus/build.tcl"
LISTED = [line for line in (RTL / "asip/asip.f").read_text().split("\n") if line]
EVERY = sorted(str(path.relative_to(ROOT)) for path in RTL.rglob("*.sv"))
BOARD = ["rtl/board/board_pll.sv", "rtl/board/asip_de3.sv"]
# Below rtl/ but not in the ASIP: units of a product or a sum alone, and wrappers around the ASIP.
NOT_IN_ASIP = {
    *("rtl/fpu/fp_add.sv", "rtl/fpu/fp_mul.sv"),
    *("rtl/asip/asip_axil.sv", "rtl/asip/asip_lockstep.sv"),
    *("rtl/memory/ram_lut.sv", "rtl/memory/ram_two_ports.sv"),
}
# Tops of the ECP5 boards, by the files that only they need.
ECP5_BOARDS = {
    f"rtl/board/{name}.sv"
    for name in (
        *("ecp5_pll", "encoder_registers", "asip_ecp5"),
        *("asip_ulx3s", "asip_colorlight_i9", "asip_ecpix5", "asip_versa_ecp5"),
    )
}
# Blocks of their own, which no file list of the ASIP names.
GENERATED = ("absolute", "ci", "debug", "drive", "dual", "encoder", "esc", "motion", "n2")
FOLDERS = ("bus", "custom", "debug", "drive", "dual", "ethercat", "motion", "nios")
OTHER_BLOCKS = tuple(
    f"rtl/{folder}/{prefix}"
    for folder, prefix in (
        *((folder, "") for folder in FOLDERS),
        *(("gen", f"{name}_") for name in GENERATED),
    )
)


def code(name: str) -> str:
    return re.sub(r"//[^\n]*", "", (ROOT / name).read_text())


def quartus_assignments(folder: Path, *words: str, pins: str = "") -> list[tuple[str, ...]]:
    """Words of every Quartus command of build.tcl, run with substitutes for those commands.

    pins: text in place of pins.tcl. An error of the script is the last call, `error` and its words.
    """
    root = folder / "project"
    for name in [*LISTED, *BOARD, "rtl/asip/asip.f", "scripts/quartus/pins.tcl"]:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)
    if pins:
        (root / "scripts/quartus/pins.tcl").write_text(pins)
    script = root / "scripts/quartus/build.tcl"
    shutil.copy(TCL, script)
    made = calls(
        f"set quartus(args) {{{' '.join(words)}}}\n"
        "proc get_names args {"
        " return {OSC1_50 BUTTON_N {address_i[0]} {address_i[1]} read_i irq_o} }\n"
        "proc get_name_info args { return [lindex $args end] }\n"
        "proc foreach_in_collection {name collection body} {"
        " uplevel 1 [list foreach $name $collection $body] }\n"
        f"if {{[catch {{source {{{script}}}}} cause]}} {{ stopped $cause }}\n",
        "stopped load_package project_new project_close set_global_assignment "
        "set_location_assignment set_instance_assignment export_assignments execute_module".split(),
    )
    return [tuple(word.replace(f"{root}/", "") for word in call) for call in made]


def test_every_listed_file_exists_and_is_listed_once():
    assert [name for name in LISTED if not (ROOT / name).is_file()] == []
    assert len(set(LISTED)) == len(LISTED)


def test_list_is_exactly_what_the_top_needs():
    needed = {str(path.relative_to(ROOT)) for path in sources_of("asip")}
    assert sorted(set(LISTED) - needed) == [], "listed, but the top does not use it"
    assert sorted(needed - set(LISTED)) == [], "used by the top, but not listed"


OTHER_LISTS = [
    ("motion/motion.f", "motion_front_end"),
    ("drive/drive.f", "drive_front_end"),
    ("drive/biss_port.f", "biss_port"),
    ("drive/ssi_port.f", "ssi_port"),
    ("drive/endat_port.f", "endat_port"),
    ("drive/absolute_position.f", "absolute_position"),
    ("drive/sincos_position.f", "sincos_position"),
    ("drive/hall_decoder.f", "hall_decoder"),
    ("dual/dual.f", "dual_asip"),
    ("debug/debug.f", "debug_asip"),
    ("ethercat/ethercat.f", "ethercat_slave"),
    ("nios/n2_core.f", "n2_core"),
    ("nios/n2_system.f", "n2_system"),
]
DEBIAN_QUICK = ("asip/asip.f", "ethercat/ethercat.f")  # the others hold the same modules


@pytest.mark.parametrize(("name", "top"), OTHER_LISTS)
def test_list_of_another_block_is_exactly_what_its_top_needs(name, top):
    listed = [line for line in (RTL / name).read_text().split("\n") if line]
    needed = {str(path.relative_to(ROOT)) for path in sources_of(top)}
    assert sorted(listed) == sorted(needed)
    packages = [path for path in listed if path.endswith("_pkg.sv")]
    assert listed[: len(packages)] == packages, "packages come first"


@pytest.mark.parametrize(("name", "top"), [*OTHER_LISTS, ("asip/asip.f", "asip")])
def test_list_compiles_alone(name, top):
    command = [verilator_driver(), "--lint-only", "-Wall", "--quiet", "--top-module", top]
    done = subprocess.run(
        [*command, "rtl/waivers.vlt", "-f", f"rtl/{name}"], cwd=ROOT, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


@needs("debian-verilator")  # 5.006 in Debian 12
@pytest.mark.parametrize(
    ("name", "top"),
    [
        pytest.param(name, top, marks=() if name in DEBIAN_QUICK else pytest.mark.full)
        for name, top in [*OTHER_LISTS, ("asip/asip.f", "asip")]
    ],
)
def test_list_compiles_alone_in_the_verilator_of_debian(name, top, monkeypatch):
    for variable in ("VERILATOR_ROOT", "VERILATOR_BIN"):
        monkeypatch.delenv(variable, raising=False)
    command = [
        find("debian-verilator"),
        "--lint-only",
        "-Wall",
        "--top-module",
        top,
        "rtl/waivers.vlt",
    ]
    done = subprocess.run([*command, "-f", f"rtl/{name}"], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_every_rtl_file_is_in_the_asip_a_board_file_or_a_named_exception():
    known = set(LISTED) | set(BOARD) | ECP5_BOARDS | NOT_IN_ASIP
    unknown = {name for name in EVERY if not name.startswith(OTHER_BLOCKS)} - known
    assert sorted(unknown) == [], "add to rtl/asip/asip.f, or to NOT_IN_ASIP with a reason"
    assert sorted(NOT_IN_ASIP & set(LISTED)) == []


@pytest.mark.parametrize("name", EVERY)
def test_file_holds_one_module_or_package_of_its_own_name(name):
    declared = re.findall(r"(?m)^\s*(?:module|package)\s+(?:automatic\s+)?(\w+)", code(name))
    assert declared == [Path(name).stem]


def test_packages_come_first_and_each_after_those_it_names():
    packages = [name for name in LISTED if name.endswith("_pkg.sv")]
    assert LISTED[: len(packages)] == packages
    for place, name in enumerate(packages):
        seen = {Path(other).stem for other in packages[: place + 1]}
        assert set(re.findall(r"\b(\w+)::", code(name))) <= seen, name


def test_quartus_project_names_no_source_of_the_asip_itself():
    text = re.sub(r"(?m)^\s*#.*$", "", TCL.read_text())
    assert "rtl/asip/asip.f" in text
    assert re.findall(r"rtl/\S+\.sv", text) == BOARD


def test_quartus_project_adds_the_listed_files_in_order_then_the_board(tmp_path):
    added = [
        words[3]
        for words in quartus_assignments(tmp_path)
        if words[:3] == ("set_global_assignment", "-name", "SYSTEMVERILOG_FILE")
    ]
    assert added == LISTED + BOARD


def test_quartus_project__from_plain_verilog__has_that_file_alone(tmp_path):
    file = tmp_path / "project/build/plain/quartus/asip_de3.v"
    assert quartus_assignments(tmp_path, "plain")[-1][1].endswith("is missing; run microtick plain")
    file.parent.mkdir(parents=True)
    file.touch()
    made = quartus_assignments(tmp_path, "plain")
    files = [words[2:] for words in made if len(words) == 4 and words[2].endswith("VERILOG_FILE")]
    assert files == [("VERILOG_FILE", "build/plain/quartus/asip_de3.v")]


LOCATED = """set real_pins { {OSC1_50 PIN_A1 "2.5 V"} {BUTTON_N PIN_B2 "2.5 V"} }\n"""


def test_quartus_project__for_the_board__needs_locations_then_makes_an_image(tmp_path):
    stopped = quartus_assignments(tmp_path, "board")[-1]
    assert stopped[0] == "stopped" and "OSC1_50 has no location" in stopped[1]
    made = quartus_assignments(tmp_path, "board", pins=LOCATED)
    places = {words[1:] for words in made if words[0] == "set_location_assignment"}
    assert places == {("PIN_A1", "-to", "OSC1_50"), ("PIN_B2", "-to", "BUTTON_N")}
    assert made[-2:] == [("execute_module", "-tool", "asm"), ("project_close",)]


def test_quartus_project__unknown_word__is_refused(tmp_path):
    (stopped,) = (w for w in quartus_assignments(tmp_path, "bord") if w[0] == "stopped")
    assert stopped[1] == "unknown word 'bord'; there are plain and board"


def test_quartus_project_has_the_published_device_and_runs_map_fit_sta(tmp_path):
    words = quartus_assignments(tmp_path)
    settings = {line[2:] for line in words if line[0] == "set_global_assignment"}
    assert ("DEVICE", "EP3SL150F1152C2") in settings
    assert ("FAMILY", "Stratix III") in settings
    assert ("TOP_LEVEL_ENTITY", "asip_de3") in settings
    assert ("VERILOG_INPUT_VERSION", "SYSTEMVERILOG_2005") in settings
    assert {("VERILOG_MACRO", "SYNTHESIS=1"), ("VERILOG_MACRO", "QUARTUS=1")} <= settings
    tools = [line[-1] for line in words if line[0] == "execute_module"]
    assert tools == ["map", "map", "fit", "sta"]


def test_quartus_project_makes_every_port_without_a_pin_virtual(tmp_path):
    virtual = [
        line[-1]
        for line in quartus_assignments(tmp_path)
        if line[:4] == ("set_instance_assignment", "-name", "VIRTUAL_PIN", "ON")
    ]
    assert virtual == ["address_i[0]", "address_i[1]", "read_i", "irq_o"]


def test_constraints_and_pins_name_ports_of_the_board_top():
    header = code("rtl/board/asip_de3.sv").split(");")[0]
    ports = set(re.findall(r"(?m)(?:input|output)\s+logic\s*(?:\[.*?\])?\s*(\w+),?$", header))
    assert {"OSC1_50", "BUTTON_N", "irq_o"} <= ports
    sdc = re.sub(r"(?m)^\s*#.*$", "", (ROOT / "scripts/quartus/asip.sdc").read_text())
    named = {
        re.sub(r"\[\*\]", "", port)
        for group in re.findall(r"get_ports \{([^}]*)\}", sdc)
        for port in group.split()
    }
    assert named == ports, "every port is a clock, has its delays or a false path"
    bus = ports - {"OSC1_50", "BUTTON_N"}
    assert len(re.findall(r"set_(?:in|out)put_delay", sdc)) == 4
    assert bus == {port for port in named if not port.isupper()}
    pins = re.findall(r"(?m)^\s*\{(\w+)\s+\"", (ROOT / "scripts/quartus/pins.tcl").read_text())
    assert set(pins) < ports


def refused(*parameters: str) -> str:
    """What Verilator says about the core with these parameters, which it must refuse."""
    options = ["--lint-only", "--quiet", "--top-module", "asip"]
    options += [f"-G{parameter}" for parameter in parameters]
    command = [verilator_driver(), *options, *LISTED]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode != 0
    return done.stderr


@pytest.mark.quick("1-2")
@pytest.mark.parametrize(("pipes", "slots"), [(1, 2), (1, 3), (2, 1), (2, 2), (3, 3)])
def test_core__shape_that_is_no_configuration__is_refused_at_elaboration(pipes, slots):
    said = refused(f"FmaPipes={pipes}", f"Slots={slots}")
    assert f"FmaPipes={pipes}, Slots={slots}, must be 2 and 3" in said


@pytest.mark.quick("Bundles=1000")
@pytest.mark.parametrize("size", ["Bundles=1000", "Bundles=2048", "DataWords=48", "DataWords=4096"])
def test_core__memory_that_is_no_power_of_two_or_too_large__is_refused_at_elaboration(size):
    said = refused(size)
    assert size in said and "must be powers of two" in said
