# SPDX-License-Identifier: Apache-2.0
"""Campaign of asip-model: mutated interface records, saved functions, URDFs and command lines."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from random import Random

from sim.laws.asip_model import __main__ as asip_model
from sim.laws.laws import LAWS
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import files_of_every_kind, mutated_arguments, mutated_text

ROOT = Path(__file__).parents[2]
URDF = ROOT / "sim/laws/urdf/pendulum.urdf"
RECORD = """\
title = "one joint"

[constants]
T_s = 1e-4

[[parameter]]
names = ["gain"]
unit = "N m/rad"
value = 40
meaning = "of the loop"

[[input]]
names = ["q"]
type = "int"
scale = "2*pi/65536"
unit = "rad"
limits = [-3, 3]
meaning = "encoder"

[[state]]
names = ["before"]
type = "int"
unit = "count"
starts_from = ["q"]
meaning = "count of the last tick"

[[state]]
names = ["total"]
unit = "rad s"
limits = [-0.01, 0.01]
meaning = "integral"

[[output]]
names = ["torque"]
unit = "N m"
limits = [-5, 5]
safe = 0
meaning = "of the joint"
"""
RECORD_WORDS = (
    "title include parameters constants parameter input state output export names unit vector "
    "meaning limits value type scale offset source rate initial starts_from safe set_points_of "
    "q total torque gain q_rate total_next [[input]] [[state]] [[output]] [[export]] int float "
    "count pi 2*pi inf -inf nan 1e300 x.toml"
).split()
URDF_WORDS = (
    "robot link joint inertial mass inertia origin xyz rpy axis parent child limit lower upper "
    "effort velocity dynamics damping friction type revolute continuous prismatic fixed floating "
    "planar mimic value name world ixx ixy iyy izz < > /> </link> </robot> &lt; &x; <!-- -->"
).split()
OPTIONS = (
    "-o --config fast small --reassociate --reciprocal --sine unit balanced --constants --c "
    "--inputs --seed --law --rate --counts --bandwidth --integral --friction --lock --loop "
    "--effort --tip --range 0 1 3 -5 1e6 nan inf 0x10 build out"
).split()
FILES = "law.casadi law.toml arm.urdf empty folder zero pipe x.s law.s".split()
LINES = (
    "law.casadi law.toml -o out",
    "law.casadi law.toml --reassociate --reciprocal --c -o out",
    "law.casadi law.toml --config small --constants 2 -o out",
    "law.casadi law.toml arm.urdf --law gravity_compensation -o out",
    "arm.urdf --law joint_impedance --friction -o out",
)


@functools.cache
def law() -> bytes:
    """A saved function to damage."""
    import casadi as ca

    q, rate, total, gain = (ca.SX.sym(name) for name in ("q", "q_rate", "total", "gain"))
    following = ca.fmax(ca.fmin(total - 1e-4 * q, 0.01), -0.01)
    torque = ca.if_else(q > 0, ca.sqrt(ca.fabs(rate)), ca.atan2(rate, q)) - gain * q + ca.sin(total)
    function = ca.Function(
        "joint",
        [q, rate, total, gain],
        [torque, following],
        ["q", "q_rate", "total", "gain"],
        ["torque", "total_next"],
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "law.casadi"
        function.save(str(file))
        return file.read_bytes()


def damaged(rng: Random, data: bytes) -> bytes:
    """The saved function after 1 to 4 edits."""
    content = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(content))
        kind = rng.randrange(4)
        if kind == 0:
            content[at] = rng.randrange(256)
        elif kind == 1:
            content[at : at + 4] = rng.randbytes(4)
        elif kind == 2:
            content[at : at + rng.choice((1, 8))] = b""
        else:
            content[at:at] = content[at : at + rng.choice((2, 8, 40))]
        content = content or bytearray(b"\0")
    return bytes(content)


def case(rng: Random) -> int | None:
    """One mutated file next to good ones, or one mutated command line."""
    record, function, urdf = RECORD, law(), URDF.read_text(encoding="utf-8")
    line = rng.choice(LINES).split()
    kind = rng.randrange(4)
    if kind == 0:
        record = mutated_text(rng, record, RECORD_WORDS)
    elif kind == 1:
        function = damaged(rng, function)
    elif kind == 2:
        urdf = mutated_text(rng, urdf, URDF_WORDS)
        line = rng.choice(LINES[-2:]).split()
    else:
        line = mutated_arguments(rng, line, [*OPTIONS, *LAWS, *FILES])
        line = [word for word in line if word not in ("--prove", "--loop")]
    Path("law.toml").write_bytes(record.encode("utf-8", errors="surrogatepass"))
    Path("law.casadi").write_bytes(function)
    Path("arm.urdf").write_bytes(urdf.encode("utf-8", errors="surrogatepass"))
    files_of_every_kind()
    return asip_model.main(line)


def prepare() -> None:
    """The function and what the command imports, once for all cases."""
    law()


CAMPAIGNS = (Campaign("asip-model", 5_000, case, prepare),)
