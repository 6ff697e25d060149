# SPDX-License-Identifier: Apache-2.0
"""Laws of streams and loops: predictive control and a policy, rows of `make goals T=matrix`."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import onnx
from onnx import helper, numpy_helper

from asip_asm.disassemble import decode_bundle
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.loops import loops_of
from asip_asm.model.bound import bounds
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.law import Law, Port
from asip_asm.model.mpc_problem import Problem
from asip_asm.model.onnx_file import OnnxPolicy, load_onnx
from asip_asm.model.onnx_layers import Network, dense_layers
from asip_asm.model.plan_items import PIPES
from asip_asm.model.program import build
from asip_asm.pace import Pace
from sim.core.api import Core
from sim.laws.mpc import build_mpc
from sim.laws.mpc_flight import fly_core, fly_reference, quadrotor_problem
from sim.laws.mpc_proof import prove_mpc
from sim.laws.mpc_reference import distance
from sim.laws.prove_program import rounded_sine
from sim.laws.rocket_landing import land_core, land_reference, rocket_problem
from sim.report.goals import Goal, at_least, at_most, depth, exactly

SEED = 38
COUNT, QUICK = 10_000, {"ticks": 40, "inputs": 40}
MOST = {"stream": 27_500, "wide": 12_500}
"""Cycles of a solve: 220 us and 100 us at 125 MHz."""
LANDING = {"stream": 12_500, "wide": 13_500}
"""Cycles of a solve of the landing: its loops wait for roots and quotients in turn, which lanes do
not shorten.
"""
SHARE = 80.0  # per cent of the multiply-add slots
BATCH = 500
SECONDS = 60.0  # of one processor
RATIO = 1.05
POLICIES: dict[tuple[str, tuple[int, ...]], int | None] = {
    ("stream", (48, 64, 64, 12)): None,
    ("wide", (48, 64, 64, 12)): 1_500,
    ("wide", (48, 256, 128, 12)): 7_500,
}
"""Most cycles of a policy with Elu, by configuration and sizes; without a number it is bound by its
share of the multiply-add slots.
"""
CURE = "make goals T=matrix RUN=full"


def predictive_control(full: bool) -> Iterator[Goal]:
    """Quadrotor: 12 states, 4 inputs, 10 steps, boxes on all, 10 iterations."""
    name, problem = "quadrotor MPC 12/4/10", quadrotor_problem()
    images: dict[str, Image] = {}
    yield from _programs(name, problem, MOST, full, images, "N")
    yield from _distance(name, problem)
    flight, cycles = fly_core(problem, images["stream"])
    double = fly_reference(problem)
    ratio = flight.error / double.error
    yield at_most(f"{name}, flight: tracking error relative to double precision", ratio, RATIO, "1",
                  f"{1000 * double.error:.1f} mm, figure eight with a gust")  # fmt: skip
    yield at_most(f"{name}, flight: violation of the box of y", 1000 * flight.beyond, 16, "mm")
    yield exactly(f"{name}, flight: different cycle counts of a tick", len(cycles), 1, "1")


def landing(full: bool) -> Iterator[Goal]:
    """Rocket: 6 states, 3 inputs in a thrust cone, 10 steps, 12 iterations."""
    name, problem = "rocket MPC 6/3/10", rocket_problem()
    images: dict[str, Image] = {}
    yield from _programs(name, problem, LANDING, full, images, "m/s^2")
    yield from _distance(name, problem)
    double = land_reference(problem)
    for configuration, image in images.items():
        where = f"{name} on {configuration}, landing"
        found, cycles = land_core(problem, image)
        note = f"after {found.time:.1f} s, in wind; {100 * found.held:.0f} % of ticks at the cone"
        yield at_most(f"{where}: distance from the pad's centre", found.miss, 0.25, "m", note)
        yield at_most(f"{where}: sink rate", found.sink, 0.6, "m/s")
        yield at_most(f"{where}: horizontal speed", found.drift, 0.15, "m/s")
        yield at_most(f"{where}: violation of the thrust cone", found.cone, 1e-6, "of its radius")
        apart = float(np.abs(found.states - double.states).max())
        yield at_most(
            f"{where}: deviation from the landing in double precision", 1e6 * apart, 100, "um, um/s"
        )
        yield exactly(f"{where}: different cycle counts of a tick", len(cycles), 1, "1")


def _programs(
    name: str, problem: Problem, most: dict[str, int], full: bool, images: dict[str, Image],
    unit: str,
) -> Iterator[Goal]:  # fmt: skip
    """Cycles and proof of the programs of a problem, whose images go to `images`."""
    for configuration, cycles in most.items():
        where = f"{name} on {configuration}"
        begin = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            built, plan = build_mpc(problem, Path(folder) / "law.s", configuration)
        seconds = time.process_time() - begin
        images[configuration] = built.image
        words = [len(words) // plan.step_words for words in plan.streams.values()]
        memories = (
            f"{len(built.image.bundles)} bundles, {len(built.image.data)} data words, "
            f"{words[0]} and {words[1]} words of the streams"
        )
        yield at_most(f"{where}, tick", built.cycles, cycles, "cycles", memories)
        yield at_most(f"{where}, compile time", seconds, SECONDS, "s of a processor")
        proof = prove_mpc(problem, built.compiled, built.image, COUNT if full else QUICK["ticks"])
        other = "runs with a cycle count other than announced"
        yield exactly(f"{where}, {other}", proof.other_cycles, 0, "")
        unequal = bool(proof.difference)
        yield exactly(f"{where}, words that differ from the interpreter", unequal, 0, "1")
        note = f"{proof.error:.2g} {unit}"
        yield at_most(f"{where}, error as a fraction of its bound", proof.share, 1, "1", note)
        yield depth(f"{where}, ticks tried", proof.ticks, COUNT, "1", CURE)


def _distance(name: str, problem: Problem) -> Iterator[Goal]:
    """Distance of the plans from the optimum of a solver that others wrote."""
    far = distance(problem, COUNT)
    high = 100 * np.quantile(far.excess, 0.99)
    note = f"{far.solver}, {COUNT} initial states, 99 %: {high:.2g} %"
    yield exactly(f"{name}, initial states without a feasible plan", far.infeasible, 0, "1")
    median = 100 * float(np.median(far.excess))
    yield at_most(f"{name}, cost above the optimum, median", median, 1, "%", note)
    worst = 100 * float(far.violation.max())
    yield at_most(f"{name}, largest violation of a state's box", worst, 1, "% of the box")


def policies(full: bool) -> Iterator[Goal]:
    """Policies with Elu and drawn weights: cycles, use of the pipes, bits, error."""
    for (configuration, sizes), most in POLICIES.items():
        yield from _policy(configuration, sizes, most, full)


def _policy(
    configuration: str, sizes: tuple[int, ...], most: int | None, full: bool
) -> Iterator[Goal]:
    name = f"policy {'-'.join(map(str, sizes))} Elu on {configuration}"
    begin = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        policy = drawn_policy(sizes, Path(folder))
        law = policy_law(policy, sizes)
        built = build(
            compile_law(law, Options(configuration=configuration)), Path(folder) / "policy.s"
        )
    seconds = time.process_time() - begin
    network = dense_layers(policy)
    assert isinstance(network, Network)
    lanes = len(PIPES) * (1 + default_isa().configurations[configuration].lanes)
    share = 100 * network.products / (lanes * built.cycles)
    note = f"{share:.1f} % of all multiply-adds of the run"
    if most is None:
        note = f"{built.cycles} cycles"
        yield at_least(f"{name}, multiply-add slots in products", share, SHARE, "%", note)
    else:
        yield at_most(f"{name}, tick", built.cycles, most, "cycles", note)
        used = 100 * network.products / (lanes * product_cycles(built.image))
        yield at_least(f"{name}, lane cycles used within the products", used, SHARE, "%")
    yield at_most(f"{name}, compile time", seconds, SECONDS, "s of a processor")
    count = COUNT if full else QUICK["inputs"]
    random = np.random.default_rng(SEED)
    graph, outputs = built.compiled.graph, [port.name for port in law.of_kind("output")]
    unequal = other = 0
    worst, pace = 0.0, Pace(f"{name}: inputs", count)
    with Core(built.image) as core:
        for begin_at in range(0, count, BATCH):
            pace.at(begin_at)
            size = min(BATCH, count - begin_at)
            x = random.uniform(-3, 3, (size, sizes[0])).astype(np.float32)
            values = {f"obs{k}": x[:, k] for k in range(sizes[0])}
            ticks = core.batch(values)
            nodes = evaluate(graph, values, rounded_sine)
            _, limit = bounds(graph, {name: v.astype(float) for name, v in values.items()})
            want = truth(policy, x)
            other += int(np.sum(ticks.cycles != built.image.cycles))
            for k, output in enumerate(outputs):
                bits = nodes[graph.outputs[output]].view(np.uint32)
                unequal += int((ticks[output].view(np.uint32) != bits).sum())
                worst = max(
                    worst, float((np.abs(ticks[output] - want[:, k]) / limit[output]).max())
                )
    yield exactly(f"{name}, words that differ from the interpreter", unequal, 0, "")
    yield exactly(f"{name}, runs with a cycle count other than announced", other, 0, "")
    yield at_most(f"{name}, error as a fraction of its bound", worst, 1, "1")
    yield depth(f"{name}, inputs tried", count, COUNT, "1", CURE)


def product_cycles(image: Image) -> int:
    """Cycles of a run that products of a matrix need: bundles with one, and cycles without any."""
    isa = default_isa()
    bundles = [decode_bundle(int(text, 16), image.configuration, isa) for text in image.bundles]
    times = [1] * len(bundles)
    for loop in loops_of(bundles):
        for i in range(loop.first, loop.last + 1):
            times[i] *= loop.rounds
    products = (
        n for n, bundle in zip(times, bundles, strict=True)
        if any(op.mnemonic == "vfmadd" for op in bundle.operations)
    )  # fmt: skip
    return sum(products) + (image.cycles or 0) - sum(times)


def drawn_policy(sizes: tuple[int, ...], folder: Path) -> OnnxPolicy:
    """A policy of dense layers with Elu between them, from a file in the folder."""
    random = np.random.default_rng(SEED)
    nodes, tensors, now = [], [], "obs"
    for k, (n, m) in enumerate(zip(sizes, sizes[1:], strict=False)):
        last = k == len(sizes) - 2
        weights, bias = random.normal(size=(m, n)) / np.sqrt(n), 0.1 * random.normal(size=m)
        for name, array in ((f"w{k}", weights), (f"b{k}", bias)):
            tensors.append(numpy_helper.from_array(array.astype(np.float32), name))
        made = "act" if last else f"sum{k}"
        nodes.append(helper.make_node("Gemm", [now, f"w{k}", f"b{k}"], [made], transB=1))
        if not last:
            now = f"hidden{k}"
            nodes.append(helper.make_node("Elu", [made], [now]))
    ends = [
        [helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, [1, size])]
        for name, size in (("obs", sizes[0]), ("act", sizes[-1]))
    ]
    graph = helper.make_graph(nodes, "policy", ends[0], ends[1], tensors)
    file = folder / "policy.onnx"
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 20)]), file)
    return load_onnx(file, whole=False)


def policy_law(policy: OnnxPolicy, sizes: tuple[int, ...]) -> Law:
    """The policy with its signals."""
    ports = [Port("input", f"obs{k}", vector="obs", limits=(-3.0, 3.0)) for k in range(sizes[0])]
    ports += [Port("output", f"act{k}", vector="act") for k in range(sizes[-1])]
    return Law("policy", policy, ports, rate=1000.0)


def truth(policy: OnnxPolicy, x: np.ndarray) -> np.ndarray:
    """Actions (n, outputs) by the evaluator of the package onnx, in double precision."""
    from sim.laws.prove_onnx import OnnxReference

    return OnnxReference(policy)({"obs": x[:, None, :].astype(float)})["act"].reshape(len(x), -1)
