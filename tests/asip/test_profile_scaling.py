# SPDX-License-Identifier: Apache-2.0
"""scripts/scaling.py: reduced tracking laws compute what the whole law computes for their axes."""

from __future__ import annotations

import functools

import pytest

from asip_asm.allocate import allocate_registers
from asip_asm.assemble import assemble, encode
from asip_asm.image import Image
from asip_asm.machine import load_machine
from asip_asm.schedule import schedule_program
from scripts.scaling import SOURCE, axis, main, measure, reduced, robots, run_tick


def reduced_image(axes: tuple[int, ...], configuration: str) -> Image:
    program = reduced(axes, configuration)
    machine = load_machine(configuration)
    schedule_program(program, machine)
    allocate_registers(program, machine)
    return encode(program, machine, SOURCE)


@functools.cache
def whole(configuration: str) -> tuple[int, int, dict[str, int]]:
    return run_tick(assemble(SOURCE, configuration=configuration))


def test_all_axes__is_the_whole_law(configuration):
    full = assemble(SOURCE, configuration=configuration)
    assert reduced_image((1, 2, 3, 4, 5), configuration).bundles == full.bundles


def test_tick__no_two_outputs_agree__so_that_a_mistaken_axis_shows():
    _, _, words = whole("fast")
    assert len(words) == len(set(words.values())) == 5


@pytest.mark.parametrize("axes", [(1,), (5,), (2, 4), (5, 4, 3)])
def test_some_axes__their_outputs_have_the_bits_of_the_whole_law(axes, configuration):
    cycles, _, words = whole(configuration)
    fewer_cycles, _, fewer = run_tick(reduced_image(axes, configuration))
    assert {axis(name) for name in fewer} == set(axes)
    assert fewer == {name: words[name] for name in fewer}
    assert fewer_cycles < cycles


def test_two_robots_in_one_program__each_has_the_bits_of_the_law_alone():
    cycles, _, words = whole("fast")
    tick, both = measure(robots(2, "fast"))
    assert both == words | {f"{name}_robot2": word for name, word in words.items()}
    assert tick.cycles > cycles


@pytest.mark.full
def test_scaling_page__measured_again__equal():
    assert main(["--check"]) == 0
