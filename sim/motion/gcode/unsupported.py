# SPDX-License-Identifier: Apache-2.0
"""Words of RS-274/NGC and Fanuc that are not accepted here: what they are, and why or what instead.

Those of LinuxCNC ("G Codes", "M Codes"), and the usual ones of Fanuc controls that shops meet.
"""

from __future__ import annotations

_SPINDLE = "the spindle has no output here"
_LATHE = "this machine is no lathe; write the passes as G0 and G1"
_IO = "there are no inputs and outputs for programs here"
_OVERRIDE = "the feed override (--override) is switched by M48, M49 and M50 P alone"
_OFF = "remove it; no word of this reader switches that on"
_AXIS = "the axes are X Y Z A C"
_LATHE_U = "only contours of G70 to G72 take U and W, as distances, and the allowance of G71 is D"

# (codes, what they are, why or what instead)
_TABLE = (
    ("G5.4 G6.2", "a NURBS of another control", "write it with G5.2 and G5.3"),
    ("G9", "an exact stop in one block", "write G61 before it and G64 after it"),
    ("G11", "the end of data input", "remove it; G10 acts in its block only"),
    ("G12 G13", "a circular pocket", "write the circles with G2 or G3"),
    ("G12.1 G13.1 G7.1 G107", "interpolation on a cylinder or face", "write the moves with A or C"),
    ("G16", "polar coordinates of Fanuc controls", "use @ radius and ^ angle"),
    ("G15", "the end of polar coordinates", f"{_OFF}; @ and ^ are for their block alone"),
    ("G17.1 G18.1 G19.1", "a plane of U V W", _AXIS),
    ("G22 G23", "limits of the stroke", "the workspace is always checked; remove it"),
    ("G27 G29 G30 G30.1", "another reference point", "use G28 with G28.1, or G53 G0"),
    ("G31", "a move up to a signal", "use G38.2 or G38.3"),
    ("G32 G34", "a thread of another control", "use G33 with K"),
    ("G35 G36", "a circular thread", "use G33 with K on straight lines"),
    ("G37 G37.1", "measuring of a tool", "give the length in the tool table (--tools)"),
    ("G43.1 G43.2", "an offset added to that of the tool", "put it into the tool table, use G43 H"),
    ("G43.5", "tool-centre control by vectors", "use G43.4 with A and C"),
    ("G44", "a negative tool length", "turn the sign in the tool table, use G43"),
    ("G45 G46 G47 G48", "tool offset of single moves", "use G41 or G42"),
    ("G51 G51.1", "scaling or a mirror", "multiply the coordinates, X[#1 * 2]"),
    ("G50 G50.1", "the end of scaling or of a mirror, or a greatest speed", _OFF),
    ("G54.1 G54.2", "a further coordinate system", "use G54 to G59.3"),
    ("G60", "positioning from one side", "write the way as two moves"),
    ("G62 G63", "an override mode", _OVERRIDE),
    ("G65 G66 G67", "a macro call of Fanuc controls", "use O<name> call [a] [b]"),
    ("G68", "a turned coordinate system", "use G10 L2 with R, or turn the points with SIN and COS"),
    ("G69", "the end of a turned coordinate system", f"{_OFF}; G10 L2 P0 R0 ends that of G10"),
    ("G68.2 G69.1 G53.1", "a tilted work plane", "use G43.4 with A and C"),
    ("G75 G76 G90.2 G92.4", "a lathe cycle", _LATHE),
    ("G84.1 G84.2 G84.3 G88", "rigid tapping, or a cycle with spindle stop", "use G33.1 with K"),
    ("G86 G87", "a boring cycle with spindle stop", "use G85 or G89"),
    ("G96", "a constant cutting speed", f"{_SPINDLE}; use G97 S"),
    ("M10 M11", "a clamp of an axis", _IO),
    ("M29", "rigid tapping", "use G33.1 with K"),
    ("M47", "a repeat of the program", "put it into O100 repeat [n], O100 endrepeat"),
    ("M51", "a switch of the spindle's override", _SPINDLE),
    ("M52", "a switch of adaptive feed", f"nothing measures the cut here; {_OVERRIDE}"),
    ("M53", "a switch of feed stop", f"no operator stops the feed here; {_OVERRIDE}"),
    ("M97", "a call of lines of the program", "write O100 sub ... O100 endsub, O100 call"),
)
_WORDS = {code: (name, cure) for codes, name, cure in _TABLE for code in codes.split()}

# (words, why): those that are read and change nothing.
IGNORED = (
    ("M7 M8 M9", "the coolant has no output here"),
    ("G97", "a constant speed of the spindle is the only kind here"),
    ("M62 M63 M64 M65 M67 M68", "signals of programs have no output here"),
    ("B0", "this machine has no axis B, so it stays at 0; any other B is refused"),
    ("N", "a number of the block; only comments and people refer to it"),
    ("O0001 O<name>", "number or name of the program, alone in the line before the first block; "
     "elsewhere a line with a number begins a subprogram of M98"),
    ("/", "block delete is off, as in a LinuxCNC that has just started; the block runs"),
    ("( ) ;", "comments, except (abort, text), which stops the program"),
)  # fmt: skip

# (word, letters, why): letters whose values are checked and change nothing.
IDLE_LETTERS = (
    ("M19", "RPQ", "the spindle has no output here; it and the path stop"),
    ("M66", "PELQ", "nothing is connected, so every input reads 0 at once (L0)"),
)

_LETTERS = {
    "B": ("an axis about Y", f"this machine has none; {_AXIS}"),
    "U": ("an axis along X", f"this machine has none; {_AXIS}; {_LATHE_U}"),
    "V": ("an axis along Y", f"this machine has none; {_AXIS}"),
    "W": ("an axis along Z", f"this machine has none; {_AXIS}; {_LATHE_U}"),
}


_OWN_PROGRAMS = "a program of the user's own", _IO


def known_word(code: str) -> tuple[str, str] | None:
    """What a G or M word is that other controls have, and why or what instead."""
    if code.startswith("M") and code[1:].isdigit() and 100 <= int(code[1:]) <= 199:
        return _OWN_PROGRAMS
    return _WORDS.get(code)


def refused_words() -> list[tuple[str, str, str]]:
    """The G and M words that other controls have: codes, what they are, why or what instead."""
    return [*_TABLE, ("M100 to M199", *_OWN_PROGRAMS)]


def refused_letters() -> list[tuple[str, str, str]]:
    """The same for letters."""
    return [(letter, *known) for letter, known in _LETTERS.items()]


def known_letter(letter: str) -> tuple[str, str] | None:
    """The same for letters."""
    return _LETTERS.get(letter)
