# SPDX-License-Identifier: Apache-2.0
"""Write docs/gcode_words.md, the words of a program that act, are ignored and are refused.

From sim/motion/gcode/block.py and sim/motion/gcode/unsupported.py. With --check nothing is written;
exit 1 if the page would differ.
"""

from __future__ import annotations

import sys

from scripts.generated import run, template
from sim.motion.gcode.block import GROUPS, letters_of
from sim.motion.gcode.unsupported import IDLE_LETTERS, IGNORED, refused_letters, refused_words

SCRIPT = "scripts/gen_gcode_words.py"


def generate() -> dict[str, str]:
    """Text of the page by its path."""
    ignored = {word for words, _ in IGNORED for word in words.split()}
    idle = [(f"{' '.join(letters)} of {code}", why) for code, letters, why in IDLE_LETTERS]
    used = [
        (group, code, " ".join(letters_of(code)) or "-")
        for group, codes in GROUPS.items()
        for code in codes
        if code not in ignored
    ]
    text = template("gcode_words.md.j2").render(
        script=SCRIPT,
        used=used,
        ignored=[*IGNORED, *idle],
        refused=[*refused_words(), *refused_letters()],
    )
    return {"docs/gcode_words.md": text}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, "Write the page of the words of G-code.", generate))
