# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the two files of asip-model: saved functions, and interface records with hostile
names and texts.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

from sim.laws.asip_model import __main__ as asip_model
from tests.fuzz.engine import Campaign
from tests.fuzz.model import RECORD, RECORD_WORDS, damaged, law
from tests.fuzz.mutate import mutated_text

LENGTH = 2  # characters of a byte in a saved function
TEXTS = (
    *("External", "GenericExternal", "ShellCompiler", "DllLibrary", "CallbackInternal", "Nlpsol"),
    *(
        "source",
        "link",
        "embed",
        "shell",
        "clang",
        "./x.so",
        "MXFunction",
        "Switch",
        "Map",
        "MapSum",
    ),
    *("", "q", "torque", "total_next", "q" * 300, "\0", '"\n.include "/etc/passwd"'),
)
HOSTILE = (
    *(
        '"',
        "'",
        "\\",
        '\\n.include \\"/etc/passwd\\"',
        "\\u2028halt",
        "*/ int x; /*",
        "%s",
        "$(id)",
    ),
    *(
        "`id`",
        "<script>",
        "|",
        "; rm",
        "#",
        "-Wno-unused-input:",
        "??/",
        "é",
        "\\u0000",
        "\\u001b[2J",
    ),
)


def encoded(data: bytes) -> bytes:
    """Bytes as `Function.save` writes them."""
    return b"".join(bytes((97 + byte % 16, 97 + byte // 16)) for byte in data)


def text_of(name: str) -> bytes:
    return encoded(len(name).to_bytes(4, "little") + name.encode())


def changed(rng: Random, content: bytes) -> bytes:
    """A saved function with other texts, numbers or bytes in it."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = LENGTH * rng.randrange(len(content) // LENGTH)
        kind = rng.randrange(6)
        if kind == 0:
            content = content[:at] + encoded(rng.randbytes(1)) + content[at + LENGTH :]
        elif kind == 1:
            number = encoded(
                rng.choice((0, 1, 2, 64, 1 << 31, (1 << 63) - 1)).to_bytes(8, "little")
            )
            content = content[:at] + number + content[at + len(number) :]
        elif kind == 2:
            content = content[:at] + text_of(rng.choice(TEXTS)) + content[at:]
        elif kind == 3:
            old, new = (text_of(rng.choice(TEXTS)) for _ in range(2))
            content = content.replace(old, new, 1)
        elif kind == 4:
            content = damaged(rng, content)
        else:
            content = content[: at or LENGTH]
        content = content or b"aa"
    return content


def run(record: str, function: bytes) -> int | None:
    Path("law.toml").write_bytes(record.encode("utf-8", errors="surrogatepass"))
    Path("law.casadi").write_bytes(function)
    return asip_model.main(["law.casadi", "law.toml", "-o", "out", "--c"])


def function_case(rng: Random) -> int | None:
    """A damaged or changed function next to a good record."""
    return run(RECORD, changed(rng, law()))


def record_case(rng: Random) -> int | None:
    """A record with other words, and texts that a generator must quote, next to a good function."""
    record = RECORD
    for _ in range(rng.choice((0, 1, 2))):
        text = "".join(rng.choice((*HOSTILE, "a ", "b")) for _ in range(rng.randint(1, 5)))
        key = rng.choice(("title", "meaning", "unit", "names", "vector"))
        line = f'{key} = ["{text}"]' if key == "names" else f'{key} = "{text}"'
        rows = record.splitlines(keepends=True)
        places = [i for i, row in enumerate(rows) if row.startswith(f"{key} =")]
        if places:
            rows[rng.choice(places)] = f"{line}\n"
        record = "".join(rows)
    if rng.random() < 0.7:
        record = mutated_text(rng, record, RECORD_WORDS)
    return run(record, law())


CAMPAIGNS = (
    Campaign("casadi-file", 5_000, function_case, law),
    Campaign("interface-file", 5_000, record_case, law),
)
