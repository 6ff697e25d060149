# SPDX-License-Identifier: Apache-2.0
"""`sim.Core`: values by name, states, batches, faults and wrong use, on all backends."""

from __future__ import annotations

import math
import re
import sys

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from sim import Core, CoreError, CoreFault
from sim.core.backends import BACKENDS, Kind
from sim.debug.backend import BlockBackend, DrivenBackend, open_backend
from sim.debug.client import connect
from sim.debug.model import DebugRtl
from sim.rtl.asip_rtl import AsipError
from tests.bench.commands import output

PROGRAM = """\
.program "way and speed"
.input  x, limit
.input  count : int
.param  gain = 2.0
.state  before : int = 0
.state  sum = 1.0
.data   table = 10.0, 20.0, 30.0, 40.0
.output out, safe = -1.5
.output looked, safe = 0.0
.export step, root, x
        isub  step, count, before
        mov   before, count
        i2f   way, step
        fmadd sum, way, gain, sum
        fsqrt root, x
        fsat  out, sum, (-1000.0), limit
        f2i   i, root
        ld    looked, table[i]
        halt
"""
FLAG_NX = 1


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    path = tmp_path_factory.mktemp("api") / "way.s"
    path.write_text(PROGRAM)
    return path


class Board(BlockBackend):
    """A core with its debug block, made for the first program."""

    def __init__(self) -> None: ...

    def load(self, image):
        model = DebugRtl(image.configuration)
        super().__init__(lambda: connect(model), "board")
        super().load(image)


@pytest.fixture(params=["rtl", "iss", "board"])
def backend(request, monkeypatch):
    monkeypatch.setitem(BACKENDS, "board", Board)
    return request.param


@pytest.fixture
def core(source, backend):
    with Core(source, backend=backend) as core:
        core.set(limit=500.0)
        yield core


def test_tick__values_by_name__and_what_stays_until_the_next(core, backend):
    assert core.inputs == ("x", "limit", "count") and core.outputs == ("out", "looked")
    assert core.states == ("before", "sum") and core.exports == ("step", "root", "x")
    assert core.tick(x=4.0, count=7) == {"out": 15.0, "looked": 30.0}
    assert core.tick({"count": -3}) == {"out": -5.0, "looked": 30.0}
    assert (core.read("before"), core.read("sum"), core.read("root")) == (-3, -5.0, 2.0)
    assert (core.read("out"), core.read("x"), core.read("gain")) == (-5.0, 4.0, 2.0)
    assert core.read_word("step") == (-10) & 0xFFFFFFFF and core.read_word("root") == 0x40000000
    assert core.ticks == 2 and core.flags == 0
    assert core.cycles == (core.image.cycles if backend != "iss" else None)
    core.tick(x=2.0)
    assert core.flags == FLAG_NX and core.read("root") == float(np.float32(math.sqrt(2.0)))


def test_state__preset__next_tick_starts_from_it(core):
    core.preset(before=100, sum=0.25)
    assert core.tick(count=101)["out"] == 2.25


def test_data_memory__preset__next_tick_reads_it(core):
    core.preset_data(1, [21.5, 32.5])
    assert core.tick(x=1.0)["looked"] == 21.5
    assert core.tick(x=4.0)["looked"] == 32.5
    assert core.tick(x=9.0)["looked"] == 40.0 and core.tick(x=0.0)["looked"] == 10.0
    for address, count in ((-1, 1), (1023, 2)):
        with pytest.raises(CoreError, match=f"{count} words from address {address} on: .* 1024"):
            core.preset_data(address, [0.0] * count)


def test_words__raw_bits__same_as_the_value(core):
    core.set_words(x=0x41100000, count=0xFFFFFFFE)
    assert core.tick() == {"out": -3.0, "looked": 40.0}


def test_batch__same_bits_as_ticks(core, source, backend):
    rng = np.random.default_rng(5)
    x, count = rng.uniform(0, 9, 40), rng.integers(-(2**31), 2**31, 40)
    ticks = core.batch({"x": x, "count": count}, read=["root", "before", "x", "gain"])
    with Core(source, backend=backend) as alone:
        alone.set(limit=500.0)
        for i in range(40):
            got = alone.tick(x=x[i], count=count[i])
            assert got == {name: ticks[name][i] for name in alone.outputs}, f"tick {i}, seed 5"
            assert alone.read("root") == ticks["root"][i] and alone.flags == ticks.flags[i]
    assert ticks["before"].tolist() == count.tolist() and ticks["before"].dtype == np.int32
    assert ticks["x"].tolist() == x.astype(np.float32).tolist()
    assert ticks["gain"].tolist() == [2.0] * 40
    assert core.ticks == 40 and core.read("x") == ticks["x"][-1]
    if backend != "iss":
        assert set(ticks.cycles.tolist()) == {core.image.cycles}
    assert len(core.batch({"x": []})["out"]) == 0


def test_backends__same_bits_on_random_ticks(source):
    rng = np.random.default_rng(6)
    inputs = {"x": rng.uniform(0, 9, 200), "count": rng.integers(-(2**20), 2**20, 200)}
    got = []
    for backend in ("rtl", "iss"):
        with Core(source, backend=backend) as core:
            core.set(limit=1e30)
            got.append(core.batch(inputs, read=["root", "sum"]))
    for name in ("out", "looked", "root", "sum"):
        words = [ticks[name].view(np.uint32) for ticks in got]
        assert np.array_equal(*words), f"{name}, seed 6"
    assert np.array_equal(got[0].flags, got[1].flags)


def test_defines_and_configuration__take_effect(source, backend):
    with Core(source, configuration="small", defines={"gain": 8.0}, backend=backend) as core:
        assert core.image.configuration == "small"
        assert core.tick(limit=100.0, count=2)["out"] == 17.0


def test_image_file__runs__and_refuses_parameters(source, tmp_path):
    file = tmp_path / "way.asip.json"
    assemble(source).save(file)
    with Core(str(file)) as core:
        assert core.tick(limit=9.0, count=1)["out"] == 3.0
    with pytest.raises(CoreError, match="give the source"):
        Core(file, defines={"gain": 1.0})
    with pytest.raises(CoreError, match="for configuration 'fast', not 'small'"):
        Core(file, configuration="small")


def test_two_cores__at_once__each_keeps_its_own(source):
    with Core(source) as one, Core(source) as two:
        one.set(limit=500.0)
        two.set(limit=500.0)
        one.preset(sum=10.0)
        assert (one.tick(count=1)["out"], two.tick(count=2)["out"]) == (12.0, 5.0)
        assert (one.tick(count=2)["out"], two.tick(count=2)["out"]) == (14.0, 5.0)
        one.close()
        assert two.tick(count=3)["out"] == 7.0


# ---------------------------------------------------------------------- faults


def test_nan_input__fault_names_input_and_place__clear__good_tick(core):
    good = core.tick(x=4.0, count=3)
    with pytest.raises(CoreFault) as caught:
        core.tick(limit=math.nan, count=2**31 - 1)
    fault, text = caught.value, str(caught.value)
    assert (fault.tick, fault.cause) == (1, "NOT_FINITE")
    assert fault.outputs == {"out": -1.5, "looked": 0.0}
    assert re.search(r"way\.s:16: fsat out, sum,", text)
    assert "inputs: limit is nan" in text and "clear()" in text
    assert core.read("out") == -1.5
    with pytest.raises(CoreError, match=r"NOT_FINITE in tick 1.*clear\(\)"):
        core.tick(limit=500.0)
    core.clear()
    assert core.read("sum") == 1.0 and core.read("before") == 0
    assert core.tick(x=4.0, count=3) == good


def test_address_fault__in_a_batch__ticks_before_it_are_kept(core):
    with pytest.raises(CoreFault, match=r"way\.s:18: ld looked") as caught:
        core.batch({"x": [1.0, 4.0, 1e10, 1.0]}, read=["root"])
    fault = caught.value
    assert (fault.cause, fault.tick) == ("ADDRESS", 2)
    assert fault.before["looked"].tolist() == [20.0, 30.0]
    assert fault.before["root"].tolist() == [1.0, 2.0] and len(fault.before.flags) == 2
    core.clear()
    assert core.tick(x=1.0)["looked"] == 20.0


def test_watchdog__endless_loop__fault_with_the_cure(tmp_path, backend):
    path = tmp_path / "endless.s"
    path.write_text(
        ".watchdog 500\n.input n : int\n.output F, safe = 1.5\n"
        "again: bnz n, again\n mov F, zero\n halt\n"
    )
    with Core(path, backend=backend) as core:
        with pytest.raises(CoreFault, match="(?s)tick 0 .*WATCHDOG.*raise .watchdog"):
            core.tick(n=1)
        core.clear()
        assert core.tick(n=0) == {"F": 0.0}


# ---------------------------------------------------------------------- wrong use


@pytest.mark.parametrize(
    ("use", "text"),
    [
        (lambda c: c.tick(limt=1.0), "no input 'limt'; did you mean 'limit'"),
        (lambda c: c.set(sum=1.0), "no input 'sum'"),
        (lambda c: c.set_words(y=1), "no input 'y'; it has x, limit, count"),
        (lambda c: c.preset(befor=1), "no state 'befor'; did you mean 'before'"),
        (lambda c: c.read("rot"), "'rot'; did you mean 'root'"),
        (lambda c: c.read("c64"), "no output, export, state, input, constant or register 'c64'"),
        (lambda c: c.batch({"x": [1.0]}, read=["rot"]), "did you mean 'root'"),
        (lambda c: c.batch({"z": [1.0]}), "no input 'z'"),
        (lambda c: c.tick(x="1"), "input x: '1' is not a number"),
        (lambda c: c.tick(x=None), "input x: None is not a number"),
        (lambda c: c.tick(x=np.ones(3)), "is not a number; a batch takes arrays"),
        (lambda c: c.tick(x=1e39), "too large for binary32"),
        (lambda c: c.tick(x=10**400), "too large for binary32"),
        (lambda c: c.tick(count=1.0), r"count is an int32, got 1.0; round it: round\(x\)"),
        (lambda c: c.tick(count=math.nan), "count is an int32, got nan"),
        (lambda c: c.tick(count=2**31), "outside of int32"),
        (lambda c: c.preset(before=0.5), "state before is an int32"),
        (lambda c: c.set_words(x=1.0), "a raw word is an integer"),
        (lambda c: c.set_words(x=2**32), "does not fit in 32 bits"),
        (lambda c: c.batch({}), "inputs of one length; given are none"),
        (lambda c: c.batch({"x": [1.0, 2.0], "count": [1]}), "given are x 2, count 1"),
        (lambda c: c.batch({"x": [[1.0]]}), r"one per tick; got shape \(1, 1\)"),
        (lambda c: c.batch({"x": 1.0}), r"got shape \(\)"),
        (lambda c: c.batch({"x": ["a"]}), "array of numbers"),
        (lambda c: c.batch({"x": [1.0, 1e39]}), "too large for binary32"),
        (lambda c: c.batch({"count": [1.5]}), "is an int32, got float64"),
        (lambda c: c.batch({"count": [2**31]}), "outside of int32"),
    ],
)
def test_wrong_use__message_with_the_cure__and_nothing_changed(core, use, text):
    with pytest.raises(CoreError, match=text):
        use(core)
    assert core.ticks == 0 and core.tick(x=4.0, count=1)["out"] == 3.0


def test_closed_core__every_call_says_so(source, backend):
    core = Core(source, backend=backend)
    core.close()
    core.close()
    for use in (core.tick, core.clear, lambda: core.read("out"), lambda: core.preset(sum=1.0)):
        with pytest.raises(CoreError, match="the core is closed"):
            use()


def test_closed_model__bus_access_is_an_error_not_a_crash(source):
    with Core(source) as core:
        rtl = core.backend.rtl
    for use in (rtl.reset, lambda: rtl.read(0), lambda: rtl.irq, lambda: rtl.cycles):
        with pytest.raises(AsipError, match="the core is closed"):
            use()


def test_backend_that_exists__runs_the_program__also_after_a_debugger(source):
    image, model = assemble(source), DebugRtl("fast")
    debugger = BlockBackend(lambda: connect(model), "core")
    debugger.load(image)
    debugger.arm([0], [])
    debugger.begin(dict.fromkeys(("x", "limit", "count"), 0), hold=True)
    assert debugger.poll(1.0).kind is Kind.HALTED
    assert open_backend("iss").label == "instruction-set model"
    with Core(image, backend=BlockBackend(lambda: connect(model), "core")) as core:
        assert core.tick(x=4.0, count=7, limit=500.0) == {"out": 15.0, "looked": 30.0}
        onlooker = BlockBackend(lambda: connect(model), "core")
        core.backend.arm([0], [])
        onlooker.close()  # it has loaded nothing, and so leaves the breakpoint
        core.backend.begin(dict.fromkeys(("x", "limit", "count"), 0), hold=False)
        assert core.backend.poll(1.0).reason == "breakpoint"
    assert not connect(model).state().held


def test_core_without_a_debug_block__refuses_to_stop_inside_a_run(source):
    with Core(source) as core:
        backend = core.backend
        for use in (
            *(backend.resume, backend.step, backend.halt, backend.abort),
            lambda: backend.begin({}, hold=True),
            lambda: backend.poll(0.0),
            lambda: backend.arm([0], []),
        ):
            with pytest.raises(AsipError, match="the Verilated core has no debug block"):
                use()
        assert backend.breakpoints == backend.watches == 0
        for place, text in {"a3.2": "first lane alone", "d9999": "no register"}.items():
            with pytest.raises(AsipError, match=text):
                backend.read(place)
        with pytest.raises(AsipError, match="only runs write outputs"):
            backend.write("o0", 1)


def test_core_that_its_host_drives__takes_no_runs_from_here(source):
    image, model = assemble(source), DebugRtl("fast")
    model.load(image)
    with Core(image, backend=DrivenBackend(lambda: connect(model), "machine")) as core:
        with pytest.raises(AsipError, match="another host starts the runs"):
            core.tick()


def test_program__that_does_not_assemble_or_exist__says_where(tmp_path):
    path = tmp_path / "wrong.s"
    path.write_text(".output F, safe = 0.0\n fad F, 1.0, 2.0\n halt\n")
    with pytest.raises(AssemblyError, match="wrong.s:2:"):
        Core(path)
    with pytest.raises(OSError, match="absent.s"):
        Core(tmp_path / "absent.s")
    with pytest.raises(CoreError, match="no backend 'fpga'; there are rtl, iss"):
        Core(path, backend="fpga")


def test_package__names_on_demand__without_loading_verilator():
    text = (
        "import sys, sim\n"
        "assert 'numpy' not in sys.modules\n"
        "from sim import Core\n"
        "assert 'verilator' not in sys.modules\n"
        "assert 'Core' in dir(sim) or 'Core' in sim.__all__\n"
        "try: sim.Corr\n"
        "except AttributeError as error: print(error)\n"
    )
    said = output(sys.executable, "-c", text)
    assert said == "module 'sim' has no attribute 'Corr'\n"


def test_export_of_bank_k__reads_the_input_or_constant_behind_it(tmp_path, backend):
    path = tmp_path / "k.s"
    path.write_text(
        ".input x, n : int\n.const w = 2.0\n.output F, safe = 0.0\n.export a = k0, b = k1, c = k2\n"
        " i2f m, n\n fmadd y, x, w, m\n mov F, y\n halt\n"
    )
    with Core(path, backend=backend) as core:
        ticks = core.batch({"x": [1.0, 2.0], "n": [3, -4]}, read=["a", "b", "c"])
        assert (ticks["a"].tolist(), ticks["b"].tolist()) == ([1.0, 2.0], [3, -4])
        assert ticks["c"].tolist() == [2.0, 2.0] and ticks["F"].tolist() == [5.0, 0.0]
        assert (core.read("a"), core.read("b"), core.read("c")) == (2.0, -4, 2.0)


def test_parameter_file__replaces_the_one_that_the_program_names(tmp_path, backend):
    (tmp_path / "mine.toml").write_text("gain = 3.0\n")
    (tmp_path / "other.toml").write_text("gain = 5.0\n")
    path = tmp_path / "p.s"
    path.write_text(
        '.params "mine.toml"\n.input x\n.output F, safe = 0.0\n fmul y, x, gain\n mov F, y\n halt\n'
    )
    with Core(path, backend=backend) as core:
        assert core.tick(x=2.0) == {"F": 6.0}
    with Core(path, params=tmp_path / "other.toml", backend=backend) as core:
        assert core.tick(x=2.0) == {"F": 10.0}
