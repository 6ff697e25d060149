# SPDX-License-Identifier: Apache-2.0
"""What the package declares: a bound for each dependency and build tool, which the lock keeps."""

from __future__ import annotations

import re
import tomllib

from packaging.requirements import Requirement

from asip_asm.project import ROOT


def test_every_dependency__has_a_lower_bound_that_the_lock_keeps():
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = whole["project"]
    declared = [*project["dependencies"]]
    build_tool = Requirement(whole["build-system"]["requires"][0])
    assert [each.operator for each in build_tool.specifier] == ["=="]
    declared.append(str(build_tool))
    for extra in project["optional-dependencies"].values():
        declared += extra
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = {
        name.lower().replace("_", "-"): version
        for name, version in re.findall(r"^([\w.-]+)==(\S+)", lock, re.MULTILINE)
    }
    assert len(declared) > 20
    for text in declared:
        wanted = Requirement(text)
        assert any(each.operator in (">=", "==") for each in wanted.specifier), text
        assert wanted.specifier.contains(locked[wanted.name.lower().replace("_", "-")]), text
