# SPDX-License-Identifier: Apache-2.0
"""Campaign of robots: mutated URDFs and mutated robot options of asip-model, with short proofs."""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path
from random import Random

from sim.laws.asip_model import __main__ as asip_model
from sim.laws.laws import LAWS
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import files_of_every_kind, mutated_arguments, mutated_text
from tests.model_compiler.robot_text import ARM

SMALL = """\
<robot name="small">
  <link name="base"/>
  <link name="a"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
  <joint name="two" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit effort="50" velocity="3"/></joint>
</robot>
"""
WORDS = (
    "robot link joint inertial mass inertia origin xyz rpy axis parent child limit lower upper "
    "effort velocity dynamics damping friction type revolute continuous prismatic fixed floating "
    "planar mimic multiplier offset value name base tool shoulder turret transmission actuator "
    "mechanicalReduction rotorInertia ixx ixy iyy izz < > /> </link> </robot> &lt; &x; <!-- --> "
    '<!DOCTYPE <![CDATA[ ]]> <?xml encoding="latin-1" ${x} xacro:macro 0 -1 1e-300 1e29 nan 0.5'
).split()
OPTIONS = (
    "--rate --counts --bandwidth --integral --friction --lock --loop --effort --velocity --range "
    "--sign --zero --encoder motor joint --tip tool ram --acceleration --overshoot --law "
    "--prove --inputs --seed shoulder=3 turret=1 slide=0.1 finger=0 one=-1:2 =3 a=b=1 -1 1 0 "
    "1e9 nan 256 -2:2"
).split()
LINES = (
    "arm.urdf --law computed_torque --integral --friction",
    "arm.urdf --law gravity_compensation --sign turret=-1 --zero shoulder=0.1 --encoder motor",
    "arm.urdf --law joint_impedance --friction --effort shoulder=3",
    "arm.urdf --law forward_kinematics --tip ram --lock slide=0.1",
    "arm.urdf --law tip_speed --counts 1000 --counts slide=4096",
    "arm.urdf --law inverse_dynamics --range shoulder=-1:1 --velocity turret=2",
)


def case(rng: Random) -> int | None:
    """One mutated file, or one mutated command line. Those that stay short are proved or closed in
    a loop as well.
    """
    text = rng.choice((ARM, SMALL, SMALL))
    line = rng.choice(LINES).split()
    if text is SMALL:
        line = ["arm.urdf", "--law", rng.choice(tuple(LAWS))]
    if rng.random() < 0.75:
        text = mutated_text(rng, text, WORDS)
    else:
        line = mutated_arguments(rng, line, [*OPTIONS, *LAWS, "arm.urdf", "zero", "pipe", "folder"])
        line = [word for word in line if word not in ("--prove", "--loop")]
    encoding = rng.choice(("utf-8", "utf-8", "utf-8", "latin-1", "utf-16"))
    if rng.random() < 0.1:
        text = f'<?xml version="1.0" encoding="{encoding}"?>' + text
    Path("arm.urdf").write_bytes(text.encode(encoding, errors="replace"))
    files_of_every_kind()
    if text.startswith("<robot") and rng.random() < 0.1:
        line += ["--prove", "--inputs", "20"]
    return asip_model.main([*line, "-o", "out"])


def prepare() -> None:
    """Builds the core that the short proofs run on, once for all cases."""
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        (Path(folder) / "arm.urdf").write_text(SMALL, encoding="utf-8")
        asip_model.main([f"{folder}/arm.urdf", "--prove", "--inputs", "20", "-o", f"{folder}/out"])


CAMPAIGNS = (Campaign("urdf", 5_000, case, prepare),)
