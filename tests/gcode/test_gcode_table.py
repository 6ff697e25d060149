# SPDX-License-Identifier: Apache-2.0
"""The table of words (docs/gcode_words.md): each word and letter acts, is ignored, or is refused.

Each program below has one block about a word. The set-points change if the word is left out or
replaced, and if the value of any of its letters changes.
"""

from __future__ import annotations

import re

import pytest

from sim.motion.gcode.block import GROUPS, letters_of
from sim.motion.gcode.interpreter import GcodeErrors, parse
from sim.motion.gcode.tools import Tool
from sim.motion.gcode.unsupported import IDLE_LETTERS, IGNORED, refused_letters, refused_words
from sim.motion.geometry.override import overridden_program
from sim.motion.geometry.workspace import default_robot
from sim.motion.trajectory.program import plan

OVERRIDE = 60.0  # percent, so that M48 to M50 act
TOOLS = {
    1: Tool((0.0, 0.0, 2.0, 0.0, 0.0), 4.0),
    2: Tool((1.0, 2.0, 3.0, 1.0, 1.0), 6.0),
}
UNUSED = {word for words, _ in IGNORED for word in words.split()}
IDLE = {code: set(letters) for code, letters, _ in IDLE_LETTERS}
CODES = [code for codes in GROUPS.values() for code in codes if code not in UNUSED]
CORNER = "G1 X3 F6000\n{}\nX6 Y2\nY5"
CONTOURS = (
    "F6000 G18\nG0 X9 Z602\no1 sub\nG0 X3\nG1 Z600\nX2 Z599\nX4 Z598\nX2 Z596\nX6 Z594\no1 endsub\n"
    "o2 sub\nG0 X2\nG1 Z600\nX1 Z599\nX4 Z598\nX2 Z596\nX6 Z593\no2 endsub\n{}"
)
FACES = (
    "F6000 G18\nG0 X9 Z602\no1 sub\nG0 Z597\nG1 X7\nZ596 X6\nX4 Z598\nZ596 X3\nZ600 X1\no1 endsub\n"
    "o2 sub\nG0 Z597\nG1 X7\nZ595 X6\nX4 Z598\nZ596 X3\nZ600 X0\no2 endsub\n{}"
)
SHIFTED = "G92 X2 Y2 Z601 A1 C1\n{}\nG0 X3 Y3 Z602 A2 C2"

# Word: what to write instead of it ("" for nothing) and programs, in which {} is its block, as
# given after "|", and M2 follows. "P0->1" at the end: the other value of a word, which is else one
# more; "=": another program changes it.
PROGRAMS = {
    "G0": ("G1 F600", "{}|G0 X1 Y2 Z603 A4 C5", "G1 X3 F6000\n{}|G0 @4 ^9"),
    "G1": ("G0", "F600\n{}|G1 X1 Y2 Z603 A4 C5", "F600 G1 X3\n{}|G1 @4 ^9"),
    "G2": (
        "G3",
        "F6000\n{}|G2 X2 Y0 Z601 A2 C3 I1 J0 P1 | X2->2.02 Y0->0.02 I1->1.01 J0->0.02",
        "F6000 G18\n{}|G2 X2 I1 K0 | I1->1.01 K0->0.02 X2->2.02",
        "F6000\n{}|G2 X2 R1.5",
        "F6000 G0 X2\n{}|G2 @2 ^90 R3",
    ),
    "G3": (
        "G2",
        "F6000\n{}|G3 X2 Y0 Z601 A2 C3 I1 J0 P1 | X2->2.02 Y0->0.02 I1->1.01 J0->0.02",
        "F6000 G18\n{}|G3 X2 I1 K0 | I1->1.01 K0->0.02 X2->2.02",
        "F6000\n{}|G3 X2 R1.5",
        "F6000 G0 X2\n{}|G3 @2 ^90 R3",
    ),
    "G5": ("G1", "F6000\n{}|G5 X3 Y1 I1 J2 P-1 Q2"),
    "G5.1": ("G1", "F6000\n{}|G5.1 X3 Y1 I1 J2"),
    "G5.2": ("G1", "F6000\n{}|G5.2 X1 Y2 P2 L3\nX2 Y1 P1\nX4 Y3 P1\nX5 Y1 P1\nG5.3 | L3->4"),
    "G5.3": ("", "F6000 G5.2 X1 Y2 P2 L3\nX2 Y1 P1\nX4 Y3 P1\n{}|G5.3"),
    "G33": (
        "G1",
        "F600 S100 M3\n{}|G33 X1 Y2 Z603 A4 C5 K2",
        "F600 S100 M3 G1 X3\n{}|G33 @4 ^9 K2",
    ),
    "G33.1": (
        "G33",
        "F600 S100 M3\n{}|G33.1 X1 Y2 Z603 K2",
        "F600 S100 M3 G1 X3\n{}|G33.1 @4 ^9 K2",
    ),
    **{
        code: (
            "G0",
            "F600\n{}|%s X1 Y2 Z603 A4 C5",
            "F600 G1 X3\n{}|%s @4 ^9",
            "F600 G1 X3\n{}|%s X4\nG0 Y[#5061]",
        )
        for code in ("G38.2", "G38.3", "G38.4", "G38.5")
    },
    "M3": ("", "S100\n{}|M3\nG33 Z602 K1"),
    "M4": ("", "S100\n{}|M4\nG33 Z602 K1"),
    "M5": ("", "S100 M3\n{}|M5\nG33 Z602 K1"),
    "M19": (
        "",
        f"G64\n{CORNER}|M19 R90 P1 Q2 | R90->= P1->= Q2->=",
        "S100 M3\n{}|M19\nG0 X[#<_spindle_on> + 1]",
    ),
    "G80": ("", "F6000 G81 X1 Z601 R602\n{}|G80\nX2"),
    "G81": (
        "G83 Q0.3", "F6000\n{}|G81 X1 Y1 Z600 R602 L2", "F6000 G1 X3\n{}|G81 @3 ^5 Z600 R602",
    ),
    "G82": (
        "G83 Q0.3",
        "F6000\n{}|G82 X1 Y1 Z600 R602 L2 P0.1",
        "F6000 G1 X3\n{}|G82 @3 ^5 Z600 R602 P0",
    ),
    "G83": (
        "G81", "F6000\n{}|G83 X1 Y1 Z600 R602 L2 Q0.7", "F6000 G1 X3\n{}|G83 @3 ^5 Z600 R602 Q1",
    ),
    "G70": ("", f"{CONTOURS}|G70 Q1 X8 Z602 D0.5 E0.1 P2 | D0.5->0.8 E0.1->0.3"),
    **dict.fromkeys(
        ("G71", "G71.1", "G71.2"), ("", f"{CONTOURS}|%s Q1 X8 Z602 D0.3 I1.5 R0.4 | D0.3->0.5")
    ),
    **dict.fromkeys(
        ("G72", "G72.1", "G72.2"), ("", f"{FACES}|%s Q1 X9 Z602 D0.3 I1.5 R0.4 | D0.3->0.5")
    ),
    "G73": (
        "G81", "F6000\n{}|G73 X1 Y1 Z600 R602 L2 Q0.7", "F6000 G1 X3\n{}|G73 @3 ^5 Z600 R602 Q1",
    ),
    "G74": (
        "G82", "F6000 M4\n{}|G74 X1 Y1 Z600 R602 P0.1", "F6000 M4 G1 X3\n{}|G74 @3 ^5 Z600 R602 P0",
    ),
    "G84": (
        "G82",
        "F6000 M3\n{}|G84 X1 Y1 Z600 R602 L2 P0.1",
        "F6000 M3 G1 X3\n{}|G84 @3 ^5 Z600 R602 P0",
    ),
    "G85": (
        "G81", "F6000\n{}|G85 X1 Y1 Z600 R602 L2", "F6000 G1 X3\n{}|G85 @3 ^5 Z600 R602",
    ),
    "G89": (
        "G82",
        "F6000\n{}|G89 X1 Y1 Z600 R602 L2 P0.1",
        "F6000 G1 X3\n{}|G89 @3 ^5 Z600 R602 P0",
    ),
    "G17": ("", "F6000 G18\n{}|G17\nG2 X2 R1"),
    "G18": ("", "F6000\n{}|G18\nG2 X2 R1"),
    "G19": ("", "F6000\n{}|G19\nG2 Z602 R2"),
    "G20": ("", "{}|G20\nG0 X1"),
    "G21": ("", "G20\n{}|G21\nG0 X1"),
    "G90": ("", "G91 G0 X1\n{}|G90\nX2"),
    "G91": ("", "G0 X1\n{}|G91\nX2"),
    "G90.1": ("", "F6000 G0 X3\n{}|G90.1\nG2 X5 I4 J0"),
    "G91.1": ("", "F6000 G0 X3 G90.1\n{}|G91.1\nG2 X5 I1 J0"),
    "G93": ("", "G94 F1000\n{}|G93\nG1 X2 F1000"),
    "G94": ("", "G93\n{}|G94\nG1 X2 F1000"),
    "G95": ("", "G94 F10 S100 M3\n{}|G95\nG1 X2 F10"),
    "G54": ("", "G10 L2 P1 X1\nG55\n{}|G54\nG0 X3"),
    **{
        f"G{n}": ("", f"G10 L2 P{p} X1\n{{}}|G{n}\nG0 X3")
        for p, n in enumerate((55, 56, 57, 58, 59, 59.1, 59.2, 59.3), start=2)
    },
    "G61": ("", f"G64\n{CORNER}|G61"),
    "G61.1": ("", f"{CORNER}|G61.1"),
    "G64": (
        "",
        f"{CORNER}|G64 P0.1",
        "F6000\n{}|G64 P0.05 Q0.1\nG1 X3\nX3.1 Y0.04\nX3.2 Y0\nX5\nY5 | P0.05->0.4 Q0.1->0",
    ),
    "G40": ("", "F6000 G41.1 D1\nG1 X3\nX6\n{}|G40\nX9 Y1"),
    "G41": ("", "F6000\n{}|G41 D1\nG1 X9\nX19"),
    "G42": ("", "F6000\n{}|G42 D1\nG1 X9\nX19"),
    "G41.1": ("", "F6000\n{}|G41.1 D1\nG1 X3\nX6"),
    "G42.1": ("", "F6000\n{}|G42.1 D1\nG1 X3\nX6"),
    "G43": ("", "{}|G43 H1\nG0 X1 Z601"),
    "G43.4": ("", "{}|G43.4\nG0 X1 A5"),
    "G49": ("", "G43 H2\n{}|G49\nG0 X1"),
    "G7": ("", "{}|G7\nG0 X1"),
    "G8": ("", "G7\n{}|G8\nG0 X1"),
    "G98": ("", "F6000 G99 G81 X1 Z598 R599\n{}|G98\nX2"),
    "G99": ("", "F6000 G98 G81 X1 Z598 R599\n{}|G99\nX2"),
    "G4": ("", "G0 X1\n{}|G4 P0.1"),
    "G10": (
        "",
        "{}|G10 L2 P1 X1 Y2 Z3 A4 C5\nG0 X3 Y3 Z602 A2 C2 | L2->=",
        "{}|G10 P1 L2 X1\nG0 X3 | L2->20",
        "{}|G10 P1 L2 R6\nG0 X3 | L2->=",
        "{}|G10 L20 P0 X1 Y2 Z601 A4 C5\nG0 X3 Y3 Z602 A2 C2 | P0->2 L20->=",
        "{}|G10 L1 P1 X1 Y2 Z3 A4 C5\nG43 H1\nG0 X3 Y3 Z602 A2 C2 | L1->=",
        "{}|G10 L10 P1 X1 Y2 Z599 A4 C5\nG43 H1\nG0 X3 Y3 Z602 A2 C2 | L10->=",
        "F6000\n{}|G10 L1 P1 R3\nG41 D1\nG1 X9\nX19 | L1->=",
        "T1 M6\n{}|G10 L1 P1 Q3\nG0 X[#5413 + 1] | L1->=",
        "G92 X5\n{}|G10 L11 P1 X1 Z599\nG43 H1\nG0 X3 Z600 | L11->10",
    ),
    "G52": ("", "{}|G52 X1 Y1 Z-1 A1 C1\nG0 X3 Y3 Z602 A2 C2"),
    "G28": ("", "G0 X3\n{}|G28 X2 Y2 Z602 A2 C2"),
    "G28.1": ("", "G0 X3\n{}|G28.1\nG0 X5\nG28"),
    "G53": ("", "G10 L2 P1 X1\n{}|G53 G0 X3"),
    "G92": ("", "{}|G92 X1 Y1 Z601 A1 C1\nG0 X3 Y3 Z602 A2 C2"),
    "G92.1": ("", f"{SHIFTED}|G92.1"),
    "G92.2": ("", f"{SHIFTED}|G92.2"),
    "G92.3": ("", "G92 X2\nG92.2\n{}|G92.3\nG0 X3"),
    **dict.fromkeys(("M2", "M30"), ("", "G0 X1\n{}|%s\nX2")),
    **dict.fromkeys(("M0", "M1", "M60"), ("", f"G64\n{CORNER}|%s")),
    "M6": ("", f"G64 T1\n{CORNER}|M6"),
    "M61": ("", "{}|M61 Q1\nG43\nG0 X1 Z601"),
    "M66": (
        "",
        f"G64\n{CORNER}|M66 P1 L0 | P1->= L0->=",
        f"G64\n{CORNER}|M66 E1 | E1->=",
        "#5399 = 3\n{}|M66 P1\nG0 X[#5399 + 1] | P1->=",
    ),
    "M70": ("", "G0 X1\n{}|M70\nG91\nM72\nX2"),
    "M71": ("", "G0 X1\nM70\n{}|M71\nM72"),
    "M72": ("", "G0 X1\nM70\nG91\n{}|M72\nX2"),
    "M73": ("", "o1 sub\n{}|M73\nG91\no1 endsub\nG0 X1\no1 call\nX2"),
    "M98": ("", "{}|M98 P7 L2\nM2\nO7\nG91 G0 X1\nM99\nO8\nG0 X3\nM99"),
    "M99": ("", "M98 P7 L2\nM2\nO7\nG91 G0 X1\n{}|M99"),
    "M48": ("", "M49\n{}|M48\nG1 X2 F1000"),
    "M49": ("", "{}|M49\nG1 X2 F1000"),
    "M50": ("", "{}|M50 P0\nG1 X2 F1000", "M49\n{}|M50\nG1 X2 F1000"),
}  # fmt: skip
SIGNALS = {
    **{f"M{number}": f"M{number} P1" for number in (62, 63, 64, 65)},
    **{f"M{number}": f"M{number} E0 Q2.5" for number in (67, 68)},
}
REFUSED_WITH = {"G80", "M71", "M5"}  # the word makes the block after it wrong


def programs(code: str) -> list[tuple[str, str, dict[str, str]]]:
    """Text with {} for the block, the block, and other values of its words."""
    found = []
    for text in PROGRAMS[code][1:]:
        before, _, rest = text.partition("|")
        block, _, after = rest.partition("\n")
        # The text after the block ends where other values begin.
        after, _, other = after.partition(" | ") if after else ("", "", "")
        if not after:
            block, _, other = block.partition(" | ")
        block = block.replace("%s", code)
        values = dict(pair.split("->") for pair in other.split())
        found.append((f"{before}\n{after}\nM2\n", block, values))
    return found


def outcome(text: str) -> bytes | str:
    """Set-points of a program, or how it is refused."""
    robot = default_robot()
    try:
        program = parse(text, tools=TOOLS)
        if not program.moves:
            return b"no move"
        path = plan(overridden_program(program, OVERRIDE), robot)
    except GcodeErrors as errors:
        return errors.errors[0].what
    return path.position.tobytes()


def without(block: str, code: str, instead: str) -> str:
    return re.sub(rf"(?<![A-Z\d.]){re.escape(code)}(?![\d.])", instead, block)


@pytest.mark.parametrize("code", CODES)
def test_word__of_the_table__acts_with_each_of_its_letters(code):
    letters = set()
    for text, block, values in programs(code):
        acting = outcome(text.format(block))
        assert isinstance(acting, str) == (code in REFUSED_WITH), acting
        words = re.findall(r"[A-FH-LN-Z@^][-+]?[\d.]+", without(block, code, ""))
        for word in words:
            value = values.get(word, f"{float(word[1:]) + 1:g}")
            if value == "=":
                continue
            other = word[0] + value
            changed = outcome(text.format(block.replace(word, other)))
            assert isinstance(changed, bytes), f"{block} with {other}: {changed}"
            assert changed != acting, f"{block} with {other}"
            letters.add(word[0])
        left = outcome(text.format(without(block, code, PROGRAMS[code][0])))
        assert left != acting, block
    letters |= IDLE.get(code, set())
    assert set(letters_of(code)) <= letters, "a letter of the table has no program here"


def test_speed_of_the_spindle__is_the_feed_of_a_thread():
    text = "S{} M3\nG33 Z602 K1\nM2"
    assert outcome(text.format(100)) != outcome(text.format(120))


@pytest.mark.parametrize("word", sorted(UNUSED - {"(", ")", ";", "O0001", "O<name>", "/"}))
def test_word__ignored__changes_nothing(word):
    text = "{}\nG0 X1\nM2"
    shown = {"N": "N7", **SIGNALS}.get(word, word)
    assert outcome(text.format(shown)) == outcome(text.format(""))


def test_words__that_other_controls_have__are_refused_by_name():
    for words, what, _ in refused_words():
        for code in words.replace("to", "").split():
            assert what in outcome(f"G0 X1 F100\n{code}\nM2")
    for letter, what, _ in refused_letters():
        assert what in outcome(f"G0 X1 {letter}1\nM2")


def test_words__of_no_list__are_refused():
    known = {*CODES, *UNUSED, *(c for words, *_ in refused_words() for c in words.split())}
    known |= {f"M{number}" for number in range(100, 200)}
    for letter in "GM":
        for tenths in range(0, 2000):
            code = f"{letter}{tenths / 10:g}"
            if code not in known:
                assert outcome(f"{code}\nM2") == f"{code} is not a known word"
    for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ@^":
        if letter not in "GMNFSTO" and not any(letter in letters_of(code) for code in CODES):
            assert letter in {refused for refused, *_ in refused_letters()}
