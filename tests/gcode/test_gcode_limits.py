# SPDX-License-Identifier: Apache-2.0
"""Input without bound: each has a limit, reported with line, cause and cure.

Time and memory are bounded by the campaigns of tests/fuzz/motion.py, which run these texts too.
"""

import itertools
import os

import pytest

from sim.motion.gcode import execution, interpreter
from sim.motion.gcode.branches import MAX_OPEN
from sim.motion.gcode.cycles import MAX_STEPS
from sim.motion.gcode.interpreter import GcodeErrors, parse, parse_file, stream
from sim.motion.trajectory.__main__ import main
from tests.gcode.mistakes import ZERO, refused

# Text, line, and parts of what and help.
HARD = {
    "loop on the spot": ("F9\no1 while [1]\nG1 X0\no1 endwhile\nM2", 4, "that goes", "loop"),
    "rests without end": ("o1 while [1]\nG4 P1\no1 endwhile\nM2", 3, "that goes", "condition"),
    "long rest": ("G4 P10000000\nM2", 1, "a rest of 1e+07 s", "P counts seconds"),
    "holes without end": ("G81 X1 Z-1 R1 L10000000 F9\nM2", 1, f"more than {MAX_STEPS}", "L and Q"),
    "pecks without end": ("G83 Z-1 R1 Q0.0000001 F9\nM2", 1, f"more than {MAX_STEPS}", "L and Q"),
    "a number of 4301 digits": (f"G0 X{'9' * 4301}\nM2", 1, "out of range", "decimal point"),
    "a parameter of 4301 digits": (f"G0 X#{'9' * 4301}\nM2", 1, "out of range", "decimal point"),
    "an argument of 4301 digits": (f"o1 call [{'9' * 4301}]\nM2", 1, "out of range", "decimal"),
    "a label of 4301 digits": (f"o{'9' * 4301} call\nM2", 1, "out of range", "decimal point"),
    "words without end": ("X1" * 10**7 + "\nM2", 1, "the line has more than", "one block"),
    "nested branches": ("".join(f"o{n} if [1]\n" for n in range(20_000)) + "M2",
                        MAX_OPEN + 1, f"nested deeper than {MAX_OPEN}", "closed"),
    "brackets": ("G0 X" + "[" * 4000 + "\nM2", 1, "nested too deeply", "parameters"),
    "signs": ("G0 X[" + "-" * 4000 + "1]\nM2", 1, "nested too deeply", "parameters"),
    "binary": ("G0 X1\n\0\1\2\xff", 2, "not a text", "binary"),
    "turns without end": ("G43.4 G1 A9999999 C9999999 F9\nM2", 1, "chords", "divide the move"),
}  # fmt: skip


@pytest.mark.parametrize("name", HARD)
def test_hard_input__has_a_limit_told_by_name(name, tmp_path, monkeypatch):
    text, line, what, help = HARD[name]
    file = tmp_path / "hard.ngc"
    file.write_text(text, encoding="latin-1")
    monkeypatch.setattr(execution, "MAX_AGAIN", 30_000)
    with pytest.raises(GcodeErrors) as caught:
        parse_file(file, ZERO)
    error = caught.value.errors[0]
    assert error.line == line
    assert what in error.what and help in error.help
    assert len(str(caught.value)) < 2000 * len(caught.value.errors)


def test_endless_moves__are_not_held_but_streamed(monkeypatch):
    monkeypatch.setattr(interpreter, "MAX_HELD", 1000)
    text = "F9\no1 while [1]\nG1 X1\nX0\no1 endwhile\nM2"
    assert "more than 1000 moves" in str(refused(text))
    assert len(list(itertools.islice(stream(text.splitlines()), 5000))) == 5000


def test_branches_beside_loops__take_time_in_proportion():
    """Many branches inside one loop."""
    inner = "".join(f"o{n} if [1]\nG0 X{n % 7}\no{n} endif\n" for n in range(2, 3000))
    moves = parse(f"o1 repeat [2]\n{inner}o1 endrepeat\nM2", start=ZERO).moves
    assert len(moves) == 2 * 2998


@pytest.mark.parametrize("kind", ["zero", "pipe", "folder", "none", "binary", "empty"])
def test_command__input_that_is_no_program__is_told_in_one_line(kind, tmp_path, capsys):
    path = tmp_path / kind
    if kind == "zero":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind != "none":
        path.write_bytes(os.urandom(100_000) + b"\0" if kind == "binary" else b"")
    assert main([str(path)]) == 1
    shown = capsys.readouterr().err
    assert f"{path}:" in shown and "error: " in shown
    assert main([__file__, "--tools", str(path)]) == 1
    assert "error: " in capsys.readouterr().err


def test_mistake__in_a_long_line__shows_its_surroundings_only():
    error = refused("(" + "a" * 5000 + ") G77 (" + "b" * 4000 + ")\nM2")
    _, source, marks = str(error).splitlines()
    assert len(source) < 300
    assert source.index("G77") == marks.index("^^^")
