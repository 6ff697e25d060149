# SPDX-License-Identifier: Apache-2.0
"""The short proofs, their planted faults, and the netlist reader against SoftFloat."""

import itertools
import multiprocessing
import re
import time
from dataclasses import asdict

import pytest

from tests.bench.needs import require

require("bitwuzla", in_module=True)
require("yosys", in_module=True)

from bitwuzla import Bitwuzla  # noqa: E402
from rich.console import Console  # noqa: E402

from sim.core.fpbench import softfloat as reference  # noqa: E402
from sim.report import cache  # noqa: E402
from tests.bench.faults import Fault, TableError  # noqa: E402
from tests.formal import __main__ as command  # noqa: E402
from tests.formal import engine, logic, netlist  # noqa: E402
from tests.formal.__main__ import PAGE, main, page_text, summary, table  # noqa: E402
from tests.formal.catalogue import Case, Context, Proof, all_faults  # noqa: E402
from tests.formal.engine import BUILD, FAILED, PROVED, REFUTED, plant, run, solve  # noqa: E402
from tests.formal.netlist import ROOT, ElaborationError, Netlist, elaborate  # noqa: E402
from tests.formal.proofs import PROOFS  # noqa: E402
from tests.fpu import stimulus  # noqa: E402
from tests.fpu.tb import generator, package_constant  # noqa: E402

PYTEST = BUILD / "pytest"
QUICK = [proof for proof in PROOFS if proof.quick]
LONG = [proof for proof in PROOFS if not proof.quick]
FAULTS = [(proof, index) for proof in QUICK for index in range(len(proof.faults))]


@pytest.mark.parametrize("proof", QUICK, ids=lambda proof: proof.name)
def test_formal__short_proof__holds(proof: Proof) -> None:
    verdicts = list(run(proof, build=PYTEST))
    assert verdicts
    assert [v for v in verdicts if v.status != PROVED] == []


@pytest.mark.quick("i2f-0", "rounding-0", "angle_outside-0", "held_core-0", "trip*-0")
@pytest.mark.parametrize("proof, index", FAULTS, ids=lambda x: getattr(x, "name", str(x)))
def test_formal__planted_fault__is_refuted(proof: Proof, index: int) -> None:
    folder = PYTEST / f"{proof.name}{index}"
    copy = plant(proof.faults[index], folder)
    assert REFUTED in {verdict.status for verdict in run(proof, rtl=copy, build=folder)}


@pytest.mark.full
@pytest.mark.parametrize("proof", LONG, ids=lambda proof: proof.name)
def test_formal__long_proof__holds(proof: Proof) -> None:
    assert main(["--only", proof.name]) == 0


@pytest.mark.full
@pytest.mark.parametrize("proof", LONG, ids=lambda proof: proof.name)
def test_formal__long_proof__sees_its_faults(proof: Proof) -> None:
    assert main(["--only", proof.name, "--check-can-fail"]) == 0


def test_formal__false_claim_or_contradictory_assumptions__are_no_proof() -> None:
    x = logic.free(8, "x")
    wrong = solve(Case("wrong", logic.ult(x, 255), (), {"x": x}))
    assert (wrong.status, wrong.note) == (REFUTED, "x=ff")
    nothing = (logic.ult(x, 3), logic.eq(x, 7))
    empty = solve(Case("empty", logic.eq(x, 1), nothing))
    assert (empty.status, empty.note) == (FAILED, "the assumptions contradict each other")
    assert solve(Case("right", logic.ule(x, 255))).status == PROVED


def test_formal__every_proof__has_a_fault() -> None:
    assert [proof.name for proof in PROOFS if not proof.faults] == []
    assert len({proof.name for proof in PROOFS}) == len(PROOFS)
    named = {name for fault in all_faults() for name in fault.found}
    assert named == {proof.name for proof in PROOFS}


def test_formal__fault_that_no_longer_applies__is_refused() -> None:
    with pytest.raises(TableError, match="`right` stands 0 times in fp_lzc.sv"):
        plant(Fault(1, "fpu/fp_lzc.sv", "", "absent", "", ()), PYTEST / "absent")


def test_formal__unknown_proof__is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--only", "nothing"])
    assert stop.value.code == 2
    assert "no proof `nothing`; there are i2f," in capsys.readouterr().err


def test_formal__broken_source__is_an_elaboration_error() -> None:
    bad = PYTEST / "bad.sv"
    bad.parent.mkdir(parents=True, exist_ok=True)
    bad.write_text("module bad (input logic a_i; endmodule\n")
    with pytest.raises(ElaborationError, match="Yosys refused bad"):
        elaborate("bad", [bad], PYTEST)


def test_formal__case_in_time_only_in_a_process_of_its_own__is_proved(monkeypatch) -> None:
    def child(name, rtl, build, skip, link) -> None:
        for case in ("quick", "slow behind others", "slow")[skip:]:
            link.send((case, case))
            assert link.recv()
            if case == "slow" or (case == "slow behind others" and skip == 0):
                time.sleep(60)
            link.send(engine.Verdict(case, PROVED, 0.1))
        link.send(None)

    fork = multiprocessing.get_context("fork")
    monkeypatch.setattr(engine, "_child", child)
    monkeypatch.setattr(multiprocessing, "get_context", lambda method: fork)
    found = [(verdict.case, verdict.status) for verdict in run(QUICK[0], limit=0.5)]
    assert found == [("quick", PROVED), ("slow behind others", PROVED), ("slow", engine.TIMEOUT)]


def test_formal__verdict_of_an_earlier_run__is_not_asked_for_again(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(command, "VERDICTS", tmp_path / "verdicts")
    monkeypatch.setattr(command, "REPORT", tmp_path / "report.json")
    proof = QUICK[0]
    solved = []
    for _ in range(2):
        console = Console(record=True, quiet=False, file=(tmp_path / "output").open("w"))
        assert command.prove(proof, console, None, False)
        solved.append(console.export_text().count(": proved, "))
    cases = command.load()["proofs"][proof.name]["cases"]
    assert solved == [len(cases), 0] and cases


@pytest.mark.parametrize(
    ("status", "seconds", "again", "counts"),
    [
        (PROVED, 1.0, True, True),
        (REFUTED, 1.0, False, True),
        (REFUTED, 1.0, True, False),
        (engine.TIMEOUT, 10.0, False, True),
        (engine.TIMEOUT, 9.0, False, False),  # a limit of 10 s may decide it
    ],
)
def test_formal__cached_verdict__counts_if_a_run_would_find_the_same(
    status, seconds, again, counts, monkeypatch, tmp_path
) -> None:
    monkeypatch.setattr(command, "VERDICTS", tmp_path)
    verdict = engine.Verdict("case", status, seconds, "digest")
    cache.save(command.entry_of("digest"), asdict(verdict))
    found = command.earlier_verdict("digest", 10.0, again)
    assert found == (verdict if counts else None)
    assert command.earlier_verdict("other", 10.0, again) is None


def test_formal__memory_in_the_netlist__is_refused() -> None:
    with pytest.raises(ElaborationError, match="sort array"):
        Netlist("1 sort bitvec 1\n2 sort array 1 1\n")


def signed(word: int) -> int:
    return word - 8 if word > 3 else word


# Of words of three bits, by BTOR2's definitions: bits of the result, and what it is, modulo those.
OPERATORS = {
    "and": (3, lambda a, b: a & b),
    "or": (3, lambda a, b: a | b),
    "xor": (3, lambda a, b: a ^ b),
    "nand": (3, lambda a, b: ~(a & b)),
    "nor": (3, lambda a, b: ~(a | b)),
    "xnor": (3, lambda a, b: ~(a ^ b)),
    "add": (3, lambda a, b: a + b),
    "sub": (3, lambda a, b: a - b),
    "mul": (3, lambda a, b: a * b),
    "sll": (3, lambda a, b: a << b),
    "srl": (3, lambda a, b: a >> b),
    "sra": (3, lambda a, b: signed(a) >> b),
    "concat": (6, lambda a, b: 8 * a + b),
    "not": (3, lambda a: ~a),
    "neg": (3, lambda a: -a),
    "redand": (1, lambda a: a == 7),
    "redor": (1, lambda a: a != 0),
    "redxor": (1, lambda a: a.bit_count()),
    "eq": (1, lambda a, b: a == b),
    "neq": (1, lambda a, b: a != b),
    "ult": (1, lambda a, b: a < b),
    "ulte": (1, lambda a, b: a <= b),
    "ugt": (1, lambda a, b: a > b),
    "ugte": (1, lambda a, b: a >= b),
    "slt": (1, lambda a, b: signed(a) < signed(b)),
    "slte": (1, lambda a, b: signed(a) <= signed(b)),
    "sgt": (1, lambda a, b: signed(a) > signed(b)),
    "sgte": (1, lambda a, b: signed(a) >= signed(b)),
}


def test_formal__every_operator_of_a_netlist__means_what_btor2_says() -> None:
    assert set(OPERATORS) == set(netlist.BINARY) | set(netlist.UNARY) | set(netlist.COMPARE)
    for name, (width, meaning) in OPERATORS.items():
        ports = ("4", "5")[: meaning.__code__.co_argcount]
        text = "1 sort bitvec 1\n3 sort bitvec 3\n6 sort bitvec 6\n4 input 3 a\n5 input 3 b\n"
        text += f"7 {name} {width} {' '.join(ports)}\n8 output 7 y\n"
        symbolic = netlist.Run(Netlist(text))
        term, inputs = symbolic.output("y", 0), [symbolic.input(port) for port in "ab"]
        for words in itertools.product(range(8), repeat=2):
            fixed = {port: logic.bv(3, word) for port, word in zip(inputs, words, strict=True)}
            got = Bitwuzla(logic.TERMS).simplify_term(logic.TERMS.substitute_term(term, fixed))
            want = int(meaning(*words[: len(ports)])) % 2**width
            assert int(got.value(2), 2) == want, f"{name} {words}"


def test_formal__terms_with_constant_operands__give_softfloat_results() -> None:
    """The reader of netlists, apart from the proofs: random sums through the terms of fp_add."""
    run_ = Context(ROOT / "rtl", PYTEST).run("fp_add")
    latency, terms = package_constant("FP_ADD_LATENCY"), logic.TERMS
    rng = generator("formal netlist")
    a, b = stimulus.thinned(stimulus.add_pairs(rng, 2000), rng, 40).T
    want, want_flags = reference.add(a, b)
    ports = {name: run_.input(name) for name in ("a_i", "b_i", "sub_i")}
    outputs = [run_.output(name, latency) for name in ("result_o", "flags_o")]
    for row in range(len(a)):
        values = dict(zip(ports, (int(a[row]), int(b[row]), 0), strict=True))
        fixed = {t: logic.bv(logic.width(t), values[n]) for n, t in ports.items()}
        solver = Bitwuzla(terms)
        got = [
            int(solver.simplify_term(terms.substitute_term(term, fixed)).value(2), 2)
            for term in outputs
        ]
        assert got == [int(want[row]), int(want_flags[row])], f"{values}"


def test_formal__report__becomes_the_table() -> None:
    name = PROOFS[0].name
    case = {"case": "c", "status": PROVED, "seconds": 2.0, "digest": "d", "note": ""}
    refuted = {**case, "status": REFUTED}
    assert summary(None)["status"] == "not run"
    assert summary({"cases": [case], "complete": True})["status"] == PROVED
    assert summary({"cases": [case], "complete": False})["status"] == "not finished"
    assert summary({"cases": [case, refuted], "complete": True})["status"] == REFUTED
    report = {"proofs": {name: {"cases": [case, case], "complete": True}}, "faults": {}}
    row = next(line for line in table(report).splitlines() if line.endswith(f" {name}` |"))
    assert "| proved | 2 of 2 | 4 s | 0 of" in row


def test_formal__page__lists_every_proof() -> None:
    text = PAGE.read_text()
    rows = re.findall(r"tests\.formal --only (\w+)` \|$", text, re.M)
    assert rows == [proof.name for proof in PROOFS], "run `python -m tests.formal --docs`"
    nothing: dict = {"proofs": {}, "faults": {}}
    assert page_text(nothing) == text, "what a report lacks keeps its row"
    assert table(nothing) not in text
