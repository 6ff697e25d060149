# SPDX-License-Identifier: Apache-2.0
"""Runs the passes over a law and chooses among the programs they can make the one that the core
runs in the fewest cycles.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from asip_asm.dependence import build_graph as dependence_graph
from asip_asm.isa import default_isa
from asip_asm.machine import Machine, load_machine
from asip_asm.model.balance import balance
from asip_asm.model.emit import emit
from asip_asm.model.expand import expand_functions
from asip_asm.model.graph import Graph
from asip_asm.model.law import Law, build_graph, check_limits
from asip_asm.model.onnx_file import OnnxPolicy
from asip_asm.model.options import SINES, Compiled, Options
from asip_asm.model.places import EFFORT, beyond_bank, choose_places, operations
from asip_asm.model.read import ModelError
from asip_asm.model.simplify import share_divisors, simplify
from asip_asm.model.sine import angles, replace_sines
from asip_asm.model.sums import SumBuilder
from asip_asm.search import build_problem, length, lower_bound, search

HELD = 96
"""Constants outside bank K of which a comparison of sums assumes that registers hold them."""
RELAXATIONS = (0.04, 0.08, 0.12, 0.16, 0.2, 0.25, 0.5, 0.75, 1.0)
"""Shares of a sum's slack that it may use to save operations: finer where they are small, because
there the critical path still leaves the sine unit its time.
"""

DIVIDE = "divide the law into several functions"


def compile_law(
    law: Law, options: Options | None = None, machine: Machine | None = None
) -> Compiled:
    """Program of a law, for `machine` (None: that of the configuration). Raises ModelError."""
    options = options or Options()
    machine = machine or load_machine(options.configuration)
    check_limits(law, machine)
    if streamed(law, options):
        from asip_asm.model.network_program import compile_network

        return compile_network(law, options, machine)
    real = expand_functions(simplify(build_graph(law)))
    if options.reciprocal:
        real = simplify(share_divisors(real))
    _check_operations(real, law, machine, options)

    def loaded(form: Graph) -> frozenset[float]:
        outside = beyond_bank(form, law, options.constants)
        return frozenset(outside[HELD if options.registers else 0 :])

    def cycles(form: Graph) -> int:
        made = SumBuilder(form, machine, options.reassociate).run()
        return trial_cycles(made, machine, loaded(made))

    if options.sine == "balanced":
        real = balance(real, law, cycles)
    elif options.sine == "pipes":
        known = angles(real, law)
        real = min((replace_sines(real, known, way) for way in (False, True)), key=cycles)
    graph = choose_sums(real, machine, options, loaded)
    places = choose_places(graph, law, machine, options.constants, options.registers)
    return Compiled(law, options, graph, emit(graph, law, machine, places))


def streamed(law: Law, options: Options) -> bool:
    """Whether the law becomes a program of loops and streams: a network of dense layers."""
    if not default_isa().configurations[options.configuration].stream_words:
        return False
    if not isinstance(law.function, OnnxPolicy):
        return False
    from asip_asm.model.onnx_layers import dense_layers

    return not isinstance(dense_layers(law.function), str)


def without_idle(law: Law, options: Options) -> Options:
    """The options without those that change nothing of this law: a reciprocal without a divisor
    that is constant or used twice, a choice of sines without an angle of known range.
    """
    if streamed(law, options):
        return options
    real = expand_functions(simplify(build_graph(law)))
    if options.reciprocal and simplify(share_divisors(real)).nodes == real.nodes:
        options = replace(options, reciprocal=False)
    return options if angles(real, law) else replace(options, sine=SINES[0])


def _check_operations(real: Graph, law: Law, machine: Machine, options: Options) -> None:
    """Raises ModelError if the fewest operations of the law are more than the program memory takes
    on the slots that they need: before the program is searched for and written.
    """
    fewest = dict.fromkeys(range(len(real.nodes)), math.inf) if options.reassociate else None
    graph = SumBuilder(real, machine, options.reassociate, fewest).run()
    counts: Counter[tuple[int, ...]] = Counter(
        tuple(machine.slots_of(op)) for op in operations(graph)
    )
    beyond_bank(graph, law, options.constants)
    most = default_isa().program_bundles
    for slots, count in counts.items():
        bundles = -(-count // len(slots))
        if bundles > most:
            raise ModelError(
                f"{law.title}: its operations take {bundles} bundles or more ({count} for "
                f"{len(slots)} slots of a bundle), the core's program memory holds {most}; {DIVIDE}"
            )


def choose_sums(
    real: Graph,
    machine: Machine,
    options: Options,
    loaded: Callable[[Graph], frozenset[float]] = lambda _: frozenset(),
) -> Graph:
    """Core operations of the graph: the form with the shortest trial schedule, loads of the
    constants that `loaded` gives included, of forms as short
    with the fewest operations. With `reassociate` the forms are sums joined for the critical path
    and with more and more of their slack spent; where the slots decide, also those with the fewest
    operations and sums as the law writes them.
    """
    if not options.reassociate:
        return SumBuilder(real, machine, False).run()
    first = SumBuilder(real, machine, True)
    fastest = first.run()
    forms = [fastest]
    slack = _slack(fastest, machine)
    if min(slack.values(), default=0) > 0:  # slots, not the critical path, decide
        fewest = dict.fromkeys(range(len(real.nodes)), math.inf)
        forms += [SumBuilder(real, machine, True, fewest).run()]
        forms += [SumBuilder(real, machine, False).run()]
    for share in RELAXATIONS:
        deadlines = {
            old: first.time(new) + share * slack[new]
            for old, new in first.map.items()
            if new in slack
        }
        forms.append(SumBuilder(real, machine, True, deadlines).run())
    return min(
        forms,
        key=lambda form: (trial_cycles(form, machine, loaded(form)), len(operations(form))),
    )


def _slack(graph: Graph, machine: Machine) -> dict[int, int]:
    """Cycles by which each operation may be late without a longer program: than the critical path,
    or than the slots, the write port and the units allow if that is longer.
    """
    order = dependence_graph(operations(graph), machine)
    heads, tails = order.heads(), order.tails()
    longest = max(max(tails, default=0), lower_bound(build_problem(order, machine)))
    numbers = (number for number, _ in graph.operations())
    return {i: longest - h - t for i, h, t in zip(numbers, heads, tails, strict=True)}


def trial_cycles(graph: Graph, machine: Machine, loaded: frozenset[float] = frozenset()) -> int:
    """Cycles of a quick schedule of the operations and loads, without moves to outputs and
    states.
    """
    problem = build_problem(dependence_graph(operations(graph, loaded), machine), machine)
    return length(problem, search(problem, EFFORT))
