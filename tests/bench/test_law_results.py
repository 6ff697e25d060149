# SPDX-License-Identifier: Apache-2.0
"""Stored measurements of laws: what is measured once is not measured again; a failure loses none
of the others.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.bench import law_results

PLACE = f"{__name__}:measured"
CALLS = "calls"


def measured(law: str, limit: int) -> dict:
    """A measurement that leaves a trace in the folder that its name begins with."""
    folder, name = law.split("|")
    with (Path(folder) / CALLS).open("a", encoding="utf-8") as file:
        file.write(f"{name}\n")
    if len(name) > limit:
        raise ValueError(f"{name} is longer than {limit}")
    return {"length": len(name)}


def test_results__of_a_run_that_failed__are_not_measured_again(monkeypatch, tmp_path):
    monkeypatch.setattr(law_results, "STORE", tmp_path / "store")
    monkeypatch.setattr(law_results, "JOBS", 1)
    laws = [f"{tmp_path}|{name}" for name in ("a", "long", "bc")]
    # A path in a name would be one of the store's too.
    monkeypatch.setattr(law_results, "file_name", lambda law: law.rpartition("|")[2] + ".json")
    with pytest.raises(law_results.MeasureError, match="long is longer than 3"):
        law_results.results(PLACE, laws, 3)
    short = law_results.results(PLACE, [laws[0], laws[2]], 3)
    assert [each["length"] for each in short.values()] == [1, 2]
    assert (tmp_path / CALLS).read_text().split() == ["a", "long", "bc"]
    law_results.results(PLACE, laws[:1], 4)  # other numbers
    monkeypatch.setattr(law_results, "fingerprint", lambda: "other sources")
    law_results.results(PLACE, laws[:1], 3)
    assert (tmp_path / CALLS).read_text().split() == ["a", "long", "bc", "a", "a"]
