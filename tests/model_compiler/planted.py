# SPDX-License-Identifier: Apache-2.0
"""Mistakes of reading a URDF, planted in what the program is made of: the proof finds each.

The reference has the file and the statements as they are. `ARM` has a feature for each mistake.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.exact import Array
from asip_asm.model.law import Law
from sim.laws.description import Description, Inertial, JointRecord, read_description
from sim.laws.laws import LAWS, Settings
from sim.laws.prove_program import SEED, compare, draw_ticks, exact_results, rounded_sine
from sim.laws.reference import LawReference, PinocchioRobot
from sim.laws.samples import near
from sim.laws.stated import Stated
from sim.laws.tree import Joint, Tree, tree_of
from sim.report.goals import Goal, exactly
from tests.model_compiler.robot_text import ARM

STATED = Stated(
    sign={"turret": -1.0}, zero={"shoulder": 0.2}, counts={"slide": 1 << 16}, motor_encoders=True
)
HELD = replace(STATED, locked={"slide": 0.2})
SETTINGS = Settings(friction=True, integral=True)
STARTS = 30
"""Starts of two ticks each that a program runs, on the exact interpreter of the core."""


@dataclass(frozen=True)
class Planted:
    """A mistake: what it does to the description, the statements, the tree or the law."""

    name: str
    law: str = "computed_torque"
    description: Callable[[Description], Description] = lambda found: found
    statements: Callable[[Stated], Stated] = lambda stated: stated
    tree: Callable[[Tree], Tree] = lambda tree: tree
    signals: Callable[[Law], Law] = lambda law: law
    stated: Stated = STATED


def record(name: str, **fields: object) -> Callable[[Description], Description]:
    """A joint of the file with other fields; a function makes its field of the old one."""

    def change(one: JointRecord) -> JointRecord:
        values = {
            key: value(getattr(one, key)) if callable(value) else value
            for key, value in fields.items()
        }
        return replace(one, **values)

    return lambda found: replace(
        found, joints=tuple(change(j) if j.name == name else j for j in found.joints)
    )


def link(name: str, **fields: object) -> Callable[[Description], Description]:
    """A link of the file with other inertial parameters, or none."""

    def change(found: Description) -> Description:
        inertial: Inertial | None = found.links[name]
        other = replace(inertial, **fields) if fields else None
        return replace(found, links=found.links | {name: other})

    return change


def joint(name: str, **fields: object) -> Callable[[Tree], Tree]:
    """A joint of the tree with other fields."""

    def change(one: Joint) -> Joint:
        return replace(one, **fields) if one.name == name else one

    return lambda tree: replace(tree, joints=tuple(change(one) for one in tree.joints))


def swapped(law: Law) -> Law:
    """The first two encoders exchanged."""
    names = {"q0": "q1", "q1": "q0"}
    ports = [
        replace(p, name=names.get(p.name, p.name), rate_of=names.get(p.rate_of, p.rate_of))
        for p in law.ports
    ]
    return replace(law, ports=ports)


def turned(placement: np.ndarray) -> np.ndarray:
    """The placement with the inverse rotation."""
    other = placement.copy()
    other[:3, :3] = placement[:3, :3].T
    return other


UPPER = np.array([[0.02, 0, 0.001], [0, 0.03, -0.002], [0.001, -0.002, 0.025]])
PLANTED = (
    Planted("encoders exchanged", signals=swapped),
    Planted("follower is a free joint's copy", description=record("finger", mimic=None)),
    Planted("multiplier of a follower lost", tree=joint("finger", multiplier=1.0)),
    Planted("sign of a follower lost", tree=joint("finger", multiplier=0.5)),
    Planted("offset of a follower lost", tree=joint("finger", shift=0.0)),
    Planted("effort invented", tree=joint("shoulder", effort=100.0)),
    Planted("effort of another joint", tree=joint("turret", effort=90.0)),
    Planted("limit halved", tree=joint("shoulder", upper=1.0)),
    Planted("continuous joint within half a turn", tree=joint("turret", lower=-3.0, upper=3.0)),
    Planted("axis of the other sign", description=record("turret", axis=lambda axis: -axis)),
    Planted("axis not that of the file", description=record("slide", axis=np.array([0, 0, 1.0]))),
    Planted("rotation the other way round", description=record("turret", origin=turned)),
    Planted("place of a joint lost", description=record("slide", origin=np.eye(4))),
    Planted("off-diagonal moment lost", description=link("upper", moments=UPPER)),
    Planted("centre of mass lost", description=link("fore", centre=np.zeros(3))),
    Planted("mass of a fixed link lost", description=link("tool")),
    Planted("gravity upside down", tree=lambda t: replace(t, gravity=-t.gravity)),
    Planted("friction lost", tree=joint("shoulder", damping=0.0, friction=0.0)),
    Planted("inertia of the rotor lost", tree=joint("shoulder", armature=0.0)),
    Planted("sign of an encoder lost", statements=lambda s: replace(s, sign={})),
    Planted("zero of an encoder lost", statements=lambda s: replace(s, zero={})),
    Planted("counts of an encoder lost", statements=lambda s: replace(s, counts={})),
    Planted("reduction lost", statements=lambda s: replace(s, motor_encoders=False)),
    Planted("place of a held joint lost", statements=lambda s: replace(s, locked={"slide": 0.0}),
            stated=HELD),
    Planted("tip of another link", "forward_kinematics",
            statements=lambda s: replace(s, tip="claw")),
    Planted("speed of another tip", "tip_speed", statements=lambda s: replace(s, tip="ram")),
)  # fmt: skip


def found(planted: Planted, folder: Path) -> bool:
    """Whether the proof of the program with the mistake fails."""
    file, rng = folder / "arm.urdf", np.random.default_rng(SEED)
    file.write_text(ARM, encoding="utf-8")
    description = planted.description(read_description(file))
    tree = planted.tree(tree_of(description, planted.statements(planted.stated)))
    law = planted.signals(LAWS[planted.law](tree, SETTINGS))
    compiled = compile_law(law, Options(sine="pipes"))
    reference = LawReference(PinocchioRobot(ARM, planted.stated), planted.law, SETTINGS)
    if reference.difference(law):
        return True
    inputs: dict[str, list[Array]] = {}
    for _ in range(STARTS):
        drawn, states = draw_ticks(law, 2, rng, near(law))
        for name, values in (drawn | {n: np.repeat(v, 2) for n, v in states.items()}).items():
            inputs.setdefault(name, []).append(values)
    words = {name: np.concatenate(parts) for name, parts in inputs.items()}
    got = exact_results(compiled, words, rounded_sine)
    return not compare(compiled, words, got, SEED, rounded_sine, reference).passed


def rows(full: bool) -> Iterator[Goal]:
    """Planted mistakes that the proof finds."""
    with tempfile.TemporaryDirectory() as folder:
        missed = [one.name for one in PLANTED if not found(one, Path(folder))]
    note = f"not found: {', '.join(missed)}" if missed else ""
    yield exactly(
        "planted mistakes of reading a URDF that --prove finds",
        len(PLANTED) - len(missed), len(PLANTED), "mistakes", note,
    )  # fmt: skip
