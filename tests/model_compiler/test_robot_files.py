# SPDX-License-Identifier: Apache-2.0
"""URDF files: what is taken, what is refused and with which words."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from sim.laws.asip_model.__main__ import main
from sim.laws.elements import BYTES, DEPTH, RobotError
from sim.laws.laws import LAWS, Settings
from sim.laws.reference import PinocchioRobot
from sim.laws.stated import ALL, Stated
from sim.laws.tree import TURNS, Tree, load_tree
from tests.model_compiler.robot_text import ARM

SHOULDER = '<joint name="shoulder" type="revolute">'
LIMIT = '<limit lower="-2.5" upper="2" effort="90" velocity="3"/>'
MASS = '<mass value="2"/>'
INERTIA = '<inertia ixx="0.02" ixy="0.003" ixz="0.001" iyy="0.03" iyz="-0.002" izz="0.025"/>'
MIMIC = '<mimic joint="turret" multiplier="-0.5" offset="0.3"/>'
EFFORT = "<hardwareInterface>effort</hardwareInterface>"
END = "</robot>"
LINK = '<link name="more"/>'

REFUSED = [
    # Half-written or wrong masses.
    (MASS, "", ":5: link 'upper': <inertial> has no <mass>; state it, or delete the whole"),
    (MASS, "<mass/>", ":7: link 'upper': <mass> has no attribute value"),
    (MASS, '<mass value="-2"/>', ":7: link 'upper': the mass -2 is negative"),
    (MASS, '<mass value="1_0"/>', ":7: link 'upper': mass value '1_0' is no number"),
    (MASS, '<mass value="nan"/>', "mass value 'nan' is no number"),
    (MASS, '<mass value="inf"/>', "mass value 'inf' is no number"),
    (MASS, '<mass value="0x10"/>', "mass value '0x10' is no number"),
    (MASS, '<mass value="٣"/>', "mass value '٣' is no number"),
    (MASS, '<mass value="1e31"/>', "mass value '1e31' is too large"),
    (MASS, '<mass value=""/>', "mass value has 0 numbers, it needs 1"),
    (MASS, '<mass value="1 2"/>', "mass value has 2 numbers, it needs 1"),
    (MASS, MASS * 2, ":7: link 'upper': a second <mass>; delete one"),
    (MASS, '<mass valeu="2"/>', "<mass> has an attribute valeu; did you mean 'value'"),
    (MASS, '<mass value="${m}"/>', r"value='\$.m.' is xacro, which is no URDF yet; expand it"),
    (INERTIA, "", "<inertial> has no <inertia>"),
    (' ixy="0.003"', "", ":8: link 'upper': <inertia> has no attribute ixy"),
    ('ixx="0.02"', 'ixx="-0.02"', "link 'upper': a moment of inertia is negative: -0.02"),
    ('xyz="0.1 0.02 -0.03"', 'xyz="0.1 0.02"', "origin xyz has 2 numbers, it needs 3"),
    ("<inertial>", "<Inertial>", "mismatched tag"),
    ('<link name="base"/>', '<link name="base"><inertal/></link>', "did you mean 'inertial'"),
    # Names and the tree.
    ('<link name="claw">', '<link name="ram">', "a second link 'ram'; rename one"),
    (SHOULDER, '<joint name="slide" type="revolute">', "a second joint 'slide'; rename one"),
    (SHOULDER, '<joint type="revolute">', "joint: <joint> has no attribute name"),
    (SHOULDER, '<joint name="" type="revolute">', "name '' is empty"),
    (SHOULDER, '<joint name="a&#10;b" type="revolute">', r"name 'a\\nb' is empty or has unprint"),
    ('<child link="tool"/>', '<child link="tol"/>', "no link 'tol'; did you mean 'tool'"),
    ('<child link="tool"/>', "", "joint 'mount' has no <child>"),
    ('<child link="tool"/>', '<child link="upper"/>', "already the child of joint 'mount': a loop"),
    ('<parent link="base"/>', '<parent link="tool"/>', "joints .* form a loop; only trees"),
    (END, LINK + END, "2 root links, base, more; join them by fixed joints"),
    (END, '<loop_joint name="x"/>' + END, "<loop_joint> closes a loop of links"),
    (END, "<joints/>" + END, "unknown element <joints>; did you mean 'joint'"),
    # Joints.
    (SHOULDER, '<joint name="shoulder" type="floating">', "is of type floating .a floating base"),
    (SHOULDER, '<joint name="shoulder" type="planar">', "joint 'shoulder' is of type planar"),
    (SHOULDER, '<joint name="shoulder" type="Revolute">', "has an unknown type 'Revolute'; types"),
    (SHOULDER, '<joint name="shoulder">', "joint 'shoulder' has no type"),
    ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', ":51: joint 'shoulder': the axis is zero"),
    ('<axis xyz="0 1 0"/>', "<axis/>", "joint 'shoulder': <axis> has no attribute xyz"),
    (LIMIT, "", "joint 'shoulder': a revolute joint needs <limit"),
    (' effort="90"', "", "joint 'shoulder': <limit> has no attribute effort"),
    (' effort="90"', ' efort="90"', "an attribute efort; did you mean 'effort'"),
    ('effort="90"', 'effort="-90"', "joint 'shoulder': effort -90 is negative"),
    ('lower="-2.5" upper="2"', 'lower="2" upper="-2.5"', "lower 2 is above upper -2.5"),
    ('upper="2"', 'upper="257"', "limits beyond 256 rad, .* --range shoulder=LOW:HIGH"),
    ('damping="0.5"', 'damping="-0.5"', "joint 'shoulder': damping -0.5 is negative"),
    (MIMIC, '<mimic joint="turet"/>', "mimics a joint 'turet' that is not there; did you mean"),
    (MIMIC, '<mimic joint="finger"/>', "joint 'finger': mimics itself through finger"),
    (">50<", ">0<", "transmission 'drive': the reduction is zero"),
    (">50<", "><", "transmission 'drive': mechanicalReduction value has 0 numbers"),
    ("SimpleTransmission", "FourBarLinkage", "type 'FourBarLinkage' is not done; take the encoder"),
    (EFFORT, "<mechanicalReduction>9</mechanicalReduction>", "two values of reduction: .9.0, 50.0"),
    # XML.
    (END, "", "no XML: no element found"),
    ("<robot", "<!DOCTYPE robot><robot", ":2: <!DOCTYPE: a URDF needs none; delete it"),
    ("<robot", '<!DOCTYPE r [<!ENTITY m "2">]><robot', "<!DOCTYPE: a URDF needs none"),
    ('value="2"', 'value="&m;"', "no XML: undefined entity; write the entity out"),
    ('<robot name="arm">', "<arm>", "mismatched tag"),
    ("<link name", "<xacro:macro/><link name", "<xacro:macro> is xacro, which is no URDF yet; exp"),
    (END, "<a>" * DEPTH + "</a>" * DEPTH + END, f"elements deeper than {DEPTH}"),
]  # fmt: skip


def saved(folder: Path, text: str, name: str = "arm.urdf") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def edited(old: str, new: str) -> str:
    assert old in ARM
    return ARM.replace(old, new, 1)


def agrees(tree: Tree) -> None:
    """Inverse dynamics of the tree is that of pinocchio's own reading, beyond all limits."""
    from tests.model_compiler.test_robots import inverse

    arm = PinocchioRobot(tree.description.text, tree.stated)
    assert arm.names == [joint.name for joint in tree.axes]
    function = inverse(tree)
    for point in np.random.default_rng(4).uniform(-7, 7, (10, 3, len(tree.axes))):
        want = arm.inverse(*point)
        assert np.abs(function(*point).full().ravel() - want).max() <= 1e-9 * np.abs(want).max()


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_file__that_cannot_be_meant__is_refused_with_its_place(old, new, message, tmp_path):
    with pytest.raises(RobotError, match=message) as found:
        load_tree(saved(tmp_path, edited(old, new)))
    assert str(found.value).startswith(f"{tmp_path}/arm.urdf")


def test_file__too_large_or_in_another_encoding__is_refused(tmp_path):
    with pytest.raises(RobotError, match="larger than 16 MiB"):
        load_tree(saved(tmp_path, ARM + " " * BYTES))
    (tmp_path / "arm.urdf").write_bytes(ARM.replace('"claw"', '"Fuß"').encode("latin-1"))
    with pytest.raises(RobotError, match="it is not in UTF-8: save it so, or declare"):
        load_tree(tmp_path / "arm.urdf")


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "UTF-8", "UTF-16"])
def test_names__in_a_declared_encoding__are_those_of_pinocchio(encoding, tmp_path):
    text = ARM.replace('version="1.0"', f'version="1.0" encoding="{encoding}"')
    text = text.replace("shoulder", "Schulter-Öse")
    (tmp_path / "arm.urdf").write_bytes(text.encode(encoding))
    tree = load_tree(tmp_path / "arm.urdf")
    assert tree.axes[0].name == "Schulter-Öse"
    agrees(tree)


def test_followers_rotors_and_continuous_joints__are_those_of_pinocchio(tmp_path):
    tree = load_tree(saved(tmp_path, ARM))
    assert [joint.name for joint in tree.joints] == ["shoulder", "turret", "slide", "finger"]
    assert [joint.name for joint in tree.axes] == ["shoulder", "turret", "slide"]
    assert tree.joints[0].armature == pytest.approx(1e-4 * 50**2)
    assert tree.axes[1].upper == TURNS * 2 * np.pi
    agrees(tree)


def test_followers__of_pinocchio_s_own_mimic_joints__are_the_same(tmp_path):
    text = edited("<rotorInertia>0.0001</rotorInertia>", "")
    text = text.replace('mimic joint="turret"', 'mimic joint="shoulder"')
    tree = load_tree(saved(tmp_path, text))
    model = pin.buildModelFromXML(text, mimic=True)
    arm, data = PinocchioRobot(text, tree.stated), model.createData()
    for q, v, a in np.random.default_rng(5).uniform(-3, 3, (5, 3, 3)):
        whole = np.array([q[0], np.cos(q[1]), np.sin(q[1]), q[2]])  # the turret is continuous
        assert arm.inverse(q, v, a) == pytest.approx(pin.rnea(model, data, whole, v, a), rel=1e-9)


CHAIN = ARM.replace(
    '<limit lower="0" upper="0.4" effort="60" velocity="1"/>',
    '<limit lower="0" upper="0.4" effort="60" velocity="1"/>'
    '<mimic joint="finger" multiplier="0.02" offset="0.1"/>',
)


def test_follower_of_a_follower__is_eliminated_and_held_with_its_leader(tmp_path):
    tree = load_tree(saved(tmp_path, CHAIN))
    slide = tree.joints[2]
    assert (slide.multiplier, slide.shift) == pytest.approx((0.02 * -0.5, 0.1 + 0.02 * 0.3))
    agrees(tree)
    held = load_tree(saved(tmp_path, CHAIN), Stated(locked={"turret": 0.7}))
    assert [joint.name for joint in held.joints] == ["shoulder"]
    agrees(held)
    agrees(load_tree(saved(tmp_path, CHAIN), Stated(locked={"shoulder": -1.0})))


def test_what_nothing_reads__is_counted(tmp_path):
    unused = load_tree(saved(tmp_path, ARM)).description.unused
    assert unused == {"visual": 1, "hardwareInterface": 1, "gazebo": 1}


def test_moments_that_no_body_has__are_warned_of(tmp_path):
    for izz, why in (("0.9", "the largest, 0.9"), ("0.00001", "not positive definite")):
        text = edited('izz="0.025"', f'izz="{izz}"')
        (warning,) = load_tree(saved(tmp_path, text)).description.warnings
        assert warning.startswith(f"{tmp_path}/arm.urdf:8: link 'upper': no body has") and (
            why in warning
        )


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (Stated(locked={"wrist": 0.0}), "--lock: no joint wrist; it has shoulder, turret"),
        (Stated(locked={"finger": 0.0}), "--lock: joint finger mimics turret; state it of turret"),
        (Stated(locked={"shoulder": 2.1}), "position 2.1 of joint shoulder is outside of its lim"),
        (Stated(effort={"sholder": 1.0}), "--effort: no joint sholder; did you mean 'shoulder'"),
        (Stated(effort={ALL: 1.0}), "--effort: the URDF states it for every joint; name the joint"),
        (Stated(range={"shoulder": (0.0, 300.0)}), "limits beyond 256 rad"),
    ],
)
def test_statement__of_no_joint_or_no_effect__is_refused(stated, message, tmp_path):
    with pytest.raises(RobotError, match=message):
        load_tree(saved(tmp_path, ARM), stated)


@pytest.mark.parametrize(
    ("old", "new", "law", "message"),
    [
        ('effort="90"', 'effort="0"', "inverse_dynamics", "joint shoulder: .* no effort"),
        ('velocity="3"', 'velocity="0"', "tip_speed", "no velocity above 0; .* --velocity sh"),
        ('lower="-2.5" upper="2"', "", "forward_kinematics", "no range of positions.* --range"),
        ('lower="-2.5" upper="2"', 'lower="0" upper="0"', "inverse_dynamics", "no range of posit"),
        ('<limit effort="20" velocity="4"/>', "", "gravity_compensation", "joint turret: the URDF"),
    ],
)  # fmt: skip
def test_number__that_the_law_needs_and_nobody_states__is_asked_for(
    old, new, law, message, tmp_path
):
    file = saved(tmp_path, edited(old, new))
    with pytest.raises(RobotError, match=message):
        LAWS[law](load_tree(file), Settings())
    option = re.search(r"--(\w+) \w+=", _error(file, law)).group(1)
    value = {"range": (-1.0, 2.0)}.get(option, 7.0)
    ports = LAWS[law](load_tree(file, Stated(**{option: {ALL: value}})), Settings()).ports
    assert any(
        port.limits in ((-7.0, 7.0), (-1.0, 2.0), (-2.5, 3.5)) for port in ports if port.limits
    )


def _error(file: Path, law: str) -> str:
    with pytest.raises(RobotError) as found:
        LAWS[law](load_tree(file), Settings())
    return str(found.value)


def test_efforts_and_ranges__of_the_file__act_whatever_their_size(tmp_path):
    text = edited('effort="90"', 'effort="200000"').replace('upper="2"', 'upper="20"')
    law = LAWS["inverse_dynamics"](load_tree(saved(tmp_path, text)), Settings(overshoot=1.0))
    assert law.port("tau0").limits == (-200_000, 200_000)
    assert law.port("pos0").limits == (-2.5, 20)


def test_tip__is_the_named_link_the_only_leaf_or_asked_for(tmp_path):
    tree = load_tree(saved(tmp_path, ARM))
    assert tree.tip.link == "tool"
    assert load_tree(saved(tmp_path, ARM), Stated(tip="ram")).tip.link == "ram"
    for name, message in (("base", "no joint moves link base"), ("tol", "did you mean 'tool'")):
        with pytest.raises(RobotError, match=message):
            _ = load_tree(saved(tmp_path, ARM), Stated(tip=name)).tip
    more = LINK + '<joint name="m" type="fixed"><parent link="ram"/><child link="more"/></joint>'
    with pytest.raises(RobotError, match="several links end a chain: .*; name one by --tip"):
        _ = load_tree(saved(tmp_path, edited(END, more + END))).tip


def test_encoders__take_counts_sign_zero_and_the_reduction_of_the_motor(tmp_path):
    stated = Stated(
        counts={"shoulder": 1000}, sign={ALL: -1.0}, zero={"turret": 0.5}, motor_encoders=True
    )
    law = LAWS["gravity_compensation"](load_tree(saved(tmp_path, ARM), stated), Settings(counts=64))
    scales = [law.port(f"q{i}").scale for i in range(3)]
    assert scales == pytest.approx([-2 * np.pi / 50_000, -2 * np.pi / 64, -0.1 / 64])
    assert [law.port(f"q{i}").offset for i in range(3)] == [0, 0.5, 0]


def run(folder: Path, *words: str) -> list[str]:
    return [str(folder / "arm.urdf"), *words, "-o", str(folder / "out")]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--law", "tip_speed", "--effort", "3"], "--effort does nothing for the law tip_speed"),
        (["--law", "inverse_dynamics", "--tip", "ram"], "--tip does nothing for the law inverse"),
        (["--effort", "x=1e99"], "'1e99' is no number"),
        (["--effort", "x=0"], "'0' is not above 0"),
        (["--effort", "=3"], "'=3' has no name of a joint"),
        (["--range", "x=3"], "'3' is no range LOW:HIGH"),
        (["--range", "x=3:2"], "'3:2': the low end is not below the high one"),
        (["--sign", "2"], "'2' is neither 1 nor -1"),
        (["--rate", "nan"], "'nan' is no number"),
        (["--counts", "x=1.5"], "'1.5' is not a number 1"),
        (["--overshoot", "0.5"], "'0.5' is not 1 or more"),
    ],
)
def test_command__option_that_does_nothing_or_is_no_value__is_a_wrong_command_line(
    words, message, tmp_path, capsys
):
    with pytest.raises(SystemExit, match="^2$"):
        main(run(tmp_path, *words))
    assert message in capsys.readouterr().err


def test_command__robot_option_without_a_urdf_or_a_xacro__is_a_wrong_command_line(tmp_path, capsys):
    for files, message in (
        (["law.casadi", "law.toml", "--tip", "x"], "--tip is for URDFs, and no file is one"),
        (["arm.urdf.xacro"], "a xacro is no URDF yet; expand it"),
    ):
        with pytest.raises(SystemExit, match="^2$"):
            main(files)
        assert message in capsys.readouterr().err


def test_command__of_an_upper_case_name__writes_what_it_made_of_the_file(tmp_path, capsys):
    file = saved(tmp_path, edited('izz="0.025"', 'izz="0.9"'), "ARM.URDF")
    assert main([str(file), "--law", "gravity_compensation", "-o", str(tmp_path / "out")]) == 0
    assert "warning:" in capsys.readouterr().err
    report = (tmp_path / "out.report.txt").read_text(encoding="utf-8")
    assert "axis 1: turret, -50.2655 to 50.2655 rad, effort 20; a count is" in report
    assert "finger follows turret: -0.5 times, plus 0.3; its own limits" in report
    assert "not used: reduction 50 and offset 0 of transmission 'drive'" in report
    assert "not used of the file: gazebo (1), hardwareInterface (1), visual (1)" in report
    assert "warning: " in report


def test_command__closed_loop_of_a_tip_without_mass__names_the_joint(tmp_path, capsys):
    text = re.sub(r'<link name="(claw|tool)">.*?</link>', r'<link name="\1"/>', ARM, flags=re.S)
    saved(tmp_path, text.replace(MIMIC, ""))
    assert main(run(tmp_path, "--loop", "0.01")) == 1
    assert "joint finger moves no mass" in capsys.readouterr().err
