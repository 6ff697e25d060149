# SPDX-License-Identifier: Apache-2.0
"""Registers of the debug block as values: state of the core, set-up and records of the scope."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from asip_asm.gen.asip_regmap import REGMAP as CORE_MAP
from asip_asm.isa import default_isa
from sim.debug.gen.debug_regmap import REGMAP

BASE = 1 << CORE_MAP.address_width
"""First word of the debug block on the bus of `debug_asip`."""
REGISTER = {name: BASE + REGMAP.address(name) for name in REGMAP.registers}
FIELDS = {name: register.fields for name, register in REGMAP.registers.items()}
STAGE = BASE + REGMAP.blocks["stage"].base
RING = BASE + REGMAP.blocks["ring"].base
RING_WORDS = REGMAP.blocks["ring"].words
BANKS = "abc"


def code(enumeration: str, name: str) -> int:
    """Code of a value of an enumeration. Raises KeyError."""
    return REGMAP.enumerations[enumeration][name.upper()].code


def configuration_of(word: int, stream: int) -> str:
    """Name of the configuration that a core's CONFIG and STREAM state, or 'unknown'."""
    shape = tuple(
        CORE_MAP.registers["CONFIG"].fields[name].of(word) for name in ("slots", "fma_pipes")
    )
    words_log2 = CORE_MAP.registers["STREAM"].fields["words_log2"].of(stream)
    words = 1 << words_log2 if words_log2 else 0
    known = default_isa().configurations.values()
    lanes = CORE_MAP.registers["STREAM"].fields["lanes"].of(stream)
    wanted = (*shape, words, lanes)
    found = (c for c in known if (len(c.slots), c.fma_pipes, c.stream_words, c.lanes) == wanted)
    return next((c.name for c in found), "unknown")


def name_of(enumeration: str, number: int) -> str:
    """Name of a code in lower case; the number in words if there is none."""
    names = {entry.code: entry.name.lower() for entry in REGMAP.enumerations[enumeration].values()}
    return names.get(number, f"code {number}")


def fields_of(register: str, word: int) -> dict[str, int]:
    """Fields of a register's word by name."""
    return {name: field.of(word) for name, field in FIELDS[register].items()}


@dataclass(frozen=True)
class Sizes:
    """What the block was built with."""

    breakpoints: int
    watches: int
    channels: int
    ring_words: int
    stage_words: int
    uart: bool


@dataclass(frozen=True)
class State:
    """State of the core and its page.

    held: no bundle issues except for a step. halted: held inside a run, with every result of the
    bundles issued written; `next` is then the bundle that issues next. reason: 'none',
    'request', 'step', 'start', 'breakpoint' or 'watch', `which` its number. last: the bundle
    issued last. fault: the core is faulted (its own STATUS states the cause). scope: 'idle',
    'waiting', 'triggered' or 'frozen'; black_box: by a fault.
    """

    held: bool
    halted: bool
    running: bool
    empty: bool
    fault: bool
    staged: bool
    committing: bool
    overflow: bool
    reason: str
    which: int
    scope: str
    black_box: bool
    triggered: bool
    next: int
    last: int

    @classmethod
    def of(cls, status: int, place: int) -> State:
        """State of the words STATUS and PLACE."""
        bits, at = fields_of("STATUS", status), fields_of("PLACE", place)
        return cls(
            held=bool(bits["held"]),
            halted=bool(bits["halted"]),
            running=bool(bits["running"]),
            empty=bool(bits["empty"]),
            fault=bool(bits["fault"]),
            staged=bool(bits["staged"]),
            committing=bool(bits["committing"]),
            overflow=bool(bits["overflow"]),
            reason=name_of("stop_reason", bits["reason"]),
            which=bits["which"],
            scope=name_of("scope_state", bits["scope"]),
            black_box=bool(bits["black_box"]),
            triggered=bool(bits["triggered"]),
            next=at["next"],
            last=at["last"],
        )


@dataclass(frozen=True)
class Channel:
    """What a channel of the scope records once a run.

    place: a register ('a3', 'b0', 'c12': its last write in the run, or the `write`-th, from 1), an
    output ('o2'), a word of bank K ('k5', as the host wrote it last), or 'cycles'. name and
    type ('float' or 'int') are for who shows it.
    """

    place: str
    write: int = 0
    name: str = ""
    type: str = "float"

    def word(self) -> int:
        """Value of the register CHANNEL. Raises ValueError."""
        record = REGMAP.registers["CHANNEL"]
        if self.place == "cycles":
            return record.word(kind=code("channel_kind", "CYCLES"))
        letter, digits = self.place[:1], self.place[1:]
        limit = {"k": 128, "o": 32}.get(letter, 64)
        if letter not in "abcko" or not digits.isdecimal() or int(digits) >= limit:
            raise ValueError(
                f"channel '{self.place}': expected a register (a0..c63), an output (o0..o31), a "
                "word of bank K (k0..k127) or 'cycles'"
            )
        if not 0 <= self.write < 16:
            raise ValueError(f"channel '{self.place}': write {self.write} is not 0 to 15")
        kind = {"k": "INPUT", "o": "OUTPUT"}.get(letter, "REGISTER")
        bank = BANKS.index(letter) if letter in BANKS else 0
        return record.word(
            kind=code("channel_kind", kind), bank=bank, index=int(digits), write=self.write
        )


@dataclass(frozen=True)
class Trigger:
    """When the scope triggers: kind of docs/debug_regmap.md in lower case, compared with the
    records of a channel (its number); low and high in the channel's type."""

    kind: str = "now"
    channel: int = 0
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class ScopeSetup:
    """Channels (1 to 8), runs per record, trigger, and how many records to keep before the
    trigger (`pre`) and from it on (`post`; 0: record on, for a display that rolls)."""

    channels: tuple[Channel, ...]
    decimation: int = 1
    trigger: Trigger = field(default_factory=Trigger)
    pre: int = 0
    post: int = 0

    @property
    def size(self) -> int:
        """Words of a record in the ring."""
        return 1 << (len(self.channels) - 1).bit_length()

    @property
    def capacity(self) -> int:
        """Records in the ring."""
        return RING_WORDS // self.size

    def check(self) -> None:
        """Raises ValueError for what the block cannot do; the text says what it can."""
        if not 1 <= len(self.channels) <= 8:
            raise ValueError(f"{len(self.channels)} channels; the scope records 1 to 8")
        if not 1 <= self.decimation <= 1 << 16:
            raise ValueError(f"decimation {self.decimation}; 1 to {1 << 16} runs per record")
        if self.trigger.kind.upper() not in REGMAP.enumerations["trigger_kind"]:
            kinds = ", ".join(name.lower() for name in REGMAP.enumerations["trigger_kind"])
            raise ValueError(f"no trigger '{self.trigger.kind}'; there are {kinds}")
        if not 0 <= self.trigger.channel < len(self.channels):
            raise ValueError(f"trigger on channel {self.trigger.channel} of {len(self.channels)}")
        if self.pre < 0 or self.post < 0 or self.pre + self.post > self.capacity:
            raise ValueError(
                f"{self.pre} records before and {self.post} from the trigger on; the ring holds "
                f"{self.capacity} of {len(self.channels)} channels"
            )


@dataclass(frozen=True)
class Records:
    """Consecutive records from number `first` on, each a word per channel; `lost` records before
    them were overwritten or never came."""

    first: int
    words: list[tuple[int, ...]]
    lost: int = 0


def word_of(value: float, type_name: str = "float") -> int:
    """The 32 bits of a number of type 'float' (rounded to binary32) or 'int'."""
    if type_name == "int":
        return int(value) & 0xFFFFFFFF
    return int.from_bytes(struct.pack("<f", value), "little")
