# SPDX-License-Identifier: Apache-2.0
"""nios_sw/custom.toml: what is refused and how, what is generated, and that it hangs together.

A custom instruction is hardware, C header, demo, test and a line of documentation that name each
other; its Platform Designer script is evaluated and compared with the ports that Verilator sees.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from scripts import gen_custom
from scripts.custom_components import ports_of
from sim.rtl.build import ROOT
from sim.rtl.custom_table import FPGA_OF, SOURCE, CustomError, load
from sim.rtl.plain import plain
from sim.rtl.sources import sources_of
from tests.asip.test_platform_designer import ports_and_parameters
from tests.bench.commands import output
from tests.bench.needs import find, needs
from tests.bench.tcl import Component

PLATFORMS = load()
# Platform, component and, as `mine`, the instructions of the component.
COMPONENTS = [
    pytest.param(p, c, [i for i in p.instructions.values() if i.component == c.name], id=c.name)
    for p in PLATFORMS.values()
    for c in p.components.values()
]
EACH = pytest.mark.parametrize(("platform", "part", "mine"), COMPONENTS)
NIOS_GCC = find("nios-gcc")
C_FLAGS = "-std=c11 -Wall -Wextra -Werror -O2 -ffp-contract=off".split()
C_FLAGS += [f"-I{ROOT}/nios_sw/include"]
HOST = [os.environ.get("CC", "gcc"), *C_FLAGS]

# what is changed in the table (first occurrence after the header) -> record of FPGA2, part of the
# message
REFUSED = {
    "number_taken": ("instructions.fadd", "n = 253", "n = 252", "already that of `fmul`"),
    "number_of_a_block_taken": (
        "instructions.fsign",
        "n = 245",
        "n = 239",
        "overlap `ci_fsign` at n = 239",
    ),
    "number_too_large": ("instructions.fmul", "n = 252", "n = 256", "an integer 0..255"),
    "outside_its_block": (
        "instructions.fmin",
        "n = 233",
        "n = 240",
        "outside the aligned block 224..239 of `fabs`; raise select or move the number",
    ),
    "cycles_zero": ("instructions.fsat", "cycles = 3", "cycles = 0", "an integer 1..128"),
    "cycles_of_no_unit": (
        "instructions.fsqrt",
        "FP_DIVSQRT_LATENCY",
        "FP_ROOT_LATENCY",
        "fp_pkg.sv has no `FP_ROOT_LATENCY`; one of FP_ADD_LATENCY",
    ),
    "two_fixed_latencies": (
        "instructions.fsat_set",
        "cycles = 3",
        "cycles = 2",
        "multicycle has one number of cycles",
    ),
    "slow_combinational": (
        "instructions.fneg",
        "cycles = 1",
        "cycles = 2",
        "combinational, but `fneg` has cycles = 2",
    ),
    "unknown_type": (
        "components.ci_fadd",
        '"multicycle"',
        '"pipelined"',
        "type `pipelined`; one of combinational, multicycle, variable",
    ),
    "unknown_key": (
        "instructions.fmul",
        "software",
        "softwear",
        "unknown key `softwear`; did you mean `software`?",
    ),
    "missing_key": ("instructions.fmul", 'operands = "f=ff"\n', "", "`operands` is missing"),
    "unknown_component": ("instructions.fmul", '"ci_fmul"', '"ci_mul"', "no component `ci_mul`"),
    "macro_taken": (
        "components.ci_fsub",
        "ALT_CI_FSUB",
        "ALT_CI_FADD",
        "macro ALT_CI_FADD is already that of `ci_fadd`",
    ),
    "bad_operands": ("instructions.fmul", '"f=ff"', '"d=dd"', "result=arguments"),
    "three_arguments_from_the_cpu": (
        "instructions.fmul",
        '"f=ff"',
        '"f=fff"',
        "at most two arguments",
    ),
    "bad_registers": ("instructions.fsat_pair", '"rrc"', '"rrx"', "r or c for each"),
}


def changed(tmp_path: Path, header: str, old: str, new: str) -> Path:
    """A copy of the table with `old` replaced by `new` in the record `[fpga2.header]`."""
    text = SOURCE.read_text(encoding="utf-8")
    begin = text.index(f"[fpga2.{header}]")
    end = text.find("\n[", begin) % (len(text) + 1)
    assert old in text[begin:end]
    path = tmp_path / "custom.toml"
    path.write_text(text[:begin] + text[begin:end].replace(old, new, 1) + text[end:])
    return path


@pytest.mark.parametrize("name", REFUSED)
def test_table__bad_record__is_refused_with_line_record_and_cause(tmp_path, name):
    header, old, new, message = REFUSED[name]
    path = changed(tmp_path, header, old, new)
    with pytest.raises(CustomError, match=re.escape(message)) as caught:
        load(path)
    found = re.match(r"(.*?):(\d+):1: error: ([\w.]+): ", str(caught.value))
    assert found and found[1] == str(path)
    assert path.read_text().splitlines()[int(found[2]) - 1] == f"[{found[3]}]"


def test_command__refused_table__exit_1_and_no_traceback(tmp_path):
    path = changed(tmp_path, *REFUSED["number_taken"][:3])
    command = [sys.executable, ROOT / "scripts/gen_custom.py", "--source"]
    done = subprocess.run([*command, path], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert "n = 252 is already that of `fmul`" in done.stderr
    path.write_text("[fpga1\n")
    done = subprocess.run([*command, path], capture_output=True, text=True)
    assert done.returncode == 1 and re.match(rf"{path}:1:7: error: ", done.stderr), done.stderr
    done = subprocess.run([*command, tmp_path / "none"], capture_output=True, text=True)
    assert done.returncode == 1 and "No such file" in done.stderr and "Trace" not in done.stderr


def test_committed_files__are_those_of_the_table(tmp_path, capsys):
    assert gen_custom.main(["--check"]) == 0, capsys.readouterr()
    assert gen_custom.main(["--root", str(tmp_path)]) == 0
    stale = tmp_path / "rtl/gen/ci_pkg.sv"
    stale.write_text(stale.read_text().replace("8'hfc", "8'hfb", 1))
    assert gen_custom.main(["--check", "--root", str(tmp_path)]) == 1
    assert "generated files are stale" in capsys.readouterr().err


# ---- four files and a line that point at each other ----


@EACH
def test_links__hardware_header_demo_test_and_documentation(platform, part, mine):
    hardware = ROOT / f"rtl/custom/{part.name}.sv"
    assert re.search(rf"^module {part.name} ", hardware.read_text(), re.M)
    header = (ROOT / "nios_sw/include/gen/ci.h").read_text()
    assert f"#define {part.macro}_N {part.base}\n" in header
    demo = (ROOT / f"nios_sw/demo/{part.name}.c").read_text()
    for place in ("nios_sw/custom.toml", f"rtl/custom/{part.name}.sv", "tests/custom"):
        assert place in demo
    page = (ROOT / "docs/ci.md").read_text()
    guide = (ROOT / "docs/custom_instructions.md").read_text()
    assert f"`{part.name}`" in guide
    bench = (ROOT / "sim/rtl/ci_bench.sv").read_text()
    assert re.search(rf"^  {part.name} ", bench, re.M)
    for item in mine:
        assert f"#define CI_{item.name.upper()}_N {item.n}\n" in header
        assert f"ci_{item.name}(" in demo
        assert f"ci_{item.name}(" in page


def test_links__every_path_named_on_the_page_exists():
    guide = (ROOT / "docs/custom_instructions.md").read_text()
    named = set(re.findall(r"`((?:rtl|nios_sw|tests|scripts|sim|docs)/[\w./]+)`", guide))
    named |= {f"docs/{name}" for name in re.findall(r"\]\((\w+\.md)\)", guide)}
    own = {name for name in named if "ci_bswap" in name}  # the example, not in the tree
    assert len(named - own) > 8
    assert [name for name in sorted(named - own) if not (ROOT / name).exists()] == []


# ---- Platform Designer ----


@EACH
def test_hw_tcl__ports_roles_and_properties_of_the_module(platform, part, mine, tmp_path):
    file = ROOT / f"scripts/platform_designer/{part.name}_hw.tcl"
    script = Component(file)
    found, _ = ports_and_parameters(part.name, sources_of(part.name), tmp_path)
    ports = {name: port for name, port in found.items() if name[-2:] in ("_i", "_o")}
    added = script.of("add_interface_port")
    assert {name: (way, int(width)) for _, name, _, way, width in added} == ports
    assert all(name.removesuffix(f"_{way[0].lower()}") == role for _, name, role, way, _ in added)
    (interface,) = script.of("add_interface")
    assert interface[1:] == ("nios_custom_instruction", "end")
    properties = {words[1]: words[2] for words in script.of("set_interface_property")}
    fixed = {i.cycles for i in mine} if part.type == "multicycle" else {1}
    assert {int(properties["clockCycle"])} == fixed
    kinds = {"combinational": "COMBINATORIAL", "multicycle": "MULTICYCLE", "variable": "VARIABLE"}
    assert properties["clockCycleType"] == kinds[part.type]
    assert int(properties["opcodeExtensionLockedValue"], 16) == min(part.numbers)
    assert int(properties["operands"]) == len({"dataa_i", "datab_i"} & set(ports))
    assert ("NAME", part.name) in script.of("set_module_property")
    filesets = script.of("add_fileset")
    assert [words[0] for words in filesets] == ["QUARTUS_SYNTH", "SIM_VERILOG"]
    for kind, _, _ in filesets:
        assert (kind, "TOP_LEVEL", part.name) in script.of("set_fileset_property")
    added = Component(file, f"{filesets[0][2]} {part.name}").of("add_fileset_file")
    assert [(file.parent / words[3]).resolve() for words in added] == sources_of(part.name)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("dataa_i", "operand_i", "port operand_i has no role"),
        ("output logic [31:0] result_o", "output logic [15:0] result_o", "16 bits, not 32"),
        ("input  logic        clk_en_i", "input  logic        unused_i", "no role"),
        ("    input  logic        reset_i,\n", "", "needs a port reset"),
    ],
)
def test_hw_tcl__module_that_does_not_fit__is_refused_with_its_line(tmp_path, old, new, message):
    part = PLATFORMS["fpga2"].components["ci_fadd"]
    source = (ROOT / "rtl/custom/ci_fadd.sv").read_text()
    source = re.sub(r"(reset_i,)\s*//.*", r"\1", source)
    assert old in source
    (tmp_path / "custom").mkdir()
    (tmp_path / "custom/ci_fadd.sv").write_text(source.replace(old, new, 1))
    with pytest.raises(CustomError, match=rf"ci_fadd\.sv:\d+:1: error: .*{message}"):
        ports_of(part, tmp_path)


# ---- C ----


def flags_of(platform: str) -> list[str]:
    """CI_FLAGS_<platform> as make sees it."""
    table = plain(ROOT / "nios_sw/include/gen/ci_flags.mk")
    text = f"include {table}\nall:\n\t@echo $(CI_FLAGS_{platform})\n"
    return output("make", "-s", "-f", "-", input=text).split()


@pytest.mark.parametrize("header", ["components.ci_fadd", "instructions.fadd"])
@pytest.mark.parametrize(
    "doc",
    ['\\"; exec date; #', "[exec date]", "$x", "*/ int x; /*", "a\\nmodule x;", "b\\u2028c", ""],
)
def test_text_that_a_language_would_obey__is_refused(tmp_path, header, doc):
    old = re.search(rf'\[fpga2\.{re.escape(header)}\][^[]*?(doc = ".*")', SOURCE.read_text())
    assert old
    path = changed(tmp_path, header, old[1], f'doc = "{doc}"')
    with pytest.raises(CustomError, match=rf"custom\.toml:\d+:1: error: fpga2\.{header}: doc = "):
        load(path)


@pytest.mark.parametrize("macro", ["X Y", "x", "X); system(1", "X\\nY", 3])
def test_macro_that_is_no_name__is_refused(tmp_path, macro):
    text = SOURCE.read_text()
    old = re.search(r'\[fpga2\.components\.ci_fadd\][^[]*?(macro = ".*")', text)
    assert old
    new = f'macro = "{macro}"' if isinstance(macro, str) else f"macro = {macro}"
    with pytest.raises(CustomError, match=r"ci_fadd: macro = .*: a capital letter"):
        load(changed(tmp_path, "components.ci_fadd", old[1], new))


@EACH
def test_demo__on_a_host__runs_in_software_and_agrees(platform, part, mine, tmp_path):
    source = ROOT / f"nios_sw/demo/{part.name}.c"
    program = tmp_path / part.name
    number = f"-DCI_PLATFORM={FPGA_OF[platform.name]}"
    output(*HOST, number, source, "-lm", "-o", program)
    said = output(program)
    told = set(re.findall(r"^(\w+): software on a host, same result$", said, re.M))
    assert {i.name for i in mine} - {"fsat_set"} <= told | {"subnormal result"}, said


def test_header__software_of_the_saturation__bounds_nan_and_exchange(tmp_path):
    source = tmp_path / "saturation.c"
    source.write_text(
        '#include "gen/ci.h"\n#include <stdio.h>\n'
        "int main(void) {\n"
        "  ci_fsat_set(5, -1.0f, 2.0f); ci_fsat_set(6, 2.0f, -1.0f);\n"
        '  printf("%g %g ", ci_fsat(-3, 2), ci_fsat(1, -2));\n'
        '  printf("%g %g ", ci_fsat(NAN, 1), ci_fsat(1, NAN));\n'
        '  printf("%g %g %g ", ci_fsat_pair(9, 5), ci_fsat_pair(-9, 5), ci_fsat_pair(0, 6));\n'
        '  printf("%g %g\\n", ci_fsat_low(5), ci_fsat_high(5));\n}\n'
    )
    output(*HOST, source, "-lm", "-o", tmp_path / "saturation")
    said = output(tmp_path / "saturation")
    assert said.replace("-nan", "nan").split() == "-2 1 nan nan 2 -1 nan -1 2".split()


@needs("nios-gcc")
@EACH
def test_demo__nios_compiler__emits_the_numbers_of_the_table(platform, part, mine):
    source = ROOT / f"nios_sw/demo/{part.name}.c"
    flags = [*C_FLAGS, *flags_of(platform.name.upper())]
    assembly = output(NIOS_GCC, *flags, "-S", source, "-o", "-")
    emitted = {int(n) for n in re.findall(r"\bcustom\s+(\d+),", assembly)}
    assert {i.n for i in mine} <= emitted <= {i.n for i in platform.instructions.values()}


@needs("nios-gcc")
@pytest.mark.parametrize("name", PLATFORMS)
def test_flags__plain_c__compiles_to_every_operation_that_the_compiler_knows(name, tmp_path):
    """GCC drops a custom operation silently where an option of the mathematics is missing."""
    platform, source = PLATFORMS[name], tmp_path / "plain.c"
    known = [i for i in platform.instructions.values() if i.gcc]
    types = {"f": "float", "i": "int"}
    lines = ["#include <math.h>"]
    for item in known:
        names = "ab"[: len(item.arguments)]
        given = ", ".join(f"{types[t]} {v}" for t, v in zip(item.arguments, names, strict=True))
        lines.append(f"{types[item.result]} f_{item.name}({given}) {{ return {item.software}; }}")
    source.write_text("\n".join(lines) + "\n")
    flags = [*C_FLAGS, *flags_of(name.upper()), "-ffast-math"]
    text = output(NIOS_GCC, *flags, "-S", source, "-o", "-")
    for item in known:
        body = text[text.index(f"f_{item.name}:") : text.index(f".size\tf_{item.name}")]
        numbers = {int(n) for n in re.findall(r"\bcustom\s+(\d+),", body)}
        assert item.n in numbers, (item.name, body)
        assert "call" not in body, item.name


@needs("nios-gcc")
def test_flags__fpga1__are_those_of_the_vendor_s_configuration(tmp_path):
    """`-mcustom-fpu-cfg=60-2` and our flags give the same code."""
    source = tmp_path / "four.c"
    source.write_text(
        "float f(float a, float b) { return (a + b) * (a - b) / b + (a < b) + a * 3; }\n"
    )
    texts = []
    for flags in (["-mcustom-fpu-cfg=60-2", "-DCI_PLATFORM=1"], flags_of("FPGA1")):
        text = output(NIOS_GCC, *C_FLAGS, *flags, "-S", source, "-o", "-")
        texts.append(re.findall(r"^\t([a-z].*)$", text, re.M))
    assert texts[0] == texts[1]
    numbers = {int(n) for line in texts[0] for n in re.findall(r"custom\s+(\d+)", line)}
    assert numbers == set(range(252, 256))


@needs("nios-gcc")
def test_assembly__internal_registers__words_of_the_instruction(tmp_path):
    """binutils encodes readra, readrb, writerc as ci_fsat expects them."""
    source = tmp_path / "fields.c"
    source.write_text(
        '#include "gen/ci.h"\n'
        "void set(float l, float h) { ci_fsat_set(7, l, h); }\n"
        "float pair(float x) { return ci_fsat_pair(x, 9); }\n"
        "float low(void) { return ci_fsat_low(11); }\n"
        "float high(void) { return ci_fsat_high(13); }\n"
        "float both(float x, float y) { return ci_fsat(x, y); }\n"
    )
    objects = tmp_path / "fields.o"
    output(NIOS_GCC, *C_FLAGS, *flags_of("FPGA2"), "-c", source, "-o", objects)
    dump = output(NIOS_GCC.with_name("nios2-elf-objdump"), "-d", objects)
    words = [int(w, 16) for w in re.findall(r"^\s*\w+:\s+(\w{8})\s+custom", dump, re.M)]
    assert len(words) == 5
    # |a 31:27|b 26:22|c 21:17|readra 16|readrb 15|writerc 14|n 13:6|50|
    fields = [
        (w >> 27, w >> 22 & 31, w >> 17 & 31, w >> 16 & 1, w >> 15 & 1, w >> 14 & 1) for w in words
    ]
    assert all(w >> 6 & 255 == 244 and w & 63 == 50 for w in words)
    assert fields[0][2:] == (7, 1, 1, 0)
    assert fields[1][1] == 9 and fields[1][3:] == (1, 0, 1)
    assert fields[2][0] == 11 and fields[2][3:] == (0, 1, 1)
    assert fields[3][0] == 13 and fields[3][3:] == (0, 0, 1)
    assert fields[4][3:] == (1, 1, 1)


def test_makefile__generates_and_checks_the_table():
    for target in ("gen", "gen-check"):
        assert "scripts/gen_custom.py" in output("make", "-n", target, cwd=ROOT)
