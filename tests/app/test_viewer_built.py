"""What is shipped of the viewer is what its sources make, and it computes what primfit computes."""

import json
from functools import partial

import numpy as np
import pytest

from primfit.fitting.primitives import PRIMITIVES
from tests.app import npm
from tests.paths import ROOT

SOURCE = ROOT / "app" / "viewer"
pytestmark = [pytest.mark.node, npm.needs_node]
_succeed = partial(npm.succeed, npm.VIEWER)
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


def test_the_built_files_are_those_of_the_sources(viewer_sources: None) -> None:
    """After a change: make viewer."""
    _succeed("npm", "run", "build", "--", "anew")
    anew = npm.VIEWER / "anew"
    shipped = {path.name: path.read_bytes() for path in (SOURCE / "built").iterdir()}
    assert {path.name: path.read_bytes() for path in anew.iterdir()} == shipped


def test_the_sources_agree_with_the_document(viewer_sources: None) -> None:
    _succeed("npm", "run", "types")
    _succeed("npm", "run", "check")


def test_distances_are_those_of_primfit(viewer_sources: None) -> None:
    points = np.random.default_rng(3).normal(2.0, 3.0, (200, 3))
    (npm.VIEWER / "asked.json").write_text(json.dumps({"surfaces": SURFACES, "points": points.tolist()}))
    (npm.VIEWER / "asked.mjs").write_text(ASKED)
    for surface, found in zip(SURFACES, json.loads(_succeed("node", "asked.mjs")), strict=True):
        values = {
            name: np.array(value) if isinstance(value, list) else value for name, value in surface.items()
        }
        primitive = PRIMITIVES[values.pop("kind")](**values)
        np.testing.assert_allclose(found, primitive.signed_distance(points), rtol=0, atol=1e-12)


def test_the_lock_file_names_no_registry() -> None:
    assert '"resolved"' not in (SOURCE / "package-lock.json").read_text()
