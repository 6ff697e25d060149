# SPDX-License-Identifier: Apache-2.0
"""Words of a block by letter, G and M words by modal group (NISTIR 6556, 3.4), and their mistakes.

GROUPS is the list of accepted G and M words.
"""

from __future__ import annotations

from sim.motion.gcode.unsupported import known_letter, known_word
from sim.motion.gcode.words import OFFSETS, Word, WordReport
from sim.motion.geometry.moves import AXES, Motion, Plane

MAX_LINE_NUMBER = 9_999_999  # CAM writes more than the 99 999 of NISTIR 6556, 3.3.1

TAPS = {"G74": "M4", "G84": "M3"}
"""Tapping cycles: the word by which the spindle turns."""
CYCLES = ("G73", "G81", "G82", "G83", "G85", "G89", *TAPS)
SPLINES = ("G5", "G5.1", "G5.2", "G5.3")
THREADS = ("G33", "G33.1")
LATHE = ("G70", "G71", "G71.1", "G71.2", "G72", "G72.1", "G72.2")
PROBES = ("G38.2", "G38.3", "G38.4", "G38.5")
ENDS = ("M2", "M30")
PAUSES = ("M0", "M1", "M60")
SYSTEMS = tuple(f"G{n}" for n in range(54, 60)) + ("G59.1", "G59.2", "G59.3")
GROUPS = {
    "motion": (
        *(*(motion.value for motion in Motion), *SPLINES, *THREADS, *PROBES),
        *("G80", *CYCLES, *LATHE),
    ),
    "plane": tuple(plane.value for plane in Plane),
    "unit": ("G20", "G21"),
    "distance": ("G90", "G91"),
    "arc distance": ("G90.1", "G91.1"),
    "feed mode": ("G93", "G94", "G95"),
    "spindle mode": ("G97",),
    "coordinate system": SYSTEMS,
    "path control": ("G61", "G61.1", "G64"),
    "cutter compensation": ("G40", "G41", "G42", "G41.1", "G42.1"),
    "tool": ("G43", "G43.4", "G49"),
    "lathe": ("G7", "G8"),
    "retract": ("G98", "G99"),
    "single": ("G4", "G10", "G28", "G28.1", "G52", "G53", "G92", "G92.1", "G92.2", "G92.3"),
    "stop": (*ENDS, *PAUSES, "M70", "M71", "M72", "M73", "M98", "M99"),
    "spindle": ("M3", "M4", "M5", "M19"),
    "coolant": ("M7", "M8", "M9"),
    "tool change": ("M6", "M61"),
    "signal": ("M62", "M63", "M64", "M65", "M66", "M67", "M68"),
    "override": ("M48", "M49", "M50"),
}
_GROUP_OF = {code: group for group, codes in GROUPS.items() for code in codes}
POLAR = "@^"
_VALUE_LETTERS = AXES + OFFSETS + "RFNPQLSTHDE" + POLAR


_PLACE = AXES + POLAR
_MOVES = {
    **dict.fromkeys(("G0", "G1", *PROBES), _PLACE),
    **{"G33": _PLACE + "K", "G33.1": "XYZ@^K"},
    **dict.fromkeys(("G2", "G3"), _PLACE + OFFSETS + "RP"),
    **{"G81": "XYZ@^RL", "G82": "XYZ@^RLP", "G83": "XYZ@^RLQ"},
    **{"G73": "XYZ@^RLQ", "G85": "XYZ@^RL", "G89": "XYZ@^RLP"},
    **{"G74": "XYZ@^RP", "G84": "XYZ@^RLP"},  # as LinuxCNC: no L for G74
    **{"G5": "XYIJPQ", "G5.1": "XYIJ", "G5.2": "XYPL", "G5.3": ""},
}
"""Letters that a motion uses."""

_ACTS = {
    **{"G10": AXES + "PLRQ", "G28": AXES, "G28.1": "", "G4": "P"},
    **dict.fromkeys(("G52", "G92"), AXES),
    **{"G43": "H", "G64": "PQ", "M50": "P", "M98": "PL"},
    **{"M19": "RPQ", "M61": "Q", "M66": "PELQ"},
    **dict.fromkeys(("M62", "M63", "M64", "M65"), "P"),
    **dict.fromkeys(("M67", "M68"), "EQ"),
    **dict.fromkeys(("G41", "G42", "G41.1", "G42.1"), "D"),
    **{"G70": "QXZDEP", **dict.fromkeys(LATHE[1:], "QXZDIR")},
}
"""Letters that another word uses."""

_OF_SYSTEMS = {2.0: "PLR", 20.0: "PL"}  # letters of G10 but the axes, by L

_OWN_WORDS = ("G10", "G28", "G28.1", "G52", "G92", *LATHE)  # the motion in force does not run


def letters_of(code: str) -> str:
    """Letters with values that a G or M word takes in its block."""
    return _MOVES.get(code, "") + _ACTS.get(code, "")


def sort_words(
    words: list[Word], report: WordReport, more: str = ""
) -> tuple[dict[str, Word], dict[str, Word]]:
    """Words with values by letter, without N, and G, M words by modal group; more: letters that
    are good here alone."""
    values: dict[str, Word] = {}
    codes: dict[str, Word] = {}
    absent: Word | None = None
    for position, word in enumerate(words):
        if word.letter in "GM":
            group = _GROUP_OF.get(word.code)
            if group is None:
                _report_unknown(word, report)
            elif word.code == "G80" and group in codes and codes[group].code in ("G0", "G1"):
                pass  # the cycle ends by the other motion too
            elif group in codes and not (codes[group].code == "G80" and word.code in ("G0", "G1")):
                report(
                    word,
                    f"second word of the {group} group in one block",
                    f"one of {' '.join(GROUPS[group])}",
                    f"keep {codes[group].text} or move {word.text} to a block of its own",
                )
            else:
                codes[group] = word
        elif word.letter == "B" and word.value == 0.0:
            absent = word
        elif word.letter not in _VALUE_LETTERS + more:
            known = known_letter(word.letter)
            report(
                word,
                f"{word.letter}, {known[0]}" if known else f"unknown word {word.letter}",
                "one of G M N F S T X Y Z A C @ ^ I J K R P Q L H D E",
                known[1] if known else "text that is not code belongs into a comment ( )",
            )
        elif word.letter in values:
            report(
                word,
                f"second {word.letter} word in one block",
                f"at most one {word.letter} word",
                f"keep one of {values[word.letter].text} and {word.text}",
            )
        elif word.letter == "N":
            _check_line_number(word, position == 0, report)
            values["N"] = word
        else:
            values[word.letter] = word
    values.pop("N", None)
    home = codes.get("single")
    if absent is not None and home is not None and home.code == "G28":
        report(
            absent,
            "G28 of an axis that this machine lacks",
            "G28 of X Y Z A C, or alone for all of them",
            f"remove {absent.text}, or the block if it has no other axis",
        )
    spindle = values.get("S")
    if spindle is not None and spindle.value < 0.0:
        report(
            spindle,
            "the speed of the spindle is negative",
            "S of 0 or more",
            "M4 turns it back",
        )
    return values, codes


def _report_unknown(word: Word, report: WordReport) -> None:
    known = known_word(word.code)
    expected = f"{'a G' if word.letter == 'G' else 'an M'} word of docs/gcode.md"
    if known is not None:
        report(word, f"{word.code}, {known[0]}, is not supported", expected, known[1])
        return
    near = [code for code in _GROUP_OF if code.split(".")[0] == word.code.split(".")[0]]
    help = f"did you mean {' or '.join(near)}?" if near else "remove the word"
    report(word, f"{word.code} is not a known word", expected, help)


def _check_line_number(word: Word, first: bool, report: WordReport) -> None:
    if not 0 <= word.value <= MAX_LINE_NUMBER:
        report(
            word,
            "the line number is not valid",
            f"a number from 0 to {MAX_LINE_NUMBER}",
            "line numbers are optional; remove it",
        )
    elif not first:
        report(
            word,
            "the line number is not at the start of the block",
            "N as the first word",
            f"move {word.text} to the front",
        )


def check_unused(
    values: dict[str, Word],
    codes: dict[str, Word],
    motion: str | None,
    feed: Word | None,
    report: WordReport,
) -> None:
    """Reports each word with a value that nothing in the block uses; motion: the one in force;
    feed: F under G93, which is for the block's own move, or with a thread, which has none."""
    acting = {word.code: _ACTS.get(word.code, "") for word in codes.values()}
    places = _PLACE if acting.keys() & {"G4", "M19"} else _PLACE + OFFSETS + "R"
    if motion in SPLINES:
        acting[motion] = _MOVES[motion]
    elif acting.keys().isdisjoint(_OWN_WORDS) and any(letter in values for letter in places):
        # Without a motion a place is another mistake.
        acting[motion or ""] = _MOVES.get(motion or "", _MOVES["G2"])
    if "G10" in acting and "L" in values and values["L"].value in _OF_SYSTEMS:
        acting["G10"] = AXES + _OF_SYSTEMS[values["L"].value]
    if feed is not None and motion in THREADS:
        if motion in acting:
            report(
                feed,
                f"F with {motion}",
                "K and S, which give its feed",
                f"move {feed.text} to a block of its own",
            )
    elif feed is not None and (motion not in acting or motion == "G0"):
        report(
            feed,
            f"no move of the block uses {feed.text}",
            "G1, G2, G3 or a spline in the block: under G93, F is for one block",
            f"remove {feed.text}",
        )
    for letter in "PQLRE":
        owners = [code for code, own in acting.items() if code and letter in own]
        if letter in values and len(owners) > 1:
            report(
                values[letter],
                f"{values[letter].text} belongs to {owners[0]} and to {owners[1]}",
                f"one word with {letter} in a block",
                f"move {owners[0]} to a block of its own",
            )
    used = "".join(acting.values())
    owner = next((code for code, own in acting.items() if code and own), "this block")
    for letter, word in values.items():
        if letter in used:
            continue
        others = [code for code, own in {**_MOVES, **_ACTS}.items() if letter in own]
        extruder = " alone; there is no extruder here" if letter == "E" else ""
        report(
            word,
            f"{letter} does not belong to {owner}",
            f"no word but {' '.join(dict.fromkeys(used))} with it" if used else "no such word",
            f"remove {word.text}; {letter} is for {' '.join(others)}{extruder}",
        )
