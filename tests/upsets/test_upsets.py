# SPDX-License-Identifier: Apache-2.0
"""The campaign of upsets: what it samples, what it finds, that a case can be run again."""

from __future__ import annotations

import numpy as np
import pytest

from sim.rtl.asip_bus import FAULT_NAMES
from tests.bench.needs import needs
from tests.silicon.netlist import make_netlist, place_of
from tests.upsets import area, campaign, report
from tests.upsets.__main__ import main
from tests.upsets.model import EFFECTS, TICKS, Model, Site, parameters_of
from tests.upsets.plan import KINDS, SHARD, block_of, draw, line_of, places, upset_of


@pytest.fixture(scope="module")
def plain() -> Model:
    return campaign.model_of("plain")


KNOWN = {"masked", "corrected", "latent", "fault reported"}  # nothing wrong, or it is reported


def effect(model: Model, line: str) -> str:
    (outcome,) = model.inject(upset_of(model.sites, line))
    return EFFECTS[outcome["effect"]]


def test_wilson__shares_of_the_literature__same_intervals():
    # R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 3
    for hits, n, want in (
        (81, 263, (0.2553, 0.3662)),
        (15, 148, (0.0624, 0.1605)),
        (0, 20, (0, 0.1611)),
    ):
        assert report.wilson(hits, n) == pytest.approx(want, abs=1e-4)


def test_sites__registers_of_the_core__wires_of_stage_q_are_none(plain):
    names = {site.name.removeprefix("TOP.asip.") for site in plain.sites}
    assert {
        "u_run.u_control.state_q",
        "u_fetch.pc_q",
        "u_host.watchdog_q",
        "u_fetch.gen_lane[3].u_ram.memory",
    } <= names
    assert not {"decoded_q", "ops_q", "valid_q"} & names
    assert block_of("TOP.asip.u_run.u_control.state_q") == "control"


def test_draw__every_kind__places_in_use_only_and_the_same_again(plain):
    for kind in KINDS:
        upsets = draw(plain, kind, 3)
        assert np.array_equal(upsets, draw(plain, kind, 3))
        allowed = {site: set(elements) for site, elements in places(plain, kind)}
        assert all(upset["element"] in allowed[upset["site"]] for upset in upsets)
        again = np.concatenate([upset_of(plain.sites, line_of(plain.sites, u)) for u in upsets])
        assert np.array_equal(upsets, again)


def test_inject__plain_core__the_known_effects(plain):
    issue = "TOP.asip.u_issue.gen_multiple.u_issue"
    assert effect(plain, f"4 157 {issue}.u_scoreboard_c.pending_q.30") == "locked up"
    assert effect(plain, "9 100 TOP.asip.u_run.u_control.state_q.1") in ("run lost", "locked up")
    assert effect(plain, "9 100 TOP.asip.u_host.readdata_q.3") == "masked"
    assert effect(plain, f"9 0 {bank_copy('a', 0)}[255].31") == "latent"


def test_inject__same_shard_twice__same_outcomes(plain):
    upsets = draw(plain, KINDS[0], 0)[:60]
    assert np.array_equal(plain.inject(upsets), plain.inject(upsets))


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("4 157", "is not TICK CLOCK NAME.BIT"),
        ("4 157 TOP.asip.no_q.0", "no register or memory TOP.asip.no_q"),
        (f"{TICKS} 1 TOP.asip.u_run.u_control.state_q.0", "beyond the"),
    ],
)
def test_replay__line_that_is_none__error_says_why(capsys, line, text):
    assert main(["--replay", line]) == 2
    assert text in " ".join(capsys.readouterr().err.split())


def test_area__a_unit_used_twice__counts_twice():
    cells = {
        "\\asip": {"LUT4": 5, "fp_fma": 2, "TRELLIS_FF": 9},
        "\\fp_fma": {"LUT4": 3, "CCU2C": 1},
    }
    modules = {name: {"num_cells_by_type": found} for name, found in cells.items()}
    assert area.luts_of("\\asip", modules, {"LUT4": 1, "CCU2C": 2}) == 5 + 2 * (3 + 2)


def test_area__orders__hold_the_same_cells_in_places_of_their_own():
    module = {"cells": dict.fromkeys("abcdefgh", 1), "netnames": {"n": 0}}
    netlist = {"creator": "", "modules": {"asip": module, "fp_fma": module}}
    one, other = (area.in_order(netlist, order)["modules"] for order in area.ORDERS[:2])
    assert one == other == netlist["modules"]  # as dictionaries, without an order
    assert list(one["asip"]["cells"]) != list(other["asip"]["cells"])
    assert list(one["fp_fma"]["cells"]) == list(module["cells"])


def bank_copy(bank: str, copy: int) -> str:
    """Name of the memory of a bank for one of its read ports."""
    operands = "TOP.asip.u_operands.gen_multiple.u_operands"
    return f"{operands}.u_bank_{bank}.gen_copy[{copy}].u_ram.memory"


def one_wrong(kind: str) -> dict:
    """Counts of a core with one injection of that effect among 499 that are masked."""
    counts = {"control": dict.fromkeys(EFFECTS, 0) | {kind: 1, "masked": 499}}
    case = {"replay": "", "effect": kind, "error": 0.5}
    return report.gather([{"counts": counts, "injections": 500, "unsafe": 1, "cases": [case]}])


def test_goals__a_wrong_output__are_not_met():
    rows = report.goals(one_wrong("wrong once"), "core 'plain'", report.LEAST)
    assert [row.met for row in rows] == [False, False, True, False, None]


@pytest.mark.parametrize(
    ("cell", "scope", "block"),
    [
        ("u_run.u_control.state_q_TRELLIS_FF_Q_1", "u_run u_control", "control"),
        ("gen_decode[0].u_decode.word_i_TRELLIS_FF_Q_39", "u_fetch", "fetch"),
        ("u_issue.stall_i_TRELLIS_FF_Q", "u_units u_aux u_f2i", "other auxiliary units"),
        ("u_host.data_i_TRELLIS_FF_Q", "", "stages R1 to E2"),
    ],
)
def test_block__flip_flop_of_a_netlist__is_that_of_its_source_not_of_its_name(cell, scope, block):
    attributes = {"always_ff": "1"} | ({"scopename": scope} if scope else {})
    assert block_of(f"TOP.asip.{place_of(cell, attributes)}") == block


def test_block__flip_flop_that_yosys_made_of_a_memory__is_that_of_its_name():
    cell = "u_fetch.gen_lane[0].u_ram.memory.0.1_DOB14_TRELLIS_FF_Q"
    assert block_of(f"TOP.asip.{place_of(cell, {})}") == "fetch"


def test_replay__line_of_a_netlist__is_the_same_upset():
    names = ("memory.0.1_DOB14_TRELLIS_FF_Q_1.Q", "gen_decode[0].u_decode.word_i_TRELLIS_FF_Q.Q")
    sites = [Site(f"TOP.asip.{name}", 1, 1, "") for name in names]
    for number, site in enumerate(sites):
        (upset,) = upset_of(sites, f"4 157 {site.name}.0")
        assert upset["site"] == number
        assert line_of(sites, upset) == f"4 157 {site.name}.0"


def test_tasks__of_the_netlist__are_flip_flops_at_full_depth_alone(monkeypatch):
    monkeypatch.setattr(campaign, "fingerprint_of", lambda core: "fingerprint")
    tasks = list(campaign.tasks_of(campaign.NETLIST, "full"))
    assert {task.kind for task in tasks} == {"flip-flops"}
    assert len(tasks) * SHARD >= report.LEAST_NETLIST
    assert len({task.path for task in tasks}) == len(tasks)
    assert campaign.NETLIST not in campaign.SHARDS["quick"]


def test_netlist_goals__a_wrong_output_or_no_run__are_not_met():
    rows = report.goals(one_wrong("wrong later"), "netlist", report.LEAST_NETLIST)
    assert [row.met for row in rows] == [False, False, True, False, None]
    assert [row.met for row in report.goals(None, "netlist", report.LEAST_NETLIST)] == [None]


@pytest.fixture(scope="module")
def resilient() -> Model:
    return campaign.model_of("resilient")


@pytest.mark.full
def test_resilient__where_the_plain_core_locks_up__goes_on(resilient):
    issue = "TOP.asip.u_issue.gen_multiple.u_issue"
    control = "TOP.asip.u_run.u_control"
    for place in (f"{issue}.u_scoreboard_c.pending_q.30", f"{issue}.sin_busy_q.0"):
        # latent: FAULT_INFO of the run that was stopped and repeated
        assert effect(resilient, f"4 157 {place}") in ("corrected", "masked", "latent")
    for clock in range(60, 300, 11):
        for place in ("state_q.0", "state_q.1", "start_q.0", "fault_q.0", "done_q.0"):
            found = effect(resilient, f"9 {clock} {control}.{place}")
            assert found in KNOWN, (clock, place)


@pytest.mark.full
def test_resilient__every_bit_of_its_own_control__no_lock_up_nothing_silent(resilient):
    own = "TOP.asip.u_run.gen_redundancy.u_redundancy"
    for clock in range(5, 400, 23):
        for register in ("control_q", "inverse_q"):
            for bit in range(16):
                found = effect(resilient, f"20 {clock} {own}.{register}.{bit}")
                assert found in KNOWN, (clock, register, bit, found)


def test_resilient__a_bit_of_the_program__is_the_fault_memory(resilient):
    (outcome,) = resilient.inject(
        upset_of(resilient.sites, "7 0 TOP.asip.u_fetch.gen_lane[1].u_ram.memory[40].9")
    )
    assert EFFECTS[outcome["effect"]] == "fault reported" and outcome["ticks"] == 0
    assert FAULT_NAMES[int(outcome["cause"])] == "MEMORY"


def test_resilient__an_output_on_its_way_to_the_host__is_no_silent_error(resilient):
    places = ("u_host.count_q.20", "u_host.group_q.20", "u_host.readdata_q.7")
    for place in (*places, "u_outputs.host_read_q.16", "u_outputs.u_host.read_q.3"):
        found = [effect(resilient, f"38 {clock} TOP.asip.{place}") for clock in range(272, 306)]
        assert set(found) <= KNOWN, (place, found)
        assert "fault reported" in found, place


def test_resilient__state_register_flipped_between_ticks__is_corrected(resilient):
    state = next(s for s in resilient.image.states if s.name == "integral1")
    bank, index = state.register[0], int(state.register[1:])
    found = {effect(resilient, f"12 2 {bank_copy(bank, p)}[{index}].22") for p in range(9)}
    assert "corrected" in found and found <= {"corrected", "masked"}


def test_cost__of_redundancy__within_the_target(plain, resilient):
    assert plain.cycles < resilient.cycles <= 2.1 * plain.cycles


def test_resilient__registers_of_the_record__a_false_verdict_is_repaired(resilient):
    own = "TOP.asip.gen_plausible.u_plausible"
    found = {
        (place, effect(resilient, f"20 {clock} {own}.{place}"))
        for clock in range(20, 300, 14)
        for place in (
            "implausible_q.0",
            "step_q.3",
            "on_q.1",
            "written_q.0",
            "turn_q.0",
            "shown_q.0",
        )
    }
    assert {effect for _, effect in found} <= KNOWN
    assert ("implausible_q.0", "corrected") in found
    assert ("implausible_q.0", "fault reported") not in found


@pytest.fixture(scope="module")
def netlist() -> Model:
    return campaign.model_of(campaign.NETLIST)


@pytest.mark.full
@needs("yosys")
def test_netlist__reference_run__has_the_clocks_of_the_rtl(netlist, resilient):
    assert netlist.cycles == resilient.cycles
    assert np.array_equal(netlist.lengths, resilient.lengths)


@pytest.mark.full
@needs("yosys")
def test_netlist__flip_flops__are_those_of_every_block_and_nothing_else(netlist, resilient):
    def blocks(model: Model) -> set[str]:
        return {block_of(model.sites[site].place) for site, _ in places(model, KINDS[0])}

    flip_flops = [netlist.sites[site] for site, _ in places(netlist, KINDS[0])]
    assert len(flip_flops) > 7000 and {site.bits for site in flip_flops} == {1}
    assert {site.name for site in flip_flops} <= set(netlist.places)
    assert blocks(netlist) == blocks(resilient)


@pytest.mark.full
@needs("yosys")
def test_netlist__flip_flops_that_yosys_added__are_the_read_words_of_the_counters():
    # Around block RAM it would add registers of what is written: one flipped, a wrong word of the
    # program has the right parity.
    added = make_netlist("asip", parameters_of(resilient=True)).added
    assert {cell.split("_TRELLIS_FF")[0] for cell in added} == {
        "u_run.u_control.u_counts.read_data_o"
    }


@pytest.mark.full
@needs("yosys")
def test_netlist__upsets_of_redundancy_and_control__nothing_wrong_is_silent(netlist):
    flip_flops = [netlist.sites[site] for site, _ in places(netlist, KINDS[0])]
    names = [s.name for s in flip_flops if block_of(s.place) in ("redundancy", "control")]
    for number, name in enumerate(names):
        found = effect(netlist, f"20 {5 + 37 * number % 380} {name}.0")
        assert found in KNOWN, (name, found)
