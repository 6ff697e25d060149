# SPDX-License-Identifier: Apache-2.0
"""asip-dbg at a terminal: prompt, completion, Ctrl-C, Ctrl-D, history."""

from __future__ import annotations

from tests.debugger.debugged import ENDLESS, LEG
from tests.debugger.terminal import PROMPT, Terminal


def test_keys_of_the_prompt(tmp_path):
    with Terminal(tmp_path, str(LEG), "--iss", "--set", "x=0.3") as terminal:
        terminal.wait_for(PROMPT)
        terminal.type("brea\t (2\t")
        terminal.wait_for("(28)")
        terminal.type("8)\r")  # read in the same way while the list of completions is being printed
        terminal.wait_for("breakpoint 1: equation (28)")
        terminal.type("ru\t\r")
        terminal.wait_for("=> bundle 4")
        terminal.type("zork\r")
        terminal.wait_for("no command 'zork'")
        terminal.wait_for(PROMPT)
        terminal.type("\x03")
        terminal.wait_for("Ctrl-D ends the session")
        terminal.wait_for(PROMPT)
        terminal.type("\x04")
        assert terminal.close() == 0
    assert "+break (28)" in (tmp_path / ".asip_dbg_history").read_text()


def test_ctrl_c_halts_a_core_that_runs(tmp_path):
    with Terminal(tmp_path, str(ENDLESS), "--iss") as terminal:
        terminal.wait_for(PROMPT)
        terminal.type("run\r")
        terminal.wait_for("halted at bundle", again="\x03")
        terminal.wait_for(PROMPT)
        terminal.type("quit 5\r")
        assert terminal.close() == 5
