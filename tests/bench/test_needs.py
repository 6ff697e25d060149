# SPDX-License-Identifier: Apache-2.0
"""A skip is a failure under CI=true: in a test, a mark or a module; the compiler may be missing."""

from __future__ import annotations

import pytest

from tests.bench import needs

pytest_plugins = ["pytester"]
FILES = {
    "mark": "from tests.bench.needs import needs\n@needs('{0}')\ndef test_a(): pass\n",
    "call": "from tests.bench.needs import require\ndef test_a(): require('{0}')\n",
    "module": "from tests.bench.needs import require\nrequire('{0}', in_module=True)\n",
    "other": "import pytest\n@pytest.mark.skipif(True, reason='{1}')\ndef test_a(): pass\n",
}


@pytest.mark.parametrize(("ci", "failed"), [("", 0), ("true", len(FILES))])
def test_missing_tool__skips_by_name_and_fails_in_ci(pytester, monkeypatch, ci, failed):
    monkeypatch.setenv("CI", ci)
    monkeypatch.setattr(needs, "find", lambda name: None)
    pytester.makeconftest((needs.ROOT / "tests/conftest.py").read_text())
    pytester.makeini("[pytest]\nmarkers = needs")
    for tool in ("yosys", "nios-gcc"):
        for name, text in FILES.items():
            file = f"test_{name}_{tool.partition('-')[0]}"
            pytester.makepyfile(**{file: text.format(tool, needs.reason(tool))})
    result = pytester.runpytest_inprocess(
        "-p", "no:cacheprovider", "-rsfE", "--continue-on-collection-errors"
    )
    outcomes = result.parseoutcomes()
    assert outcomes.get("failed", 0) + outcomes.get("errors", 0) == failed
    assert outcomes["skipped"] == 2 * len(FILES) - failed
    shown = result.stdout.str()
    assert "SKIPPED [1] test_mark_nios.py:2: nios-gcc is missing (building" in shown
    assert ("FAILED test_call_yosys.py::test_a" in shown) == bool(failed)


def test_tool_of_no_list__refused():
    with pytest.raises(KeyError):
        needs.find("no such tool")
    with pytest.raises(AssertionError):
        needs.needs("no such tool")
