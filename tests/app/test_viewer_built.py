"""What is shipped of the viewer is what its sources make, and it computes what primfit computes."""

import json
import shutil
from functools import partial

import numpy as np
import pytest

from primfit.fitting.primitives import PRIMITIVES
from tests.app import npm
from tests.paths import DOCS, ROOT

SOURCE = ROOT / "app" / "viewer"
# node_modules stay here from one run to the next.
BUILD = ROOT / "build" / "viewer"

pytestmark = [pytest.mark.node, npm.needs_node]
_succeed = partial(npm.succeed, BUILD / "app" / "viewer")
SURFACES = [
    {"kind": "plane", "normal": [0.6, 0.0, 0.8], "point": [1.0, 2.0, 3.0]},
    {"kind": "sphere", "center": [1.0, 2.0, 3.0], "radius": 2.5},
    {"kind": "cylinder", "axis": [0.6, 0.0, 0.8], "point": [1.0, 2.0, 3.0], "radius": 1.5},
    {"kind": "cone", "apex": [1.0, 2.0, 3.0], "axis": [0.6, 0.0, 0.8], "half_angle": 0.4},
    {
        "kind": "torus",
        "center": [1.0, 2.0, 3.0],
        "axis": [0.6, 0.0, 0.8],
        "major_radius": 3.0,
        "minor_radius": 1.0,
    },
]
ASKED = """
import { build } from "esbuild";
import { readFileSync } from "node:fs";
await build({ entryPoints: ["src/geometry/kinds.ts"], bundle: true, format: "esm", outfile: "kinds.mjs" });
const { distanceTo } = await import("./kinds.mjs");
const { surfaces, points } = JSON.parse(readFileSync("asked.json"));
console.log(JSON.stringify(surfaces.map((each) => points.map((point) => distanceTo(each)(...point)))));
"""


@pytest.fixture(scope="module")
def sources() -> None:
    """The sources with the packages of their lock file, in a folder of their own."""
    here = BUILD / "app" / "viewer"
    shutil.rmtree(here / "src", ignore_errors=True)
    shutil.copytree(SOURCE / "src", here / "src", dirs_exist_ok=True)
    for path in SOURCE.iterdir():
        if path.is_file():
            shutil.copy(path, here)
    (BUILD / "docs").mkdir(exist_ok=True)
    shutil.copy(DOCS / "openapi.json", BUILD / "docs")
    npm.installed(here, (SOURCE / "package-lock.json").read_text())


def test_the_built_files_are_those_of_the_sources(sources: None) -> None:
    """After a change: make viewer."""
    _succeed("npm", "run", "build", "--", "anew")
    anew = BUILD / "app" / "viewer" / "anew"
    shipped = {path.name: path.read_bytes() for path in (SOURCE / "built").iterdir()}
    assert {path.name: path.read_bytes() for path in anew.iterdir()} == shipped


def test_the_sources_agree_with_the_document(sources: None) -> None:
    _succeed("npm", "run", "types")
    _succeed("npm", "run", "check")


def test_distances_are_those_of_primfit(sources: None) -> None:
    points = np.random.default_rng(3).normal(2.0, 3.0, (200, 3))
    here = BUILD / "app" / "viewer"
    (here / "asked.json").write_text(json.dumps({"surfaces": SURFACES, "points": points.tolist()}))
    (here / "asked.mjs").write_text(ASKED)
    for surface, found in zip(SURFACES, json.loads(_succeed("node", "asked.mjs")), strict=True):
        values = {
            name: np.array(value) if isinstance(value, list) else value for name, value in surface.items()
        }
        primitive = PRIMITIVES[values.pop("kind")](**values)
        np.testing.assert_allclose(found, primitive.signed_distance(points), rtol=0, atol=1e-12)


def test_the_lock_file_names_no_registry() -> None:
    assert '"resolved"' not in (SOURCE / "package-lock.json").read_text()
