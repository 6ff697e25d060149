# SPDX-License-Identifier: Apache-2.0
"""List the locked packages with their licences and hashes.

    microtick sbom        write build/sbom.json (CycloneDX 1.5) and build/licences.md

The lock files say which packages there are, their own metadata which licences they have and what
they need. `scope` says what a package is for: "required" is needed by the wheel, "optional" by one
of its extras, "excluded" by building, tests and synthesis alone.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from asip_asm.command import command, command_parser
from asip_asm.files import write_text
from asip_asm.project import ROOT
from scripts.generated import table

LOCKS = (ROOT / "requirements.lock", ROOT / "requirements-synth.lock")
SBOM, PAGE = ROOT / "build/sbom.json", ROOT / "build/licences.md"
FOR = {
    "required": "the wheel",
    "optional": "an extra of the wheel",
    "excluded": "building, tests and synthesis alone",
}
COPYLEFT = re.compile(r"GPL|General Public|CeCILL", re.IGNORECASE)
# Packages whose metadata name no licence, with the one in their files.
STATED = {"cmeel-qhull": "Qhull", "cocotb-bus": "BSD-3-Clause"}
UNKNOWN = "not stated"


@dataclass(frozen=True)
class Package:
    """A locked package. expression: whether `licence` is an SPDX expression, else it is a name."""

    name: str
    version: str
    hashes: tuple[str, ...]
    licence: str
    expression: bool
    scope: str
    needs: tuple[str, ...]

    @property
    def purl(self) -> str:
        """The package URL."""
        return f"pkg:pypi/{self.name}@{self.version}"

    @property
    def copyleft(self) -> bool:
        """Whether the licence asks for the source of what is distributed with it."""
        return COPYLEFT.search(self.licence) is not None


def locked(files: Iterable[Path]) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Name -> version and SHA-256 hashes. Raises ValueError for an entry without either."""
    found: dict[str, tuple[str, tuple[str, ...]]] = {}
    for file in files:
        text = re.sub(r"\s*#.*", "", file.read_text())
        for line in text.replace("\\\n", " ").splitlines():
            if not line.strip():
                continue
            pinned = Requirement(line.split(" --hash")[0])
            versions = [each.version for each in pinned.specifier if each.operator == "=="]
            hashes = tuple(re.findall(r"--hash=sha256:([0-9a-f]{64})", line))
            if len(versions) != 1 or not hashes:
                raise ValueError(f"{file.name}: {pinned.name} has no version or no hash; make lock")
            found[canonicalize_name(pinned.name)] = versions[0], hashes
    return found


def licence(package: Distribution) -> tuple[str, bool]:
    """The licence that the metadata state, and whether it is an SPDX expression."""
    fields = package.metadata
    stated = next(
        (fields[name] for name in ("License-Expression", "License") if name in fields), ""
    )
    try:
        return canonicalize_license_expression(stated), True
    except InvalidLicenseExpression:
        pass
    named = [
        each.split(" :: ")[-1]
        for each in package.metadata.get_all("Classifier") or ()
        if each.startswith("License :: ") and each != "License :: OSI Approved"
    ]
    lines = stated.strip().splitlines()
    short = lines[0] if len(lines) == 1 and stated.strip() != "UNKNOWN" else ""
    return " and ".join(named) or short or STATED.get(
        canonicalize_name(package.name), UNKNOWN
    ), False


def needs(requirements: Iterable[str], extras: Iterable[str] = ("",)) -> Iterator[str]:
    """Names of the packages that requirements ask for here."""
    wanted = tuple(extras)
    for requirement in map(Requirement, requirements):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in wanted):
            yield canonicalize_name(requirement.name)


def closure(names: Iterable[str], graph: Mapping[str, Iterable[str]]) -> set[str]:
    """The names and all that they need."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += graph.get(name, ())
    return found


def packages() -> list[Package]:
    """The locked packages by name. Raises ValueError if one is missing or of another version."""
    pins = locked(LOCKS)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    installed: dict[str, Distribution] = {}
    for name, (version, _) in pins.items():
        try:
            installed[name] = distribution(name)
        except PackageNotFoundError:
            raise ValueError(f"{name} is locked but not installed; make setup-synth") from None
        if installed[name].version != version:
            there = installed[name].version
            raise ValueError(f"{name} {version} is locked, {there} is installed; make setup-synth")
    graph = {
        name: sorted(set(needs(each.requires or ())) & set(pins))
        for name, each in installed.items()
    }
    required = closure(needs(project["dependencies"]), graph)
    extras = [each for extra in project["optional-dependencies"].values() for each in extra]
    optional = closure(needs(extras), graph)
    return [
        Package(
            name, *pins[name], *licence(installed[name]),
            "required" if name in required else "optional" if name in optional else "excluded",
            tuple(graph[name]),
        )
        for name in sorted(pins)
    ]  # fmt: skip


def bill(found: Iterable[Package]) -> dict:
    """The CycloneDX document; the same packages give the same text."""
    found = list(found)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    own = f"pkg:pypi/{project['name']}@{project['version']}"
    components = [
        {
            "type": "library",
            "bom-ref": each.purl,
            "name": each.name,
            "version": each.version,
            "scope": each.scope,
            "hashes": [{"alg": "SHA-256", "content": one} for one in each.hashes],
            "licenses": [
                {"expression": each.licence}
                if each.expression
                else {"license": {"name": each.licence}}
            ],
            "purl": each.purl,
        }
        for each in found
    ]
    purls = {each.name: each.purl for each in found}
    direct = sorted(set(needs(project["dependencies"])))
    dependencies = [{"ref": own, "dependsOn": [purls[name] for name in direct]}]
    dependencies += [
        {"ref": each.purl, "dependsOn": [purls[name] for name in each.needs]} for each in found
    ]
    content = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps([own, components, dependencies]))
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "serialNumber": f"urn:uuid:{content}",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": own,
                "name": project["name"],
                "version": project["version"],
                "licenses": [{"expression": project["license"]}],
                "purl": own,
            }
        },
        "components": components,
        "dependencies": dependencies,
    }


def page(found: Iterable[Package]) -> str:
    """The table of licences."""
    found = list(found)
    lines = [
        "# Licences of others",
        "",
        "Written by `microtick sbom` from the lock files and the packages' own metadata.",
        "The wheel holds files of this project alone. Nothing of these packages is in it:",
        "pip gets each from its own publisher.",
        "",
    ]
    for scope, use in FOR.items():
        named = [
            each.name for each in found if each.scope == scope and COPYLEFT.search(each.licence)
        ]
        lines += [f"Under GPL, LGPL or CeCILL for {use}: {', '.join(named) or 'none'}.", ""]
    rows = [[each.name, each.version, each.licence, FOR[each.scope]] for each in found]
    return "\n".join(lines + table(["package", "version", "licence", "needed by"], rows)) + "\n"


@command("microtick sbom")
def main(argv: Sequence[str] | None = None) -> int:
    """Write both files."""
    command_parser("microtick sbom", __doc__).parse_args(argv)
    try:
        found = packages()
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    SBOM.parent.mkdir(exist_ok=True)
    write_text(SBOM, json.dumps(bill(found), indent=2) + "\n")
    write_text(PAGE, page(found))
    print(f"sbom: {len(found)} packages, {SBOM.relative_to(ROOT)}, {PAGE.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
