# SPDX-License-Identifier: Apache-2.0
"""The mark `quick`: it selects cases for make test; a pattern without a case is an error."""

from __future__ import annotations

import pytest

pytest_plugins = "pytester"

CASES = """
import pytest

@pytest.mark.quick({patterns})
@pytest.mark.parametrize("unit", ["add-0", "add-1", "mul"])
def test_unit(unit):
    pass

def test_other():
    pass
"""


@pytest.fixture
def selected(pytester: pytest.Pytester):
    def run(patterns: str, *arguments: str) -> pytest.RunResult:
        pytester.makeconftest("from tests.conftest import pytest_collection_modifyitems")
        pytester.makeini("[pytest]\nmarkers =\n  full\n  quick\n")
        pytester.makepyfile(CASES.format(patterns=patterns))
        return pytester.runpytest_inprocess("-m", "not full", *arguments)

    return run


def test_cases_that_match__run_and_the_others_are_full(selected):
    selected('"add-*"').assert_outcomes(passed=3, deselected=1)


def test_several_patterns__one_that_matches_is_enough(selected):
    selected('"mul", "add-1"').assert_outcomes(passed=3, deselected=1)


def test_pattern_without_a_case__is_an_error(selected):
    result = selected('"add-*", "div"')
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*test_unit: quick('div') matches no case of this test"])


def test_no_pattern__is_an_error(selected):
    result = selected("")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*test_unit: quick() names no case*"])


def test_test_without_cases__is_an_error(selected, pytester):
    pytester.makepyfile(test_alone="import pytest\n\n@pytest.mark.quick('a')\ndef test_a(): pass")
    result = selected('"mul"')
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*test_a: quick('a') matches no case of this test"])


def test_single_test_asked_for__other_patterns_are_not_judged(selected, pytester):
    name = "test_single_test_asked_for__other_patterns_are_not_judged.py::test_unit[mul]"
    selected('"add-*", "mul"', name).assert_outcomes(passed=1)
