# SPDX-License-Identifier: Apache-2.0
"""The file of one motor: ten lines of TOML, read and checked.

Phases are in star; currents and fluxes are peaks of a phase. The inverter and its sensing are those
of the drives' hardware (`INVERTER`); `dead_time` and `current_range` may be given.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from asip_asm.diagnostics import closest
from asip_asm.parameters import ParameterFileError, read_toml
from sim.bench.drive.start_up import OVERCURRENT
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD, LOOP_PERIOD
from sim.laws.drive.current_law import FASTEST, LARGEST, Setting
from sim.robot.drives import Friction, Motor

KINDS = {"rotary": "rotary motor", "linear": "linear motor"}
OPTIMUM = 1 / (3 * LOOP_PERIOD)  # crossover of the magnitude optimum [rad/s]: the largest
MOST_CURRENT_BANDWIDTH, MOST_VELOCITY_BANDWIDTH = 9000.0, 300.0  # Hz
SEPARATION = 10.0  # least ratio of both bandwidths
LEAST_COUNTS = 200  # of an electrical turn
MOST_RIPPLE = 0.5  # of the rated current
DELAY_ON, DELAY_OFF = 0.3e-6, 0.5e-6  # of the inverter's switches [s]
DROP, DROP_RESISTANCE = 1.2, 0.05  # of a switch or diode [V], [ohm]
GAIN_ERROR, OFFSET = 0.005, 0.001  # of the current sensors, of their value and of their range
PRESLIDING = 2e-3  # of an electrical turn's 1 / (2 pi), by which the bristles bend
STRIBECK = 2.0  # electrical speed at which static friction has fallen [rad/s]
STATIC = 1.3  # static friction as a share of Coulomb friction


class MotorFileError(ValueError):
    """A key is missing, unknown or impossible: file, line, cause, cure."""


@dataclass(frozen=True)
class Key:
    """A number of the file: unit, limits, meaning; kind: the type of motor that has it; encoders:
    the only ones that have it."""

    unit: str
    low: float
    high: float
    meaning: str
    kind: str = ""
    needed: bool = True
    encoders: tuple[str, ...] = ()


@dataclass(frozen=True)
class SerialLine:
    """What a port needs of the file: its module, limits of the clock and the clock without the key
    [Hz], bits of a position at most."""

    port: str
    slowest: float
    fastest: float
    clock: float
    bits: int


INCREMENTAL, BISS, SSI, ENDAT = "incremental", "biss", "ssi", "endat"
SINCOS, HALL = "sincos", "hall"
ENCODERS = {
    INCREMENTAL: "lines A and B",
    BISS: "lines A and B, and the position over BiSS-C at the start (`biss_port`)",
    SSI: "lines A and B, and the position over SSI at the start (`ssi_port`)",
    ENDAT: "lines A and B, and the position over EnDat at the start (`endat_port`)",
    SINCOS: "sine and cosine lines (`sincos_position`)",
    HALL: "three Hall lines (`hall_decoder`)",
}
ABSOLUTE = (BISS, SSI, ENDAT)
LINES = {
    BISS: SerialLine("biss_port", 2.1e6, 1e7, 1e7, 64),
    SSI: SerialLine("ssi_port", 4e5, 2e6, 1e6, 64),
    ENDAT: SerialLine("endat_port", 5e5, 8e6, 2e6, 48),
}
MOST_CLOCKS = 254  # of a bit
# EnDat: longer first low phase of clocks above 1 MHz, longest recovery time, bit that measures the
# delay of the line [s].
ENDAT_START, ENDAT_RECOVERY, ENDAT_MEASURE = 2e-6, 30e-6, 4e-6
# Without lines A and B: time from the request to the answer, and after the last bit of a frame to
# the next request, without `encoder_frame` [s]. SSI has the monoflop time within its frame.
ANSWER = {BISS: 5e-6, SSI: 0.0, ENDAT: 5e-6}
REST = {BISS: 20e-6, SSI: 1e-6, ENDAT: ENDAT_RECOVERY + 1e-6}
SSI_MONOFLOP = 25e-6
SERIAL_LINE = ("encoder_bits", "encoder_clock")
# Sine and cosine lines: windows of both filters, their samples, a period that is whole bits, and
# the amplitude, a half of the full scale.
SINE_RATE, SINE_BIT, SINE_WIDTH, SINE_PERIOD = 32, 6, 16, 624
SINE_AMPLITUDE = SINE_RATE**3 // 4
MOST_OF_A_LINE = 7 / 16  # in a period
SINE_ERROR, SINE_NOISE = 0.005, 5e-4  # of the amplitude
# Hall lines: counts of a sector, clocks of the filter and of the longest sector that is timed, by
# which line v is late and w is early [rad], edges of the lines in a period of the velocity loop.
HALL_BITS, HALL_FILTER, HALL_LIMIT, HALL_ERROR = 8, 15, (1 << 22) - 1, 0.03
HALL_EDGES, HALL_SPEED = 16.0, 0.7  # at this share of the fastest moves
SECTORS = 6  # of an electrical turn
ACTS = 6  # clocks of `absolute_position`
ALLOWED_PERIODS = 4  # without a good frame
JUMP_MARGIN = 2.0  # of the greatest acceleration
ROTARY, LINEAR = "rotary", "linear"
KEYS = {
    "R": Key("ohm", 0.01, 100.0, "resistance of a phase: half of that between two terminals"),
    "L": Key("H", 2e-5, 0.2, "inductance of a phase", needed=False),
    "L_d": Key("H", 2e-5, 0.2, "inductance along the magnets", needed=False),
    "L_q": Key("H", 2e-5, 0.2, "inductance across the magnets", needed=False),
    "flux": Key("V s", 1e-3, 10.0, "peak flux linkage of the magnets", needed=False),
    "torque_constant": Key("N m/A", 1e-3, 1e3, "torque by peak current", ROTARY, needed=False),
    "force_constant": Key("N/A", 0.1, 1e4, "force by peak current", LINEAR, needed=False),
    "pole_pairs": Key("1", 1, 100, "pole pairs of a turn", ROTARY),
    "pole_pitch": Key("m", 1e-3, 0.5, "north pole to next south pole", LINEAR),
    "inertia": Key("kg m2", 1e-7, 100.0, "of rotor and load", ROTARY),
    "mass": Key("kg", 1e-2, 1e4, "of slider and load", LINEAR),
    "travel": Key("m", 1e-2, 100.0, "free travel; the motor begins in its middle", LINEAR),
    "rated_current": Key("A", 0.2, 200.0, "peak of a phase"),
    "bus_voltage": Key("V", 24.0, 800.0, "DC bus"),
    "encoder_counts": Key(
        *("1", 1e2, 1e9, "counts of a turn, or of a metre"),
        encoders=tuple(name for name in ENCODERS if name != HALL),
    ),
    "absolute_counts": Key(
        *("1", 1e2, 1e12, "positions of a turn or metre over the serial line"),
        needed=False,
        encoders=ABSOLUTE,
    ),
    "encoder_offset": Key(
        *("rad", -7.0, 7.0, "electrical angle at position 0"),
        needed=False,
        encoders=(*ABSOLUTE, HALL),
    ),
    "encoder_bits": Key("1", 1, 64, "bits of the position on the line", encoders=(SSI, ENDAT)),
    "encoder_clock": Key(
        "Hz", 4e5, 1e7, "clock of the serial line", needed=False, encoders=(SSI, ENDAT)
    ),
    "encoder_frame": Key(
        *("s", 2e-6, 1e-3, "from a frame to the next, without lines A and B"),
        needed=False,
        encoders=ABSOLUTE,
    ),
    "sine_periods": Key("1", 1, 1e7, "lines of a turn, or of a metre", encoders=(SINCOS,)),
    "sine_offset": Key(
        *("1", 0.0, 0.1, "offset of the sine, of its amplitude"), needed=False, encoders=(SINCOS,)
    ),
    "sine_gain": Key(
        *("1", -0.2, 0.2, "by how much the sine is larger than the cosine"),
        needed=False,
        encoders=(SINCOS,),
    ),
    "sine_noise": Key(
        *("1", 0.0, 0.02, "noise of a sample, rms, of the amplitude"),
        needed=False,
        encoders=(SINCOS,),
    ),
    "hall_error": Key(
        *("rad", 0.0, 0.2, "electrical angle by which line v is late and w is early"),
        needed=False,
        encoders=(HALL,),
    ),
    "current_bandwidth": Key("Hz", 500.0, MOST_CURRENT_BANDWIDTH, "-3 dB of the current loop"),
    "velocity_bandwidth": Key("Hz", 2.0, MOST_VELOCITY_BANDWIDTH, "-3 dB of the velocity loop"),
    "friction": Key("N m or N", 0.0, 1e4, "Coulomb friction", needed=False),
    "viscous": Key("N m s/rad or N s/m", 0.0, 1e4, "viscous friction", needed=False),
    "cogging": Key("N m or N", 0.0, 1e3, "amplitude of the cogging", needed=False),
    "dead_time": Key("s", 12 * CLOCK, 255 * CLOCK, "of the inverter", needed=False),
    "current_range": Key("A", 0.2, 1000.0, "full scale of the current sensors", needed=False),
}
TEXTS = ("type", "encoder")
# What has the keys of these encoders.
OWNERS = {
    (SINCOS,): "sine and cosine lines",
    (HALL,): "Hall lines",
    KEYS["encoder_counts"].encoders: "an encoder that is finer than Hall lines",
}
# true or false, and the encoders that have it
FLAGS = {
    "encoder_lines": ABSOLUTE,
    "encoder_gray": (SSI,),
    "encoder_alarm": (SSI,),
    "encoder_repeat": (SSI,),
    "encoder_endat22": (ENDAT,),
}
PARITIES = ("none", "even", "odd")  # by their number, `Parity` of `ssi_port`
CHOICES = {"encoder_parity": ((SSI,), PARITIES)}  # one of these texts
EITHER = (("L", "L_d"), ("L", "L_q"), ("flux", "torque_constant", "force_constant"))


@dataclass(frozen=True)
class OneMotor:
    """A motor's file in SI units; an `Inverter` of the current law, with one motor.

    inertia: kg m2 or kg; resolution: travel of a count [rad or m]; travel: free travel [rad or m],
    infinite of a rotary motor; bandwidths: of the current and velocity loops [Hz]. encoder: of
    `ENCODERS`; absolute: travel of a position over its serial line; encoder_offset: electrical
    angle where that position is 0 [rad], None: the start-up finds it; port: parameters of the port
    of `LINES`, `sincos_position` or `hall_decoder`, empty of other encoders; counter: those of
    `absolute_position`, empty with lines A and B; frame_clocks: from the encoder's instant until
    the count has its position; sine_errors: offset of the sine, its gain, noise, shares of the
    amplitude; hall_error: electrical angle by which line v is late and w is early [rad].
    """

    kind: str
    motor: Motor
    friction: Friction
    inertia: float
    resolution: float
    travel: float
    current_bandwidth: float
    velocity_bandwidth: float
    U_dc: float
    current_scale: float
    dead_time: float = 125 * CLOCK
    delay_on: float = DELAY_ON
    delay_off: float = DELAY_OFF
    drop: float = DROP
    drop_resistance: float = DROP_RESISTANCE
    f_pwm: float = 1 / (2 * HALF_PERIOD * CLOCK)
    encoder: str = INCREMENTAL
    absolute: float = 0.0
    encoder_offset: float | None = None
    port: Mapping[str, int] = field(default_factory=dict)
    counter: Mapping[str, int] = field(default_factory=dict)
    frame_clocks: int = 0
    sine_errors: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hall_error: float = 0.0

    @property
    def motors(self) -> tuple[Motor, ...]:
        return (self.motor,)

    @property
    def port_name(self) -> str:
        """Module that reads the encoder with the parameters `port`; empty without them."""
        if self.encoder in (SINCOS, HALL):
            return "sincos_position" if self.encoder == SINCOS else "hall_decoder"
        return LINES[self.encoder].port if self.port else ""

    @property
    def units(self) -> tuple[str, str, str]:
        """Of travel, force and inertia."""
        return ("m", "N", "kg") if self.kind == LINEAR else ("rad", "N m", "kg m2")

    def setting(self, angle: float = 0.0, crossover: float = 0.0) -> Setting:
        """Of the current law, for one axis."""
        return Setting(
            *((self.resolution,), (angle,)),
            order_filter=(0.0,),
            crossover=(crossover,),
            coarse=(float(self.encoder == HALL),),
        )


def fastest_move(one: OneMotor, psi: float) -> float:
    """Speed of moves with this flux, electrical [rad/s]."""
    return min(400.0, 0.35 * one.U_dc / math.sqrt(3) / psi)


def load(path: Path) -> OneMotor:
    """Read a motor's file. Raises MotorFileError, whose text is `file:line: error: cause; cure`,
    and OSError."""
    try:
        content, lines = read_toml(path)
    except ParameterFileError as error:
        raise MotorFileError(str(error)) from None
    try:
        return _made(_checked(content))
    except _Wrong as wrong:
        line = lines.get(wrong.name)
        place = f"{path}:{line}" if line else f"{path}:{max(lines.values(), default=1)}"
        raise MotorFileError(f"{place}: error: {wrong}") from None


class _Wrong(ValueError):
    def __init__(self, name: str, text: str) -> None:
        super().__init__(f"{name}{text}")
        self.name = name


def _checked(content: Mapping[str, Any]) -> dict[str, Any]:
    """Type and numbers, each within its limits; every key that the motor needs is there."""
    kind = content.get("type")
    if kind not in KINDS:
        got = f" = {kind!r}" if kind is not None else ": missing"
        raise _Wrong("type", f'{got}; write type = "rotary" or type = "linear"')
    known = {name: key for name, key in KEYS.items() if key.kind in ("", kind)}
    encoder = content.get("encoder", INCREMENTAL)
    if encoder not in ENCODERS:
        known_ones = "; ".join(f'"{name}": {text}' for name, text in ENCODERS.items())
        raise _Wrong(
            "encoder",
            f" = {encoder!r}: not supported; write one of {known_ones}",
        )
    if encoder == HALL and kind == LINEAR:
        raise _Wrong(
            "encoder",
            ' = "hall": not with a linear motor; the start-up must stop within the travel, and '
            "Hall lines give the position to a sixth of an electrical turn. Take another encoder",
        )
    encoders: dict[str, tuple[str, ...]] = {**FLAGS}
    encoders |= {name: having for name, (having, _) in CHOICES.items()}
    encoders |= {name: key.encoders for name, key in KEYS.items() if key.encoders}
    alone = content.get("encoder_lines") is False  # without lines A and B
    if alone:
        for name in SERIAL_LINE:
            known[name] = replace(known[name], encoders=ABSOLUTE)
            encoders[name] = ABSOLUTE
    elif "encoder_frame" in content:
        raise _Wrong("encoder_frame", ": with encoder_lines = false alone; add that, or remove it")
    for name, having in encoders.items():
        if name in content and encoder not in having:
            ones = " or ".join(f'"{one}"' for one in having)
            what = OWNERS.get(having, "an absolute encoder")
            raise _Wrong(name, f": of {what}; write encoder = {ones}, or remove it")
    if line := LINES.get(encoder) if alone or encoder != BISS else None:
        known["encoder_bits"] = replace(known["encoder_bits"], high=line.bits)
        known["encoder_clock"] = replace(
            known["encoder_clock"], low=line.slowest, high=line.fastest
        )
    for name, value in content.items():
        if name in CHOICES and value not in CHOICES[name][1]:
            ones = " or ".join(f'{name} = "{one}"' for one in CHOICES[name][1])
            raise _Wrong(name, f" = {value!r}: write {ones}")
        if name in FLAGS and not isinstance(value, bool):
            raise _Wrong(name, f" = {value!r}: write {name} = true or {name} = false")
        if name in TEXTS or name in FLAGS or name in CHOICES:
            continue
        if name not in known:
            raise _Wrong(name, _unknown(name, kind, known))
        key = known[name]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _Wrong(name, f" = {value!r}: is no number; write {name} = 1.5, in {key.unit}")
        if not key.low <= value <= key.high:
            raise _Wrong(
                name,
                f" = {value:g} {key.unit} ({key.meaning}): must be within {key.low:g} .. "
                f"{key.high:g} {key.unit}; check the unit",
            )
    for name, key in known.items():
        has_it = not key.encoders or encoder in key.encoders
        if key.needed and has_it and name not in content:
            raise _Wrong(name, f": missing; add a line {name} = ... in {key.unit}, {key.meaning}")
    for first, *others in EITHER:
        names = [name for name in (first, *others) if name in known]
        given = [name for name in names if name in content]
        if len(given) != 1:
            got = f"has {' and '.join(given)}" if given else "missing"
            raise _Wrong(
                given[-1] if given else names[0], f": {got}; enter one of {', '.join(names)}"
            )
    for name, why in (("pole_pairs", "poles are pairs"), ("encoder_bits", "count them")):
        value = content.get(name, 1)
        if value != int(value):
            raise _Wrong(name, f" = {value}: must be a whole number; {why}")
    return dict(content)


def _unknown(name: str, kind: str, known: Mapping[str, Key]) -> str:
    if name in KEYS:
        return f": a {KINDS[kind]} has none; remove the line, or change type"
    names = (*TEXTS, *FLAGS, *CHOICES, *known)
    return f": unknown key; {closest(name, names) or 'the keys are ' + ', '.join(names)}"


def _made(values: Mapping[str, Any]) -> OneMotor:
    kind = values["type"]
    linear = kind == LINEAR
    pole = 2 * values["pole_pitch"] if linear else 2 * math.pi / values["pole_pairs"]
    wave = 2 * math.pi / pole
    constant = values.get("force_constant" if linear else "torque_constant")
    flux = values["flux"] if constant is None else constant / (1.5 * wave)
    l_d, l_q = values.get("L_d", values.get("L")), values.get("L_q", values.get("L"))
    rated = values["rated_current"]
    motor = Motor(pole, values["R"], l_d, l_q, flux, rated, values.get("cogging", 0.0))
    coulomb = float(values.get("friction", 0.0))
    inertia = values["mass" if linear else "inertia"]
    stiffness = coulomb * wave / PRESLIDING
    friction = Friction(
        coulomb=coulomb,
        static=STATIC * coulomb,
        speed=STRIBECK / wave,
        stiffness=stiffness,
        damping=math.sqrt(stiffness * inertia),
        viscous=float(values.get("viscous", 0.0)),
    )
    encoder = values.get("encoder", INCREMENTAL)
    counts = values.get("encoder_counts", values.get("pole_pairs", 0) * SECTORS << HALL_BITS)
    one = OneMotor(
        kind,
        motor,
        friction,
        inertia,
        _travel_of(linear, counts),
        values.get("travel", math.inf),
        values["current_bandwidth"],
        values["velocity_bandwidth"],
        U_dc=float(values["bus_voltage"]),
        current_scale=values.get("current_range", 2.0 * rated),
        dead_time=round(values.get("dead_time", 1e-6) / CLOCK) * CLOCK,
        encoder=encoder,
        absolute=_travel_of(linear, values.get("absolute_counts", counts)),
        encoder_offset=values.get("encoder_offset"),
        port=_port(values),
        hall_error=float(values.get("hall_error", HALL_ERROR if encoder == HALL else 0.0)),
    )
    if values.get("encoder_lines") is False:
        one = _alone(one, values)
    if one.encoder == SINCOS:
        one = _sincos(one, values)
    for name, wrong, text in _possible(one, values):
        if wrong:
            raise _Wrong(name, f" = {values.get(name, 0.0):g}{text}")
    return one


def _port(values: Mapping[str, Any]) -> dict[str, int]:
    """Parameters of the port: its clock is the fastest that does not exceed the file's."""
    encoder = values.get("encoder", INCREMENTAL)
    if encoder == HALL:
        return {"Bits": HALL_BITS, "Filter": HALL_FILTER, "Limit": HALL_LIMIT}
    if encoder not in LINES or "encoder_bits" not in values:
        return {}
    clock = values.get("encoder_clock", LINES[encoder].clock)
    width, per_bit = int(values["encoder_bits"]), _even_clocks(1 / clock)
    port = {"Width": width, "ClocksPerBit": per_bit}
    if encoder == BISS:
        return port
    if encoder == SSI:
        flags = {"Gray": "encoder_gray", "Alarm": "encoder_alarm", "Repeat": "encoder_repeat"}
        port |= {name: int(values.get(key, False)) for name, key in flags.items()}
        return port | {"Parity": PARITIES.index(values.get("encoder_parity", PARITIES[0]))}
    return port | {
        "Endat22": int(values.get("encoder_endat22", True)),
        "StartClocks": _even_clocks(ENDAT_START) if clock > 1e6 else 0,
        "RecoveryClocks": _even_clocks(ENDAT_RECOVERY),
        "MeasureClocks": min(_even_clocks(ENDAT_MEASURE), (width + 5) * per_bit),
    }


def _alone(one: OneMotor, values: Mapping[str, Any]) -> OneMotor:
    """With the count of `absolute_position`. Raises _Wrong."""
    linear, encoder, port = one.kind == LINEAR, one.encoder, one.port
    ratio = one.resolution / one.absolute
    drop = round(math.log2(ratio)) if ratio >= 0.75 else -1
    if drop < 0 or abs(ratio / 2**drop - 1) > 1e-9 or drop > port["Width"] - 2:
        raise _Wrong(
            "encoder_counts",
            f" = {values['encoder_counts']:g}: without lines A and B they are those of the "
            "position divided by 1, 2, 4, ...; correct them or absolute_counts",
        )
    counts = round(2 * math.pi / one.resolution)
    turn_bits = math.ceil(math.log2(counts) - 1e-9) + drop
    modulus = 0 if linear or counts == 1 << (turn_bits - drop) else counts
    if modulus and port["Width"] != turn_bits:
        raise _Wrong(
            "encoder_bits",
            f" = {port['Width']}: a position of several turns needs a power of two in a turn; "
            f"{turn_bits} bits for one turn",
        )
    bit = port["ClocksPerBit"]
    if encoder == BISS:
        frame = (port["Width"] + 12) * bit
    elif encoder == SSI:
        bits = port["Width"] + port["Alarm"] + (port["Parity"] > 0) + 2
        frame = bits * (1 + port["Repeat"]) * bit + _even_clocks(SSI_MONOFLOP)
    else:
        frame = port["StartClocks"] + (port["Width"] + 18 + port["Endat22"]) * bit
    frame += _even_clocks(ANSWER[encoder])
    given = values.get("encoder_frame", 0.0)
    period = math.ceil(given / CLOCK - 1e-6) if given else frame + _even_clocks(REST[encoder])
    if period <= frame + ACTS:
        raise _Wrong(
            "encoder_frame",
            f" = {given:g} s: a frame takes {(frame + ACTS) * CLOCK:.3g} s; a longer one, or a "
            "faster encoder_clock",
        )
    motor = one.motor
    speed = FASTEST / (motor.wave * one.resolution) * CLOCK
    if speed > 1:
        raise _Wrong(
            "encoder_counts",
            f" = {values['encoder_counts']:g}: {speed:.3g} counts a clock at {FASTEST:g} rad/s "
            "electrical, without lines A and B at most 1; divide them by a power of two",
        )
    jump = _jump(one, period, frame)
    slow = port.get("MeasureClocks", 0) * (port["Width"] + 19)
    counter = {
        "Width": port["Width"],
        "Drop": drop,
        "Modulus": modulus,
        "Period": period,
        "Instant": bit // 2 + 1 if encoder == BISS else 1,
        "MostJump": math.ceil(jump) + 3,
        "Periods": ALLOWED_PERIODS + math.ceil(slow / period),
    }
    return replace(one, counter=counter, frame_clocks=frame + ACTS)


def _sincos(one: OneMotor, values: Mapping[str, Any]) -> OneMotor:
    """With the count of `sincos_position` and `absolute_position`. Raises _Wrong."""
    lines, counts = values["sine_periods"], values["encoder_counts"]
    bits = round(math.log2(counts / lines)) if counts > lines else 0
    if not 4 <= bits <= 16 or abs(counts / lines / 2**bits - 1) > 1e-9:
        raise _Wrong(
            "encoder_counts",
            f" = {counts:g}: with sine and cosine lines they are sine_periods = {lines:g} times "
            "16, 32, 64, ... or 65536; correct one of both",
        )
    if one.kind != LINEAR and lines != int(lines):
        raise _Wrong("sine_periods", f" = {lines}: a turn has no part of a line; a whole number")
    period, instant = SINE_PERIOD, (3 * SINE_RATE - 1) * SINE_BIT // 2
    frame = 3 * SINE_RATE * SINE_BIT + 4 + bits + 3 + ACTS - instant
    speed = FASTEST / (one.motor.wave * one.resolution) * CLOCK
    if speed > 1:
        raise _Wrong(
            "encoder_counts",
            f" = {counts:g}: {speed:.3g} counts a clock at {FASTEST:g} rad/s electrical, at most "
            "1; divide them by a power of two",
        )
    if speed * period > MOST_OF_A_LINE * 2**bits:
        raise _Wrong(
            "sine_periods",
            f" = {lines:g}: {speed * period / 2**bits:.3g} lines in the {period * CLOCK:.3g} s of "
            f"a sample at {FASTEST:g} rad/s electrical, at most {MOST_OF_A_LINE:g}; an encoder "
            "with fewer",
        )
    offset = float(values.get("sine_offset", SINE_ERROR))
    gain = float(values.get("sine_gain", SINE_ERROR))
    noise = float(values.get("sine_noise", SINE_NOISE))
    # Errors of the lines act in three samples at most twice, as `absolute_position` has it.
    wrong = 4 * (offset + abs(gain) / 2 + 6 * noise) / (2 * math.pi) * 2**bits
    jump = math.ceil(_jump(one, period, frame - ACTS) + wrong) + 3
    if jump > MOST_OF_A_LINE * 2**bits:
        raise _Wrong(
            "sine_periods",
            f" = {lines:g}: an acceleration by the rated current, and the errors of the lines, "
            f"move the position by {jump / 2**bits:.3g} lines in a sample, at most "
            f"{MOST_OF_A_LINE:g}; smaller errors, more encoder_counts, an encoder with fewer "
            "lines, or a larger inertia",
        )
    counter = {
        "Width": bits,
        "Drop": 0,
        "Modulus": 0,
        "Period": period,
        "Instant": instant,
        "MostJump": jump,
        "Periods": ALLOWED_PERIODS,
    }
    port = {
        "Width": SINE_WIDTH,
        "Bits": bits,
        "Least": SINE_AMPLITUDE // 2,
        "Most": SINE_AMPLITUDE * 3 // 2,
        "After": ALLOWED_PERIODS,
    }
    return replace(
        one, port=port, counter=counter, frame_clocks=frame, sine_errors=(offset, gain, noise)
    )


def _jump(one: OneMotor, period: int, frame: int) -> float:
    """Counts by which the motor can leave the extrapolated position until a frame acts; both in
    clocks."""
    motor = one.motor
    push = JUMP_MARGIN * OVERCURRENT * motor.force_per_ampere * motor.i_max / one.inertia
    return push / one.resolution * CLOCK**2 * period * (period + frame + ACTS)


def _even_clocks(time: float) -> int:
    """The least even number of clocks that are not shorter than the time [s]."""
    return 2 * math.ceil(time / CLOCK / 2 - 1e-9)


def _travel_of(linear: bool, counts: float) -> float:
    """Travel of a count [m or rad] of so many of a metre or a turn."""
    return 1 / counts if linear else 2 * math.pi / counts


def _possible(one: OneMotor, values: Mapping[str, Any]) -> Iterator[tuple[str, bool, str]]:
    """Name, whether impossible, cause and cure: what single limits do not see."""
    motor, rated = one.motor, one.motor.i_max
    linear = one.kind == LINEAR
    circle = one.U_dc / math.sqrt(3)
    constant = "force_constant" if linear else "torque_constant"
    yield (
        *("R", motor.R * rated > 0.6 * circle),
        f" ohm: the rated current needs {motor.R * rated:.3g} V of the {circle:.3g} V that a bus "
        f"of {one.U_dc:g} V gives; a smaller rated_current, or a larger bus_voltage",
    )
    least = min(motor.L_d, motor.L_q)
    ripple = one.U_dc * LOOP_PERIOD / (8 * least)
    name = "L" if "L" in values else ("L_d" if motor.L_d < motor.L_q else "L_q")
    yield (
        *(name, ripple > MOST_RIPPLE * rated),
        f" H: the carrier of {one.f_pwm:g} Hz makes a ripple of {ripple:.3g} A in it, more than "
        f"{MOST_RIPPLE:g} of the rated current; a choke in each phase, or a smaller bus_voltage",
    )
    ratio = max(motor.L_d, motor.L_q) / least
    yield (
        *("L_q", ratio > 3),
        f" H: {ratio:.3g} times apart from L_d; the torque of the reluctance is not used here, "
        "must be within 3 times",
    )
    counts = motor.pole / one.resolution
    yield (
        *("encoder_counts", counts < LEAST_COUNTS),
        f": only {counts:.4g} counts of an electrical turn; at least {LEAST_COUNTS} for the angle "
        "of the current loop, take a finer encoder",
    )
    turn = round(2 * math.pi / one.absolute)
    yield (
        *("absolute_counts", motor.pole / one.absolute < LEAST_COUNTS),
        f": only {motor.pole / one.absolute:.4g} positions of an electrical turn; at least "
        f"{LEAST_COUNTS} for the angle at the start, take a finer encoder",
    )
    yield (
        *("absolute_counts", not linear and abs(turn * one.absolute / (2 * math.pi) - 1) > 1e-12),
        ": must be a whole number, a turn has no part of a position",
    )
    positions = (one.travel if linear else 2 * math.pi) / one.absolute
    bits = 64 if one.encoder == SINCOS else one.port.get("Width", 64)
    yield (
        *("encoder_bits", round(positions) > 1 << bits),
        f": {positions:.6g} positions of {'the travel' if linear else 'a turn'} need "
        f"{math.ceil(math.log2(positions))} bits; correct encoder_bits or absolute_counts",
    )
    clocks = one.port.get("ClocksPerBit", 0)
    yield (
        *("encoder_clock", clocks > MOST_CLOCKS),
        f" Hz: {clocks} clocks a bit at {1e-6 / CLOCK:g} MHz, "
        f"`{one.port_name}` has {MOST_CLOCKS}; a faster clock",
    )
    span = one.travel if linear else 100 * 2 * math.pi
    yield (
        *("encoder_counts", min(span, 8 * motor.pole) / one.resolution > LARGEST),
        f": more than {LARGEST} counts in the travel or in 8 electrical turns, which binary32 does "
        "not hold exactly; divide them, or a shorter travel",
    )
    yield (
        *("travel", one.travel < 2.5 * motor.pole),
        f" m: less than 2.5 electrical turns of {motor.pole:g} m; the alignment moves by one to "
        "each side; a longer free travel",
    )
    force = motor.force_per_ampere * rated
    yield (
        *("friction", STATIC * one.friction.coulomb + motor.cogging > 0.3 * force),
        f" {one.units[1]}: with static friction of {STATIC:g} times that and the cogging, more "
        f"than 0.3 of the rated {force:.3g} {one.units[1]}; nothing would move, enter a "
        f"larger {constant} or rated_current",
    )
    yield (
        *("current_range", one.current_scale < OVERCURRENT * rated),
        f" A: axes trip at {OVERCURRENT:g} of the rated current, {OVERCURRENT * rated:.3g} A, "
        "which the sensors must show; a larger range or a smaller rated_current",
    )
    yield (
        *("velocity_bandwidth", one.velocity_bandwidth * SEPARATION > one.current_bandwidth),
        f" Hz: more than 1/{SEPARATION:g} of current_bandwidth = {one.current_bandwidth:g} Hz; it "
        f"needs a fast current loop, must be <= {one.current_bandwidth / SEPARATION:g}",
    )
    fast = HALL_SPEED * fastest_move(one, motor.psi)
    edges = SECTORS * fast / (2 * math.pi)  # a second
    yield (
        *(
            "velocity_bandwidth",
            one.encoder == HALL and one.velocity_bandwidth > edges / HALL_EDGES,
        ),
        f" Hz: Hall lines have {edges:.3g} edges a second at {fast:.3g} rad/s "
        f"electrical, where the loop is measured; must be <= {edges / HALL_EDGES:.3g}, or take "
        "another encoder",
    )
    speed = 0.1 * circle / motor.psi
    yield (
        *("flux" if "flux" in values else constant, speed < 1.0),
        f": the bus voltage allows only {10 * speed:.3g} rad/s electrical of at most {FASTEST:g}; "
        "check the unit, or a larger bus_voltage",
    )
