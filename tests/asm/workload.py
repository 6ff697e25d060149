# SPDX-License-Identifier: Apache-2.0
"""Programs for the scheduler's tests: random graphs, and the tracking law in the shape of
docs/law.md.
"""

from __future__ import annotations

import random

from asip_asm.ir import (
    ZERO,
    Export,
    Operation,
    Output,
    OutputWord,
    Program,
    Region,
    Register,
    State,
    Virtual,
)

BINARY_AUX = ("feq", "flt", "fmin", "fmax", "iadd", "isub", "fdiv")
UNARY_AUX = ("fabs", "fneg", "mov", "fsgn", "i2f", "f2i", "fsqrt")


class Builder:
    """Collects operations of one region in single-assignment form; methods return the written
    value.
    """

    def __init__(self, configuration: str = "fast") -> None:
        self.program = Program(configuration=configuration)
        self.region = Region(halt=True)
        self.program.regions.append(self.region)
        self.names = 0
        self.words = 0

    def input(self) -> Register:
        self.words += 1
        return Register("K", (self.words - 1) % 128)

    def emit(self, mnemonic: str, dst=None, *values, **fields) -> Operation:
        layout = {"fadd": "ac", "fsub": "ac"}.get(mnemonic, "abc")
        op = Operation(mnemonic, dst, **dict(zip(layout, values, strict=False)), **fields)
        self.region.operations.append(op)
        return op

    def op(self, mnemonic: str, *values, name: str | None = None, version: int = 1, **fields):
        if name is None:
            self.names += 1
            name = f"v{self.names}"
        dst = Virtual(name, version)
        self.emit(mnemonic, dst, *values, **fields)
        return dst

    def output(self, mnemonic: str, *values) -> None:
        index = len(self.program.outputs)
        self.program.outputs.append(OutputWord(f"o{index}", index, 0))
        self.emit(mnemonic, Output(index), *values)

    def state(self, name: str, pin: str | None = None) -> Virtual:
        first = Virtual(name, 0)
        self.program.states.append(State(name, "float", 0, first, pin=pin))
        return first

    def write_state(self, name: str, mnemonic: str, *values) -> Virtual:
        state = next(s for s in self.program.states if s.name == name)
        state.last = self.op(mnemonic, *values, name=name, version=1)
        return state.last

    def export(self, value: Virtual) -> None:
        self.program.exports.append(Export(value.name, value))


def random_program(seed: int, size: int, configuration: str = "fast") -> Program:
    """Random operations with outputs, states (one pinned), exports, loads, stores and shared
    symbols.
    """
    rng = random.Random(seed)
    build = Builder(configuration)
    values = [build.input() for _ in range(6)] + [ZERO]
    states = [build.state(f"s{i}", pin="A" if i == 0 else None) for i in range(rng.randrange(1, 4))]
    values += states
    build.program.data = [0] * 8

    def pick():
        window = values[-12:] if rng.random() < 0.7 else values
        return rng.choice(window)

    outputs = 0
    for _ in range(size):
        kind = rng.random()
        if kind < 0.55:
            mnemonic = rng.choice(("fmadd", "fmsub", "fnmsub", "fmul", "fadd", "fsub"))
            count = 3 if mnemonic.startswith(("fma", "fms", "fnms")) else 2
            values.append(build.op(mnemonic, *(pick() for _ in range(count))))
        elif kind < 0.72:
            values.append(build.op(rng.choice(BINARY_AUX), pick(), pick()))
        elif kind < 0.82:
            values.append(build.op(rng.choice(UNARY_AUX), pick()))
        elif kind < 0.84:
            values.append(build.op(rng.choice(("fsin", "fcos")), pick()))
        elif kind < 0.88:
            index = pick() if rng.random() < 0.2 else ZERO
            build.emit("st", None, pick(), index, imm=rng.randrange(8))
        elif kind < 0.92:
            index = pick() if rng.random() < 0.2 else ZERO
            values.append(build.op("ld", ZERO, index, imm=rng.randrange(8)))
        elif kind < 0.96:
            name = rng.choice(("p", "q"))
            mnemonic = "fmul" if name == "p" else "mov"
            symbol = build.op(mnemonic, pick(), pick(), name=name, version=-1)
            values.append(symbol)
        elif outputs < 20:
            outputs += 1
            build.output("fsat", pick(), pick(), pick())
    for position, state in enumerate(states):
        if rng.random() < 0.8 or state.name == "s0":
            mnemonic = "fadd" if position == 0 else rng.choice(("fadd", "mov", "fdiv"))
            operands = rng.choice(values), rng.choice(values)
            # From here on the name means the new value.
            values = [v for v in values if v != state]
            values.append(build.write_state(state.name, mnemonic, *operands))
    exportable = [v for v in values if isinstance(v, Virtual) and v.name.startswith("v")]
    for value in rng.sample(exportable, min(3, len(exportable))):
        build.export(value)
    return build.program


def tracking_law(shared: bool, configuration: str = "fast") -> Program:
    """The tracking law for five axes; `shared` False repeats common terms as the printed equations
    do.
    """
    b = Builder(configuration)
    k = [b.input() for _ in range(30)]
    x, y, z, vx, vy, vz, ax, ay, az, theta4, theta5, om4, om5, ep4, ep5 = k[:15]
    counts = k[15:20]
    con = [b.input() for _ in range(40)]
    px, py = con[0:3], con[3:6]
    one = con[6]

    def mul(p, q):
        return b.op("fmul", p, q)

    def add(p, q):
        return b.op("fadd", p, q)

    def sub(p, q):
        return b.op("fsub", p, q)

    def mac(p, q, r):
        return b.op("fmadd", p, q, r) if shared else add(mul(p, q), r)

    def radius(i):
        dx, dy = sub(x, px[i]), sub(y, py[i])
        return mac(z, z, mac(dy, dy, mul(dx, dx)))

    def rate(i):
        dx, dy = sub(x, px[i]), sub(y, py[i])
        if shared:
            return mac(z, vz, mac(dy, vy, mul(dx, vx)))
        return mac(mul(con[7], z), vz, mac(mul(con[7], dy), vy, mul(mul(con[7], dx), vx)))

    def integrator(axis, error, desired):
        sign_old, since = b.state(f"sg{axis}"), b.state(f"tc{axis}")
        total = b.state(f"sc{axis}")
        sign = b.op("fsgn", desired)
        same = b.op("feq", sign, sign_old)
        b.write_state(f"sg{axis}", "mov", sign)
        later = add(since, con[8])
        elapsed = b.write_state(f"tc{axis}", "sel", same, later, ZERO)
        big = b.op("fle", con[9], b.op("fabs", error))
        ramp = mul(mul(con[10], sub(one, mul(elapsed, con[11]))), big)
        half = b.op("fle", elapsed, con[12])
        middle = b.op("sel", half, con[13], ramp)
        phi = add(b.op("sel", b.op("flt", elapsed, con[14]), middle, ZERO), one)
        summed = mac(mul(phi, error), con[15], total)
        return b.write_state(f"sc{axis}", "fsat", summed, con[16], con[17])

    measured = [mac(b.op("i2f", counts[i]), con[18], con[19]) for i in range(5)]
    desired_l, desired_v, desired_a = [], [], []
    for i in range(3):
        if shared:
            q, s = radius(i), rate(i)
            length = b.op("fsqrt", q)
            inverse = b.op("fdiv", one, length)
            v = mul(s, inverse)
            acc = mac(b.op("fnmul", v, v), inverse, mul(accel(b, i, k, con, mac, sub), inverse))
        else:
            length = b.op("fsqrt", radius(i))
            v = b.op("fdiv", mul(con[20], rate(i)), b.op("fsqrt", radius(i)))
            s = rate(i)
            q = radius(i)
            cube = mul(q, b.op("fsqrt", radius(i)))
            first = b.op("fdiv", mul(con[21], mul(s, s)), cube)
            second = b.op(
                "fdiv", mul(con[20], accel(b, i, k, con, mac, sub)), b.op("fsqrt", radius(i))
            )
            acc = sub(second, first)
        desired_l.append(length)
        desired_v.append(v)
        desired_a.append(acc)
    l1, l2, l3 = measured[:3]
    d23 = sub(mul(l2, l2), mul(l3, l3))
    mx = mul(d23, con[22])

    def my():
        return mul(sub(sub(mul(con[7], mul(l1, l1)), mul(l2, l2)), mul(l3, l3)), con[23])

    yy = my()
    ym = add(yy if shared else my(), con[24])
    zm = b.op("fsqrt", sub(sub(mul(l1, l1), mul(mul(d23, d23), con[25])), mul(ym, ym)))
    inverse_l = [b.op("fdiv", one, measured[i]) for i in range(3)]
    mz = con[26]
    for i in range(3):
        li = inverse_l[i]
        if not shared:
            li = b.op("fdiv", one, measured[i])
        mz = add(mz, mul(sub(mul(con[27], sub(measured[i], con[28])), con[29]), li))
    weight = b.op("fdiv", mul(mz, con[30]), zm)
    gravity = []
    for i in range(3):
        term = mac(mx, con[31 + i], mac(yy, con[34], one))
        gravity.append(mul(mul(measured[i], weight), term))
    pair: dict = {}

    def cosine(i, j):
        key = (min(i, j), max(i, j))
        if shared and key in pair:
            return pair[key]
        top = sub(mac(measured[i], measured[i], mul(measured[j], measured[j])), con[35])
        if shared:
            pair[key] = mul(mul(top, con[20]), mul(inverse_l[i], inverse_l[j]))
        else:
            pair[key] = b.op("fdiv", top, mul(con[7], mul(measured[i], measured[j])))
        return pair[key]

    for i in range(3):
        mass = con[36]
        for j in range(3):
            if j == i:
                continue
            mass = mac(con[37], mul(cosine(i, j), cosine(i, j)), mass)
            c = cosine(i, j)
            offset = sub(measured[j], con[28])
            inertia = mac(con[37], mul(offset, offset), con[38])
            part = mul(inertia, sub(one, mul(c, c)))
            if shared:
                mass = mac(part, mul(inverse_l[j], inverse_l[j]), mass)
            else:
                mass = add(mass, b.op("fdiv", part, mul(measured[j], measured[j])))
        control(
            b,
            i,
            mass,
            gravity[i],
            measured[i],
            desired_l[i],
            desired_v[i],
            desired_a[i],
            con,
            counts[i],
            shared,
            integrator,
        )
    sine = b.op("fsin", measured[3])
    control(
        b,
        3,
        con[39],
        mul(sine, con[38]),
        measured[3],
        theta4,
        om4,
        ep4,
        con,
        counts[3],
        shared,
        integrator,
    )
    control(b, 4, con[39], ZERO, measured[4], theta5, om5, ep5, con, counts[4], shared, integrator)
    return b.program


def accel(b, i, k, con, mac, sub):
    x, y, z, vx, vy, vz, ax, ay, az = k[:9]
    dx, dy = sub(x, con[i]), sub(y, con[3 + i])
    total = b.op("fmul", vx, vx)
    for p, q in ((dx, ax), (vy, vy), (dy, ay), (vz, vz), (z, az)):
        total = mac(p, q, total)
    return total


def control(b, axis, mass, gravity, value, desired, speed, accel_d, con, count, shared, integrator):
    """Equations (28) to (37) of one axis: error, derivative, integrator, force, limits."""
    previous = b.state(f"previous{axis}")
    error = b.op("fsub", desired, value)
    if shared:
        difference = b.op("i2f", b.op("isub", count, previous))
        b.write_state(f"previous{axis}", "mov", count)
        velocity = b.op("fmul", difference, con[18])
    else:
        velocity = b.op("fdiv", b.op("fsub", value, previous), con[15])
        b.write_state(f"previous{axis}", "mov", value)
    rate_error = b.op("fsub", speed, velocity)
    integral = integrator(axis, error, speed)
    if shared:
        drive = b.op("fmadd", con[0], error, accel_d)
        drive = b.op("fmadd", con[1], rate_error, drive)
        drive = b.op("fmadd", con[2], integral, drive)
        force = b.op("fmadd", mass, drive, gravity)
    else:
        drive = b.op("fadd", accel_d, b.op("fmul", con[0], error))
        drive = b.op("fadd", drive, b.op("fmul", con[1], rate_error))
        drive = b.op("fadd", drive, b.op("fmul", con[2], integral))
        force = b.op("fadd", b.op("fmul", mass, drive), gravity)
    b.output("fsat", force, con[3], con[4])


def loop_program():
    """Counts down in a loop, chooses one of two paths, and uses values from before both."""
    k0, k1 = Register("K", 0), Register("K", 1)
    build = Builder()
    before = build.op("fmul", k0, k1)
    build.op("mov", k0, name="n", version=-1)
    n, r = Virtual("n", -1), Virtual("r", -1)
    loop = Region(labels=["loop"])
    loop.operations += [
        Operation("fdiv", Virtual("t", 1), n, before),
        Operation("isub", n, n, k1),
        Operation("mov", r, Virtual("t", 1)),
        Operation("bnz", None, n, target="loop"),
    ]
    path = Region(
        operations=[
            Operation("mov", r, before),
            Operation("st", None, r, imm=0),
            Operation("bz", None, r, target="end"),
        ]
    )
    other = Region(operations=[Operation("fneg", r, n)])
    end = Region(labels=["end"], halt=True)
    end.operations += [
        Operation("ld", Virtual("w", 1), imm=0),
        Operation("fsat", Output(0), r, before, Virtual("w", 1)),
        Operation("fadd", Virtual("s", 1), Virtual("s", 0), r),
    ]
    program = build.program
    program.data = [0]
    program.states = [State("s", "float", 0, Virtual("s", 0), Virtual("s", 1))]
    build.region.halt = False
    program.regions += [loop, path, other, end]
    return program
