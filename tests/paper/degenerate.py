"""Three hundred clouds that determine little: few points, flat, thin, repeated, huge, tiny, far off."""

from collections.abc import Iterator

import numpy as np

from primfit.fitting.geometry.vectors import Array

SCALES = (1.0, 1e-290, 1e-12, 1e9, 1e99, 1e290)
OFFSETS = (0.0, 1e7)
"""In sizes of the cloud."""


def shapes() -> Iterator[tuple[str, Array]]:
    """Twenty-five of them, of size 1, by name."""
    rng = np.random.default_rng(0)
    for count in (0, 1, 2, 3, 4, 5, 7):
        yield f"{count} points", rng.normal(size=(count, 3))
    line = np.linspace(-1.0, 1.0, 40)
    nothing = np.zeros(40)
    yield "one place", np.ones((40, 3))
    yield "two places", np.repeat(rng.normal(size=(2, 3)), 20, axis=0)
    yield "three places", np.repeat(rng.normal(size=(3, 3)), 20, axis=0)
    yield "line along x", np.column_stack([line, nothing, nothing])
    yield "line", np.outer(line, [1.0, 2.0, 3.0])
    yield "line and a point", np.vstack([np.outer(line, [1.0, 2.0, 3.0]), [[1.0, 0.0, 0.0]]])
    yield "nearly a line", np.outer(line, [1.0, 2.0, 3.0]) + 1e-9 * rng.normal(size=(40, 3))
    yield "two lines", np.vstack([np.outer(line, [1.0, 0.0, 0.0]), np.outer(line, [0.0, 1.0, 0.0])])
    yield "cross in space", np.vstack([np.outer(line, row) for row in np.eye(3)])
    grid = np.stack(np.meshgrid(line[::4], line[::4]), axis=-1).reshape(-1, 2)
    yield "flat grid", np.column_stack([grid, np.zeros(len(grid))])
    yield "nearly flat", np.column_stack([grid, 1e-12 * rng.normal(size=len(grid))])
    yield "flat with a spike", np.vstack([np.column_stack([grid, np.zeros(len(grid))]), [[0.0, 0.0, 50.0]]])
    turn = 3.0 * line
    yield "circle", np.column_stack([np.cos(turn), np.sin(turn), nothing])
    yield (
        "two circles",
        np.vstack([np.column_stack([np.cos(turn), np.sin(turn), nothing + height]) for height in (0.0, 1.0)]),
    )
    yield "cube corners", np.stack(np.meshgrid(*[[0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    yield "ball", rng.normal(size=(200, 3))
    yield "two clumps", np.vstack([1e-6 * rng.normal(size=(30, 3)), 1.0 + 1e-6 * rng.normal(size=(30, 3))])
    yield "one far off", np.vstack([rng.normal(size=(60, 3)), [[1e6, 0.0, 0.0]]])


DEGENERATE: dict[str, Array] = {
    f"{name}, scale {scale:g}, offset {offset:g}": scale * (points + offset)
    for name, points in shapes()
    for scale in SCALES
    for offset in OFFSETS
}
