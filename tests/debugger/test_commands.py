# SPDX-License-Identifier: Apache-2.0
"""asip-dbg's commands on the instruction-set model: what they answer, and how they refuse."""

from __future__ import annotations

import io
import re
import subprocess
import sys
from itertools import chain, repeat
from unittest.mock import DEFAULT, Mock

import pytest

from asip_asm.cli_as import main as asip_as
from sim.debug.asip_dbg.__main__ import main
from sim.debug.asip_dbg.command_table import CommandError, find_command
from sim.debug.asip_dbg.completion import completions
from sim.rtl.asip_bus import LinkError
from tests.debugger import debugged
from tests.debugger.debugged import LEG, LOOP, STORES


class Debugger(debugged.Debugger):
    """`refuses(line)` gives the text of an error that the command must end with."""

    def refuses(self, line: str) -> str:
        with pytest.raises(CommandError) as error:
            self.commands.execute(line)
        return str(error.value)


@pytest.fixture
def leg() -> Debugger:
    return Debugger(LEG)


@pytest.fixture
def loop() -> Debugger:
    return Debugger(LOOP)


def test_break_at_an_equation_and_print_by_name(leg):
    assert "equation (28)" in leg.tell("break (28)")
    assert "fsub e, l_d, l  (28)" in leg.tell("run")
    assert leg.tell("print t").startswith("t = 0.25  (")
    assert leg.tell("print/x t") == "t = 0x3e800000"
    assert leg.tell("p/d t") == "t = 1048576000"
    assert leg.tell("print 2*t - 0.5 < 1") == "2*t - 0.5 < 1 = true"
    assert "not yet computed" in leg.refuses("print e")
    leg.tell("stepi")
    assert leg.tell("p e").startswith("e = 0.00825")


def test_definitions_of_a_name_are_told_apart(leg):
    leg.tell("break e", "run")
    assert "leg.s:13" in leg.tell("p t") and "leg.s:12" in leg.tell("p t@1")
    assert "f: not yet computed" in leg.refuses("p f")


def test_places_of_breakpoints(leg):
    for text in ("16", "leg.s:16", "(28)", "*4", "e", "bundle 4"):
        assert leg.session.location(text).bundles == (4,), text
    assert "first operation from line 2 on" in leg.session.location("2").text
    assert "(7), (28), (29), (30)" in leg.refuses("break (31)")
    assert "go to 7" in leg.refuses("break *8")
    assert "did you mean 'de'" in leg.refuses("break dee")
    assert "leg.s" in leg.refuses("break nowhere.s:3")


def test_line_of_a_macro_and_its_call(loop):
    call = loop.session.location("18")
    body = loop.session.location("loop.s:10")
    assert len(call.bundles) == len(body.bundles) == 1
    loop.tell("break 11", "run")
    assert "macro add_entry, called at" in loop.tell("backtrace")
    assert "label again" in loop.tell("info line again")


def test_breakpoint_in_a_loop_counts_and_has_conditions(loop):
    loop.tell("break entry if i == 1", "run")
    assert loop.tell("p i").startswith("i = 1  ")
    loop.tell("delete", "tbreak entry", "continue")
    assert loop.tell("p i").startswith("i = 0  ")
    assert "no breakpoints" in loop.tell("info breakpoints")
    assert "sum     30" in loop.tell("continue")


def test_watch_stops_for_the_value_and_not_for_its_register(leg):
    leg.tell("watch e")
    assert "watch 1, e in" in leg.tell("run")
    assert leg.session.position == 5
    assert "end of tick" in leg.tell("continue")
    assert "one of its definitions: t@1, t@2" in leg.refuses("watch t")
    assert "watch 2: t@2" in leg.tell("watch t@2")
    assert "never written" in leg.refuses("watch R")


def test_watch_of_a_data_word_stops_when_a_store_changes_it():
    stores = Debugger(STORES)
    assert "watch 1: table[1] in d1" in stores.tell("watch table[1]")
    assert "watch 1, table[1] in d1: 0 -> 0.3" in stores.tell("run")
    assert stores.session.in_run and stores.tell("p table[1]").startswith("table[1] = 0.3")
    stores.tell("continue")
    assert stores.tell("run").startswith("end of tick")  # the store writes what is there
    stores.tell("set table[1] = 7")
    assert "watch 1, table[1] in d1: 7 -> 0.3" in stores.tell("run")


def test_watch_of_a_data_word_sees_the_store_of_the_last_bundle():
    stores = Debugger(STORES)
    stores.tell("watch table[2]", "watch table[0]")
    assert "watch 1, table[2] in d2: 0 -> 0.054" in stores.tell("run")
    assert stores.tell("print table[0]").startswith("table[0] = 0 ")
    assert "end of tick" in stores.tell("run", "run")
    stores.tell("delete", "watch table[2] if table[2] > 100", "set table[2] = 0")
    assert "watch" not in stores.tell("run")


def test_watch_of_a_data_word_that_nothing_stores_is_refused(loop):
    assert "table[1] is never written" in loop.refuses("watch table[1]")
    assert "table has 4 words" in loop.refuses("watch table[4]")


def test_set_changes_what_the_program_computes(leg):
    leg.tell("break (29)", "run", "set e = 0.5", "set $a63 = 1", "continue")
    assert leg.tell("p last").startswith("last = 0.5  ")
    assert leg.tell("p a63").startswith("a63 = 1  ")
    assert "F       100 " in leg.tell("info outputs")
    assert "0x3f800000" in leg.tell("set x = 0f3f800000")
    assert "too large" in leg.refuses("set x = 1e39")
    assert "constant" in leg.refuses("set K = 3")


def test_ticks_states_and_finish(leg):
    assert "end of tick 0" in leg.tell("tick")
    assert "end of tick 3" in leg.tell("tick 3")
    leg.tell("start")
    assert "before bundle 0" in leg.tell("info state")
    assert "from the run before" in leg.tell("p last")
    assert "end of tick 4" in leg.tell("finish")
    assert "no tick is running" in leg.refuses("finish")
    leg.tell("reset")
    assert leg.session.tick == 0


def test_steps_by_line_call_and_bundle(loop):
    loop.tell("start", "break (1)", "continue")
    inside = loop.session.position
    loop.tell("next")
    entry = loop.session.program.primary(loop.session.position)
    assert entry.line not in (10, 11) and loop.session.position != inside
    before = loop.session.position
    loop.tell("stepi 2")
    assert loop.session.position != before


def test_fault_names_the_first_value_that_is_not_finite(leg):
    text = leg.tell("set z = 0.7", "run")
    assert text.splitlines()[1].startswith("NOT_FINITE")
    assert "not finite, first computed: l_d = nan" in text and "leg.s:15" in text
    leg.tell("break l_d", "run")
    assert leg.tell("p q").startswith("q = -0.23999998")


def test_data_memory_and_its_bounds(loop):
    assert loop.tell("x/4f table") == "   0  table:  1  2  4  8"
    assert "0x40800000" in loop.tell("x/1x 2")
    assert loop.tell("p table[3]").startswith("table[3] = 8")
    assert "0..1023" in loop.refuses("x/8f 1020")
    assert "did you mean 'table'" in loop.refuses("x/8f tabel")


def test_list_disassemble_and_registers(leg):
    assert "=>" not in leg.tell("list 16")
    leg.tell("break (28)", "run")
    assert "=>    16" in leg.tell("list")
    assert "=>    4  { fsub" in leg.tell("disassemble")
    assert leg.tell("disassemble 0 1").count("{") == 2
    assert "l_d" in leg.tell("info registers")
    assert "e" in leg.tell("info values e")


def test_display_is_shown_at_every_stop(leg):
    leg.tell("display/x t", "break (28)")
    assert "1: t = 0x3e800000" in leg.tell("run")
    leg.tell("undisplay 1")
    assert "1:" not in leg.tell("stepi")


def test_abbreviations_and_repeats(leg):
    assert find_command("disas").names[0] == "disassemble"
    with pytest.raises(CommandError, match="ambiguous"):
        find_command("e")
    with pytest.raises(CommandError, match="did you mean 'break'"):
        find_command("braek")
    leg.tell("start", "stepi")
    before = leg.session.position
    leg.tell("", "")
    assert leg.session.position == before + 2


def test_too_many_breakpoints_are_refused_and_not_kept(leg):
    leg.session.target.breakpoints = 2
    leg.tell("b *1", "b *2")
    assert "has 2" in leg.refuses("b *3")
    assert len(leg.session.breakpoints) == 2
    leg.tell("disable 1", "b *3")
    assert "has 2" in leg.refuses("enable 1")


def test_completion(leg):
    assert "break" in completions(leg.session, "br")
    assert completions(leg.session, "p l_") == ["l_d"]
    assert "(28)" in completions(leg.session, "break ")
    assert "registers" in completions(leg.session, "info reg")
    assert completions(leg.session, "x ta") == ["table"]
    assert completions(leg.session, "zzz a") == []


def test_scripts_end_at_their_first_error_with_its_line(leg, tmp_path):
    script = tmp_path / "find.dbg"
    script.write_text("# find the fault\nbreak (28)\nrun\nassert t > 1\nprint t\n")
    message = leg.refuses(f"source {script}")
    assert message == f"{script}:4: assert t > 1: false"
    script.write_text(f"source {script}\n")
    assert "16 deep" in leg.refuses(f"source {script}")
    assert "No such file" in leg.refuses("source nothing.dbg")


@pytest.fixture
def run_main(monkeypatch):
    def run(*arguments: object, stdin: str = "") -> int:
        monkeypatch.setattr(sys, "stdin", io.StringIO(stdin))
        return main([*map(str, arguments), "--iss"])

    return run


def test_exit_status(tmp_path, capsys, run_main):
    base = [LEG, "--set", "x=0.3"]
    for arguments, status in [
        (["--batch", "-ex", "run"], 0),
        (["--batch", "-ex", "zork"], 1),
        (["--batch", "-ex", "assert 1 > 2"], 3),
        (["--batch", "-ex", "quit 7"], 7),
        (["-x", tmp_path / "none"], 1),
    ]:
        assert run_main(*base, *arguments) == status, arguments
    assert run_main(*base, stdin="run\np F\nquit\n") == 0
    assert "F = " in capsys.readouterr().out
    assert run_main(*base, stdin="zork\n") == 1


def test_files_that_do_not_fit(tmp_path, capsys, run_main):
    image = tmp_path / "leg.asip.json"
    assert asip_as([str(LEG), "-o", str(image)]) == 0
    beside = tmp_path / "leg.asip.map.json"
    kept = beside.read_text()
    beside.unlink()
    assert run_main(image) == 1
    assert "asip-as and asip-model write it next to the image" in capsys.readouterr().err
    assert asip_as([str(LEG), "-O0", "-o", str(image)]) == 0
    beside.write_text(kept)
    assert run_main(image) == 1
    assert "another program" in capsys.readouterr().err
    assert run_main(tmp_path / "none.s") == 1
    assert run_main(LEG, "--set", "w=1") == 2


def test_changed_source_is_told(tmp_path, capsys, run_main):
    source, image = tmp_path / "leg.s", tmp_path / "leg.asip.json"
    source.write_text(LEG.read_text())
    assert asip_as([str(source), "-o", str(image)]) == 0
    source.write_text("; one line more\n" + LEG.read_text())
    assert run_main(image, "--batch") == 0
    assert "changed since it was assembled" in capsys.readouterr().err


def test_target_that_is_gone_can_be_found_again(leg):
    target = leg.session.target

    def gone(seconds: float) -> None:
        raise LinkError("no answer")

    target.poll = gone
    with pytest.raises(LinkError):
        leg.tell("run")
    del target.poll
    assert "program loaded" in leg.tell("reconnect")
    assert "end of tick 0" in leg.tell("run")


def test_ctrl_c_halts_the_core(leg):
    target = leg.session.target
    target.poll = Mock(wraps=target.poll, side_effect=chain([KeyboardInterrupt], repeat(DEFAULT)))
    assert "halted at bundle 0" in leg.tell("run")
    assert leg.session.in_run
    assert "end of tick 0" in leg.tell("continue")


def test_rows_of_inputs_feed_the_ticks(leg, tmp_path):
    table = tmp_path / "rows.csv"
    table.write_text("x,z\n0.1,0.2\n0.2,0.2\n0.4,0.2\n")
    assert leg.tell(f"inputs {table}") == "3 rows of inputs"
    assert "end of tick 2" in leg.tell("run")
    assert leg.tell("p x").startswith("x = 0.4  ")


def test_start_takes_no_package_that_it_does_not_need():
    code = (
        "import sys; from sim.debug.asip_dbg.__main__ import main; "
        f"main([{str(LEG)!r}, '--iss', '--batch']); "
        "print([m for m in ('prompt_toolkit', 'scipy', 'matplotlib', 'rich') if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == "[]"


def test_hits__are_ignored_counted_and_chosen(leg):
    leg.tell("break (28)")
    assert "the next 2 hits of 1 do nothing" in leg.tell("ignore 1 2")
    assert [("equation" in leg.tell("tick")) for _ in range(2)] == [False, False]
    assert "equation (28)" in leg.tell("tick")
    assert "fifth" in leg.tell("help hits")
    leg.tell("kill", "hits 1 % 2")
    leg.tell("tick 3", "kill")
    text = leg.tell("info breakpoints")
    assert "hits % 2" in text and re.search(r"breakpoint +on +4 ", text)
    assert "is not a hit condition" in leg.refuses("hits 1 sometimes")
    assert "no breakpoint 7" in leg.refuses("ignore 7 1")


def test_commands_at_a_breakpoint__run_at_each_stop(leg):
    leg.tell("break (28)", "commands", "print t", "set t = 0.5", "print t", "end")
    text = leg.tell("run")
    assert "equation (28)" in text and "t = 0.25 " in text and "t = 0.5 " in text
    leg.tell("kill", "delete", "break (28)", "commands", "print t", "continue", "end", "break (30)")
    text = leg.tell("run")
    assert text.index("t = 0.25") < text.index("equation (30)")


def test_log_point__writes_and_does_not_stop(leg):
    assert "log point 1" in leg.tell('dprintf (28), "t is {t}, e is {e}" if t > 0')
    text = leg.tell("run")
    assert "t is 0.25, e is <e: not yet computed" in text and "end of tick 0" in text
    assert 'dprintf PLACE, "TEXT"' in leg.refuses("dprintf 17 text")


def test_until__stops_at_a_place_or_out_of_a_loop(loop):
    loop.tell("start")
    assert (
        "label again" in loop.tell("until again")
        or loop.session.position == (loop.session.program.image.labels["again"])
    )
    before = loop.session.position
    loop.tell(f"break *{before}", "continue", "delete")
    loop.tell("until")
    assert loop.session.position > before and not loop.session.breakpoints
    assert "no tick is running" in Debugger(LEG).refuses("until")


def test_condition__without_a_value_stops_and_says_why(leg):
    leg.tell("break (28) if e > 0")
    assert "the condition has no value: e: not yet computed" in leg.tell("run")
    assert "is not an expression" in leg.refuses("break 17 if e > 0 and")
    assert "no value 'missing'" in leg.refuses("break 17 if missing > 0")


def test_expression__of_a_name_without_a_value_says_that(leg):
    leg.tell("start")
    for line in ("print e + 1", "assert F > 0 and e > 0", "print table[1] + e"):
        assert re.search("[eF]: not yet computed", leg.refuses(line))
    assert "number outside of the function's range" in leg.refuses("print sqrt(0 - 1)")
    assert leg.tell("print table[3]").startswith("table[3] = 8 ")
    assert "table has 4 words, 0 to 3" in leg.refuses("print table[9]")
    assert "5 is after 2" in leg.refuses("disassemble 5 2")


@pytest.mark.parametrize("form", ["x", "t"])
def test_value__shown_in_a_form_reads_back(leg, form):
    shown = leg.tell(f"print/{form} x").partition(" = ")[2]
    leg.tell("set x = 7", f"set x = {shown}")
    assert leg.tell(f"print/{form} x").partition(" = ")[2] == shown
