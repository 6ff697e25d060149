# SPDX-License-Identifier: Apache-2.0
"""Write docs/function_errors.md from asip_asm/model/functions.py and combinations.py.

With --check nothing is written; exit 1 if the page would differ.
"""

from __future__ import annotations

import sys

from asip_asm.model.combinations import COMBINATIONS, Combination
from asip_asm.model.functions import FUNCTIONS, Function
from scripts.generated import run, table, template

SCRIPT = "scripts/gen_function_page.py"


def error_text(ulp: float, absolute: float, growth: str = "") -> str:
    """The stated error in words."""
    if not ulp and not absolute:
        return "exact"
    units = f"{ulp:g} + {growth}" if growth else f"{ulp:g}"
    return f"{units}; {absolute:g}" if absolute else units


def of_function(name: str, function: Function) -> list[str]:
    low, high = function.domain
    error = error_text(function.ulp, function.absolute)
    return [f"`{name}`", error, f"{low:.8g} to {high:.8g}", function.outside]


def of_combination(name: str, made: Combination) -> list[str]:
    error = error_text(made.ulp, made.absolute, made.growth_text)
    first, comma, rest = name.partition(",")
    return [f"`{first}`{comma}{rest}", error, made.domain_text, made.outside]


def generate() -> dict[str, str]:
    """Text of the page by its path."""
    rows = [of_function(*item) for item in FUNCTIONS.items()]
    rows += [of_combination(*item) for item in COMBINATIONS.items()]
    head = ["function", "error: units of 2^-23; absolute", "domain", "outside"]
    text = template("function_errors.md.j2").render(script=SCRIPT, rows=table(head, rows))
    return {"docs/function_errors.md": text}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, __doc__.splitlines()[0], generate))
