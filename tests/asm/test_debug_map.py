# SPDX-License-Identifier: Apache-2.0
"""Debug maps: what they say of registers, against an interpreter of the program as it is written.

The interpreter gives every operation a result of its own, so a register that holds another value
than the map says is seen.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from asip_asm.assemble import build_program, encode, parse_program
from asip_asm.cli_as import main as asip_as
from asip_asm.debug_map import DebugMap, DebugMapError, Finder, map_path
from asip_asm.debug_values import debug_map
from asip_asm.image import Image
from asip_asm.ir import Program, Virtual, register_name
from asip_asm.isa import default_isa
from asip_asm.machine import load_machine
from asip_asm.project import ROOT

from .interpret import run_bundles, run_written
from .workload import arrange, loop_program, random_program

PROGRAMS = ROOT / "asip_asm/programs"
LEG = Path(__file__).with_name("ok_leg_length.s")


def check(
    program: Program, words: int, configuration: str, written: dict[Virtual, int]
) -> tuple[int, int]:
    """Compare every value that the map says a register holds, and what it says of those that are
    overwritten; returns how many of both there were.
    """
    machine = load_machine(configuration)
    found = debug_map(program, machine, encode(program, machine, "test"))
    finder = Finder(found)
    compared = overwritten = 0

    def watch(position: int, registers: dict, memory: list) -> None:
        nonlocal compared, overwritten
        named = {register_name(r): word for r, word in registers.items()}
        for value in found.values:
            symbol = Virtual(value.name, value.version)
            if value.version < 0 or value.place.startswith("o") or position % 3:
                continue
            where = finder.where(value, position)
            if where.place:
                assert not where.text.startswith("only on some")
                data = where.place.startswith("d")
                held = memory[int(where.place[1:])] if data else named[where.place]
                assert held == written[symbol], (position, value, where)
                compared += 1
            else:
                assert where.text, value
                assert ("not" in where.text) == (position <= value.first)
                if where.text.startswith("overwritten"):
                    overwritten += 1
                    bundle, name = int(where.text.split()[3]), where.text.split()[-1]
                    takers = [v for v in found.named(name) if v.place == value.place]
                    assert bundle in [write.bundle for v in takers for write in v.writes]
                    assert value.held[-1][1] == bundle

    run_bundles(program, words, watch)
    return compared, overwritten


@pytest.mark.quick("0-fast-True", "*-small-False")
@pytest.mark.parametrize("optimise", [True, False])
@pytest.mark.parametrize("configuration", ["fast", "small"])
@pytest.mark.parametrize("seed", range(2))
def test_registers_of_random_programs(seed, configuration, optimise):
    program = random_program(seed, 500, configuration)
    written: dict = {}
    words = len(program.data)
    run_written(program, written)
    arrange(program, load_machine(configuration), in_order=not optimise, effort=4)
    held, overwritten = check(program, words, configuration, written)
    assert held > 2000 and overwritten > 100


@pytest.mark.parametrize("name", ["tracking_optimised", "tracking_as_printed", "tracking_observer"])
def test_every_value_of_the_law_at_every_bundle(name):
    written: dict = {}
    run_written(parse_program(PROGRAMS / f"{name}.s"), written)
    program, _ = build_program(PROGRAMS / f"{name}.s", optimise=True)
    held, overwritten = check(program, len(program.data), "fast", written)
    assert held > 2000 and overwritten > 100


def test_words_of_a_value_that_is_not_there(tmp_path):
    finder, image = assembled(tmp_path, LEG.read_text())
    first = next(v for v in finder.map.values if v.writes and v.place[0] == "a")
    bundle = first.first
    assert finder.where(first, bundle).text == (
        f"not yet computed at bundle {bundle}; bundle {bundle} computes it"
    )
    assert finder.where(first, bundle + 1).place == first.place
    assert finder.find("nonsense", 0) is None
    assert finder.map.image == image.to_json()["checksum"]


def test_overwritten_value_names_bundle_and_taker(tmp_path):
    chain = "\n".join(f"        fadd x{i}, x{i - 1}, x" for i in range(1, 140))
    text = f""".input x
.output y, safe = 0.0
        fmul x0, x, x
{chain}
        mov y, x139
        halt
"""
    finder, _ = assembled(tmp_path, text)
    end = finder.map.bundles
    gone = finder.find("x0", end)
    assert gone.place == "" and gone.text.startswith("overwritten at bundle ")
    words = gone.text.split()
    taker = finder.map.named(words[-1])[0]
    assert taker.place == gone.value.place and taker.first == int(words[3])
    assert finder.find("x139", end).place


def test_bundle_that_finds_a_value_written(tmp_path):
    text = """.input x, z
.output y, safe = 0.0
        fsqrt r, x
        fadd  a, z, x
        fadd  b, a, z
        fmul  c, b, r
        mov   y, c
        halt
"""
    finder, _ = assembled(tmp_path, text)
    root = finder.map.named("r")[0]
    lands = root.writes[0].lands
    reader = finder.map.named("c")[0]
    assert root.first == 0 and lands == reader.first > 1


def test_values_on_some_ways_only():
    program = loop_program()
    machine = load_machine("fast")
    arrange(program, machine, effort=40)
    found = debug_map(program, machine, encode(program, machine, "test"))
    finder = Finder(found)
    other = found.named("r")[0]
    assert len(other.writes) == 3 and other.version == -1
    last = finder.find("r", found.bundles)
    assert last.place == other.place
    temporary = found.named("t")[0]
    assert finder.where(temporary, found.bundles).place == temporary.place
    assert found.follow  # branches and the end of the run


def test_macro_calls_and_equations_are_kept():
    program, machine = build_program(PROGRAMS / "tracking_as_printed.s")
    found = debug_map(program, machine, encode(program, machine, "law"))
    assert any("length at " in call for calls in found.calls.values() for call in calls)
    assert {value.equation for value in found.values} >= {"7", "8", "28"}


def test_file_beside_the_image_and_what_is_refused(tmp_path, capsys):
    image_path = tmp_path / "leg.asip.json"
    assert asip_as([str(LEG), "-o", str(image_path)]) == 0
    path = map_path(image_path)
    assert path.name == "leg.asip.map.json"
    image = Image.load(image_path)
    found = DebugMap.load(path, image)
    assert len(next(iter(found.files.values()))) == 64
    assert asip_as([str(LEG), "-O0", "-o", str(image_path)]) == 0
    capsys.readouterr()
    again = Image.load(image_path)
    path_of_old = tmp_path / "old.map.json"
    path_of_old.write_text(found.dumps())
    for text, message in [
        (path_of_old.read_text(), "another program"),
        ("{", "not a JSON file"),
        ("{}", "not a debug map"),
        (found.dumps().replace('"version": 1,', '"version": 9,', 1), "map version 9"),
        (found.dumps().replace('"held"', '"hold"', 1), "damaged"),
    ]:
        path_of_old.write_text(text)
        with pytest.raises(DebugMapError, match=message):
            DebugMap.load(path_of_old, again)


def test_largest_program_has_a_bounded_map(tmp_path):
    count = default_isa().program_bundles - 1
    chain = "\n".join(f"        fadd x{i}, x{i - 1}, x" for i in range(1, count))
    text = f".input x\n.output y, safe = 0.0\n        fmul x0, x, x\n{chain}\n"
    finder, _ = assembled(tmp_path, text + f"        mov y, x{count - 1}\n        halt\n")
    assert len(finder.map.dumps()) < 1 << 20


def assembled(tmp_path: Path, text: str) -> tuple[Finder, Image]:
    source = tmp_path / "program.s"
    source.write_text(text)
    program, machine = build_program(source)
    image = encode(program, machine, source)
    return Finder(debug_map(program, machine, image)), image
