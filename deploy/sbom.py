"""What an image is made of, as CycloneDX in JSON: `make sbom`, or python deploy/sbom.py --help.

The image is asked, not the lock: each Python package and each Debian package that is installed in it.
"""

import argparse
import json
import subprocess
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import DisjunctiveLicense, LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

Run = Callable[[list[str]], str]

_NAME_LENGTH = 60
"""The longest name of a license; what is longer in its place is the text of one."""

_ASK = """
import json, platform, subprocess
from importlib.metadata import distributions
shown = "${db:Status-Status} ${Package} ${Version} ${Architecture}\\\\n"
query = ["dpkg-query", "--show", "--showformat", shown]
print(json.dumps({
    "system": platform.freedesktop_os_release(),
    "debian": subprocess.check_output(query, text=True).splitlines(),
    "interpreter": platform.python_version(),
    "python": [
        {
            "name": one.metadata["Name"],
            "version": one.version,
            "license": one.metadata["License-Expression"] or "",
            "license name": one.metadata["License"] or "",
            "requires": one.requires or [],
        }
        for one in distributions()
    ],
}))
"""
"""Run in the image, by its own Python."""


def inventory(run: Run) -> dict[str, Any]:
    """What is installed where `run` runs a command; `CalledProcessError` where it cannot be asked."""
    found: dict[str, Any] = json.loads(run(["python3", "-c", _ASK]))
    return found


def sbom(image: str, found: Mapping[str, Any]) -> str:
    """The parts of an image in CycloneDX 1.6, equal for equal parts but for its serial number and time."""
    bom, (name, _, version) = Bom(), image.rpartition("/")[2].partition(":")
    whole = Component(name=name, version=version or None, type=ComponentType.CONTAINER, bom_ref=image)
    bom.metadata.component = whole
    python: dict[str, Component] = {canonicalize_name(one["name"]): _python(one) for one in found["python"]}
    interpreter = _component(
        "python", found["interpreter"], PackageURL("generic", None, "python", found["interpreter"])
    )
    others = [interpreter, *_debian(found["debian"], found["system"])]
    bom.components.update(python.values(), others)
    bom.register_dependency(whole, [python["primfit"], *others])
    for package, needed in _needs(found["python"]).items():
        bom.register_dependency(python[package], [python[one] for one in needed if one in python])
    return JsonV1Dot6(bom).output_as_string(indent=2)


def _component(name: str, version: str, purl: PackageURL, **more: Any) -> Component:
    return Component(
        name=name, version=version, type=ComponentType.LIBRARY, purl=purl, bom_ref=purl.to_string(), **more
    )


def _python(one: Mapping[str, Any]) -> Component:
    name, version = canonicalize_name(one["name"]), one["version"]
    licenses: list[LicenseExpression | DisjunctiveLicense] = []
    if one["license"]:
        licenses = [LicenseExpression(one["license"])]
    elif 0 < len(one["license name"]) <= _NAME_LENGTH:
        licenses = [DisjunctiveLicense(name=one["license name"])]
    return _component(name, version, PackageURL("pypi", None, name, version), licenses=licenses)


def _debian(lines: list[str], system: Mapping[str, str]) -> Iterator[Component]:
    """The packages that are installed; others may have left their settings."""
    distribution, release = system["ID"], system["VERSION_ID"]
    for status, name, version, architecture in map(str.split, lines):
        if status == "installed":
            qualifiers = {"arch": architecture, "distro": f"{distribution}-{release}"}
            yield _component(name, version, PackageURL("deb", distribution, name, version, qualifiers))


def _needs(packages: list[dict[str, Any]]) -> dict[str, set[str]]:
    """The names that each Python package needs, also for those of its extras that another one asks for."""
    needs = {
        canonicalize_name(one["name"]): [Requirement(text) for text in one["requires"]] for one in packages
    }
    extras: dict[str, set[str]] = defaultdict(lambda: {""})
    for asked in (requirement for several in needs.values() for requirement in several):
        extras[canonicalize_name(asked.name)] |= asked.extras
    return {
        name: {canonicalize_name(one.name) for one in several if _holds(one, extras[name])}
        for name, several in needs.items()
    }


def _holds(requirement: Requirement, extras: set[str]) -> bool:
    """Whether it counts with any of these extras; the image and who asks have about the same Python."""
    marker = requirement.marker
    return marker is None or any(marker.evaluate({"extra": extra}) for extra in extras)


@contextmanager
def container(engine: str, image: str) -> Iterator[Run]:
    """What runs a command in the image and gives what it prints."""
    if engine != "buildah":
        yield lambda command: _output(engine, "run", "--rm", "--entrypoint", command[0], image, *command[1:])
        return
    name = _output("buildah", "from", image).strip()
    try:
        yield lambda command: _output("buildah", "run", name, "--", *command)
    finally:
        _output("buildah", "rm", name)


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def main() -> None:
    """Ask the image and write the file."""
    parser = argparse.ArgumentParser(description="Write what an image is made of, as CycloneDX in JSON.")
    parser.add_argument("image")
    parser.add_argument("--engine", default="docker", help="docker, podman or buildah")
    parser.add_argument("--out", type=Path, default=Path("build/sbom.json"))
    given = parser.parse_args()
    with container(given.engine, given.image) as run:
        written = sbom(given.image, inventory(run))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(f"{written}\n")
    print(f"{given.out}: {len(json.loads(written)['components'])} components")


if __name__ == "__main__":
    main()
