# SPDX-License-Identifier: Apache-2.0
"""The list of packages is whole, of the form that CycloneDX 1.5 asks for, and says the truth."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from importlib.metadata import Distribution

import jsonschema
import pytest

from scripts import sbom
from tests.bench.needs import needs
from tests.package.environment import build_wheel

TEXT = {"type": "string", "minLength": 1}
COMPONENT = {
    "type": "object",
    "required": ["type", "name", "version", "bom-ref", "purl", "licenses"],
    "properties": {
        "type": {"enum": ["application", "library"]},
        "name": TEXT,
        "version": TEXT,
        "bom-ref": TEXT,
        "purl": {"type": "string", "pattern": r"^pkg:pypi/[a-z0-9-]+@[A-Za-z0-9.+!]+$"},
        "scope": {"enum": ["required", "optional", "excluded"]},
        "hashes": {
            "type": "array",
            "minItems": 1,
            "items": {
                "type": "object",
                "required": ["alg", "content"],
                "properties": {
                    "alg": {"const": "SHA-256"},
                    "content": {"type": "string", "pattern": "^[0-9a-f]{64}$"},
                },
                "additionalProperties": False,
            },
        },
        "licenses": {
            "type": "array",
            "minItems": 1,
            "items": {
                "oneOf": [
                    {"required": ["expression"], "properties": {"expression": TEXT}},
                    {
                        "required": ["license"],
                        "properties": {
                            "license": {"required": ["name"], "properties": {"name": TEXT}}
                        },
                    },
                ]
            },
        },
    },
    "additionalProperties": False,
}
SCHEMA = {
    "type": "object",
    "required": ["bomFormat", "specVersion", "version", "metadata", "components", "dependencies"],
    "properties": {
        "bomFormat": {"const": "CycloneDX"},
        "specVersion": {"const": "1.5"},
        "serialNumber": {"type": "string", "pattern": r"^urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-"},
        "version": {"type": "integer", "minimum": 1},
        "metadata": {"required": ["component"], "properties": {"component": COMPONENT}},
        "components": {"type": "array", "items": COMPONENT, "uniqueItems": True},
        "dependencies": {
            "type": "array",
            "items": {
                "required": ["ref", "dependsOn"],
                "properties": {"dependsOn": {"type": "array", "uniqueItems": True}},
            },
        },
    },
    "additionalProperties": False,
}


@pytest.fixture(scope="module")
def found() -> list[sbom.Package]:
    return sbom.packages()


@needs("yosys", "bitwuzla")
def test_bill__has_every_locked_package_in_the_form_asked_for(found):
    document = json.loads(json.dumps(sbom.bill(found)))
    jsonschema.validate(document, SCHEMA)
    components = {each["name"]: each for each in document["components"]}
    assert components.keys() == sbom.locked(sbom.LOCKS).keys() and len(components) > 100
    assert {"pip", "setuptools"} <= components.keys()
    refs = {each["bom-ref"] for each in components.values()}
    refs.add(document["metadata"]["component"]["bom-ref"])
    assert len(refs) == len(components) + 1
    assert {each["ref"] for each in document["dependencies"]} == refs
    assert all(set(each["dependsOn"]) <= refs for each in document["dependencies"])
    numpy = components["numpy"]
    lock = (sbom.ROOT / "requirements.lock").read_text()
    assert all(f"--hash=sha256:{each['content']}" in lock for each in numpy["hashes"])
    assert numpy["scope"] == "required" and components["casadi"]["scope"] == "optional"
    assert components["scapy"]["scope"] == "optional"
    assert components["ruff"]["scope"] == components["python-can"]["scope"] == "excluded"
    assert sbom.bill(found) == document


@needs("yosys", "bitwuzla")
def test_page__names_each_licence_and_copyleft_by_use(found):
    page = sbom.page(found)
    assert sbom.UNKNOWN not in page
    alone = page.split("tests and synthesis alone:")[1]
    assert "for the wheel: gmpy2." in page and "python-can" in alone
    other = [dataclasses.replace(each, licence="MIT", expression=True) for each in found]
    assert sbom.page(other).count(": none.") == 3


@needs("yosys", "bitwuzla")
def test_security_page__names_each_package_under_a_copyleft_licence(found):
    text = (sbom.ROOT / "SECURITY.md").read_text(encoding="utf-8")
    rows = text.partition("| GPL, LGPL or CeCILL |")[2].partition("\n\n")[0].splitlines()[2:]
    assert len(rows) == len(sbom.FOR)
    for scope, row in zip(sbom.FOR, rows, strict=True):
        listed = row.split("|")[1].replace(" (by way of pinocchio)", "")
        wanted = [each.name for each in found if each.scope == scope and each.copyleft]
        assert sorted(listed.strip().split(", ")) == wanted


def test_wheel__holds_nothing_of_other_packages(tmp_path):
    """Nothing but this project's folders, as the page says."""
    with zipfile.ZipFile(build_wheel(tmp_path)) as wheel:
        tops = {name.partition("/")[0] for name in wheel.namelist()}
    assert {each for each in tops if not each.endswith(".dist-info")} == {"microtick"}


@pytest.mark.parametrize(
    ("line", "name"),
    [("numpy>=2 --hash=sha256:" + "0" * 64, "numpy"), ("scipy==1.17.0", "scipy")],
)
def test_lock__without_version_or_hash_is_refused(line, name, tmp_path):
    file = tmp_path / "requirements.lock"
    file.write_text(line + "\n")
    with pytest.raises(ValueError, match=f"requirements.lock: {name} has no"):
        sbom.locked([file])


def test_installed_version__that_differs_from_the_lock_is_refused(tmp_path, monkeypatch):
    file = tmp_path / "requirements.lock"
    file.write_text("numpy==1.0 --hash=sha256:" + "0" * 64 + "\n")
    monkeypatch.setattr(sbom, "LOCKS", (file,))
    with pytest.raises(ValueError, match="numpy 1.0 is locked, .* is installed; make setup-synth"):
        sbom.packages()


@pytest.mark.parametrize(
    ("lines", "stated"),
    [
        ("License-Expression: MIT", ("MIT", True)),
        ("License: apache-2.0", ("Apache-2.0", True)),
        (
            "License: LGPLv3\nClassifier: License :: OSI Approved :: MIT License",
            ("MIT License", False),
        ),
        ("License: Apache Software License", ("Apache Software License", False)),
        ("License: UNKNOWN", (sbom.UNKNOWN, False)),
    ],
)
def test_licence__is_read_from_the_metadata(lines, stated, tmp_path):
    folder = tmp_path / "x-1.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.4\nName: x\nVersion: 1\n{lines}\n")
    assert sbom.licence(Distribution.at(folder)) == stated
