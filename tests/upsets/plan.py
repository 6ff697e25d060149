# SPDX-License-Identifier: Apache-2.0
"""Where and when upsets are injected: samples by kind of place, from a seed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.upsets.model import TICKS, UPSET, Model, Site

SEED = 20260401
SHARD = 500
"""Injections of a shard."""
BLOCKS = {
    "multiply-add pipes": r"\.gen_pipe\[",
    "fetch": r"\.u_fetch\.",
    "issue, scoreboard": r"\.u_issue\.",
    "operands": r"\.u_operands\.",
    "division, root": r"\.u_aux\..*u_divsqrt\.",
    "sine, cosine": r"\.u_aux\..*u_sincos\.",
    "other auxiliary units": r"\.u_aux\.",
    "control": r"\.u_run\.u_control\.",
    "redundancy": r"\.u_redundancy\.",
    "outputs": r"\.u_outputs\.",
    "host port": r"\.u_host\.",
    "stages R1 to E2": r"",
}
"""Block of flip-flops -> pattern of their places; the first that fits counts."""


@dataclass(frozen=True)
class Kind:
    """A kind of place. share: of all injections; pattern: of the names of its sites."""

    name: str
    share: float
    pattern: str
    memory: bool


KINDS = (
    Kind("flip-flops", 0.5, r"(_q|\.Q)$", False),
    Kind("program memory in use", 0.2, r"\.u_fetch\.gen_lane\[\d+\]\.u_ram\.memory$", True),
    Kind("bank K in use", 0.1, r"\.u_bank_k\..*\.memory$", True),
    Kind("banks A, B, C", 0.1, r"\.u_bank_[abc]\..*\.memory$", True),
    Kind("outputs in use", 0.1, r"\.u_outputs\.u_(host|record)\.memory$", True),
)


A_IN_A, K_IN_A = 64, 128
"""First words of banks A and K in a memory that both share (asip_operands_multiple.sv)."""


def block_of(place: str) -> str:
    """Block of a flip-flop by its place."""
    return next(block for block, pattern in BLOCKS.items() if re.search(pattern, place))


def places(model: Model, kind: Kind) -> list[tuple[int, np.ndarray]]:
    """(site, elements) of a kind, each element of it in use by the program."""
    image = model.image
    used = {
        "program memory in use": np.arange(len(image.bundles)),
        "bank K in use": np.array([e.index for e in (*image.inputs, *image.constants)]),
        "outputs in use": np.concatenate(
            [np.array([o.index for o in image.outputs]) + 32 * page for page in range(3)]
        ),
    }.get(kind.name)
    # Without redundancy bank K is in the memories of bank A, after its registers.
    shared = not any(".u_bank_k." in site.name for site in model.sites)
    pattern = kind.pattern
    if shared and kind.name == "bank K in use":
        pattern, used = pattern.replace("bank_k", "bank_a"), used + K_IN_A
    found = []
    for number, site in enumerate(model.sites):
        if (site.elements > 1) == kind.memory and re.search(pattern, site.name):
            elements = np.arange(site.elements) if used is None else used
            if shared and kind.memory and used is None and ".u_bank_a." in site.name:
                elements = np.arange(A_IN_A, K_IN_A)
            found.append((number, elements))
    return found


def draw(model: Model, kind: Kind, shard: int) -> np.ndarray:
    """Upsets (SHARD, UPSET) of a shard: every bit of the kind and every clock of a tick."""
    random = np.random.default_rng([SEED, [k.name for k in KINDS].index(kind.name), shard])
    found = places(model, kind)
    weights = np.array([model.sites[site].bits * len(e) for site, e in found], dtype=float)
    chosen = random.choice(len(found), SHARD, p=weights / weights.sum())
    upsets = np.zeros(SHARD, dtype=UPSET)
    upsets["tick"] = random.integers(TICKS, size=SHARD)
    upsets["clock"] = random.integers(model.lengths[upsets["tick"]])
    for i, place in enumerate(chosen):
        site, elements = found[place]
        upsets["site"][i] = site
        upsets["element"][i] = random.choice(elements)
        upsets["bit"][i] = random.integers(model.sites[site].bits)
    return upsets


def line_of(sites: Sequence[Site], upset: np.void) -> str:
    """An upset as a line that `--replay` takes."""
    site = sites[upset["site"]]
    place = f"[{upset['element']}]" if site.elements > 1 else ""
    return f"{upset['tick']} {upset['clock']} {site.name}{place}.{upset['bit']}"


def upset_of(sites: Sequence[Site], line: str) -> np.ndarray:
    """The upset (1, UPSET) of such a line. Raises ValueError."""
    found = re.fullmatch(r"\s*(\d+) (\d+) (\S+?)(?:(?<=memory)\[(\d+)\])?\.(\d+)\s*", line)
    if not found:
        raise ValueError(f"'{line}' is not TICK CLOCK NAME.BIT, as the campaign prints it")
    tick, clock, name, element, bit = found.groups()
    numbers = {site.name: number for number, site in enumerate(sites)}
    if name not in numbers:
        raise ValueError(f"no register or memory {name} in this core")
    site = sites[numbers[name]]
    if int(tick) >= TICKS or int(bit) >= site.bits or int(element or 0) >= site.elements:
        raise ValueError(f"'{line}': tick, word or bit beyond the {TICKS} ticks or the memory")
    return np.array([(tick, clock, numbers[name], element or 0, bit)], dtype=UPSET)
