# SPDX-License-Identifier: Apache-2.0
"""Runs proofs case by case in a process of its own, with limits on time and memory.

A case is known by the hash of its formula and of the solver's version: if neither the RTL nor the
specification nor the solver changed what has to be proved, the earlier verdict holds.
"""

from __future__ import annotations

import multiprocessing
import resource
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

import bitwuzla

from sim.report.cache import fingerprint
from tests.bench.faults import Fault, copy
from tests.formal import logic
from tests.formal.catalogue import Case, Context, Proof
from tests.formal.netlist import ROOT, ElaborationError
from tests.formal.proofs import PROOFS

BUILD = ROOT / "build/formal"
MEMORY = 6 << 30  # bytes of address space of a solver process
ELABORATION_LIMIT = 300  # seconds for Yosys and for building the terms of a case
PROVED, REFUTED, TIMEOUT, FAILED = "proved", "refuted", "timeout", "failed"


@dataclass(frozen=True)
class Verdict:
    """Outcome of one case: CPU seconds of the solver; `note` is a counterexample or an error."""

    case: str
    status: str
    seconds: float
    digest: str = ""
    note: str = ""


def digest_of(case: Case) -> str:
    """Hash of what is asked and of who is asked."""
    return fingerprint([], bitwuzla.version(), *map(str, case.assume), str(case.claim))


def solve(case: Case) -> Verdict:
    """Ask the solver for values that meet the assumptions and break the claim."""
    options = bitwuzla.Options()
    options.set(bitwuzla.Option.PRODUCE_MODELS, True)
    start = time.process_time()
    if case.assume:  # what contradictory assumptions imply would count for nothing
        solver = bitwuzla.Bitwuzla(logic.TERMS, options)
        for term in case.assume:
            solver.assert_formula(term)
        if solver.check_sat() != bitwuzla.Result.SAT:
            return Verdict(case.name, FAILED, 0.0, note="the assumptions contradict each other")
    solver = bitwuzla.Bitwuzla(logic.TERMS, options)
    for term in (*case.assume, logic.no(case.claim)):
        solver.assert_formula(term)
    # Only the solver: WebAssembly reserves more addresses than that.
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))
    result = solver.check_sat()
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    seconds = time.process_time() - start
    if result == bitwuzla.Result.UNSAT:
        return Verdict(case.name, PROVED, seconds)
    if result == bitwuzla.Result.SAT:
        shown = {name: solver.get_value(term) for name, term in case.show.items()}
        values = {name: f"{int(value.value(2), 2):x}" for name, value in shown.items()}
        note = " ".join(f"{name}={value}" for name, value in values.items())
        return Verdict(case.name, REFUTED, seconds, note=note)
    return Verdict(case.name, FAILED, seconds, note="the solver gave no answer")


def _child(name: str, rtl: Path, build: Path, skip: int, link: Connection) -> None:
    """Send (name, digest) of every case after the first `skip`, then its verdict where asked."""
    proof = next(p for p in PROOFS if p.name == name)
    try:
        context = Context(rtl, build)
        for index, case in enumerate(proof.cases(context)):
            if index < skip:
                continue
            link.send((case.name, digest_of(case)))
            if link.recv():
                link.send(solve(case))
        link.send(None)
    except (ElaborationError, FileNotFoundError, MemoryError, bitwuzla.BitwuzlaException) as error:
        link.send(("elaboration", ""))
        if link.recv():
            text = str(error) or type(error).__name__
            link.send(Verdict("elaboration", FAILED, 0.0, note=text))
        link.send(None)


def run(
    proof: Proof,
    rtl: Path = ROOT / "rtl",
    build: Path = BUILD / "netlists",
    known: Callable[[str], Verdict | None] = lambda digest: None,
    limit: float | None = None,
) -> Iterator[Verdict]:
    """Verdicts of a proof's cases in order. `known` finds an earlier verdict by its digest.

    A case that exceeds `limit` seconds (default: the proof's own) is tried again in a process that
    has solved no other: the solver may take another way there. If not, it is a timeout.
    """
    limit = limit or proof.timeout
    method = multiprocessing.get_context("forkserver")  # modules are imported once, not a process
    method.set_forkserver_preload([__name__])
    done = 0
    while True:
        here, there = method.Pipe()
        arguments = (proof.name, rtl, build, done, there)
        child = method.Process(target=_child, args=arguments, daemon=True)
        child.start()
        there.close()
        try:
            restart = solved = False
            while not restart:
                message = _receive(here, ELABORATION_LIMIT)
                if message is None:
                    return
                if isinstance(message, str):
                    yield Verdict("elaboration", FAILED, 0.0, note=message)
                    return
                case, digest = message
                done += 1
                earlier = known(digest)
                here.send(earlier is None)
                if earlier is not None:
                    yield replace(earlier, case=case)
                    continue
                answer = _receive(here, limit)
                restart = isinstance(answer, str)
                if restart and solved:
                    done -= 1
                elif restart:
                    status = TIMEOUT if answer == "timeout" else FAILED
                    yield Verdict(case, status, limit, digest, answer)
                else:
                    solved = True
                    yield replace(answer, digest=digest)
        finally:
            child.kill()
            child.join()
            here.close()


def _receive(link: Connection, seconds: float) -> tuple | Verdict | str | None:
    """Next message, or a word on why there is none."""
    if not link.poll(seconds):
        return "timeout"
    try:
        return link.recv()
    except EOFError:
        return "the solver process ended (out of memory?)"


def plant(fault: Fault, folder: Path) -> Path:
    """Copy of rtl/ below `folder` with the fault in it; returns the copy. Raises TableError."""
    shutil.rmtree(folder, ignore_errors=True)
    return copy(folder / "rtl", [fault])
