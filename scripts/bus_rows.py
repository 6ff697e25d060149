# SPDX-License-Identifier: Apache-2.0
"""Producers of the rows of `microtick bus`: each measures one thing and gives its rows."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from asip_asm.project import BUILD, ROOT
from scripts.motion_size import area, speed
from sim.bench.motion.sizes import MEASURE
from sim.bus import ethercrab_master, locked_run
from sim.bus.clocks import synchronise
from sim.bus.coe.dictionary import load
from sim.bus.device import CYCLE_CLOCKS
from sim.bus.line import Line, library
from sim.bus.measure import CLOCK_PS, forwarding, keeps_cycle
from sim.bus.tap import in_namespace
from sim.report import cache
from sim.report.goals import Goal, at_least, at_most, depth, not_measured
from sim.robot.parameters import Robot
from sim.rtl.sources import sources_of
from tests.ethercat import sequences
from tests.ethercat import stops as random_stops
from tests.ethercat.test_cia402 import random_controlwords, transitions_one_by_one
from tests.ethercat.test_frames import run_chains

FORWARDING_NS, NEAR_NS, LUTS, MHZ, TOOL_UM = 600, 20, 7500, 100, 10
PERIODS_NS = (100_000, 31_250)
MASTER_CYCLES = {False: 200, True: 100_000}
PATH_TICKS = {False: 3_001, True: None}
CHAINS = {False: 200, True: 100_000}
CONTROLWORDS, PASSES = 100_000, 200
STOPS = {False: 300, True: random_stops.CAMPAIGN}
SEQUENCES = {False: 2_000, True: sequences.CAMPAIGN}
CLOCK_CYCLES = 10_000
LOCKED = {False: 40, True: 4_000}  # cycles at each phase
PPM = (0.0, 100.0, -100.0)
CABLE_PS = 500_000
SEEDS = (1, 2, 3)
TOP, DEVICE = "ethercat_slave", "ethercat_nios"
KICKCAT_CYCLES = 200
ETHERCRAB_CYCLES = 10_000
SCAPY_CHAINS = 20
CACHED = BUILD / "bus"
# What a result depends on: everything that could, rather than what does. The slaves and their
# masters: their benches, the dictionary and what is made of it.
BENCH = [f"sim/bus/*.{kind}" for kind in ("py", "cpp", "h")]
BENCH += [
    "sim/bus/coe/*.py",
    "sim/bus/gen/*.py",
    "nios_sw/ethercat/dictionary.toml",
    "sim/rtl/*.h",
    "sim/rtl/*.py",
]
# The device besides its RTL: its program.
PROGRAM = ["nios_sw/images/ethercat*.elf", "nios_sw/system.toml"]
# The robot that it drives: its parameters, plant, path, and the law on the ASIP.
ROBOT = [
    "sim/robot.toml",
    "sim/robot/*.py",
    "sim/bench/run/*.py",
    "sim/core/*.py",
    "sim/paths/agh.ngc",
]
ROBOT += [
    "sim/motion/gcode/**/*.py",
    "sim/motion/trajectory/*.py",
    "asip_asm/*.py",
    "asip_asm/*.toml",
]
ROBOT += ["asip_asm/programs/tracking*", "sim/rtl/asip_harness.cpp"]
SYNTHESIS = [path.relative_to(ROOT).as_posix() for path in MEASURE]
SYNTHESIS += ["sim/bench/motion/sizes.py"]  # FLOWS
HOURS = 12 * 3600
FULL = "microtick bus --full"

Report = Callable[[str], None]


@dataclass
class Order:
    """What to do. curves: of the path, once it was run."""

    full: bool
    capture: Path
    curves: Path | None = None


def counted(name: str, right: int, made: int, target: int) -> Goal:
    """Cycles that were right, of those made; if all were, fewer than the target are a sample."""
    goal = at_least(name, right, target, "cycles")
    return depth(name, right, target, "cycles", FULL) if right == made else goal


def fingerprint(top: str, files: Sequence[str], *choices: object) -> str:
    """Hash of the RTL of a top, of other files and of choices. files: patterns below the root.

    Raises FileNotFoundError for a pattern without a file.
    """
    paths = list(sources_of(top))
    for name in files:
        if not (found := sorted(ROOT.glob(name))):
            raise FileNotFoundError(
                f"{name}: no such file; mend the patterns in scripts/bus_rows.py"
            )
        paths += found
    return cache.fingerprint(paths, *choices)


def rtl_of(top: str) -> list[str]:
    """Names of its sources."""
    return [path.relative_to(ROOT).as_posix() for path in sources_of(top)]


def versions(*packages: str) -> list[str]:
    """Of what was installed."""
    return [f"{name} {version(name)}" for name in packages]


def cached(name: str, of: str, work: Callable[[], Any]) -> Any:
    """What `work` gave for the fingerprint `of`, in an earlier run or now."""
    return cache.result_of(cache.Entry(CACHED / f"{name}.json", of), work)


def run(module: str, options: Sequence[str]) -> dict[str, Any]:
    """Report of a program in a network namespace. Raises RuntimeError with what it printed."""
    done = in_namespace(module, options, timeout=HOURS)
    if done.returncode and not done.stdout:
        raise RuntimeError((done.stderr.strip() or module).splitlines()[-1])
    return json.loads(done.stdout.splitlines()[-1])


def timing(order: Order, report: Report) -> Iterator[Goal]:
    """Forwarding and cycles, counted in clocks."""
    report("forwarding, all phases of the sender's clock")
    found = forwarding()
    worst = found.most * CLOCK_PS // 1000
    yield at_most("forwarding port to port, longest", worst, FORWARDING_NS, "ns")
    yield at_most("forwarding, between frames", found.spread, 0, "clocks")
    device = load()
    for period in PERIODS_NS:
        report(f"cycles of {period / 1000} us with the process data of five axes")
        wrong, late = keeps_cycle(device, period, 200)
        name = (
            "process data of five axes, copied back by the test bench, every "
            f"{period / 1000:g} us: cycles of 200 with a wrong counter or late inputs"
        )
        yield at_most(name, wrong + late, 0, "cycles")


def device(order: Order, report: Report) -> Iterator[Goal]:
    """Control passes of the whole device, its program on the Nios II core."""
    report("control passes of the whole device")
    options = ["--step", "0", "--cycles", str(PASSES)]
    of = fingerprint(DEVICE, [*BENCH, *PROGRAM], *options, *versions("pysoem"))
    found = cached("device", of, lambda: run("sim.bus.device_run", options))
    for passes in found["passes"]:
        name = (
            f"whole device, five axes in CSP, a frame every {passes['period_us']} us at every "
            "phase: longest control pass"
        )
        goal = at_most(name, passes["longest"], CYCLE_CLOCKS, "cycles")
        yield goal if passes["powered"] else replace(goal, met=False, note="drives without power")


def locked(order: Order, report: Report) -> Iterator[Goal]:
    """The whole device with process data each 62.5 us, locked to SYNC0."""
    report("process data each 62.5 us, locked to SYNC0")
    options = ["--cycles", str(LOCKED[order.full])]
    of = fingerprint(DEVICE, [*BENCH, *PROGRAM], *options, *versions("pysoem"))
    found = cached(f"locked_{options[1]}", of, lambda: run("sim.bus.locked_run", options))
    cycles, target = found["cycles"], LOCKED[True] * locked_run.PHASES
    about = "process data of five axes in CSP each 62.5 us, locked to SYNC0"
    yield counted(
        f"{about}: cycles without a wrong counter", cycles - found["wrong"], cycles, target
    )
    late = max(found["late"], found["exceeded"])
    yield at_most(f"{about}: late control passes", late, 0, "passes")
    yield at_most(f"{about}: longest control pass", found["longest"], found["limit"], "cycles")
    yield at_most(f"{about}: SYNC0 to the next tick", found["apart"], 1, "clocks")


def masters(order: Order, report: Report) -> Iterator[Goal]:
    """pysoem with one slave, three in a line and in a ring, KickCAT with three, scapy."""
    library()
    working = 0
    for master, slaves, cycles, target in (
        ("pysoem", 1, MASTER_CYCLES[order.full], MASTER_CYCLES[True]),
        ("pysoem", 3, MASTER_CYCLES[order.full], MASTER_CYCLES[True]),
        ("kickcat", 3, KICKCAT_CYCLES, KICKCAT_CYCLES),
    ):
        report(f"{master}, {slaves} slave(s), {cycles} cycles in OP")
        options = ["--master", master, "--slaves", str(slaves), "--cycles", str(cycles)]
        of = fingerprint(TOP, BENCH, slaves, cycles, *versions(master))
        found = cached(
            f"{master}_{slaves}_{cycles}",
            of,
            partial(run, "sim.bus.master_loop", options),
        )
        right = cycles - found["wrong_counters"] if found["state"] == "OP" else 0
        working += slaves == 3 and right == cycles
        name = f"{master}, {slaves} slave(s): cycles in OP without a wrong counter"
        yield counted(name, right, cycles, target)
    cycles = MASTER_CYCLES[order.full]
    report(f"pysoem at both ends of a ring of three, a cable pulled, {cycles} cycles in OP")
    options = ["--slaves", "3", "--cycles", str(cycles), "--cable", "1"]
    of = fingerprint(TOP, BENCH, options, *versions("pysoem"))
    found = cached(f"ring_{cycles}", of, lambda: run("sim.bus.redundant", options))
    right = cycles - sum(found["wrong_counters"].values()) if found["state"] == "OP" else 0
    name = (
        "pysoem, ring of three with redundancy, a third of the cycles with a cable pulled: cycles "
        "in OP without a wrong counter"
    )
    yield counted(name, right, cycles, MASTER_CYCLES[True])
    yield from ethercrab(order, report)
    report("scapy")
    run_chains(SCAPY_CHAINS, 2)
    yield at_least("unrelated masters that work", working + 1, 3, "masters")


def ethercrab(order: Order, report: Report) -> Iterator[Goal]:
    """A third master, in Rust; it is compiled here, which a quick run leaves out."""
    cycles = ETHERCRAB_CYCLES
    for slaves in (1, 3):
        name = f"ethercrab, {slaves} slave(s): cycles in OP without a wrong counter"
        if not order.full:
            yield not_measured(name, f">= {cycles}", "cycles", FULL)
            continue
        report(f"ethercrab, {slaves} slave(s), {cycles} cycles in OP")
        try:
            ethercrab_master.build()
        except RuntimeError as error:
            yield not_measured(name, f">= {cycles}", "cycles", str(error))
            continue
        options = ["--master", "ethercrab", "--slaves", str(slaves), "--cycles", str(cycles)]
        files = ["sim/bus/ethercrab/Cargo.lock", "sim/bus/ethercrab/src/main.rs"]
        of = fingerprint(TOP, [*BENCH, *files], slaves, cycles)
        found = cached(
            f"ethercrab_{slaves}_{cycles}",
            of,
            partial(run, "sim.bus.master_loop", options),
        )
        right = cycles - found["wrong_counters"] if found["state"] == "OP" else 0
        yield at_least(name, right, cycles, "cycles")


def clocks(order: Order, report: Report) -> Iterator[Goal]:
    """System times of three slaves; only the full run is long enough to count."""
    name = f"system times apart, three slaves 100 ppm apart, {CLOCK_CYCLES} cycles"
    if not order.full:
        yield not_measured(name, f"<= {NEAR_NS}", "ns", FULL)
        return
    report(f"distributed clocks, {CLOCK_CYCLES} cycles")

    def worst() -> int:
        with Line(PPM, cable_ps=CABLE_PS) as line:
            return synchronise(line, CLOCK_CYCLES).worst

    of = fingerprint(TOP, BENCH, PPM, CABLE_PS, CLOCK_CYCLES)
    yield at_most(name, cached("clocks", of, worst), NEAR_NS, "ns")


def path(order: Order, report: Report) -> Iterator[Goal]:
    """A-G-H over the bus, every clock of slave, processor and ASIP."""
    ticks = PATH_TICKS[order.full]
    seconds = "whole path" if ticks is None else f"first {(ticks - 1) * Robot.load(None).T_s:g} s"
    report(f"A-G-H over the bus, {seconds}")
    name = "whole" if order.full else "slice"
    CACHED.mkdir(parents=True, exist_ok=True)
    order.curves = CACHED / f"path_{name}.npz"
    options = ["--capture", str(order.capture), "--curves", str(order.curves)]
    options += [] if ticks is None else ["--ticks", str(ticks)]
    of = fingerprint(
        DEVICE, [*BENCH, *PROGRAM, *ROBOT, *rtl_of("asip")], ticks, *versions("pysoem")
    )
    if not (order.capture.exists() and order.curves.exists()):
        (CACHED / f"path_{name}.json").unlink(missing_ok=True)
    found = cached(f"path_{name}", of, lambda: run("sim.bus.path_run", options))
    about = f"A-G-H over the bus, CSP at 1 kHz, {seconds}"
    yield at_most(f"{about}, tool error", 1e6 * found["tool"], TOOL_UM, "um")
    yield at_most(f"{about}, following-error faults", found["following_errors"], 0, "faults")
    lost = found["wrong_counters"] + len(found["faults"])
    yield at_most(f"{about}, wrong counters and other faults", lost, 0, "cycles")


def chains(order: Order, report: Report) -> Iterator[Goal]:
    """Datagrams at random against the memory model."""
    count = CHAINS[order.full]
    report(f"{count} chains of datagrams at random")

    def agree() -> int:
        run_chains(count, 1)
        return count

    files = [f"tests/ethercat/{name}" for name in ("frames.py", "test_frames.py")]
    of = fingerprint(TOP, [*BENCH, *files], count, *versions("scapy"))
    found = cached(f"chains_{count}", of, agree)
    name = "random chains that agree with the memory model"
    yield depth(name, found, CHAINS[True], "chains", FULL)


def drives(order: Order, report: Report) -> Iterator[Goal]:
    """CiA 402: controlwords against python-canopen's masks and table."""
    report(f"{CONTROLWORDS} controlwords at random")
    random_controlwords(CONTROLWORDS, 2)
    name = "CiA 402, controlwords that agree with python-canopen's table"
    yield at_least(name, CONTROLWORDS, CONTROLWORDS, "controlwords")
    seen = transitions_one_by_one()
    yield at_least("CiA 402, transitions seen, of 16", len(seen), 16, "transitions")


def stops(order: Order, report: Report) -> Iterator[Goal]:
    """Stops at random, in any mode, by faults, commands and the end of the frames."""
    count = STOPS[order.full]
    report(f"{count} stops at random")
    found = [stop for _, stop in random_stops.campaign(1, count)]
    name = "random stops in all modes and cycles"
    yield depth(name, count, random_stops.CAMPAIGN, "stops", FULL)
    ratio = max(stop.ratio for stop in found)
    about = "highest speed after a stop over the measured speed at it, noise aside"
    yield at_most(about, round(ratio, 4), 1, "1")
    longer = [stop.distance - stop.shortest for stop in found if stop.distance > stop.shortest]
    about = "stops longer than v^2/2a and a tick"
    note = f"the longest by {max(longer, default=0.0):.2f} increments of the encoder"
    yield at_most(about, len(longer), 0, "stops", note)
    about = f"{about} by more than an increment of the encoder"
    yield at_most(about, sum(stop.too_far for stop in found), 0, "stops")


def objects(order: Order, report: Report) -> Iterator[Goal]:
    """Writes to the objects at random, against the rules between objects."""
    count = SEQUENCES[order.full]
    report(f"{count} sequences of writes at random")
    wrong = sum(bool(found) for _, found in sequences.campaign(1, count))
    name = "random sequences of writes to objects"
    yield depth(name, count, sequences.CAMPAIGN, "sequences", FULL)
    name = "sequences that end in objects that do not go together"
    yield at_most(name, wrong, 0, "sequences")


def size(order: Order, report: Report) -> Iterator[Goal]:
    """Area, and in a full run the routed clock, on ECP5."""
    report("area on ECP5")
    luts = cached("area", fingerprint(TOP, SYNTHESIS), lambda: area(TOP, {})["luts"])
    yield at_most("slave controller on ECP5, area", luts, LUTS, "LUT4")
    name = "slave controller on ECP5, clock, median of three seeds"
    if not order.full:
        yield not_measured(name, f">= {MHZ}", "MHz", FULL)
        return
    report("clock on ECP5")
    mhz = cached(
        "clock",
        fingerprint(TOP, SYNTHESIS, SEEDS),
        lambda: speed(TOP, {}, TOP, SEEDS)["mhz_median"],
    )
    yield at_least(name, mhz, MHZ, "MHz")


PRODUCERS: dict[str, Callable[[Order, Report], Iterator[Goal]]] = {
    "timing": timing,
    "device": device,
    "locked": locked,
    "masters": masters,
    "clocks": clocks,
    "path": path,
    "drives": drives,
    "chains": chains,
    "stops": stops,
    "objects": objects,
    "size": size,
}
