# SPDX-License-Identifier: Apache-2.0
"""Commands in a checkout that cannot be written: each names the folder and the cure."""

from __future__ import annotations

import shlex
import shutil

import pytest

from tests.bench.commands import output
from tests.security.campaign_environments import can_confine
from tests.security.environments import SQUARE, copied

CURE = "copy the checkout to a folder of your own, or make it writable"
COMMANDS = (
    "-m asip_asm.cli_as asip_asm/programs/tracking_optimised.s",
    "-m sim.debug.asip_run ../square.s",
    "-m sim.debug.asip_dbg ../square.s --batch -ex run",
    "-m sim.debug.nios_run --system fpga1 nios_sw/images/run/demo_hello_fpga1.elf",
    "-m sim.core.host -o libcore.so",
    "-m sim.cocotb asip",
    "-m sim.rtl.board ulx3s",
    "-m sim.core.fpbench case mul 00ffffff 3f000000",
    # An installed rs274 is not fetched.
    *(() if shutil.which("rs274") else ("-m sim.motion.gcode.oracle",)),
    "-m scripts.goals security caches",
    "-m scripts.plain_verilog --only biss_port",
    "scripts/gen_isa.py",
    "-m pytest -p no:cacheprovider tests/asm/test_machine.py",
)


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Command -> its exit status and what it printed."""
    if not can_confine():
        pytest.fail("unshare -rm is needed")
    folder = tmp_path_factory.mktemp("read_only")
    checkout = copied(folder / "checkout")
    (checkout / "docs/isa.md").write_text("old\n", encoding="utf-8")  # to be generated again
    (folder / "square.s").write_text(SQUARE, encoding="utf-8")
    place = shlex.quote(str(checkout))
    lines = [f"mount --bind {place} {place}", f"mount -o remount,ro,bind {place}", f"cd {place}"]
    for n, command in enumerate(COMMANDS):
        lines.append(f"PYTHONPATH=. .venv/bin/python {command} > ../{n} 2>&1; echo $? >> ../{n}")
    script = "\n".join(lines)
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "PYTHONUTF8": "1"}
    output("unshare", "-rm", "sh", "-c", script, env=environment, timeout=600)
    return {command: (folder / str(n)).read_text() for n, command in enumerate(COMMANDS)}


@pytest.mark.parametrize("command", COMMANDS)
def test_command__in_a_read_only_checkout__says_the_cure(command: str, said) -> None:
    text = said[command]
    assert CURE in text and "Traceback" not in text, text
    assert text.splitlines()[-1] != "0", text


def test_message__names_the_output(said) -> None:
    """The file that the user knows, not one that is written on the way."""
    first = said[COMMANDS[0]]
    assert first.startswith("asip-as: error: ") and "/tracking_optimised.asip.json: " in first
