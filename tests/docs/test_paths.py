# SPDX-License-Identifier: Apache-2.0
"""Files that README, CONTRIBUTING and the pages name exist, and so do the names in the steps of
CONTRIBUTING and registers.md in the files that they send a reader to."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterator
from functools import cache

import pytest

from asip_asm.project import ROOT
from tests.bench.commands import output
from tests.docs.plain_english import pages

TOPS = ("asip_asm", "docs", "nios_sw", "rtl", "scripts", "sim", "tests")
BLOCK = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`([^`\n]+)`")
NAMED = re.compile(rf"(?<![\w./-])(?:{'|'.join(TOPS)})/[\w./*-]*[\w*]")
MADE = {  # by steps of docs/custom_instructions.md
    "rtl/custom/ci_bswap.sv",
    "scripts/platform_designer/ci_bswap_hw.tcl",
    "nios_sw/demo/ci_bswap.c",
}
PAGES = pages() | {"CONTRIBUTING.md": (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")}
# Names in the steps, with the file that each step names.
STEPS = {
    "LAWS": "sim/laws/laws.py",
    "gravity_compensation": "sim/laws/laws.py",
    "USED_BY": "sim/laws/asip_model/robot_options.py",
    "LawReference": "sim/laws/reference.py",
    "test_gravity_compensation_is_its_equation": "tests/model_compiler/test_laws.py",
    "MAPS": "scripts/gen_regmap.py",
    "REG_WATCHDOG": "rtl/gen/asip_regmap_pkg.sv",
    "GROUPS": "sim/motion/gcode/block.py",
    "_MOVES": "sim/motion/gcode/block.py",
    "_ACTS": "sim/motion/gcode/block.py",
    "single": "sim/motion/gcode/actions.py",
    "_stop": "sim/motion/gcode/interpreter.py",
    "PROGRAMS": "tests/gcode/test_gcode_table.py",
    "TOPS": "scripts/lint_rtl.py",
    "CORES": "scripts/gen_core_files.py",
    "Settings": "sim/laws/laws.py",
    "add_robot_options": "sim/laws/asip_model/robot_options.py",
    "settings_of": "sim/laws/asip_model/robot_options.py",
    "PLANTED": "tests/model_compiler/planted.py",
    "word": "rtl/asip/asip_host.sv",
    "configures": "rtl/asip/asip_host.sv",
    "gen_parity": "rtl/asip/asip_host.sv",
    "IGNORED": "sim/motion/gcode/unsupported.py",
    "IDLE_LETTERS": "sim/motion/gcode/unsupported.py",
    "Motion": "sim/motion/geometry/moves.py",
    **dict.fromkeys(
        ("CYCLES", "SPLINES", "THREADS", "PROBES", "LATHE", "_VALUE_LETTERS"),
        "sim/motion/gcode/block.py",
    ),
    "_change_tool": "sim/motion/gcode/interpreter.py",
    "OTHER_LISTS": "tests/rtl/test_rtl_files.py",
    "LISTS": "tests/package/test_core_files.py",
    "Work": "tests/silicon/work.py",
    "AT_WORK": "scripts/plain_goals.py",
    "BLOCKS": "scripts/drive.py",
    "PACKAGES": "tests/rtl/test_assertions.py",
    **dict.fromkeys(
        ("ENCODERS", "LINES", "KEYS", "ANSWER", "REST", "port_name"),
        "sim/bench/drive/axis/motor_file.py",
    ),
    "axis_check": "nios_sw/ethercat/axis.c",
    "application_written": "nios_sw/ethercat/application.c",
    "WANTED": "tests/ethercat/test_dictionary.py",
    "AREAS": "scripts/goals.py",
    **dict.fromkeys(
        ("at_most", "at_least", "exactly", "depth", "not_measured"), "sim/report/goals.py"
    ),
    "Page": "scripts/measured_pages.py",
}


@cache
def known() -> frozenset[str]:
    """Files of the repository and their folders."""
    files = output("git", "ls-files", "--cached", "--others", "--exclude-standard", cwd=ROOT)
    found = set(files.splitlines())
    for file in files.splitlines():
        parts = file.split("/")
        found |= {"/".join(parts[:n]) for n in range(1, len(parts))}
    return frozenset(found)


def named(text: str) -> Iterator[str]:
    """Paths in the inline code of a page."""
    for code in INLINE.findall(BLOCK.sub("", text)):
        yield from NAMED.findall(code)


def exists(path: str) -> bool:
    return path in known() or ("*" in path and bool(fnmatch.filter(known(), path)))


def missing(text: str) -> list[str]:
    return [path for path in named(text) if path not in MADE and not exists(path)]


@pytest.mark.parametrize("page", PAGES)
def test_page__paths_that_it_names__exist(page: str) -> None:
    assert not missing(PAGES[page])


def test_path__that_is_gone__is_found() -> None:
    text = "See `sim/laws/laws.py`, `sim/rooms/gone.py` and `tests/gone/*.toml`."
    assert missing(text) == ["sim/rooms/gone.py", "tests/gone/*.toml"]
    assert not missing("```\ncat sim/rooms/gone.py\n```\n")


@pytest.mark.parametrize("name", STEPS)
def test_steps__names__are_in_their_files(name: str) -> None:
    steps = PAGES["CONTRIBUTING.md"] + PAGES["docs/registers.md"]
    assert re.search(rf"`[^`]*\b{name}\b[^`]*`", steps)
    text = (ROOT / STEPS[name]).read_text(encoding="utf-8")
    assert re.search(rf"\b{name}\b", text)
