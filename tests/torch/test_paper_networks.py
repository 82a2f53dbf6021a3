"""Networks of the paper's methods against other ways to compute what they compute."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch: make test-torch")
pytestmark = pytest.mark.torch

from torch.nn import functional

from primfit.fitting.names import KINDS
from primfit.fitting.primitives import values_of
from primfit.paper.parts import losses, views, voxels
from primfit.paper.parts.numbers import DIRECTION, LAYOUT, ROW, from_numbers, to_numbers
from primfit.paper.parts.pointnet import AlignmentNet, PointNet, unlike_rotations
from primfit.paper.parts.voxels import Convolution, Grid, VoxelNet, voxelized
from primfit.paper.training.batches import mirrored, rotations, turned_numbers
from tests.fitting.clouds import EXAMPLES

RNG = np.random.default_rng(5)


def cloud(count: int = 2, size: int = 300) -> torch.Tensor:
    points = np.random.default_rng(6).normal(size=(count, size, 3))
    return torch.from_numpy((points / np.linalg.norm(points, axis=2).max()).astype(np.float32))


def pairs(count: int = 4) -> tuple[torch.Tensor, torch.Tensor]:
    """Predictions of any length, and truth with unit directions."""
    found, truth = RNG.normal(size=(2, count, ROW))
    truth[:, DIRECTION] /= np.linalg.norm(truth[:, DIRECTION], axis=1, keepdims=True)
    return torch.from_numpy(found).requires_grad_(), torch.from_numpy(truth)


def by_hand(method: str, kind: str, found: np.ndarray, truth: np.ndarray) -> float:
    """A loss of one pair of rows, from the paper's formulas."""
    a, b = found[:3], truth[:3]
    cosine = a @ b / np.linalg.norm(a)
    if method == "m3":
        turned = b if cosine > 0.0 or kind == "cone" else -b
        axis = 1.0 - cosine**8 + np.sum((a - turned) ** 2)
    else:
        axis = 1.0 - cosine**2
    offset = found[3:6] - truth[3:6]
    if method == "m4" and kind == "cylinder":
        offset = np.cross(offset, b)
    sizes = {"plane": 0, "sphere": 1, "cylinder": 1, "cone": 1, "torus": 2}[kind]
    squares = np.sum((found[6:] - truth[6:])[:sizes] ** 2)
    return float(np.linalg.norm(offset) + squares + (0.0 if kind == "sphere" else axis))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("method", ["m3", "m4"])
def test_losses_are_the_formulas_and_so_are_their_gradients(method: str, kind: str) -> None:
    found, truth = pairs()
    loss = {"m3": losses.m3_loss, "m4": losses.m4_loss}[method]
    rows = zip(found.detach().numpy(), truth.numpy(), strict=True)
    expected = np.mean([by_hand(method, kind, *row) for row in rows])
    assert loss(kind, found, truth).item() == pytest.approx(expected, rel=1e-12)
    assert torch.autograd.gradcheck(lambda rows: loss(kind, rows, truth), found)


def test_an_axis_and_its_opposite_are_one_but_for_a_cone() -> None:
    found, truth = pairs()
    opposite = truth * torch.tensor([-1.0] * 3 + [1.0] * 5)
    for loss, kind, same in (
        (losses.m3_loss, "torus", True),
        (losses.m4_loss, "torus", True),
        (losses.m4_loss, "cone", True),
        (losses.m3_loss, "cone", False),
    ):
        of_both = [loss(kind, found, axis).item() for axis in (truth, opposite)]
        assert (of_both[0] == pytest.approx(of_both[1])) == same


@pytest.mark.parametrize("kind", KINDS)
def test_a_primitive_is_its_numbers_wherever_it_is_turned(kind: str) -> None:
    example = EXAMPLES[kind].canonical(np.zeros(3))
    numbers = to_numbers(example)
    apart = np.abs(values_of(from_numbers(kind, numbers))) - np.abs(values_of(example))
    np.testing.assert_allclose(apart, 0.0, atol=1e-12)
    turn = rotations(1, "xyz", np.random.default_rng(1))
    np.testing.assert_allclose(turn[0] @ turn[0].T, np.eye(3), atol=1e-6)
    turned = turned_numbers(torch.from_numpy(numbers[None].astype(np.float32)), torch.from_numpy(turn))
    expected = to_numbers(example.transformed(turn[0].astype(float), np.zeros(3), 1.0))
    assert float(losses.m4_loss(kind, turned.double(), torch.from_numpy(expected[None]))) < 1e-4


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("row", [np.zeros(ROW), np.full(ROW, -1e30), np.full(ROW, 1e-30)])
def test_any_numbers_are_a_primitive(kind: str, row: np.ndarray) -> None:
    found = from_numbers(kind, row)
    assert np.isfinite(values_of(found)).all()
    assert all(getattr(found, name) > 0.0 for name in LAYOUT[kind][2])


def dense(features: torch.Tensor, grid: Grid) -> torch.Tensor:
    """Features on all cells of a grid, (B, C, S, S, S)."""
    result = torch.zeros(grid.clouds, *[grid.side] * 3, features.shape[1])
    result[tuple(grid.cells.T)] = features
    return result.permute(0, 4, 1, 2, 3)


@pytest.mark.parametrize("stride", [1, 2])
def test_a_convolution_of_occupied_cells_is_one_of_the_whole_grid(stride: int) -> None:
    torch.manual_seed(2)
    grid, means = voxelized(cloud())
    out = None if stride == 1 else grid.coarser()[0]
    layer = Convolution(3, 4)
    layer.after = torch.nn.Identity()
    means.requires_grad_()
    found = layer(means, grid.pairs(out))
    kernel = layer.weights.permute(2, 1, 0).reshape(4, 3, 3, 3, 3)
    whole = functional.conv3d(dense(means, grid), kernel, stride=stride, padding=1)
    places = tuple((out or grid).cells.T)
    expected = whole.permute(0, 2, 3, 4, 1)[places]
    torch.testing.assert_close(found, expected, atol=1e-5, rtol=1e-4)
    slopes = [gradients(each, means, layer.weights) for each in (found, expected)]
    torch.testing.assert_close(*slopes, atol=1e-4, rtol=1e-3)


def gradients(result: torch.Tensor, *of: torch.Tensor) -> tuple[torch.Tensor, ...]:
    return torch.autograd.grad(result.square().sum(), of, retain_graph=True)


def test_cells_hold_the_mean_of_their_points_and_are_found_again() -> None:
    points = cloud()
    grid, means = voxelized(points)
    for row in (0, 17, len(means) - 1):
        number, *place = grid.cells[row].tolist()
        inside = ((points[number] + 1.0) / voxels.CELL).floor() == torch.tensor(place)
        torch.testing.assert_close(means[row], points[number][inside.all(dim=1)].mean(dim=0))
    assert torch.equal(grid.neighbors()[:, 13], torch.arange(len(means)))
    grids, parents = voxels.pyramid(grid, 2)
    assert torch.equal(grids[2].cells[parents[1]][:, 1:], grid.cells[:, 1:] // 4)


def test_pooling_is_by_cloud() -> None:
    grid, means = voxelized(cloud())
    found = voxels.pooled(means, grid)
    for number in range(2):
        mine = means[grid.cells[:, 0] == number]
        torch.testing.assert_close(found[number], torch.cat([mine.amax(dim=0), mine.mean(dim=0)]))


@pytest.mark.parametrize("network", [PointNet(5), VoxelNet(5)])
def test_the_order_of_points_and_other_clouds_do_not_matter(network: torch.nn.Module) -> None:
    points = cloud()
    network.eval()
    with torch.no_grad():
        together, alone = network(points), network(points[1:].flip(1))
    torch.testing.assert_close(together[1:], alone, atol=1e-5, rtol=1e-4)


def test_alignment_begins_with_nothing_turned() -> None:
    matrices = AlignmentNet(3, (8, 16)).eval()(cloud())
    torch.testing.assert_close(matrices, torch.eye(3).expand(2, 3, 3))
    assert float(unlike_rotations(matrices).detach()) == 0.0
    assert float(unlike_rotations(2.0 * torch.eye(3)[None])) == pytest.approx(27.0)


def test_a_view_counts_points_and_says_their_depth() -> None:
    points = torch.tensor([[[0.01, 0.51, 0.2], [0.01, 0.51, 0.4], [-0.99, -0.99, -0.5]]])
    bright, depth = views.view(points, 2)[0]
    place = int(1.01 * views.PIXELS / 2), int(1.51 * views.PIXELS / 2)
    assert float(bright[place]) == 1.0
    assert float(bright[0, 0]) == pytest.approx(np.log(2) / np.log(3))
    assert float(depth[place]) == pytest.approx(0.3)
    assert int(torch.count_nonzero(bright)) == 2


@pytest.mark.parametrize("axis", range(3))
def test_a_mirrored_picture_is_one_of_a_mirrored_cloud(axis: int) -> None:
    points = cloud()
    other = points.clone()
    other[..., axis] *= -1.0
    pictures = [torch.cat([views.view(each, k) for k in range(3)], dim=1) for each in (points, other)]
    torch.testing.assert_close(mirrored(pictures[0], axis), pictures[1])


def test_pictures_do_not_depend_on_the_pose() -> None:
    points = cloud(1, 2000) * torch.tensor([0.3, 0.6, 0.9])
    turn = torch.from_numpy(rotations(1, "xyz", np.random.default_rng(3)))
    before, after = (views.principal_views(each) for each in (points, points @ turn.transpose(1, 2)))
    assert float((before - after).abs().mean()) < 1e-3
