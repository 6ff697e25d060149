# SPDX-License-Identifier: Apache-2.0
"""What the system does with its real programs if a core faults, is late, or gets a NaN.

Defined: no word that is not finite is handed over or put out. The last set-point is held with its
rates 0, or the safe outputs of the tracking program are out; nothing is started until clear.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sim.bench.dual.moves import Move, moves_of
from sim.bench.dual.system import RATES, TwoProcessors, program
from sim.core.controller import AsipController, ControllerFault
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import generate
from sim.motion.trajectory.program import set_points
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.rtl.asip_bus import CSR, FAULT_NAMES, STATUS
from sim.rtl.dual_rtl import MEASURED_SOURCE, REGMAP
from tests.dual.test_path import HOME, MOVES, QUICK, SHORT

NAN, INF = 0x7FC00000, 0x7F800000
NUMBERS = {"v0": 1, "vm": 2, "tr": 3, "tm": 4, "length": 5, "half_turn": 6}  # words of a record
NUMBERS |= {"start of x": 7, "end of z": 14, "direction of y": 18, "radius of x": 22}


@pytest.fixture(scope="module")
def path():
    return set_points(generate(parse_file(MOVES), QUICK), 200)


@pytest.fixture(scope="module")
def moves():
    return moves_of(generate(parse_file(MOVES), QUICK), QUICK)


class Run:
    """System and plant, period by period, whatever happens: counts seen, records."""

    def __init__(self, path, moves: list[Move]) -> None:
        self.controller = TwoProcessors(Robot.load(), moves, SHORT)
        self.system = self.controller.system
        self.plant = Plant(Robot.load(), HOME[:3], HOME[3:])
        self.seen = self.plant.counts()
        self.counts, self.records = [], []
        self.controller.prime(path.words()[0], self.seen)

    def go(self, periods: int) -> np.ndarray:
        for _ in range(periods):
            self.counts.append(self.seen)
            self.records.append(self.controller.periods([self.seen])[0])
            self.seen = self.plant.step(self.records[-1]["commands"].view(np.float32).tolist())
        return np.array(self.records[-periods:])

    def tool(self) -> np.ndarray:
        return np.array(self.plant.tool)

    def safe(self) -> list[float]:
        """Safe values of the tracking program's outputs."""
        outputs = self.controller.images["tracking"].outputs[:5]
        return [float(np.uint32(int(o.safe, 16)).view(np.float32)) for o in outputs]


def commands(records: np.ndarray) -> np.ndarray:
    return records["commands"].view(np.float32)


def cause(core) -> str:
    return FAULT_NAMES[STATUS["cause"].of(core.read(CSR["STATUS"]))]


# ---------------------------------------------------------------------- no numbers


@pytest.mark.quick("v0-2143289344")
@pytest.mark.parametrize(
    ("name", "word"), [*((name, NAN) for name in NUMBERS), ("vm", INF), ("start of x", INF)]
)
def test_record__with_a_word_that_is_no_number__hands_over_finite_words_alone(
    name, word, path, moves
):
    run = Run(path, moves[:1])
    bad = moves[1].words()
    bad[NUMBERS[name]] = word
    record = dataclasses.replace(moves[1])
    object.__setattr__(record, "words", lambda: bad)
    run.controller.append([record])
    until = moves[1].duration if name == "end of z" else 0  # the end counts from the middle on
    ticks = moves[0].duration + until + 20
    records = run.go(ticks)
    handed = np.array(run.controller.set_points)[: ticks + 1]
    assert np.isfinite(handed).all()
    assert np.isfinite(commands(records)).all()
    flags = run.system.flags()
    assert flags["trajectory_fault"] and flags["stop"] and flags["hold"], name
    assert not flags["tracking_fault"]
    assert cause(run.system.trajectory) == "NOT_FINITE"
    last = np.flatnonzero(records["stored"])[-1] + 1
    assert np.array_equal(handed[last], handed[-1]) and last < ticks
    if not until:
        assert np.linalg.norm(run.tool() - HOME[:3]) < 1e-6


def test_set_point__that_is_no_number_in_the_tracking_core__puts_the_safe_outputs_out(path, moves):
    run = Run(path, moves)
    run.go(30)
    system, tracking = run.system, run.system.tracking
    place = REGMAP.blocks["lists"].base + 32  # x is the first input
    target = tracking.input_addresses(["x"])[0]
    system.write_word(place, target << 16 | MEASURED_SOURCE)
    safe = run.safe()
    bad = system.run([[NAN, *run.seen[1:]]])
    assert commands(bad)[0].tolist() == safe
    assert cause(tracking) == "NOT_FINITE"
    after = run.go(50)
    assert commands(after).tolist() == [safe] * 50
    assert not after["updates"].any() and not after["stored"].any()
    flags = system.flags()
    assert flags["stop"] and flags["tracking_fault"] and not flags["trajectory_fault"]
    assert system.stop


# ---------------------------------------------------------------------- planner late


def test_planner_overrun__one_tick_is_held_at_rest_and_no_set_point_is_lost(path, moves):
    """One period is too short for the trajectory core alone; the path goes on a tick later."""
    run = Run(path, moves)
    run.go(60)
    run.system.write("PERIOD", 250)  # above the commands of a period, below the end of the run
    late = run.go(1)
    run.system.queue([(REGMAP.address("PERIOD"), SHORT)])  # now the next one has begun
    assert late["late"].tolist() == [1] and late["updates"].tolist() == [1]
    records = run.go(60)
    assert not records["late"].any() and (records["updates"] == 1).all()
    flags = run.system.flags()
    assert flags["trajectory_overrun"] and flags["underrun"]
    assert not any(flags[name] for name in ("tracking_overrun", "stop", "hold"))
    assert run.system.read("UNDERRUNS") == run.system.read("OVERRUNS") == 1
    # The same words as without the overrun, tick 60's once more with speeds and accelerations 0.
    undisturbed = Run(path, moves)
    undisturbed.go(121)
    words = np.array(undisturbed.controller.set_points[:121])
    held = words[60].copy()
    held[list(RATES)] = 0.0
    tracked = np.concatenate([words[:61], held[np.newaxis], words[61:120]])
    alone = AsipController(program("tracking_optimised", "fast", Robot.load()))
    alone.prime(path.words()[0], run.counts[0])
    answers = alone.batch(tracked, np.array(run.counts))
    assert np.array_equal(answers.outputs, commands(np.array(run.records)))


def test_planner__that_never_ends_is_stopped_by_its_watchdog_and_the_tool_stands(path, moves):
    run = Run(path, moves[:1])
    run.go(20)
    run.system.trajectory.write(CSR["WATCHDOG"], 100)  # ends each run as if it never did
    records = run.go(300)
    flags = run.system.flags()
    assert flags["trajectory_fault"] and flags["stop"] and flags["hold"]
    assert not flags["tracking_fault"]
    assert cause(run.system.trajectory) == "WATCHDOG"
    assert (records["updates"] == 1).all()  # the tool is held by the tracking law
    assert not records["stored"][1:].any()
    assert np.linalg.norm(run.tool() - HOME[:3]) < 1e-6


def test_tracking_core__that_never_ends_puts_the_safe_outputs_out(path, moves):
    run = Run(path, moves)
    run.go(20)
    run.system.tracking.write(CSR["WATCHDOG"], 50)
    safe = run.safe()
    records = run.go(5)
    assert commands(records).tolist() == [safe] * 5
    assert run.system.flags()["tracking_fault"] and cause(run.system.tracking) == "WATCHDOG"


def test_closed_loop__a_fault_ends_it_with_the_tick_and_the_flags(path, moves):
    run = Run(path, moves)
    for _ in range(10):
        run.controller.advance(run.seen)
    run.system.tracking.write(CSR["WATCHDOG"], 50)
    with pytest.raises(ControllerFault, match=r"tick 10: no new command .*stop.*tracking_fault"):
        run.controller.advance(run.seen)
