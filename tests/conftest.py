# SPDX-License-Identifier: Apache-2.0
"""Models of tests carry the assertions of sim/rtl/assertions; the robot; reasons to skip a test."""

import os

# Set before NumPy and SciPy are loaded, here and in all that a test starts: the threads of their
# linear algebra spin while they wait, which takes more of a processor than the small matrices.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import fnmatch
import re
import shutil
import signal
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from asip_asm import schedule
from asip_asm.command import cause_of
from asip_asm.project import BUILD
from sim.robot.parameters import Robot
from sim.rtl import build, coverage, wave_layout, waves
from tests.bench import needs, schedules

MOST_FILES = 40  # of counts, before they are merged

# A shell ignores interrupts for what it starts in the background, and so would every server that a
# test starts and ends by one: each would go on for a minute, until it is killed.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# A slow machine fails no test: hypothesis allows an example 200 ms by default.
settings.register_profile("no deadline", settings(), deadline=None)
settings.load_profile("no deadline")
build.assertions = True
build.optimisation = os.environ["MODEL_OPTIMISATION"] = (
    "-O1"  # of commands in their own process too
)
schedule.search = schedules.found


@pytest.fixture(scope="session")
def robot() -> Robot:
    """The robot of sim/robot.toml."""
    return Robot.load()


def stop(number: int, frame: object) -> None:
    """TERM and HUP end the tests as Ctrl-C does, so that they end the programs that they run."""
    raise KeyboardInterrupt


def pytest_configure(config: pytest.Config) -> None:
    """The folder of results is made before any test: in a read-only checkout, say so at once."""
    if hasattr(config, "workerinput") or not config.option.numprocesses:
        # It is read; a pytest that a test starts has its own options.
        os.environ.pop("PYTEST_ADDOPTS", None)
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, stop)
    if not hasattr(config, "workerinput"):
        try:
            BUILD.mkdir(exist_ok=True)
            tempfile.TemporaryFile(dir=BUILD).close()
        except OSError as error:
            raise pytest.UsageError(cause_of(error)) from error


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of a test marked `quick`, the cases that match no pattern are marked `full`.

    A mark without a pattern is an error, and so is a pattern that matches no case, unless single
    tests were asked for.
    """
    unused: dict[tuple[str, str], bool] = {}
    for item in items:
        mark = item.get_closest_marker("quick")
        if mark is None:
            continue
        test = item.nodeid.split("[")[0]
        if not mark.args:
            raise pytest.UsageError(f"{test}: quick() names no case; write full, or a pattern")
        case = item.callspec.id if hasattr(item, "callspec") else ""
        matched = [fnmatch.fnmatchcase(case, pattern) for pattern in mark.args]
        for pattern, found in zip(mark.args, matched, strict=True):
            unused[test, pattern] = unused.get((test, pattern), True) and not found
        if not any(matched):
            item.add_marker(pytest.mark.full)
    if not any("::" in str(given) for given in config.args):
        for (test, pattern), missing in unused.items():
            if missing:
                raise pytest.UsageError(f"{test}: quick({pattern!r}) matches no case of this test")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    if waves.wanted():
        begin_waves(item)
    for mark in item.iter_markers("needs"):
        for name in mark.args:
            needs.require(name)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, Any, Any]:
    report = yield
    needs.refuse_skip(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, Any, Any]:
    report = yield
    needs.refuse_skip(report)
    return report


def begin_waves(item: pytest.Item) -> None:
    """With WAVES=1: an empty folder for the waves of a test."""
    folder = BUILD / "waves" / re.sub(r"[^\w.=-]+", "_", item.nodeid)[-150:].strip("_")
    shutil.rmtree(folder, ignore_errors=True)
    os.environ["WAVES_FOLDER"] = str(folder)
    waves.folder()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, Any, Any]:
    result = yield
    if waves.wanted():
        waves.close()
        files = sorted(map(str, waves.folder().glob("*.fst")))
        for path in files:
            wave_layout.write(Path(path))
        item.user_properties.append(("waves", files))
    return result


@pytest.hookimpl(trylast=True)
def pytest_runtest_logfinish() -> None:
    """With RTL_COVERAGE=1: the counts of many models become one file."""
    if coverage.wanted():
        coverage.gather(MOST_FILES)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    reports = [r for each in terminalreporter.stats.values() for r in each]
    for report in reports:
        if getattr(report, "when", "") == "teardown":
            for file in dict(report.user_properties).get("waves", []):
                terminalreporter.write_line(f"waves: {file}")
