# SPDX-License-Identifier: Apache-2.0
"""Models of tests carry the assertions of sim/assertions; what a test may be skipped for."""

from collections.abc import Generator
from typing import Any

import pytest

from sim.harness import build
from tests.bench import needs

build.assertions = True


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
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
