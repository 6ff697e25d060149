# SPDX-License-Identifier: Apache-2.0
"""What the motor drives are to reach, hardware and simulation, to build/drive.json and .html.

    python -m scripts.drive           minutes: short runs; rows that need long ones say so
    python -m scripts.drive --full    whole path, 2 s of every clock, 10^9 edges, place and route
    python -m scripts.drive guards motors    only these; the file keeps the rows of the others
    python -m scripts.drive --docs    write docs/drive.md from build/drive.json: of a part of the
                                      producers their rows alone
    python -m scripts.drive motor.toml    bring up the motor of that file alone, to build/motor.*

Exit status: 0 if no goal is missed, 1 if one is, 2 wrong command line.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any

from asip_asm.command import command
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from scripts.generated import table
from scripts.motion_size import area, speed
from scripts.synth_unit import SynthesisError
from sim.bench.drive.__main__ import main as simulate
from sim.bench.drive.axis.campaign import rows as random_motors
from sim.bench.drive.goals import FULL_RUN, Job, Part, Rows
from sim.bench.drive.guards import campaign as campaign_of_guards
from sim.laws.drive.clocks import CLOCK
from sim.laws.drive.current_law import Setting
from sim.report.goals import depth, updated_table
from sim.report.marks import between_marks, text_between
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.verbs import YOSYS, absent
from tests.servo.axis_latency import latency
from tests.servo.decoder_edges import campaign

AXIS = "drive_axis"
BLOCKS = (
    *(
        "quadrature_decoder",
        "quadrature_time",
        "biss_master",
        "biss_port",
        "ssi_port",
        "endat_port",
        "absolute_position",
        "sincos_position",
        "hall_decoder",
        "sinc3_timing",
        "sinc3_filter",
        "current_sense",
        "current_sum",
    ),
    *("pwm_carrier", "pwm_bound", "pwm_phase", "pwm_bridge", "servo_link"),
    *("drive_plausible", "index_check", "drive_front_end"),
)
LUTS, MHZ, SEEDS = 700, 125, (1, 2, 3)
LATENCY_US = 1.5
EDGES = {False: 20_000_000, True: 1_000_000_000}
PROOFS = {
    "no_shoot_through": "PWM, no shoot-through for any registers and faults",
    "trip_in_two_clocks": "PWM, gates off in 2 clocks after any fault",
}
PAGE = ROOT / "docs/drive.md"


def size(full: bool, rows: Rows, report: Callable[[str], None]) -> None:
    """Area, and in a full run the routed clock, of one axis on ECP5."""
    luts = mhz = None
    try:
        report("area of one axis on ECP5")
        luts = area(AXIS, {})["luts"]
        if full:
            report(f"clock of one axis on ECP5, {len(SEEDS)} seeds")
            mhz = speed(AXIS, {}, AXIS, SEEDS)["mhz_median"]
    except (SynthesisError, FileNotFoundError) as error:
        report(f"  {error}; `make setup-synth` installs the tools")
    rows.most("one axis (decoder, sinc3 pair, PWM) on ECP5, area", luts, "LUT4", LUTS)
    rows.least("one axis on ECP5, clock, median of 3 seeds", mhz, "MHz", MHZ)


def proofs(rows: Rows, report: Callable[[str], None]) -> None:
    """Cases that the solver has not proved."""
    from tests.formal.engine import PROVED, run  # noqa: PLC0415, needs the solver
    from tests.formal.proofs import PROOFS as KNOWN

    for proof in KNOWN:
        if proof.name in PROOFS:
            report(f"proof {proof.name}")
            verdicts = list(run(proof))
            left = sum(verdict.status != PROVED for verdict in verdicts) if verdicts else None
            rows.most(f"{PROOFS[proof.name]}: cases not proved", left, "cases", 0)


def guards(robot: Robot, drives: Drives, rows: Rows, report: Callable[[str], None]) -> None:
    """Faults of sensors, windings, bus voltage and encoders that are not found in time."""
    report("planted faults of sensors, phases, bus voltage and encoders, three sensors an axis")
    found = campaign_of_guards(robot, drives, report)
    missed = sum(not each.in_time for each in found)
    name = "planted faults of sensors, phases, bus and encoders, three sensors an axis"
    rows.most(f"{name}: not found in time, of {len(found)}", missed, "faults", 0)


def decoder(full: bool, rows: Rows, report: Callable[[str], None]) -> None:
    """Edges at 25 million counts a second with jitter; changes of both lines at once."""
    report("edges into the decoder")
    found = campaign(EDGES[full], report)
    about = "decoder at 25 M counts/s and 100 MHz, jitter"
    rows.append(depth(f"{about}: edges", found.edges, EDGES[True], "edges", FULL_RUN))
    rows.most(f"{about}: clocks with a wrong count", found.wrong, "clocks", 0)
    name = f"decoder, illegal changes not flagged, of {found.planted}"
    rows.most(name, found.missed, "changes", 0)


def blocks(full: bool, report: Callable[[str], None]) -> list[dict[str, Any]]:
    """Rows {name, luts, registers, mhz} of the blocks with their default parameters on ECP5; mhz:
    routed alone with one seed, None unless `full`. Empty without the tools."""
    found = []
    try:
        for name in BLOCKS:
            report(f"area {'and clock ' if full else ''}of {name} on ECP5")
            row = area(name, {})
            mhz = speed(name, {}, name, SEEDS[:1])["mhz_median"] if full else None
            found.append({"name": name, "luts": row["luts"], "registers": row["registers"]})
            found[-1]["mhz"] = mhz
    except (SynthesisError, FileNotFoundError) as error:
        report(f"  {error}; `make setup-synth` installs the tools")
    return found


def axis_latency(job: Job, rows: Rows) -> dict[str, Any]:
    """One axis from its samples to its values, RTL."""
    job.report("one axis from its samples to its values, RTL")
    clocks = max(latency(job.drives, Setting(job.robot.resolution)))
    name = "sampling instant to new compare values, one axis on fast, RTL"
    rows.most(name, 1e6 * CLOCK * clocks, "us", LATENCY_US)
    return {}


def _only(measure: Callable[[Job, Rows], None]) -> Part:
    """A producer of rows without further fields."""

    def part(job: Job, rows: Rows) -> dict[str, Any]:
        measure(job, rows)
        return {}

    return part


HARDWARE: dict[str, Part] = {
    "latency": axis_latency,
    "proofs": _only(lambda job, rows: proofs(rows, job.report)),
    "guards": _only(lambda job, rows: guards(job.robot, job.drives, rows, job.report)),
    "motors": _only(lambda job, rows: rows.extend(random_motors(job.report))),
    "decoder": _only(lambda job, rows: decoder(job.full, rows, job.report)),
    "size": _only(lambda job, rows: size(job.full, rows, job.report)),
    "blocks": lambda job, rows: {"blocks": blocks(job.full, job.report)},
}
"""Producers besides those that are simulated in the chain (`sim.bench.drive.goals.PARTS`)."""


def tools() -> str | None:
    """What is wrong where the tools of the hardware are missing; one motor needs none of them."""
    return None if find_spec(YOSYS) else absent(YOSYS, "make setup-synth")


def block_table(rows: list[dict[str, Any]]) -> str:
    """Rows of `blocks` as Markdown."""
    cells = []
    for row in rows:
        mhz = "" if row["mhz"] is None else format(row["mhz"], ".0f")
        cells.append([f"`{row['name']}`", str(row["luts"]), str(row["registers"]), mhz])
    return "\n".join(table(["block", "LUT4", "registers", "clock, MHz"], cells)) + "\n"


def page_text(page: str, results: dict[str, Any]) -> str:
    """docs/drive.md with the figures of build/drive.json; what it lacks stays. Raises ValueError
    without its marks."""
    texts = {"goals": updated_table(text_between(page, "goals", PAGE.name), results)}
    if "delays" in results:
        texts |= delay_texts(results["delays"])
    if results.get("blocks"):
        texts["blocks"] = block_table(results["blocks"])
    return between_marks(page, texts, PAGE.name)


def delay_texts(late: Mapping[str, float]) -> dict[str, str]:
    """Delays of the chain, and the force of a count."""
    return {
        "delays": (
            "| from | to | delay at 125 MHz |\n| --- | --- | --- |\n"
            "| first clock of a control period, positions taken | commands, friction in the law | "
            f"{late['commands']:.1f} us |\n"
            "| commands | set-points of the current loops | "
            f"next sample, {late['orders']:.0f} us at most |\n"
            "| middle of the currents' window | compare values in force | "
            f"{late['values']:.1f} us |\n"
            "| compare values in force | middle of the resulting voltage | "
            f"{late['voltage']:.0f} us |\n"
        ),
        "pulse": (
            f"One count of the table is {late['count']:.0f} urad. The tracking law answers it with "
            f"{late['pulse']:.0f} N m for one tick of 100 us.\n"
        ),
    }


@command("microtick drive")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments == ["--docs"]:
        results = json.loads((BUILD / "drive.json").read_text(encoding="utf-8"))
        text = page_text(PAGE.read_text(encoding="utf-8"), results)
        write_text(PAGE, text)
        return 0
    return simulate(arguments, "python -m scripts.drive", HARDWARE, tools)


if __name__ == "__main__":
    sys.exit(main())
