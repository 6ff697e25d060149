# SPDX-License-Identifier: Apache-2.0
"""Interface records: what they say, what is refused, and the assembler's `.interface`."""

from __future__ import annotations

from pathlib import Path

import pytest

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from asip_asm.expression import float_value
from asip_asm.image import Image
from asip_asm.interface import PROGRAMS, SUFFIX, load_interface, program_interface
from asip_asm.interface_text import c_struct, markdown
from asip_asm.signals import Interface, InterfaceError

RECORD = """\
title = "two axes"
[constants]
turn = "2*pi"
hold = "weight/2"
[[parameter]]
names = ["weight"]
unit = "N"
value = 8
meaning = "of the load"
[[input]]
names = ["q1", "q2"]
vector = "q"
type = "int"
unit = "rad"
scale = "turn/4096"
offset = -0.5
limits = [-3, "turn/2"]
source = "measurement"
meaning = "encoders of the joints"
[[input]]
names = ["demand"]
unit = "rad"
source = "set-point"
meaning = "of both joints"
[[state]]
names = ["before1", "before2"]
unit = "count"
starts_from = ["q1", "q2"]
meaning = "counts of the last tick"
[[state]]
names = ["sum"]
unit = "rad s"
initial = "hold/4"
meaning = "integrator"
[[output]]
names = ["torque"]
unit = "N m"
safe = "-hold"
limits = [-20, 20]
meaning = "of the first joint"
[[export]]
names = ["demand", "sum"]
[[export]]
names = ["error"]
unit = "rad"
meaning = "of the first joint"
"""

PROGRAM = """\
.program "two axes"
.interface "two.interface.toml"
        i2f     p1, q1
        i2f     p2, q2
        fsub    d1, p1, before1
        fsub    d2, p2, before2
        fadd    error, d1, d2
        mov     before1, p1
        mov     before2, p2
        fmadd   sum, demand, weight, sum
        fadd    t, sum, error
        mov     torque, t
        halt
"""


@pytest.fixture
def record(tmp_path: Path) -> Path:
    path = tmp_path / f"two{SUFFIX}"
    path.write_text(RECORD, encoding="utf-8")
    (tmp_path / "two.s").write_text(PROGRAM, encoding="utf-8")
    return path


def names(signals: object) -> list[str]:
    return [signal.name for signal in signals]


def test_signals_stand_in_the_order_of_the_file(record: Path) -> None:
    interface = load_interface(record)
    assert names(interface.inputs) == ["q1", "q2", "demand"]
    assert names(interface.states) == ["before1", "before2", "sum"]
    assert names(interface.outputs) == ["torque"]
    assert names(interface.exports) == ["demand", "sum", "error"]
    assert interface.measurements == ("q1", "q2") and interface.set_points == ("demand",)
    assert interface.inputs[1].line == 10 and interface.inputs[1].vector == "q"
    assert interface.states[0].starts_from == "q1"
    assert interface.exports[1].unit == "rad s"  # the state's


def test_expressions_have_the_values_of_the_parameters(record: Path) -> None:
    interface = load_interface(record)
    values = interface.names()
    first, torque = interface.inputs[0], interface.outputs[0]
    assert interface.value(first.scale, first, values) == 2 * 3.141592653589793 / 4096
    assert interface.value(torque.safe, torque, values) == -4.0
    assert interface.value(torque.safe, torque, interface.names({"weight": 3.0})) == -1.5


def test_a_program_is_assembled_from_the_record(record: Path) -> None:
    image = assemble(record.with_name("two.s"), defines={"weight": 2.0})
    assert [(e.name, e.index, e.type) for e in image.inputs] == [
        ("q1", 0, "int"),
        ("q2", 1, "int"),
        ("demand", 2, "float"),
    ]
    assert [(o.name, o.safe) for o in image.outputs] == [("torque", "bf800000")]
    initial = {state.name: state.bits for state in image.states}
    assert initial == {"before1": "00000000", "before2": "00000000", "sum": "3e800000"}


def test_first_states_are_the_first_inputs_in_the_unit_of_the_state(record: Path) -> None:
    record.write_text(RECORD.replace('unit = "count"', 'unit = "rad"'), encoding="utf-8")
    interface = load_interface(record)
    turn = 2 * 3.141592653589793 / 4096
    first = interface.first_states({"q1": 1024, "q2": 0, "demand": 0.0})
    assert first == {"before1": 1024 * turn - 0.5, "before2": -0.5}
    record.write_text(RECORD, encoding="utf-8")
    first = load_interface(record).first_states({"q1": 1024, "q2": 0, "demand": 0.0})
    assert first == {"before1": 1024, "before2": 0}


def test_texts_have_every_signal_with_its_unit(record: Path) -> None:
    interface = load_interface(record)
    assert c_struct(interface, "input", "tick") == (
        "struct tick {\n"
        "  int32_t q[2]; /* encoders of the joints [rad] */\n"
        "  float demand; /* of both joints [rad] */\n"
        "};\n"
    )
    page = "\n".join(markdown(interface))
    for signal in interface.signals[1:]:
        assert f"| `{signal.name}` | {signal.type} | {signal.unit} |" in page
    assert "`-20.0` .. `20.0` | `-hold` | of the first joint" in page


MISTAKES = {
    'unit = "N"\n|unt = "N"\n': "7: error: parameter 1: no key 'unt' is known; did you mean",
    'safe = "-hold"\n|': "35: error: output 1: 'safe' is missing; add 'safe = ...'",
    'unit = "rad s"|unit = "?"': "32: error: '?' is not a unit; write it as 'm/s^2'",
    "limits = [-20, 20]|limits = [20, -20]": "39: error: the lower limit 20 is above the upper -20",
    "limits = [-20, 20]|limits = 20": "39: error: output 1, limits: expected",
    'names = ["sum"]|names = ["a3"]': "31: error: the name 'a3' is reserved; a0.., b0..",
    'names = ["sum"]|names = ["2x"]': "31: error: '2x' is not a name; use letters",
    'names = ["sum"]|names = []': "31: error: names is empty",
    'names = ["demand"]|names = ["demand", "q1"]': "20: error: 'q1' appears twice; it is input",
    'names = ["error"]|names = ["torque"]': "43: error: 'torque' appears twice; it is output",
    'scale = "turn/4096"|scale = 0': "15: error: scale is 0; give the unit of one count",
    'scale = "turn/4096"\n|': "15: error: an offset without a scale; add 'scale = 1'",
    'type = "int"|type = "float"': "15: error: a float input has no scale",
    'type = "int"|type = "double"': "13: error: input 1, type: invalid enum value 'double'",
    '["q1", "q2"]\nmeaning|["q1"]\nmeaning': "28: error: 1 inputs for 2 states; name one input",
    'starts_from = ["q1", "q2"]|starts_from = ["q1", "q3"]': "25: error: state 'before2' starts "
    "from 'q3', which is no input; inputs are q1, q2, demand",
    'unit = "count"|unit = "m"': "25: error: state 'before1' has the unit m, input 'q1' has rad",
    'names = ["demand", "sum"]|names = ["demand", "sun"]': "41: error: export 'sun' is no input",
    'title = "two axes"|title = 3': "1: error: title: expected `str`, got `int`",
    'title = "two axes"|titel = "two"': "1: error: no key 'titel' is known; did you mean 'title'?",
    'title = "two axes"|title = "t"\ninclude = "x.toml"': "2: error: cannot read 'x.toml'",
    'title = "two axes"|title = "t"\ninclude = "two.interface.toml"': "1: error: the file includes",
    'title = "two axes"|title = "t"\nparameters = "x.toml"': "2: error: there is no file 'x.toml'",
    'title = "two axes"|title = = "t"': "1:9: error: Invalid value",
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=[text.split(": ")[-1] for text in MISTAKES])
def test_a_mistake_names_line_cause_and_cure(record: Path, mistake: str) -> None:
    right, wrong = mistake.split("|")
    assert RECORD.count(right) == 1
    record.write_text(RECORD.replace(right, wrong), encoding="utf-8")
    with pytest.raises(InterfaceError) as error:
        load_interface(record)
    assert str(error.value).startswith(f"{record}:{MISTAKES[mistake]}")


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('hold = "weight/2"', 'hold = "wight/2"', "4: error: 'wight/2': 'wight' is not the name"),
        ('turn = "2*pi"', 'turn = "2*"', "3: error: '2*': expected a number"),
        ('turn = "2*pi"', 'turn = "1/0"', "3: error: '1/0': division by zero"),
    ],
)
def test_a_wrong_expression_names_its_line(
    record: Path, right: str, wrong: str, message: str
) -> None:
    record.write_text(RECORD.replace(right, wrong), encoding="utf-8")
    with pytest.raises(InterfaceError) as error:
        load_interface(record).names()
    assert str(error.value).startswith(f"{record}:{message}")
    # The assembler points at the line of the record too.
    with pytest.raises(AssemblyError) as assembly_error:
        assemble(record.with_name("two.s"))
    line = message.partition(":")[0]
    assert f"{SUFFIX}:{line}:" in str(assembly_error.value)


def test_the_assembler_shows_what_is_wrong_with_a_record(record: Path) -> None:
    record.write_text(RECORD.replace("[-20, 20]", "[20, -20]"), encoding="utf-8")
    with pytest.raises(AssemblyError) as error:
        assemble(record.with_name("two.s"))
    assert "the lower limit 20 is above the upper -20" in str(error.value)
    record.unlink()
    with pytest.raises(AssemblyError, match="file 'two.interface.toml' not found"):
        assemble(record.with_name("two.s"))


def check_image(image: Image, interface: Interface) -> None:
    """The image's names, types and values are those of the record."""
    values = interface.names()
    assert [(e.name, e.type) for e in image.inputs] == [(s.name, s.type) for s in interface.inputs]
    assert [e.name for e in image.outputs] == names(interface.outputs)
    assert [(e.name, e.type) for e in image.states] == [(s.name, s.type) for s in interface.states]
    assert [e.name for e in image.exports] == names(interface.exports)
    for entry, signal in zip(image.outputs, interface.outputs, strict=True):
        safe = interface.value(signal.safe, signal, values)
        assert float_value(int(entry.safe, 16)) == pytest.approx(safe, rel=2**-24)
        if signal.limits is not None:
            low, high = (interface.value(limit, signal, values) for limit in signal.limits)
            assert low <= safe <= high


@pytest.mark.parametrize("path", sorted(PROGRAMS.glob(f"*{SUFFIX}")), ids=lambda path: path.name)
def test_the_records_of_the_programs_hold(path: Path) -> None:
    name = path.name.removesuffix(SUFFIX)
    interface = program_interface(name)
    source = path.with_name(f"{name}.s")
    if source.exists():
        check_image(assemble(source, configuration="small"), interface)
    for signal in interface.signals:
        for limit in signal.limits or ():
            interface.value(limit, signal, interface.names())


def test_set_points_leave_one_core_as_they_enter_the_other() -> None:
    """The planner's outputs are the tracking law's set-points, with their units."""
    made = program_interface("path_set_points").outputs
    taken = [s for s in program_interface("tracking").inputs if s.source == "set-point"]
    assert [(s.name, s.unit) for s in made[:-1]] == [(s.name, s.unit) for s in taken]
    assert made[-1].name == "begun"
