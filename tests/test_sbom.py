"""deploy/sbom.py on this machine in place of an image: valid CycloneDX that names what is installed."""

import json
import shutil
import subprocess
import sys
from importlib.metadata import version
from typing import Any

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packageurl import PackageURL

from deploy.sbom import inventory, sbom
from tests.test_packaging import PROJECT

IMAGE = "localhost/primfit:0.2.0"
SMALL: dict[str, Any] = {
    "system": {"ID": "debian", "VERSION_ID": "12"},
    "debian": ["installed libc6 2.36-9+deb12u10 amd64", "config-files nano 7.2-1 amd64"],
    "interpreter": "3.11.2",
    "python": [
        {"name": "primfit", "version": "0.2.0", "requires": ["Read_Er[fast]", "odd; python_version<'3'"]},
        {"name": "read-er", "version": "1.0", "requires": ["quick; extra=='fast'", "odd; extra=='slow'"]},
        {"name": "Quick", "version": "2", "license": "MIT", "requires": []},
        {"name": "odd", "version": "3", "license name": "Permission is granted ..." * 99, "requires": []},
    ],
}
for _one in SMALL["python"]:
    _one |= {"license": "", "license name": ""} | _one


def _read(written: str) -> dict[str, Any]:
    errors = JsonStrictValidator(SchemaVersion.V1_6).validate_str(written)
    assert errors is None, errors
    read: dict[str, Any] = json.loads(written)
    return read


@pytest.mark.skipif(shutil.which("dpkg-query") is None, reason="needs a Debian, as the image is one")
def test_what_is_installed_is_listed_and_the_list_is_valid() -> None:
    def asked(command: list[str]) -> str:
        here = [sys.executable if word == "python3" else word for word in command]
        return subprocess.check_output(here, text=True)

    found = inventory(asked)
    # The check against the schema takes its time: a few of the packages do.
    found["debian"] = [line for line in found["debian"] if line.startswith("installed libc")][:9]
    parts = _read(sbom(IMAGE, found))["components"]
    purls = [PackageURL.from_string(part["purl"]) for part in parts]
    named = {(purl.type, purl.name, purl.version) for purl in purls}
    assert {("pypi", name, version(name)) for name in ("primfit", "numpy", "scipy")} <= named
    assert found["debian"]
    assert {("deb", *line.split()[1:3]) for line in found["debian"]} <= named


def test_parts_depend_on_what_they_need_and_nothing_is_told_that_is_not_there() -> None:
    made = _read(sbom(IMAGE, SMALL))
    of = {entry["ref"]: entry.get("dependsOn", []) for entry in made["dependencies"]}
    libc = "pkg:deb/debian/libc6@2.36-9%2Bdeb12u10?arch=amd64&distro=debian-12"
    assert set(of[IMAGE]) == {"pkg:pypi/primfit@0.2.0", "pkg:generic/python@3.11.2", libc}
    assert of["pkg:pypi/primfit@0.2.0"] == ["pkg:pypi/read-er@1.0"]
    assert of["pkg:pypi/read-er@1.0"] == ["pkg:pypi/quick@2"]
    assert {part["bom-ref"] for part in made["components"]} | {IMAGE} == set(of)
    licenses = {part["name"]: part.get("licenses") for part in made["components"]}
    assert licenses["quick"] == [{"expression": "MIT"}] and licenses["odd"] is None


def test_the_whole_is_the_image() -> None:
    whole = _read(sbom(IMAGE, SMALL))["metadata"]["component"]
    assert (whole["type"], whole["name"], whole["version"]) == ("container", "primfit", "0.2.0")


def test_the_tool_is_not_in_the_image() -> None:
    assert not any("cyclonedx" in text for text in PROJECT["project"]["dependencies"])
