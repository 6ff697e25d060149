# SPDX-License-Identifier: Apache-2.0
"""Lathe cycles G70 to G72.2: the moves of rs274, passes by hand, and mistakes with their place."""

from __future__ import annotations

import itertools
import math
import time

import pytest

from sim.motion.gcode.interpreter import GcodeErrors, parse, stream
from sim.motion.gcode.oracle import OracleError, differences, rs274
from sim.motion.geometry.moves import Motion, Move, Plane
from tests.bench.needs import needs
from tests.gcode.contours import lathe_program
from tests.gcode.mistakes import ZERO, errors_of

HEAD = "G21 G18 G90 G94 G54 F100\n"
SHAFT = "O1 sub\nG0 X2 Z0\nG1 Z-5\nX4 Z-8\nO1 endsub\n"
POCKET = (
    "O1 sub\nG0 X5 Z0\nG1 Z-3\nX3 Z-5\nZ-7\nG2 X5 Z-9 I2 K0\nG1 Z-11\nX7 Z-12\n"
    "G3 X7 Z-16 I-1 K-2\nG1 X9 Z-18\nO1 endsub\n"
)


def text_of(contour: str, block: str, head: str = HEAD) -> str:
    return f"{head}{contour}G0 X12 Z3 Y1\n{block}\nM2\n"


def moves_of(contour: str, block: str, head: str = HEAD) -> list[Move]:
    """Moves of the cycle that go anywhere, without the way to X12 Z3."""
    moves = parse(text_of(contour, block, head), start=ZERO).moves[1:]
    return [move for move in moves if move.start != move.end]


def ends(moves: list[Move]) -> list[tuple[str, float, float]]:
    return [(m.motion.value, round(m.end[0], 9), round(m.end[2], 9)) for m in moves]


# Passes


def test_roughing__shaft__is_cut_level_by_level_and_along_the_contour():
    assert ends(moves_of(SHAFT, "G71 Q1 X6 Z1 I2 R0.5")) == [
        *(("G0", 6.0, 1.0), ("G1", 6.0, -8.0), ("G0", 6.5, -7.5), ("G0", 6.5, 0.5)),
        *(("G0", 6.0, 1.0), ("G0", 4.0, 0.5), ("G1", 4.0, -8.0), ("G0", 4.5, -7.5)),
        *(("G0", 4.5, 0.0), ("G0", 4.0, 0.5), ("G0", 2.0, 0.0), ("G1", 2.0, -5.0)),
        *(("G1", 4.0, -8.0), ("G1", 6.0, -8.0)),
    ]


def test_roughing__its_forms__cut_all_no_pocket_or_the_pockets_alone():
    whole, outside, inside = (
        moves_of(POCKET, f"{code} Q1 X12 Z2 I1 R0.3") for code in ("G71", "G71.1", "G71.2")
    )

    def lowest(moves: list[Move]) -> float:
        return min(m.end[0] for m in moves if m.end[2] <= -4)

    assert lowest(whole) == lowest(inside) == 3.0
    assert lowest(outside) == 5.0
    assert len(inside) < len(whole) and len(outside) < len(whole)


@pytest.mark.parametrize("code", ["G71", "G72"])
@pytest.mark.parametrize("distance", [0.0, 0.3])
def test_roughing__keeps_its_distance_to_the_contour(code, distance):
    """Feed moves end nowhere nearer to the line X2 Z-5 to X4 Z-8, and one of them at it."""
    back = "O1 sub\nG0 X4 Z-8\nG1 X2 Z-5\nZ0\nO1 endsub\n"
    contour = SHAFT if code == "G71" else back
    moves = moves_of(contour, f"{code} Q1 X6 Z1 I0.7 D{distance}")
    begin, end = complex(-5, 2), complex(-8, 4)
    along = (end - begin) / abs(end - begin)
    # Material is at less x: its side is at the right of the way.
    gaps = [
        -((complex(m.end[2], m.end[0]) - begin) * along.conjugate()).imag
        for m in moves
        if m.motion is not Motion.RAPID and -8 < m.end[2] < -5
    ]
    assert min(gaps) == pytest.approx(distance, abs=1e-9)


def test_finishing__its_passes__are_at_falling_distances():
    moves = moves_of(SHAFT, "G70 Q1 X6 Z1 D1 E0.1 P3")
    depths = [m.end[0] for m in moves if m.motion is Motion.LINEAR and -5.5 < m.end[2] < -4]
    assert depths == pytest.approx([2 + (2 * 0.9 / 3 + 0.1), 2 + (0.9 / 3 + 0.1), 2.1])


def test_cycle__moves_in_x_and_z_alone__with_the_feed_and_modes_in_force():
    head = HEAD + "G64 P0.01\n"
    moves = moves_of(POCKET, "G71 Q1 X12 Z2 D0.2", head)
    assert {(m.start[1], m.end[1], m.tolerance, m.line) for m in moves} == {(1.0, 1.0, 0.01, 15)}
    assert {m.feed for m in moves} == {None, 100.0}
    arcs = [m for m in moves if m.motion.is_arc]
    assert arcs and all(m.plane is Plane.ZX for m in arcs)
    for before, after in itertools.pairwise(moves):
        assert before.end == after.start
    for arc in arcs:
        (first, second), centre = arc.circle
        radii = [math.dist((p[first], p[second]), centre) for p in (arc.start, arc.end)]
        assert radii[0] == pytest.approx(radii[1], abs=1e-6)


def test_corners_of_a_contour__are_rounded_and_cut():
    for letter, kinds in (("A", (Motion.ARC_CW, Motion.ARC_CCW)), ("C", (Motion.LINEAR,))):
        contour = SHAFT.replace("Z-5", f"Z-5 {letter}0.5").replace("X4 Z-8", "X4\nZ-8")
        moves = moves_of(contour, "G70 Q1 X6 Z1")
        assert (2.0, -4.5) in [(m.end[0], m.end[2]) for m in moves]
        assert (2.5, -5.0) in [(m.end[0], m.end[2]) for m in moves]
        at = [m.end[0] for m in moves].index(2.5)
        assert moves[at].motion in kinds


def test_cycle__selects_no_motion__and_leaves_parameters_of_its_own():
    text = text_of("O1 sub\n#1=7 #31=#5420\nG0 X2 Z0\nG1 Z-5\nX[#<_x> + 2] Z-8\nO1 endsub\n", "")
    moves = parse(text.replace("M2", "#1=3\nG71 Q1 X6 Z1\nG0 X#1 Z#31\nM2"), start=ZERO).moves
    assert moves[-1].end[0] == 3.0 and moves[-1].end[2] == 6.0
    (error,) = errors_of(text.replace("M2", "G71 Q1 X6 Z1\nX3\nM2"))
    assert error.line == 11 and error.what == "no motion is selected"


# rs274

CUT = {
    "shaft": (SHAFT, "G71 Q1 X6 Z1 I2"),
    "pockets": (POCKET, "G71 Q1 X12 Z2 I0.7 D0.2 R0.3"),
    "no pockets, then the pockets": (POCKET, "G71.1 Q1 X12 Z2 D0.4\nG71.2 Q1 X12 Z2 D0.2 I0.5"),
    "facing": (SHAFT, "G72 Q1 X6 Z1 I0.7 D0.1"),
    "facing forms": (
        "O1 sub\nG0 X9 Z-6\nG1 X7\nZ-8\nX5\nZ-5\nX3 Z-4\nX1 Z-1\nO1 endsub\n",
        "G72.1 Q1 X10 Z1\nG72.2 Q1 X10 Z1",
    ),
    "finishing": (POCKET, "G70 Q1 X12 Z2 D1 E0.2 P3"),
    "finishing of a face": ("O1 sub\nG0 X9 Z-6\nG1 X7\nZ-2\nX1 Z-4\nO1 endsub\n", "G70 Q1 X10 Z1"),
    "diameters": (SHAFT, "G7 G71 Q1 X12 Z1 D.3\nG0 X#5420"),
    "inches": ("G20\nF9\n" + SHAFT, "G71 Q1 X6 Z1 D0.1"),
    "increments": (
        "O1 sub\nX-3 Z-1\nG1 Z-5\nG2 X2 Z-2 R2\nG1 X2 Z-3\nO1 endsub\n",
        "G0 X5 Z1\nG91 G71 Q1 I1\nG90",
    ),
    "absolute centres": (
        "G90.1\nO1 sub\nG0 X2 Z0\nG1 Z-5\nG2 X4 Z-7 I4 K-5\nO1 endsub\n",
        "G71 Q1 X6 Z1",
    ),
    "U and W": ("O1 sub\nG0 X2 Z0\nG1 W-5\nU2 W-3\nU1\nO1 endsub\n", "G71 Q1 X6 Z1"),
    "U in diameters": ("O1 sub\nG0 X2 Z0\nG1 W-5\nU2 W-3\nO1 endsub\n", "G7 G71 Q1 X12 Z1"),
    "corners": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 A0.5\nX4 C.3\nZ-8 A0.4\nX5 Z-9\nO1 endsub\n",
        "G71 Q1 X6 Z1 D0.1\nG70 Q1 X6 Z1",
    ),
    "flow inside the contour": (
        "O1 sub\nG0 X2 Z0\n#2=3\nO2 repeat [#2]\nG1 X[#<_x> + 1] Z[#5422 - 2]\nG1 Z[#<_z> - 1]\n"
        "O2 endrepeat\nO3 if [#2 GT 2]\nO4 call [9]\nO3 endif\nO1 return\nG1 X99\nO1 endsub\n"
        "O4 sub\nG1 X#1\nO4 endsub\n",
        "G71 Q1 X10 Z1 I0.8",
    ),
    "no start": (SHAFT, "G0 X6 Z1\nG71 Q1"),
    "start in X alone": (SHAFT, "G71 Q1 X6"),
    "negative distance": (SHAFT, "G71 Q1 X6 Z1 D-0.2"),
    "tiny increment": (SHAFT, "G71 Q1 X2.02 Z1 I0.001"),
    "no retract": (SHAFT, "G71 Q1 X6 Z1 R0"),
    "coordinate system and shift": (SHAFT, "G10 L2 P2 X3 Z2\nG55 G92 X1\nG71 Q1 X6 Z1\nG92.1"),
    "table axes stay": (SHAFT, "G0 A5 C7\nG71 Q1 X6 Z1"),
}


@needs("rs274")
@pytest.mark.parametrize("name", CUT)
def test_rs274__each_feature_of_the_cycles__gives_the_same_moves(name):
    assert differences(text_of(*CUT[name])) == []


@needs("rs274")
def test_rs274__subroutine_after_the_cycle__gives_the_same_moves():
    assert differences(f"{HEAD}G71 Q1 X6 Z1\nG0 X9\nM2\n{SHAFT}") == []


SEEDS = range(120)
LEAST_CUT = 90


@needs("rs274")
def test_rs274__random_contours__are_cut_alike_or_refused_by_both():
    """rs274 does not end where a pass finds no way on; such contours are not given to it."""
    cut: dict[str, int] = {}
    for seed in SEEDS:
        text = lathe_program(seed)
        try:
            parse(text, start=ZERO)
        except GcodeErrors as errors:
            what = errors.errors[0].what
            if "goes back" in what or "not on its circle" in what:
                with pytest.raises(OracleError):
                    rs274(text)
            else:
                assert "finds no way on" in what or "no room for the corner" in what
            continue
        assert differences(text) == [], f"seed {seed}:\n{text}"
        code = text.split("Y2\n")[1].split()[0]
        cut[code] = cut.get(code, 0) + 1
    assert sum(cut.values()) >= LEAST_CUT
    assert len(cut) == 7, "every cycle is among them"


# Mistakes: contour, block, line, text, parts of what and help. rs274 refuses those of BOTH too.

BOTH = {
    "no Q": (SHAFT, "G71 X6 Z1", 8, "G71", "G71 without Q", "mm are G21"),
    "Q in part": (SHAFT, "G71 Q1.5 X6 Z1", 8, "Q1.5", "Q of G71 is 1.5", "correct"),
    "no increment": (SHAFT, "G71 Q1 X6 Z1 I0", 8, "I0", "I of G71 is 0", "correct"),
    "negative increment": (SHAFT, "G72 Q1 X6 Z1 I-1", 8, "I-1", "I of G72 is -1", "correct"),
    "plane": (SHAFT, "G17 G71 Q1 X6 Z1", 8, "G71", "G71 in G17", "write G18"),
    "compensation": (SHAFT, "G41.1 D1 G1 X9\nG71 Q1 X6 Z1", 9, "G71", "G71 during cutter", "G40"),
    "goes back": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5\nX4 Z-4\nX5 Z-8\nO1 endsub\n",
        "G71 Q1 X6 Z1", 9, "G71", "goes back in Z in line 5", "G71 needs this of Z",
    ),
    "goes back in x": (
        "O1 sub\nG0 X4 Z-5\nG1 X2\nX3 Z-2\nX1\nO1 endsub\n",
        "G72 Q1 X6 Z1", 9, "G72", "goes back in X in line 5", "G72 of X",
    ),
    "lines that go on": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5\nZ-8\nX4\nO1 endsub\n",
        "G71 Q1 X6 Z1 D.1", 9, "G71", "the lines 4 and 5 go in the same", "as one move",
    ),
    "two corners": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 A.1 C.1\nX4 Z-8\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "C.1", "one size", "A0.5",
    ),
    "arc without a centre": (
        "O1 sub\nG0 X2 Z0\nG2 X4 Z-2\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "G2", "no centre", "from the start",
    ),
    "U and X": (
        "O1 sub\nG0 X2 Z0\nG1 X3 U1 Z-1\nX4\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "U1", "U together with X", "remove U1",
    ),
    "W with increments": (
        "O1 sub\nG0 X-2\nG1 W-1\nX4\nO1 endsub\n",
        "G91 G71 Q1", 4, "W-1", "W together with G91", "remove W-1",
    ),
    "allowance of Fanuc": (SHAFT, "G71 Q1 X6 Z1 U.5", 8, "U.5", "U, an axis along X", "is D"),
}  # fmt: skip
OURS = {
    "corner without room": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 A20\nX4 Z-8\nZ-9\nO1 endsub\n",
        "G71 Q1 X6 Z1", 9, "G71", "no room for the corner of line 4", "A (rounding)",
    ),
    "repeat without end": (
        "O1 sub\nG0 X2 Z0\nO2 repeat [2]\nG1 X4 Z-8\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "O2 repeat", "is not closed", "closing line",
    ),
    "no subroutine": (SHAFT, "G71 Q7 X6 Z1", 8, "Q7", "no subroutine 7", "files of their own"),
    "no contour": ("O1 sub\nO1 endsub\n", "G71 Q1 X6 Z1", 5, "G71", "has 0 moves", "X and Z"),
    "one move": (
        "O1 sub\nG0 X2 Z0\nO1 endsub\n", "G71 Q1 X6 Z1", 6, "G71", "has 1 moves", "X and Z",
    ),
    "last corner": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 A.2\nO1 endsub\n",
        "G71 Q1 X6 Z1", 7, "G71", "ends with A.2", "remove A.2",
    ),
    "feed of the contour": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 F9\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "F9", "F in the contour", "before the cycle",
    ),
    "mode of the contour": (
        "O1 sub\nG91 G0 X2 Z0\nG1 Z-5\nO1 endsub\n",
        "G71 Q1 X6 Z1", 3, "G91", "G91 in the contour", "read, not run",
    ),
    "other motion": (
        "O1 sub\nG0 X2 Z0\nG33 Z-5 K1\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "G33", "G33 in the contour", "read, not run",
    ),
    "end of the program": (
        "O1 sub\nG0 X2 Z0\nM2\nO1 endsub\n", "G71 Q1 X6 Z1", 4, "M2", "M2 in the", "not run",
    ),
    "y": ("O1 sub\nG0 X2 Y1\nO1 endsub\n", "G71 Q1 X6 Z1", 3, "Y1", "Y in the contour", "not run"),
    "centre of a line": (
        "O1 sub\nG0 X2 Z0\nG1 Z-5 K1\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "K1", "K does not belong to G1", "G2 or G3",
    ),
    "corner at rest": (
        "O1 sub\nG0 X2 Z0\nG1 X2 A1\nO1 endsub\n", "G71 Q1 X6", 4, "A1", "stays where", "X or Z",
    ),
    "radius too small": (
        "O1 sub\nG0 X2 Z0\nG2 X4 Z-2 R1\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "R1", "R1 does not give", "I and K",
    ),
    "greater arc": (
        "O1 sub\nG0 X2 Z0\nG2 X4 Z-2 R-3\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "R-3", "R-3 does not give", "I and K",
    ),
    "half an absolute centre": (
        "G90.1\nO1 sub\nG0 X2 Z0\nG2 X4 Z-2 I4\nO1 endsub\n",
        "G71 Q1 X6 Z1", 5, "G2", "no centre", "coordinates",
    ),
    "end off the arc": (
        "O1 sub\nG0 X2 Z0\nG2 X4 Z-2 I1\nO1 endsub\n",
        "G71 Q1 X6 Z1", 4, "G2", "not on its circle", "check the end",
    ),
    "increments of the start": (SHAFT, "G91 G71 Q1 X6", 8, "X6", "X of G71 with G91", "before"),
    "time": (SHAFT, "G93\nG71 Q1 X6", 9, "G71", "G71 with G93", "G94"),
    "rotation": (SHAFT, "G10 L2 P1 R5\nG71 Q1 X6", 9, "G71", "rotated", "R0"),
    "rest in the block": (SHAFT, "G4 P1 G71 Q1 X6", 8, "G4", "G4 shares its block", "its own"),
    "end in the block": (SHAFT, "G71 Q1 X6 M2", 8, "M2", "M2 shares its block", "its own"),
    "letter of another cycle": (SHAFT, "G71 Q1 X6 E1", 8, "E1", "E does not belong to G71", "G70"),
    "y of the start": (SHAFT, "G70 Q1 X6 Y1", 8, "Y1", "Y does not belong to G70", "remove Y1"),
    "passes in part": (SHAFT, "G70 Q1 X6 P1.5", 8, "P1.5", "P of G70 is 1.5", "correct"),
    "no passes": (SHAFT, "G70 Q1 X6 P0", 8, "P0", "P of G70 is 0", "correct"),
    "retract forward": (SHAFT, "G71 Q1 X6 R-1", 8, "R-1", "R of G71 is -1", "correct"),
    "motion after it": (SHAFT, "G71 Q1 X6 Z1\nX9", 9, "X9", "no motion is selected", "G0 or G1"),
    "extruder": (SHAFT, "G1 X6 E1", 8, "E1", "E does not belong to G1", "no extruder"),
    "its own offset": (
        "O1 sub\nG0 X2 Z0\nG1 Z-1\nX4\nZ-1.4\nX2\nZ-3\nX4\nO1 endsub\n",
        "G71 Q1 X6 Z1 D9", 12, "G71", "", "check D",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [*BOTH, *OURS])
def test_mistake__of_a_cycle_or_contour__is_reported_with_place_and_cure(name):
    contour, block, line, text, what, help = {**BOTH, **OURS}[name]
    error = errors_of(text_of(contour, block))[0]
    assert (error.line, error.text) == (line, text)
    assert what in error.what and help in error.help and error.expected


@needs("rs274")
@pytest.mark.parametrize("name", BOTH)
def test_rs274__mistakes_of_a_cycle__are_refused_by_both(name):
    with pytest.raises(OracleError):
        rs274(text_of(*BOTH[name][:2]))


def test_cycle__without_a_feed__is_refused():
    (error,) = errors_of(text_of(SHAFT, "G71 Q1 X6 Z1", "G18\n"))
    assert "no feed is set for G71" in error.what


def test_name_of_the_position__cannot_be_set():
    (error,) = errors_of("#<_x>=5\nM2")
    assert "read only" in error.what


# Limits


def long_contour(count: int) -> str:
    loop = "#1=[#1 + 1]\nG1 X[1 + [#1 MOD 2]] Z[-#1/100]\n"
    return f"O1 sub\nG0 X1 Z0\nO2 repeat [{count}]\n{loop}O2 endrepeat\nG1 X9\nO1 endsub\n"


@pytest.mark.parametrize(
    "contour, block, what",
    [
        (SHAFT, "G71 Q1 X6 Z1 I0.000000001", "I of G71 is 1e-09"),
        (SHAFT, "G71 Q1 X6 Z1 I0.0001", "more than 50000 moves"),
        (SHAFT, "G71 Q1 X9000000 Z1 I0.1", "more than 50000 moves"),
        (long_contour(3000), "G71 Q1 X10 Z1 I0.001", "looks at more than"),
        (long_contour(9000), "G70 Q1 X10 Z1 P1000", "more than 50000 moves"),
        (long_contour(11_000), "G71 Q1 X10 Z1", "more than 10000 moves"),
        ("O1 sub\nO2 while [1]\nO2 endwhile\nO1 endsub\n", "G71 Q1 X6", "characters of loops"),
        ("O1 sub\nO1 call\nO1 endsub\n", "G71 Q1 X6", "deeper than 9"),
    ],
)
def test_cycle__without_bound__ends_with_an_error_in_time(contour, block, what):
    began = time.process_time()
    with pytest.raises(GcodeErrors) as caught:
        for _ in stream(text_of(contour, block).splitlines(), start=ZERO):
            pass
    assert what in caught.value.errors[0].what
    assert time.process_time() - began < 20.0
