"""An independent oracle: each signed distance written again in torch, with the Jacobian from autograd.

The formulas here are not those of `fitting.primitives`: distances to an axis come from cross products, the
cone from the closest point of its profile ray, the torus from the closest point of its center circle, and an
axis is tilted by adding to it and normalizing, which has the same derivative at zero as turning it.
"""

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import basis
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.solver.refine import linearize, stepped

torch = pytest.importorskip("torch", reason="needs torch: make test-torch")
pytestmark = pytest.mark.torch

# Float64 round-off of a few operations on numbers of size 10, with the division by small distances.
TOLERANCE = 1e-11

Tensor = Any
Oracle = Callable[[Any, Callable[[Any], Tensor], Tensor, Tensor], Tensor]


def plane(given: Plane, tensor: Callable[[Any], Tensor], step: Tensor, x: Tensor) -> Tensor:
    normal, *across = _frame(given.normal, tensor)
    foot = (normal @ tensor(given.point) + step[2]) * normal
    return (x - foot) @ _tilted(normal, across, step)


def sphere(given: Sphere, tensor: Callable[[Any], Tensor], step: Tensor, x: Tensor) -> Tensor:
    return torch.linalg.norm(x - (tensor(given.center) + step[:3]), dim=1) - (given.radius + step[3])


def cylinder(given: Cylinder, tensor: Callable[[Any], Tensor], step: Tensor, x: Tensor) -> Tensor:
    axis, *across = _frame(given.axis, tensor)
    foot = _foot(tensor(given.point), axis) + step[2] * across[0] + step[3] * across[1]
    return _from_axis(x - foot, _tilted(axis, across, step)) - (given.radius + step[4])


def cone(given: Cone, tensor: Callable[[Any], Tensor], step: Tensor, x: Tensor) -> Tensor:
    axis, *across = _frame(given.axis, tensor)
    foot = _foot(tensor(given.apex), axis) + step[2] * across[0] + step[3] * across[1]
    below = (foot - tensor(given.apex)) @ axis * np.sin(given.half_angle)
    angle = given.half_angle + step[4]
    axis = _tilted(axis, across, step)
    relative = x - (foot - (below + step[5]) / torch.sin(angle) * axis)
    profile = torch.stack([relative @ axis, _from_axis(relative, axis)], dim=1)
    ray = torch.stack([torch.cos(angle), torch.sin(angle)])
    along = torch.clamp(profile @ ray, min=0.0)
    outside = (profile[:, 1] * ray[0] > profile[:, 0] * ray[1]) | (along == 0.0)
    return torch.where(outside, 1.0, -1.0) * torch.linalg.norm(profile - along[:, None] * ray, dim=1)


def torus(given: Torus, tensor: Callable[[Any], Tensor], step: Tensor, x: Tensor) -> Tensor:
    axis, *across = _frame(given.axis, tensor)
    center = tensor(given.center) + step[2] * across[0] + step[3] * across[1] + step[4] * axis
    axis = _tilted(axis, across, step)
    relative = x - center
    radial = relative - torch.outer(relative @ axis, axis)
    circle = (given.major_radius + step[5]) * radial / torch.linalg.norm(radial, dim=1)[:, None]
    return torch.linalg.norm(relative - circle, dim=1) - (given.minor_radius + step[6])


ORACLES: dict[str, Oracle] = {
    "plane": plane,
    "sphere": sphere,
    "cylinder": cylinder,
    "cone": cone,
    "torus": torus,
}


def _frame(axis: Any, tensor: Callable[[Any], Tensor]) -> list[Tensor]:
    """The axis and the two directions that its minimal coordinates refer to."""
    return [tensor(axis), *(tensor(direction) for direction in basis(axis))]


def _tilted(axis: Tensor, across: list[Tensor], step: Tensor) -> Tensor:
    moved = axis + step[0] * across[0] + step[1] * across[1]
    return moved / torch.linalg.norm(moved)


def _foot(point: Tensor, axis: Tensor) -> Tensor:
    """The point of the line closest to the origin."""
    return torch.linalg.cross(axis, torch.linalg.cross(point, axis))


def _from_axis(relative: Tensor, axis: Tensor) -> Tensor:
    return torch.linalg.norm(torch.linalg.cross(relative, axis.expand_as(relative)), dim=1)


def _examples(kind: str) -> list[Primitive]:
    """Ten poses and sizes, among them a thin cone, a spindle torus and axes along the coordinates."""
    rng = np.random.default_rng([11, KINDS.index(kind)])
    fixed = {"cone": {"half_angle": 0.01}, "torus": {"major_radius": 0.7, "minor_radius": 1.0}}
    examples = []
    for i in range(10):
        direction = np.eye(3)[i % 3] * (-1.0) ** i if i < 6 else rng.normal(size=3)
        values = {
            "normal": direction,
            "axis": direction,
            "point": rng.normal(size=3),
            "center": rng.normal(size=3),
            "apex": 2.0 * rng.normal(size=3),
            "radius": rng.uniform(0.5, 4.0),
            "half_angle": rng.uniform(0.2, 1.4),
            "major_radius": rng.uniform(2.0, 4.0),
            "minor_radius": rng.uniform(0.2, 1.9),
            **(fixed.get(kind, {}) if i == 9 else {}),
        }
        names = [field.name for field in fields(PRIMITIVES[kind])]  # type: ignore[arg-type]
        examples.append(PRIMITIVES[kind](**{name: values[name] for name in names}))
    return examples


@pytest.fixture(params=["cpu", "cuda"])
def tensor(request: pytest.FixtureRequest) -> Callable[[Any], Tensor]:
    """Float64 tensors on the processor and, where there is one, on a GPU."""
    if request.param == "cuda" and not torch.cuda.is_available():
        pytest.skip("no CUDA device here")
    return lambda values: torch.tensor(np.array(values), dtype=torch.float64, device=request.param)


@pytest.mark.parametrize("kind", KINDS)
def test_signed_distance(kind: str, tensor: Callable[[Any], Tensor]) -> None:
    points = np.random.default_rng(7).normal(scale=3.0, size=(400, 3))
    for primitive in _examples(kind):
        step = tensor(np.zeros(primitive.dof))
        expected = ORACLES[kind](primitive, tensor, step, tensor(points)).cpu().numpy()
        np.testing.assert_allclose(primitive.signed_distance(points), expected, atol=TOLERANCE)
        np.testing.assert_allclose(linearize(primitive, points)[0], expected, atol=TOLERANCE)


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian(kind: str, tensor: Callable[[Any], Tensor]) -> None:
    points = np.random.default_rng(8).normal(scale=3.0, size=(400, 3))
    for primitive in _examples(kind):
        expected = (
            torch.autograd.functional.jacobian(
                lambda step, given=primitive: ORACLES[kind](given, tensor, step, tensor(points)),
                tensor(np.zeros(primitive.dof)),
            )
            .cpu()
            .numpy()
        )
        _, jacobian = linearize(primitive, points)
        scale = np.maximum(1.0, np.abs(expected))
        np.testing.assert_allclose(jacobian / scale, expected / scale, atol=TOLERANCE)


@pytest.mark.parametrize("kind", KINDS)
def test_steps_move_along_the_jacobian(kind: str, tensor: Callable[[Any], Tensor]) -> None:
    """A finite step, taken by both: turning and normalizing differ in second order only."""
    rng = np.random.default_rng(9)
    points = rng.normal(scale=3.0, size=(100, 3))
    for primitive in _examples(kind):
        if kind == "cone" and primitive.half_angle < 0.1:  # type: ignore[attr-defined]
            continue  # an offset of 1e-5 moves the apex of a thin cone far: second order is no longer small
        step = rng.normal(scale=1e-5, size=primitive.dof)
        moved = ORACLES[kind](primitive, tensor, tensor(step), tensor(points)).cpu().numpy()
        np.testing.assert_allclose(stepped(primitive, step).signed_distance(points), moved, atol=1e-7)
