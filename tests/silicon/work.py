# SPDX-License-Identifier: Apache-2.0
"""What a module does while its netlist is beside it: work that an existing test gives it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import pytest

from sim.custom_table import load as custom_instructions
from sim.ethercat.datagram import APWR, single
from sim.ethercat.gen import esc_regmap
from sim.ethercat.line import Line
from sim.harness.nios_map import default_system_map
from sim.harness.nios_rtl import PLATFORMS
from sim.model import float32
from sim.model.parameters import Robot
from sim.motion import show_path
from sim.motion.step_stream import Steps
from sim.run.nios import NiosController, torque_limit
from tests.asip.tracking_path import reversing_path
from tests.bench.seed import SEED
from tests.ethercat.test_frames import run_chains
from tests.motion.test_step_stream import SHORT
from tests.motion_rtl.test_path import run_commands
from tests.nios.test_nios_system import check_words
from tests.servo.test_chain import chain
from tests.silicon.netlist import ROOT

PATH_TICKS = 600  # of the reversing path: every part of the law acts


@dataclass(frozen=True)
class Work:
    """top: the module, in a model with these parameters; do: so much of the work.

    `do` raises AssertionError where the RTL does its work wrong.
    """

    top: str
    do: Callable[[int], None]
    parameters: Mapping[str, int] = field(default_factory=dict)


def run_tests(*files: str, without: str = "") -> None:
    """Tests of these files that are not for the full run. Raises AssertionError if one fails."""
    options = ["-q", "-s", "-x", "-n0", "-m", "not full", "-p", "no:cacheprovider"]
    options += ["-k", f"not {without}"] if without else []
    done = pytest.main([*options, *(str(ROOT / "tests" / file) for file in files)])
    assert done == pytest.ExitCode.OK, "a test fails"


def frames(count: int) -> None:
    """Tests of frames, disturbances and clocks, an interrupt, then so many chains of datagrams."""
    run_tests(*(f"ethercat/test_{name}.py" for name in ("frames", "disturbed", "clocks")))
    interrupt()
    run_chains(count, SEED)


def interrupt() -> None:
    """The master asks for a state, and the application is told."""
    with Line() as line:
        line.write(esc_regmap.AL_EVENT_MASK, esc_regmap.AL_EVENT.word(al_control=1))
        asked = esc_regmap.AL_CONTROL.word(state=1).to_bytes(2, "little")
        line.exchange(single(APWR, 0, esc_regmap.AL_CONTROL.address, asked))


def control_periods(count: int) -> None:
    """Start-up of five drives and so many control periods of 12 500 clocks on a path."""
    machine, _ = chain(True, "tracking_optimised")
    machine.advance(count)
    machine.system.close()


def path_commands(count: int) -> None:
    """Tests of lines and arcs on the step lines, so many random commands, a G64 program.

    The program moves five axes by records, the commands by the interpolators.
    """
    run_tests("motion_rtl/test_path.py", without="without_interpolators")
    run_commands(count, SEED)
    drawn = show_path.run(SHORT, Steps(leg=5e5))
    assert all(row.agrees for row in show_path.results(drawn))


def control_ticks(platform: str, count: int) -> None:
    """The tracking law in C on a system: so many ticks of a path with reversals."""
    robot = Robot.load()
    path, counts = reversing_path(robot, max(count, PATH_TICKS))
    controller = NiosController(platform, robot)
    words = path.words()
    controller.prime(words[0], counts[0])
    result = controller.batch(words[:count], counts[:count])
    single = float32.run(robot, path, counts)
    check_words(result, single, 0, torque_limit(single, slice(0, count)))
    controller.core.close()


def core_parameters(platform: str) -> dict[str, int]:
    """Parameters of the core in a system as `NiosRtl` builds it."""
    system = default_system_map()
    code, data = system.memories["itcm"], system.memories["dtcm"]
    return {
        "ItcmBase": code.base,
        "ItcmBytes": 4 * code.words,
        "DtcmBase": data.base,
        "DtcmBytes": 4 * data.words,
        "ResetVector": system.reset_vector,
        "ExceptionVector": system.exception_vector,
        "BreakVector": system.exception_vector,
        "CiCombinational": custom_instructions()[platform].combinational,
        "Debug": 0,
        "Trace": 1,
    }


WORK = {
    "ethercat_slave": Work("ethercat_slave", frames),
    "drive_front_end": Work("drive_front_end", control_periods),
    "motion_front_end": Work("motion_front_end", path_commands, {"Interpolators": 1}),
    **{
        f"n2_core_{platform}": Work(
            "n2_core", partial(control_ticks, platform), core_parameters(platform)
        )
        for platform in PLATFORMS
    },
}
