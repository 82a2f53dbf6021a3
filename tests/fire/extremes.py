"""What the largest and the worst clouds cost: the figures behind limits by criterion and memory.

`python -m tests.fire.extremes` fits spheres, tori, cubes and planes, with noise and without, by each extreme
criterion with all kinds allowed, and tells the seconds of the processor beside those that the limit of the
criterion allows for so many points; before, the address space that a fit of five million points takes.
"""

import argparse
from pathlib import Path
from time import process_time

import numpy as np

from primfit import fit
from primfit.app.service.budgets import POINTS_A_SECOND
from tests.fire.report import Report, reported

NOISE = 0.01
MIB = 2**20
_SIZES = Path("/proc/self/status")


def clouds(n: int) -> dict[str, np.ndarray]:
    """Clouds (n, 3) of some units, by their names."""
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(n, 3))
    first, second = rng.uniform(0.0, 2.0 * np.pi, (2, n))
    distance = 2.0 + 0.5 * np.cos(second)
    clean = {
        "sphere": ball / np.linalg.norm(ball, axis=1, keepdims=True),
        "torus": np.column_stack([distance * np.cos(first), distance * np.sin(first), 0.5 * np.sin(second)]),
        "plane": np.column_stack([*rng.uniform(-1.0, 1.0, (2, n)), np.zeros(n)]),
    }
    noisy = {f"noisy {name}": points + rng.normal(0.0, NOISE, (n, 3)) for name, points in clean.items()}
    return {**clean, **noisy, "cube": rng.uniform(size=(n, 3))}


def paces(figures: Report, n: int) -> None:
    """The processor's seconds of each criterion and cloud, and the worst of each beside what is allowed."""
    for criterion, allowed in POINTS_A_SECOND.items():
        worst = 0.0
        for name, points in clouds(n).items():
            started = process_time()
            fit(points, criterion=criterion)
            seconds = process_time() - started
            figures.note(f"{criterion}, {name}", seconds, "s")
            worst = max(worst, seconds)
        figures.at_most(f"{criterion}, the worst", worst, n / allowed, "s")


def memory(figures: Report, n: int) -> None:
    """The most address space that the fit of a cylinder takes beyond what there was."""
    rng = np.random.default_rng(1)
    azimuth, height = rng.uniform(0.0, 5.0, (2, n))
    points = np.column_stack([np.cos(azimuth), np.sin(azimuth), height]) + rng.normal(0.0, 1e-3, (n, 3))
    before = _address_space("VmSize")
    fit(points)
    figures.note(f"fit of {n} points", (_address_space("VmPeak") - before) / MIB, "MiB")


def _address_space(name: str) -> int:
    line = next(line for line in _SIZES.read_text().splitlines() if line.startswith(name))
    return 1024 * int(line.split()[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    given = parser.parse_args()
    with reported("extremes") as figures:
        memory(figures, 5_000_000)
        paces(figures, given.points)


if __name__ == "__main__":
    main()
