# SPDX-License-Identifier: Apache-2.0
"""Profiles of runs on the core: every cycle has a cause, every operation its place in each view."""

from __future__ import annotations

import random
import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.cli_as import main as asip_as
from asip_asm.gantt import gantt_page, lanes
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.konata import konata_log
from asip_asm.profile import CAUSE_COUNTERS, Profile, ProfileError, Trace, profile_run
from sim.core.backends import RtlBackend
from sim.debug.asip_run.__main__ import main as asip_run
from tests.asip.core_bench import CONFIGURATIONS
from tests.bench.konata import KonataReader

ROOT = Path(__file__).parents[2]
PROGRAMS = ("tracking_optimised", "tracking_as_printed")
SEED = 20261121

# Assembled in the order written: operands are waited for, the second sine waits for the unit, moves
# after the load meet its result at bank C's port, and the loop is fetched again.
CAUSES = """\
.program "causes"
.input x
.data  table = 1.0
.output F, safe = 0.0
        mov i, 2.0
        fsin s, x
        fsin t, x
again:  ld   p, table
        mov  q, x
        mov  r, x
        mov  v, x
        fadd h, p, q
        fadd h, h, r
        fadd h, h, v
        fsub j, i, 1.0
        mov  i, j
        bnz  j, again
        fadd u, s, t
        mov  F, u
        halt
"""


def core_run(image: Image, inputs: dict[str, int]) -> Trace:
    """One traced run on the core; inputs that are not given are 0."""
    core = RtlBackend(trace=True)
    core.load(image)
    core.clear()
    words = {entry.name: inputs.get(entry.name, 0) for entry in image.inputs}
    data = np.array([list(words.values())], dtype=np.uint32)
    assert core.run(list(words), data, []).fault is None
    return core.observed().trace


def bits(value: float) -> int:
    """Word of a single float."""
    return int(np.float32(value).view(np.uint32))


TRACKING_INPUTS = {"z": bits(0.6)} | dict.fromkeys(("count1", "count2", "count3"), 2_600_000)


def tracking(name: str, configuration: str) -> tuple[Image, Trace]:
    image = assemble(ROOT / f"asip_asm/programs/{name}.s", configuration=configuration)
    return image, core_run(image, TRACKING_INPUTS)


def causes_program(folder: Path, configuration: str) -> tuple[Image, Trace]:
    path = folder / "causes.s"
    path.write_text(CAUSES)
    image = assemble(path, configuration=configuration, optimise=False)
    return image, core_run(image, {"x": bits(0.25)})


@pytest.fixture(
    scope="module", params=[(n, c) for n in (*PROGRAMS, "causes") for c in CONFIGURATIONS]
)
def profiled(request, tmp_path_factory) -> tuple[Image, Trace, Profile]:
    """A program of the list in a configuration, run once."""
    name, configuration = request.param
    if name == "causes":
        image, trace = causes_program(tmp_path_factory.mktemp("profile"), configuration)
    else:
        image, trace = tracking(name, configuration)
    return image, trace, profile_run(image, trace)


# ---------------------------------------------------------------------- profile


def test_causes__any_program__add_up_to_the_cycles_of_the_core(profiled):
    _, trace, profile = profiled
    assert sum(profile.causes.values()) == profile.cycles == trace.counters["CYCLES"]
    for cause, counter in CAUSE_COUNTERS.items():
        assert profile.causes[cause] == trace.counters[counter]


def test_causes__program_with_every_kind_of_wait__all_are_seen(tmp_path):
    image, trace = causes_program(tmp_path, "small")
    causes = profile_run(image, trace).causes
    assert all(causes.values()), causes


def test_cycles__any_program__each_has_an_issue_or_a_wait_and_only_one(profiled):
    _, _, profile = profiled
    seen = Counter(cycle for cycle, _ in profile.issues)
    for wait in profile.waits:
        seen.update(range(wait.cycle, wait.cycle + wait.cycles))
    assert seen == Counter(range(profile.cycles))


def test_executions__any_program__one_per_operation_issued_and_all_writes_of_the_core(profiled):
    image, trace, profile = profiled
    issued = Counter(address for _, address in trace.issues)
    places = {(a, e.slot): n for a, n in issued.items() for e in image.sources[a] if e.op != "nop"}
    assert Counter((e.address, e.slot) for e in profile.executions) == places
    origin = trace.issues[0][0]
    writes = Counter((c - origin, f"{bank.lower()}{i}", word) for c, bank, i, word in trace.writes)
    results = [e for e in profile.executions if e.target is not None]
    assert Counter((e.end - 1, e.target, e.word) for e in results) == writes


def test_producers__any_program__have_written_when_the_reader_reads(profiled):
    _, _, profile = profiled
    pairs = [(profile.executions[p], e) for e in profile.executions for p in e.producers]
    assert pairs
    # The bypass hands a result over in the last cycle before E1, the cycle of the write.
    assert all(producer.end - 1 <= reader.start - 1 for producer, reader in pairs)


def test_units__any_program__count_operations_and_never_exceed_the_cycles(profiled):
    _, _, profile = profiled
    assert sum(use.operations for use in profile.units.values()) == len(profile.executions)
    assert all(use.operations <= use.busy <= profile.cycles for use in profile.units.values())


def test_text__any_program__names_every_cause_and_unit(profiled):
    _, _, profile = profiled
    rows = [row.split()[0] for row in profile.render().splitlines()[1:]]
    assert {name.split()[0] for name in (*profile.causes, *profile.units)} <= set(rows)


def test_counters_of_another_run__profile__is_refused_with_both_counts(tmp_path):
    image, trace = causes_program(tmp_path, "fast")
    wrong = trace.counters | {"STALL_OPERAND": trace.counters["STALL_OPERAND"] + 1}
    message = (
        rf"'operand' in the trace, the core counted {wrong['STALL_OPERAND']} \(STALL_OPERAND\)"
    )
    with pytest.raises(ProfileError, match=message):
        profile_run(image, replace(trace, counters=wrong))


def test_write_missing_or_late__profile__is_refused(tmp_path):
    image, trace = causes_program(tmp_path, "fast")
    choose = random.Random(SEED)
    place = choose.randrange(len(trace.writes))
    cycle, *write = trace.writes[place]
    for found in ([], [(cycle + 1, *write)]):
        writes = [*trace.writes[:place], *found, *trace.writes[place + 1 :]]
        with pytest.raises(ProfileError, match="no write of"):
            profile_run(image, replace(trace, writes=writes))


# ---------------------------------------------------------------------- Konata


def test_konata__any_program__obeys_the_format_and_retires_everything_in_order(profiled):
    _, _, profile = profiled
    log = KonataReader(konata_log(profile))
    numbers = {execution.number for execution in profile.executions}
    assert set(log.retired) == set(log.labels) == numbers
    assert log.orders == list(range(len(numbers)))


def test_konata__any_program__stages_join_and_the_last_is_the_traced_write(profiled):
    image, trace, profile = profiled
    log = KonataReader(konata_log(profile))
    for number, stages in log.stages.items():
        assert [end for *_, end in stages[:-1]] == [start for _, start, _ in stages[1:]]
        assert log.retired[number] == stages[-1][2]
        assert re.fullmatch(r"D( R\d)+( E\d+)+( W)?", " ".join(name for name, *_ in stages))
    origin = trace.issues[0][0]
    written = Counter(cycle - origin for cycle, *_ in trace.writes)
    last = [stages[-1] for stages in log.stages.values() if stages[-1][0] == "W"]
    assert Counter(start for _, start, _ in last) == written
    issued = Counter(
        {c - origin: sum(e.op != "nop" for e in image.sources[a]) for c, a in trace.issues}
    )
    assert Counter(stages[0][2] - 1 for stages in log.stages.values()) == +issued


# ---------------------------------------------------------------------- chart


class Chart(HTMLParser):
    """Bars, stalls and outside references of a page; asserts that tags are balanced."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.stack: list[str] = []
        self.bars: list[dict[str, str]] = []
        self.stalls: list[dict[str, str]] = []
        self.outside: list[str] = []
        self.feed(text)
        self.close()
        assert not self.stack

    def handle_starttag(self, tag, attrs):
        if tag != "meta":
            self.stack.append(tag)
        values = dict(attrs)
        self.outside += [name for name in values if name in ("src", "href")]
        kind = (values.get("class") or "").split(" ")[0]
        if kind == "bar":
            self.bars.append(values)
        elif kind == "stall":
            self.stalls.append(values)

    def handle_endtag(self, tag):
        assert self.stack.pop() == tag


def pixels(values: dict[str, str], name: str) -> int:
    found = re.search(rf"(?:^|;){name}:(\d+)px", values["style"])
    assert found
    return int(found[1])


def test_chart__any_program__every_operation_once_from_e1_to_its_write(profiled):
    _, _, profile = profiled
    page = gantt_page(profile)
    chart = Chart(page)
    assert sorted(int(bar["data-n"]) for bar in chart.bars) == list(range(len(profile.executions)))
    cycle = pixels(chart.stalls[0], "width") / profile.waits[0].cycles
    for bar in chart.bars:
        execution = profile.executions[int(bar["data-n"])]
        assert execution.text in bar["title"] and execution.where in bar["title"]
        assert not execution.equation or f"equation ({execution.equation})" in bar["title"]
        left, width = pixels(bar, "left") / cycle, pixels(bar, "width") / cycle
        assert (left, left + width) == (execution.start, execution.end)
    stalled = sum(pixels(stall, "width") for stall in chart.stalls) / cycle
    assert stalled == profile.cycles - len(profile.issues)
    assert not chart.outside and "://" not in page


def test_lanes__any_program__no_two_bars_overlap(profiled):
    _, _, profile = profiled
    for unit in profile.units:
        for lane in lanes(e for e in profile.executions if e.unit == unit):
            assert all(a.end <= b.start for a, b in zip(lane, lane[1:], strict=False))


def test_units__of_each_configuration__are_those_of_its_slots():
    for configuration in CONFIGURATIONS:
        image, trace = tracking(PROGRAMS[0], configuration)
        pipes = [name for name in profile_run(image, trace).units if name.startswith("pipe")]
        assert len(pipes) == default_isa().configurations[configuration].fma_pipes


# ---------------------------------------------------------------------- commands


def test_asip_run_profile__text_log_and_chart_are_those_of_the_run(configuration, tmp_path, capsys):
    image, trace = causes_program(tmp_path, configuration)
    image.save(tmp_path / "causes.asip.json")
    log, page = tmp_path / "views/causes.konata", tmp_path / "views/causes.html"
    arguments = [tmp_path / "causes.asip.json", "--set", "x=0.25", "--konata", log, "--gantt", page]
    assert asip_run([str(argument) for argument in arguments]) == 0
    profile = profile_run(image, trace)
    assert capsys.readouterr().out.endswith(profile.render())
    assert log.read_text() == konata_log(profile)
    assert page.read_text() == gantt_page(profile)


def test_asip_run_profile__table_of_runs__goes_to_standard_error(tmp_path, capsys):
    causes_program(tmp_path, "fast")
    (tmp_path / "in.csv").write_text("x\n0.5\n0.25\n")
    arguments = [tmp_path / "causes.s", "--inputs", tmp_path / "in.csv", "--profile"]
    assert asip_run([str(argument) for argument in arguments]) == 0
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 3 and err.startswith("profile of causes (fast): ")


def test_asip_run_profile__on_the_model__is_a_wrong_command_line(tmp_path, capsys):
    causes_program(tmp_path, "fast")
    assert asip_run([str(tmp_path / "causes.s"), "--iss", "--profile"]) == 2
    assert "no clock cycles to profile; use --rtl" in capsys.readouterr().err


@pytest.mark.parametrize("level", ["-O", "-O0"])
def test_asip_as_report__says_the_cycles_that_the_core_takes(
    level, configuration, tmp_path, capsys
):
    source = ROOT / "asip_asm/programs/tracking_optimised.s"
    output = tmp_path / "t.asip.json"
    arguments = [str(source), level, "--config", configuration, "-o", str(output), "--report"]
    assert asip_as(arguments) == 0
    head, *report = capsys.readouterr().out.splitlines()
    assert head.startswith(str(output)) and report[0] == f"tracking, optimised ({configuration})"
    rows = {row[:21].strip(): row[21:] for row in report[1:]}
    assert set(rows) > {"cycles", "lower bounds", "occupancy", "stalled cycles", "registers in use"}
    trace = core_run(Image.load(output), TRACKING_INPUTS)
    assert int(rows["cycles"].split(",")[0]) == trace.counters["CYCLES"]
    stalls = dict(text.split() for text in rows["stalled cycles"].split(", "))
    counted = {"STALL_OPERAND": int(stalls["operand"]) + int(stalls["waw"])}
    counted |= {"STALL_UNIT": int(stalls["unit"]), "STALL_PORT": int(stalls["port"])}
    assert counted == {name: trace.counters[name] for name in counted}
