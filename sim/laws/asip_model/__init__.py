# SPDX-License-Identifier: Apache-2.0
"""Command asip-model, which needs more packages than the other commands."""

import sys


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status, 1 without CasADi."""
    try:
        from sim.laws.asip_model import __main__ as command
    except ModuleNotFoundError as error:
        if error.name != "casadi":
            raise
        print(
            "asip-model: error: CasADi is not installed\n"
            "help: pip install 'microtick[model]', or make setup in a checkout",
            file=sys.stderr,
        )
        return 1
    return command.main(arguments)
