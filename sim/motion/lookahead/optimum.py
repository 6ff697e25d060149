# SPDX-License-Identifier: Apache-2.0
"""Least time of a path inside its tolerance, by an independent solver (CasADi's IPOPT).

    python -m sim.motion.lookahead.optimum          the paths of the goal
    python -m sim.motion.lookahead.optimum --path "star of 7 points" --tolerance 0.01

The unknowns are a point in path space (blend.py), its constant jerk in each interval, and the
durations of the intervals. Across the line or arc of its move the point stays within P in each
direction, and it passes each corner within P. The limits of tool and table and the feed hold. Those
of the legs are left out, which can only make the least time less. Between the ends of the
intervals, points that bound speed and path are examined too, except the path next to an arc. The
solver begins at the planner's motion, and shares no code of speeds or corners with it.

It finds a local optimum on a grid of intervals: neither a faster motion nor a finer grid is
excluded. Where it finds none, the command says so.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from asip_asm.command import command, command_parser
from sim.motion.command import failed, interruptible
from sim.motion.gcode.interpreter import parse
from sim.motion.geometry.blend import SCALE, TABLE_RADIUS
from sim.motion.geometry.curves import Arc, TurnedArc, curve_of, feed_of, to_si
from sim.motion.geometry.moves import GcodeProgram, Move
from sim.motion.lookahead import paths
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.robot.parameters import Robot

WANTED = (
    ("A-G-H", 0.01),
    ("raster, 12 lines of 20 mm, 2 mm apart", 0.05),
    ("circle, chords of 1 and 0.02 mm", 0.02),
)
LEAST, MOST, AT_REST = 3, 12, 8  # intervals of a move, and of those from or to rest
# The start is about feasible. The end: limits and corridor exceeded by at most a thousandth, and a
# time that changes by less than 1e-4 of it; the last digits would take hundreds of iterations more.
SOLVER: dict[str, Any] = {
    **{"print_level": 0, "sb": "yes", "max_iter": 1500, "tol": 1e-5},
    **{"mu_init": 1e-2, "bound_push": 1e-4, "bound_frac": 1e-4},
    **{"acceptable_tol": 5e-2, "acceptable_iter": 5, "acceptable_obj_change_tol": 1e-4},
    **{"acceptable_constr_viol_tol": 1e-3, "acceptable_compl_inf_tol": 1e-4},
}
STEP = 0.02  # s at the feed, for which a move gets an interval more


class OptimumError(ValueError):
    """The solver has not found an optimum, or the path has moves that the problem has not."""


@dataclass(frozen=True)
class Compared:
    """Times of a path [s]: of the planner, and the least."""

    name: str
    tolerance: float
    planned: float
    least: float

    @property
    def more(self) -> float:
        """Share by which the planner takes longer."""
        return self.planned / self.least - 1.0


def groups_of(program: GcodeProgram) -> list[list[Move]]:
    """The moves that go anywhere, from rest to rest: rests divide them."""
    rests = {before for before, _ in program.dwells}
    groups: list[list[Move]] = [[]]
    for number, move in enumerate(program.moves):
        if number in rests and groups[-1]:
            groups.append([])
        if curve_of(move) is not None:
            groups[-1].append(move)
    return [group for group in groups if group]


class Start:
    """The planner's motion of moves, where the solver begins.

    planned [s]: its duration.
    """

    def __init__(self, moves: Sequence[Move], settings: LookaheadSettings) -> None:
        run = Lookahead(iter(moves), settings)
        blocks = list(run.setpoints())
        self.planned = float(run.duration())
        self.period = settings.period
        self.position, self.velocity, self.acceleration, self.move = (
            np.concatenate([getattr(block, name) for block in blocks])
            for name in ("position", "velocity", "acceleration", "move")
        )

    def of_move(self, number: int, count: int) -> tuple[float, list[tuple[Any, Any, Any]]]:
        """Duration [s] of each of `count` equal intervals of a move; position, velocity and
        acceleration (5,) at their ends, in SI units."""
        first, last = np.searchsorted(self.move, [number, number + 1])
        ticks = np.linspace(first, min(last, len(self.move) - 1), count + 1)
        ends = np.rint(ticks[1:]).astype(int)
        states = [(self.position[k], self.velocity[k], self.acceleration[k]) for k in ends]
        return max(float(ticks[1] - ticks[0]), 0.1) * self.period, states


def least_time(
    moves: Sequence[Move], settings: LookaheadSettings, start: Start | None = None
) -> float:
    """Least time [s] of moves from rest to rest. Raises OptimumError."""
    limits, start = settings.limits, start or Start(moves, settings)
    curves = [curve_of(move) for move in moves]
    poses = np.array([move.start for move in moves] + [moves[-1].end])
    arcs = any(move.motion.is_arc for move in moves)
    used = [n for n in range(5) if np.ptp(poses[:, n]) > 0.0 or (arcs and n < 2)]
    tool, table = (sum(n in used for n in group) for group in ((0, 1, 2), (3, 4)))
    fastest = [limits.table if move.turns_only_the_table else limits.tool for move in moves]
    feeds = [min(feed_of(m), most.speed) for m, most in zip(moves, fastest, strict=True)]
    # Units in which speeds and accelerations are about 1.
    second = limits.tool.speed / 4 / limits.tool.acceleration
    metre = limits.tool.speed / 4 * second
    scale = SCALE[used] / metre
    problem = casadi.Opti()
    size = len(used)
    x = casadi.MX(casadi.DM(to_si(moves[0].start)[used] * scale))
    v = a = casadi.MX(casadi.DM.zeros(size))
    total = casadi.MX(0.0)

    def within(value: casadi.MX, order: int, limits: MachineLimits) -> None:
        """Bounds the derivative of an order by the limits of the tool and of each table axis."""
        name, unit = ("speed", "acceleration", "jerk")[order - 1], metre / second**order
        if tool:
            most = getattr(limits.tool, name) / unit
            problem.subject_to(casadi.sumsqr(value[:tool] / most) <= 1.0)
        if table:
            most = getattr(limits.table, name) * TABLE_RADIUS / unit
            problem.subject_to(problem.bounded(-1.0, value[tool:] / most, 1.0))

    for number, (move, curve, own) in enumerate(zip(moves, curves, feeds, strict=True)):
        assert curve is not None
        count = int(min(MOST, max(LEAST, math.ceil(curve.length / own / STEP))))
        count = max(count, AT_REST) if number in (0, len(moves) - 1) else count
        mean = problem.variable()
        step, states = start.of_move(number, count)
        problem.set_initial(mean, step / second)
        along = np.linspace(0.0, curve.length, count + 1)
        places, tangents, _ = (each[:, used] * scale for each in curve.evaluate(along))
        p = max(move.tolerance, 1e-4) / 1e3 / metre
        alone = move.turns_only_the_table
        feed = own * (TABLE_RADIUS if alone else 1.0) * second / metre
        asked = slice(tool, size) if alone else slice(0, tool)
        spent = casadi.MX(0.0)
        for k in range(1, count + 1):
            j = problem.variable(size)
            within(j, 3, limits)
            h = problem.variable()
            problem.set_initial(h, step / second)
            problem.subject_to(problem.bounded(1e-4, h, 1e3))
            problem.subject_to(h <= 2 * mean)
            spent = spent + h
            following = [problem.variable(size) for _ in range(3)]
            # With those at the ends, these points bound speed and way between them.
            if number or k > 1:
                middle = v + h * a / 2
                within(middle, 1, limits)
                problem.subject_to(casadi.sumsqr(middle[asked] / feed) <= 1.0)
            if (number or k > 1) and size > 1 and not isinstance(curve, Arc):
                across = np.linalg.svd(tangents[k][None, :])[2][1:]
                for point in (x + h * v / 3, x + h * (2 * v / 3 + h * a / 6)):
                    away = across @ (point - places[k]) / p
                    problem.subject_to(problem.bounded(-1.0, away, 1.0))
            problem.subject_to(following[0] == x + h * (v + h * (a / 2 + h * j / 6)))
            problem.subject_to(following[1] == v + h * (a + h * j / 2))
            problem.subject_to(following[2] == a + h * j)
            x, v, a = following
            for order, (unknown, state) in enumerate(zip(following, states[k - 1], strict=True)):
                problem.set_initial(unknown, state[used] * scale * second**order)
            if number == len(moves) - 1 and k == count:
                problem.subject_to(x == places[k])
                problem.subject_to(v == 0)
                problem.subject_to(a == 0)
                continue
            within(v, 1, limits)
            within(a, 2, limits)
            problem.subject_to(casadi.sumsqr(v[asked] / feed) <= 1.0)
            off = (x - places[k]) / p
            if k == count:
                problem.subject_to(casadi.sumsqr(off) <= 1.0)
            elif isinstance(curve, Arc) and not isinstance(curve, TurnedArc):
                centre = np.array(curve.centre) / metre
                first, last = (used.index(axis) for axis in curve.axes)
                away = casadi.sumsqr(casadi.vertcat(x[first] - centre[0], x[last] - centre[1]))
                radius = curve.radius / metre
                lower, upper = (radius - p) ** 2, (radius + p) ** 2
                problem.subject_to(problem.bounded(lower / p, away / p, upper / p))
            else:
                across = np.linalg.svd(tangents[k][None, :])[2][1:]
                if len(across):
                    problem.subject_to(problem.bounded(-1.0, across @ off, 1.0))
        problem.subject_to(spent == mean * count)
        total = total + spent
    problem.minimize(total)
    problem.solver("ipopt", {"print_time": False, "error_on_fail": False}, SOLVER)
    try:
        found = problem.solve_limited()
    except RuntimeError as error:
        raise OptimumError(f"line {moves[0].line}: {error}") from None
    if not found.stats()["success"]:
        status = found.stats()["return_status"]
        raise OptimumError(f"lines {moves[0].line} to {moves[-1].line}: IPOPT ends with {status}")
    return float(found.value(total)) * second


def compare(name: str, tolerance: float, robot: Robot | None = None) -> Compared:
    """A path of paths.py: the planner's time and the least."""
    settings = LookaheadSettings(robot=robot or Robot.load())
    program = parse(f"G21 G90 G64 P{tolerance:g}\n{paths.PATHS[name]()}\nM2")
    planned = least = 0.0
    for group in groups_of(program):
        start = Start(group, settings)
        planned += start.planned
        least += least_time(group, settings, start)
    return Compared(name, tolerance, planned, least)


@command("python -m sim.motion.lookahead.optimum")
def main(argv: list[str] | None = None) -> int:
    """Command line; 1 where the solver finds no optimum."""
    prog = "python -m sim.motion.lookahead.optimum"
    parser = command_parser(prog, __doc__, f"example: {prog} --path hexagon --tolerance 0.01")
    parser.add_argument("--path", choices=[*paths.PATHS], metavar="NAME", help="of paths.py")
    parser.add_argument("--tolerance", type=float, metavar="MM", help="P of --path [mm] (0.01)")
    arguments = parser.parse_args(argv)
    if arguments.tolerance is not None and not arguments.path:
        parser.error("--tolerance is that of one path: name it with --path")
    tolerance = 0.01 if arguments.tolerance is None else arguments.tolerance
    wanted = ((arguments.path, tolerance),) if arguments.path else WANTED
    try:
        if not 1e-4 <= tolerance <= 10.0:
            raise OptimumError(f"--tolerance {tolerance:g} is outside its limit: 0.0001 to 10 mm")
        for name, tolerance in wanted:
            found = compare(name, tolerance)
            sys.stdout.write(
                f"{name}, P {tolerance:g} mm: {found.planned:.3f} s planned, {found.least:.3f} s "
                f"at least, {100 * found.more:.1f} % longer\n"
            )
    except OptimumError as error:
        return failed(parser.prog, error)
    return 0


if __name__ == "__main__":
    sys.exit(interruptible(main))
