# SPDX-License-Identifier: Apache-2.0
"""O words: order of the lines that run, parameters of calls, memory held, and every mistake.

Expectations are from the O code chapter of LinuxCNC's manual; where rs274 is there, each program
is also read by it and must give the same moves.
"""

import itertools
import tracemalloc

import pytest

from sim.motion.gcode import execution
from sim.motion.gcode.execution import LINE_COST, MAX_AGAIN
from sim.motion.gcode.interpreter import GcodeErrors, _Parser, parse, parse_file, stream
from sim.motion.gcode.oracle import OracleError, differences, rs274
from sim.motion.gcode.oword import ARGUMENTS
from sim.motion.gcode.subroutines import MAX_DEPTH
from tests.bench.needs import needs
from tests.gcode.mistakes import ZERO, check_error, errors_of


def xs(text: str) -> list[float]:
    return [move.end[0] for move in parse(text, start=ZERO).moves]


# Text, and the x of its moves.
PROGRAMS = {
    "if": ("#1=2\no1 if [#1 GT 1]\nG0 X1\no1 endif\no2 if [#1 LT 1]\nX2\no2 endif\nX3", [1, 3]),
    "else": ("o1 if [0]\nG0 X1\no1 else\nG0 X2\no1 endif\nX3", [2, 3]),
    "first branch": ("o1 if [1]\nG0 X1\no1 elseif [1]\nX2\no1 else\nX3\no1 endif\nX4", [1, 4]),
    "elseif": (
        "o1 if [0]\nG0 X1\no1 elseif [0]\nX2\no1 elseif [5]\nG0 X3\no1 elseif [1]\nX4\no1 else\n"
        "X5\no1 endif",
        [3],
    ),
    "while": ("#1=0\no1 while [#1 LT 3]\nG0 X#1 Y1\n#1=[#1+1]\no1 endwhile\nX9", [0, 1, 2, 9]),
    "while never": ("o1 while [0]\nG0 X1\no1 endwhile\nG0 X9", [9]),
    "do": ("#1=5\no1 do\nG0 X#1\n#1=[#1+1]\no1 while [#1 LT 5]\nX9", [5, 9]),
    "do again": ("#1=5\no1 do\nG0 X#1\n#1=[#1+1]\no1 while [#1 LT 7]", [5, 6]),
    "repeat": ("G91\no1 repeat [3]\nG0 X1\no1 endrepeat\nG90 X9", [1, 2, 3, 9]),
    "repeat never": ("o1 repeat [0]\nX1\no1 endrepeat\no2 repeat [-3]\nX2\no2endrepeat\nG0X3", [3]),
    "repeat rounded": ("G91\no1 repeat [2.4]\nG0X1\no1 endrepeat\no2 repeat [2.6]\nX1\no2endrepeat",
                       [1, 2, 3, 4, 5]),
    "loops in loops": (
        "G91\no1 repeat [2]\no2 repeat [2]\nG0 X1\no2 endrepeat\nX10\no1 endrepeat",
        [1, 2, 12, 13, 14, 24],
    ),
    "break": (
        "#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 GT 2]\no1 break\no2 endif\nG0 X#1\no1 endwhile\n"
        "o3 if [1]\nX9\no3 endif",
        [1, 2, 9],
    ),
    "break of the outer loop": (
        "o1 while [1]\nG0 X1\no2 while [1]\nX2\no1 break\no2 endwhile\no1 endwhile\nX3",
        [1, 2, 3],
    ),
    "continue": (
        "#1=0\no1 while [#1 LT 4]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 endif\nG0 X#1\n"
        "o1 endwhile",
        [1, 3, 4],
    ),
    "continue in do": (
        "#1=0\no1 do\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 endif\nG0 X#1\n"
        "o1 while [#1 LT 4]",
        [1, 3, 4],
    ),
    "subroutine": ("o1 sub\nG0 X#1\nX#2\no1 endsub\no1 call [3] [4]\no1 call [5]", [3, 4, 5, 0]),
    "subroutine behind": ("o1 call [3]\nG0 X7\nM2\no1 sub\nG0 X#1\no1 endsub", [3, 7]),
    "call of a later one": (
        "o1 sub\nG0 X1\no2 call\nX3\no1 endsub\no2 sub\nX2\no2 endsub\no1 call\no1 call",
        [1, 2, 3, 1, 2, 3],
    ),
    "arguments given back": (
        "#1=4 #2=5 #30=6 #31=7\no1 sub\n#1=11 #2=12 #30=13 #31=14\no1 endsub\no1 call [9]\n"
        "G0 X#1\nX#2\nX#30\nX#31",
        [4, 5, 6, 14],
    ),
    "arguments left out": ("#2=5\no1 sub\nG0 X#1\nX#2\no1 endsub\no1 call [9]", [9, 0]),
    "thirty arguments": (
        "o1 sub\nG0 X#1\nX#30\no1 endsub\no1 call" + "".join(f" [{n}]" for n in range(1, 31)),
        [1, 30],
    ),
    "names are local": (
        "#<a>=1\no1 sub\nG0 X[EXISTS[#<a>]+5]\n#<a>=9\n#<b>=9\nX#<a>\no1 endsub\no1 call\n"
        "X#<a>\nX[EXISTS[#<b>]+6]",
        [5, 9, 1, 6],
    ),
    "global names": (
        "#<_my count>=1\no1 sub\n#<_MyCount>=[#<_mycount>*2]\no1 endsub\no1 call\no1 call\n"
        "G0 X#<_mycount>",
        [4],
    ),
    "value of endsub": ("o1 sub\no1 endsub [#1*2]\no1 call [4]\nG0 X#<_value>\nX#<_value_returned>",
                        [8, 1]),
    "value of return": (
        "o1 sub\no2 if [#1 GT 0]\no2 return [7]\no2 endif\nG0 X3\no1 endsub\no1 call [1]\n"
        "G0 X#<_value>\no1 call\nX[#<_value>+#<_value_returned>+5]",
        [7, 3, 5],
    ),
    "return from loops": (
        "o1 sub\no2 while [1]\no3 repeat [5]\nG0 X1\no1 return\no3 endrepeat\no2 endwhile\n"
        "o1 endsub\no1 call\nX2\no1 call",
        [1, 2, 1],
    ),
    "recursion": (
        "o1 sub\nG0 X#1\no2 if [#1 GT 0]\no1 call [#1-1]\nX[#1+10]\no2 endif\no1 endsub\n"
        "o1 call [2]",
        [2, 1, 0, 11, 12],
    ),
    "same numbers elsewhere": (
        "o1 sub\no7 while [#1 GT 0]\nG0 X#1\n#1=[#1-1]\no7 endwhile\no1 endsub\n#5=0\n"
        "o7 while [#5 LT 2]\no1 call [2]\n#5=[#5+1]\no7 endwhile",
        [2, 1, 2, 1],
    ),
    "names of any case": ("o<My Part> sub\nG0 X#1\nO<mypart> endsub\nO<MYPART> CALL [4]", [4]),
    "computed labels": ("#5=100\no#5 if [1]\nG0 X5\no100 endif\no[#5+1] sub\nX#1\no101 endsub\n"
                        "o[#5+1] call [6]", [5, 6]),
    "no blanks": ("o1sub\nG0X#1\no1endsub\nN20o1call[3](rest);rest", [3]),
    "comments": ("o1 sub (a) ; b\nG0X#1 Y#2\no1 endsub\no1 call (a) [1] (b) [2] (c)", [1]),
    "end in a branch": ("G0 X1\no1 if [1]\nM2\no1 endif\nX2", [1]),
    "end in a subroutine": ("o1 sub\nG0 X1\nM2\no1 endsub\no1 while [1]\no1 call\no1 endwhile\nX2",
                            [1]),
    "percent lines": ("%\no1 repeat [2]\nG0 X1\nX2\no1 endrepeat\n%", [1, 2, 1, 2]),
    "nearly equal": ("o1 if [1 EQ 1.00009]\nG0 X1\no1 endif\no2 if [1 NE 1.00011]\nG0 X2\no2 endif",
                     [1, 2]),
}  # fmt: skip
HAVE_END = {"subroutine behind", "end in a branch", "end in a subroutine", "percent lines"}


def ended(name: str) -> str:
    text = PROGRAMS[name][0]
    return text if name in HAVE_END else f"{text}\nM2"


@pytest.mark.parametrize("name", PROGRAMS)
def test_o_words__each__run_their_lines_in_order(name):
    assert xs(ended(name)) == PROGRAMS[name][1]


@needs("rs274")
@pytest.mark.parametrize("name", PROGRAMS)
def test_o_words__each__give_the_moves_of_rs274(name):
    assert differences(ended(name)) == []


def test_lines_that_do_not_run__are_not_read():
    text = "o1 if [0]\nany text ! #\no1 else\nG0 X1\no1 endif\no2 sub\nX[1/0] oo\no2 endsub\nM2"
    assert xs(text) == [1]


def test_move__in_a_subroutine__has_the_line_of_its_text():
    program = parse("o1 sub\nG0 X#1\no1 endsub\no1 call [1]\no1 call [2]\nM2")
    assert [(move.line, move.source) for move in program.moves] == [(2, "G0 X#1")] * 2


def test_calls_inside_calls__to_the_limit__run():
    text = "o1 sub\nG0 X#1\no2 if [#1 GT 1]\no1 call [#1-1]\no2 endif\no1 endsub\no1 call [{}]\nM2"
    assert len(xs(text.format(MAX_DEPTH))) == MAX_DEPTH
    (error,) = errors_of(text.format(MAX_DEPTH + 1))
    assert (error.line, error.column) == (4, 1)
    assert f"deeper than {MAX_DEPTH}" in error.what


@needs("rs274")
def test_calls_inside_calls__one_more_than_the_limit__are_refused_by_rs274_too():
    text = "o1 sub\no2 if [#1 GT 1]\no1 call [#1-1]\no2 endif\no1 endsub\nG0X1\no1 call [{}]\nM2"
    rs274(text.format(MAX_DEPTH))
    with pytest.raises(OracleError):
        rs274(text.format(MAX_DEPTH + 1))


def test_loop_without_a_move__ends_with_its_place():
    (error,) = errors_of("G0 X1\n#1=0\n o1 while [#1 LT 1]\n#2=1\n o1 endwhile\nM2")
    assert (error.file, error.line, error.column) == ("part.ngc", 5, 2)
    assert f"runs {MAX_AGAIN} characters of loops" in error.what and "without a move" in error.what
    assert "condition" in error.help


@pytest.mark.parametrize("comment", ["", "(" + "-" * 200 + ")"])
def test_loop_without_a_move__costs_by_its_characters(comment, monkeypatch):
    monkeypatch.setattr(execution, "MAX_AGAIN", 10_000)
    body = [f"G4 P1 {comment}", "o1 endwhile"]
    rests = []
    with pytest.raises(GcodeErrors):
        for item in stream(["o1 while [1]", *body, "M2"]):
            rests.append(item)
    again = sum(len(line) + LINE_COST for line in ["o1 while [1]", *body])
    assert abs(len(rests) - 10_000 / again) <= 2


@pytest.mark.parametrize(
    "text",
    [
        "o1 do\no1 while [1]\nM2",
        "o1 repeat [1000]\no1 endrepeat\nM2",
        "o1 while [1]\no1 continue\no1 endwhile\nM2",
        "o1 sub\no1 endsub\no2 repeat [1000]\no1 call\no2 endrepeat\nM2",
    ],
)
def test_endless__of_each_kind__ends(text, monkeypatch):
    monkeypatch.setattr(execution, "MAX_AGAIN", 1000)
    (error,) = errors_of(text)
    assert "runs 1000 characters of loops and calls again" in error.what


def test_loop_with_moves__longer_than_the_limit__runs(monkeypatch):
    monkeypatch.setattr(execution, "MAX_AGAIN", 2000)
    assert len(xs("G91\no1 repeat [200]\nG0 X1\no1 endrepeat\nM2")) == 200
    assert len(parse("o1 repeat [50]\nG4 P1\no1 endrepeat\nM2").dwells) == 50
    with pytest.raises(GcodeErrors):  # rests alone go nowhere
        parse("o1 repeat [200]\nG4 P1\no1 endrepeat\nM2")


def test_long_text__without_o_words__is_not_held():
    def lines():
        yield "o1 sub\n"
        yield "G0 X1\n"
        yield "o1 endsub\n"
        yield "o2 if [1]\n"
        for k in itertools.count():
            yield f"G1 X{k % 100} F100\n"

    moves = stream(lines(), start=ZERO)
    tracemalloc.start()
    for _ in itertools.islice(moves, 4000):  # fills Python's own store of tuples
        pass
    before = tracemalloc.get_traced_memory()[0]
    for _ in itertools.islice(moves, 3000):
        pass
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 30_000  # 3000 lines of text held would be ten times more


def test_loop__when_it_has_ended__is_not_held():
    lines = ["o1 sub", "G0 X#1", "o1 endsub", "o9 repeat [2]", *["G0 X1"] * 50, "o9 endrepeat"]
    parser = _Parser([*lines, "G0 X3", "G0 X4", "M2"], "text", ZERO, {})
    sizes = [(move.end[0], len(parser.flow.kept)) for move in parser.items()]
    assert max(size for _, size in sizes) > 50
    assert sizes[-1] == (4.0, 0)
    assert len(parser.flow.bodies) == 3


# Text, line, column, offending text, parts of what and of expected. rs274 refuses all but OURS.
MISTAKES = {
    "while not closed": ("o1 while [0]\nG0 X1\nM2", 1, 1, "o1 while", "not closed", "o1 endwhile"),
    "while not closed, run": ("o1 while [1]\nG0X1\nM2", 1, 1, "o1 while", "not closed", "endwhile"),
    "if not closed": ("G0X1\nN5 o1 if [0]\nM2", 2, 4, "o1 if", "o1 if is not closed", "o1 endif"),
    "if not closed, run": ("o1 if [1]\nG0 X1\nM2", 1, 1, "o1 if", "not closed", "o1 endif"),
    "if not closed, no end": ("o1 if [1]\nG0 X1", 1, 1, "o1 if", "not closed", "o1 endif"),
    "do not closed": ("o1 do\nG0 X1\nM2", 1, 1, "o1 do", "o1 do is not closed", "o1 while"),
    "repeat not closed": ("o<a> repeat [0]\nM2", 1, 1, "o<a> repeat", "closed", "o<a> endrepeat"),
    "sub not closed": ("G0 X1\no1 sub\nX2\nM2", 2, 1, "o1 sub", "o1 sub is not closed", "endsub"),
    "loop across endsub": (
        "o1 sub\no2 while [0]\no1 endsub\no1 call\no2 endwhile\nM2",
        2, 1, "o2 while", "not closed", "o2 endwhile",
    ),
    "open at endsub": (
        "o1 sub\no2 if [1]\no1 endsub\no1 call\no2 endif\nM2",
        2, 1, "o2 if", "not closed", "o2 endif",
    ),
    "endsub without sub": ("G0X1\n  o1 endsub\nM2", 2, 3, "o1 endsub", "outside of a", "a line of"),
    "return without sub": ("o1 return [1]\nM2", 1, 1, "o1 return", "outside of a", "subroutine"),
    "other endsub": (
        "o1 sub\no2 endsub\no1 endsub\no1 call\nM2", 2, 1, "o2 endsub", "O1 sub", "O1 endsub",
    ),
    "endif without if": ("o1 endif\nM2", 1, 1, "o1 endif", "endif without if", "open if"),
    "else without if": ("o1 else\nM2", 1, 1, "o1 else", "else without if", "open if"),
    "endwhile without while": ("o1 endwhile\nM2", 1, 1, "o1 endwhile", "without while", "open"),
    "endrepeat of another": (
        "o1 repeat [2]\nG0 X1\no2 endrepeat\nM2",
        3, 1, "o2 endrepeat", "does not belong to o1 repeat of line 1", "the end of o1 repeat",
    ),
    "wrong label": (
        "o1 while [1]\nG0 X1\no2 endwhile\nM2", 3, 1, "o2 endwhile", "of line 1", "o1 while",
    ),
    "crossed": (
        "o1 if [1]\no2 while [1]\no1 endif\no2 endwhile\nM2",
        3, 1, "o1 endif", "does not belong to o2 while of line 2", "the end of o2 while",
    ),
    "endif of a while": (
        "o1 while [1]\nG0X1\no1 endif\no1 endwhile\nM2",
        3, 1, "o1 endif", "does not belong to o1 while of line 1", "the end of o1 while",
    ),
    "else twice": (
        "o1 if [0]\no1 else\nG0X1\no1 else\nG0X2\no1 endif\nM2",
        4, 1, "o1 else", "after the else", "endif",
    ),
    "label twice": (
        "o1 if [1]\no1 endif\no1 while [0]\no1 endwhile\nM2",
        3, 1, "o1 while", "label is used twice", "label of its own",
    ),
    "subroutine twice": (
        "o1 sub\no1 endsub\no1 sub\no1 endsub\nM2", 3, 1, "o1 sub", "defined twice", "one sub",
    ),
    "subroutine in a subroutine": (
        "o1 sub\no2 sub\no2 endsub\no1 endsub\no1 call\nM2", 2, 1, "o2 sub", "inside O1 sub", "end",
    ),
    "break outside": ("o1 break\nM2", 1, 1, "o1 break", "break without its loop", "while or do"),
    "continue of repeat": (
        "o1 repeat [2]\nG0 X1\no1 continue\no1 endrepeat\nM2",
        3, 1, "o1 continue", "continue without its loop", "while or do",
    ),
    "no such subroutine": ("G0X1\no7 call [1]\nM2", 2, 1, "o7 call", "no subroutine 7", "O7 sub"),
    "no such file": ("o<pocket> call\nM2", 1, 1, "o<pocket> call", "<pocket>", "O<pocket> sub"),
    "unknown keyword": ("o1 goto\nM2", 1, 1, "o1 goto", "no known keyword", "sub endsub call"),
    "keyword missing": ("G0 X1\no<a>\nM2", 2, 1, "o<a>", "no known keyword", "sub endsub call"),
    "label missing": ("o if [1]\nM2", 1, 1, "o", "no label", "a number"),
    "label not an integer": ("o1.5 if [1]\no1.5 endif\nM2", 1, 1, "o1.5", "is 1.5", "integer"),
    "condition missing": ("o1 if\nG0 X1\no1 endif\nM2", 1, 1, "o1 if", "if without a value", "[ ]"),
    "condition without brackets": ("o1 while #1\nM2", 1, 10, "#", "after while", "[value]"),
    "word behind": ("o1 if [1] G0\nX1\no1 endif\nM2", 1, 11, "G", "after if", "[value]"),
    "two conditions": ("o1 if [1] [2]\no1 endif\nM2", 1, 11, "[", "after if", "end of the line"),
    "value of sub": ("o1 sub [1]\no1 endsub\nM2", 1, 8, "[", "after sub", "the end of the line"),
    "too many arguments": (
        "o1 sub\no1 endsub\no1 call " + "[1]" * (ARGUMENTS + 1) + "\nM2",
        3, 9 + 3 * ARGUMENTS, "[", "too many arguments", "at most 30",
    ),
    "division by zero": ("#1=0\no1 if [1/#1]\nM2", 2, 9, "/", "no value for these", "finite"),
    "division in elseif": (
        "o1 if [0]\nG0 X1\no1 elseif [1/0]\no1 endif\nM2", 3, 13, "/", "no value for", "finite",
    ),
    "division in while": ("o1 do\nG0X1\no1 while [1/0]\nM2", 3, 12, "/", "no value for", "finite"),
    "name without value": ("o1 while [#<a>]\nM2", 1, 11, "#<a>", "has no value", "line before"),
    "name of the caller": (
        "#<a>=1\no1 sub\nG0 X#<a>\no1 endsub\no1 call\nM2", 3, 5, "#<a>", "has no value", "set",
    ),
    "bracket open": ("o1 if [1\no1 endif\nM2", 1, 7, "[1", "not closed", "operator or ]"),
    "comment open": ("o1 if [1] (a\no1 endif\nM2", 1, 11, "(a", "comment is not closed", ")"),
    "comment open, and more": (
        "o1 if [1] (a\nG0 E1\no1 endif\nM2", 1, 11, "(a", "comment is not closed", ")",
    ),
    "mistake before a mistake": (
        "G0 V1\no1 if [1/0]\no1 endif\nM2", 1, 4, "V1", "V, an axis along Y", "one of",
    ),
    "value read only": ("#<_value>=1\nM2", 1, 1, "#<_value>=1", "read only", "another"),
    "after a word": ("G0 X1\n#1=3 o1 if [1]\nM2", 2, 6, "o1 if [1]", "after other words", "first"),
    "mistake inside": (
        "o1 repeat [3]\nG0 V1\no1 endrepeat\nM2", 2, 4, "V1", "V, an axis along Y", "one of",
    ),
    "end missing": ("o1 repeat [2]\nG0 X1\no1 endrepeat", 3, 13, "", "has no end", "M2"),
    "percent in a loop": ("%\no1 while [0]\n%\no1 endwhile\nM2", 2, 1, "o1 while", "closed", "o1"),
}  # fmt: skip
OURS = {
    "while not closed, run", "if not closed, run", "do not closed", "other endsub", "else twice",
    "crossed", "open at endsub", "loop across endsub", "keyword missing",
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_o_words__one_mistake__is_the_only_error_with_its_place_and_text(name):
    text, *told = MISTAKES[name]
    (error,) = errors_of(text)
    assert error.file == "part.ngc"
    check_error(error, *told)


@needs("rs274")
@pytest.mark.parametrize("name", sorted(MISTAKES.keys() - OURS))
def test_o_words__mistakes__are_refused_by_rs274_too(name):
    with pytest.raises(OracleError):
        rs274(MISTAKES[name][0] + "\n")


def test_mistakes_before_an_o_word__are_told_together_and_end_the_reading():
    errors = errors_of("G0 X\nG1 Y1\no1 if [1]\nT5\no1 endif\nM2")
    assert [(error.line, error.column) for error in errors] == [(1, 4), (2, 1)]


def test_parse_file__with_o_words__reads_as_the_text(tmp_path):
    text = PROGRAMS["recursion"][0] + "\nM2\n"
    path = tmp_path / "part.ngc"
    path.write_text(text)
    assert parse_file(path, ZERO).moves == parse(text, str(path), ZERO).moves
