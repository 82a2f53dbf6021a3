"""What schemathesis cannot make up from a schema: points that are a cloud, and files that hold one."""

import io
import json
from typing import Any

import numpy as np
import schemathesis
from hypothesis import strategies as st

from primfit.app.service.media_types import RAW_TYPES
from primfit.app.wire.options import OBJECTS
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.sphere import Sphere


def _cloud(seed: int) -> np.ndarray:
    """3 to 60 points of a sphere or a cylinder, exact or with noise, at any scale and place."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 61))
    if seed % 2:
        points = Sphere(np.zeros(3), 1.0).surface(rng.uniform(0, 6, n), rng.uniform(0, 3, n))
    else:
        cylinder = Cylinder(np.array([0.0, 0.6, 0.8]), np.zeros(3), 1.0)
        points = cylinder.surface(rng.uniform(0, 6, n), rng.uniform(-2, 2, n))
    points = points + rng.normal(0, rng.choice([0.0, 1e-3, 1e-2]), (n, 3))
    return np.asarray(points * 10.0 ** rng.uniform(-6, 6) + rng.normal(0, 10.0 ** rng.uniform(-6, 6), 3))


def _csv(points: np.ndarray) -> bytes:
    return b"x,y,z\n" + b"".join(b"%r,%r,%r\n" % tuple(row) for row in points.tolist())


def _npy(points: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def _ply(points: np.ndarray) -> bytes:
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {name}\n" for name in "xyz") + "end_header\n"
    return header.encode() + points.astype("<f8").tobytes()


CLOUDS = st.builds(_cloud, st.integers(0, 2**32))
FILES = st.builds(lambda write, points: write(points), st.sampled_from((_csv, _npy, _ply)), CLOUDS)
BODIES = st.one_of(FILES, FILES, st.binary(max_size=200), st.text(max_size=200).map(str.encode))

schemathesis.openapi.format("binary", BODIES)


@schemathesis.serializer(*RAW_TYPES)
def raw(context: Any, body: Any) -> dict[str, bytes]:
    """Bytes as they are, and the text of an example."""
    return {"data": body if isinstance(body, bytes) else str(body).encode()}


@schemathesis.hook
def before_call(context: Any, case: Any, kwargs: dict[str, Any]) -> None:
    """Points as the schema has them hardly ever are a cloud: in half of the requests they become one."""
    positive = case.meta is not None and case.meta.generation.mode is schemathesis.GenerationMode.POSITIVE
    if positive and case.media_type == "application/json" and len(json.dumps(case.body)) % 2:
        for request in case.body if isinstance(case.body, list) else [case.body]:
            if "points" in request:
                request["points"] = _cloud(len(json.dumps(request))).tolist()


@schemathesis.hook
def filter_case(context: Any, case: Any) -> bool:
    """No bodies whose only fault would be a null that the schema allows: it is taken for a wrong object."""
    negative = case.meta is not None and case.meta.generation.mode is schemathesis.GenerationMode.NEGATIVE
    options = case.body.get("options") if isinstance(case.body, dict) else None
    null = isinstance(options, dict) and None in (options.get(name, 0) for name in OBJECTS)
    return not (negative and null)
