"""Train the network:  python -m primfit.models.training.network --seed 2022

The same seed and sizes give the same bytes on one machine and set of packages. Training uses clouds of
`seed`, calibration clouds of `seed + 2`, and the card's figures clouds of `seed + 1`.
"""

import argparse
import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from primfit.fitting.cloud.cloud import NORMAL_POINTS

from ..features import BLOCKS
from ..network import CLIP, NetworkClassifier, softmax
from ..rough import KINDS
from ..weights import DIRECTORY, Card, save
from .dataset import HELD_BACK_CLOUDS, SEED, TRAINING_CLOUDS, Dataset, make_dataset, numbers, option
from .metrics import calibration_error, metrics, rank_of_truth

Array = NDArray[np.float64]

CALIBRATION_CLOUDS = 750
"""A family, beside those of `models.training.dataset`."""
WIDTHS = (128, 64)
EPOCHS = 40
BATCH = 128
LEARNING_RATE = 4e-3
WEIGHT_DECAY = 2e-2
DROPOUT = 0.2
NOISE = 0.1
"""Standard deviation of the noise that training adds to the standardized features."""
TEMPERATURES = np.geomspace(0.3, 5.0, 200)

Curves = list[dict[str, float]]


def network(inputs: int, widths: tuple[int, ...] = WIDTHS) -> nn.Sequential:
    """Fully connected layers with ReLU and dropout between them."""
    layers: list[nn.Module] = []
    for width in widths:
        layers += [nn.Linear(inputs, width), nn.ReLU(), nn.Dropout(DROPOUT)]
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, len(KINDS)))


def fit(
    model: nn.Module,
    inputs: torch.Tensor,
    labels: NDArray[np.int64],
    validation: tuple[torch.Tensor, NDArray[np.int64]],
    epochs: int,
    augment: Callable[[torch.Tensor], torch.Tensor] = lambda batch: batch,
) -> Curves:
    """Cross-entropy by AdamW under one cosine cycle; returns a row of the learning curves an epoch."""
    targets = torch.from_numpy(labels)
    steps = max(1, len(labels) // BATCH)
    optimizer = torch.optim.AdamW(model.parameters(), LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=epochs * steps)
    curves: Curves = []
    for epoch in range(epochs):
        model.train()
        order = torch.randperm(len(labels))
        loss_sum = 0.0
        for step in range(steps):
            chosen = order[step * BATCH : (step + 1) * BATCH]
            loss = nn.functional.cross_entropy(model(augment(inputs[chosen])), targets[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            loss_sum += float(loss.detach())
        logits = predict(model, validation[0])
        likelihood = np.log(softmax(logits)[np.arange(len(logits)), validation[1]])
        top1 = float(np.mean(rank_of_truth(logits, validation[1]) == 0))
        row = {"epoch": epoch + 1, "loss": loss_sum / steps, "validation_loss": -float(likelihood.mean())}
        curves.append({**row, "validation_top1": top1})
    return curves


def predict(model: nn.Module, inputs: torch.Tensor) -> Array:
    """Logits (M, 5)."""
    model.eval()
    with torch.no_grad():
        return torch.cat([model(part) for part in inputs.split(500)]).double().numpy()


def temperature(logits: Array, labels: NDArray[np.int64]) -> float:
    """The temperature at which the likelihood of the labels is highest."""
    rows = np.arange(len(labels))
    losses = [-np.log(softmax(logits / t)[rows, labels] + 1e-12).mean() for t in TEMPERATURES]
    return float(TEMPERATURES[int(np.argmin(losses))])


def build(
    data: Dataset, validation: Dataset, seed: int, epochs: int
) -> tuple[dict[str, NDArray[Any]], Curves, nn.Module]:
    """Arrays of a `NetworkClassifier` with its temperature, learning curves, and the trained module."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    mean, scale = data.rows.mean(axis=0), data.rows.std(axis=0)
    scale = np.where(scale > 1e-6, scale, 1.0)
    arrays: dict[str, NDArray[Any]] = {"mean": mean.astype(np.float32), "scale": scale.astype(np.float32)}
    model = network(data.rows.shape[1])

    def noisy(batch: torch.Tensor) -> torch.Tensor:
        return batch + NOISE * torch.randn_like(batch)

    known = (standardized(validation.rows, arrays), validation.labels)
    curves = fit(model, standardized(data.rows, arrays), data.labels, known, epochs, noisy)
    linear = [layer for layer in model if isinstance(layer, nn.Linear)]
    for index, layer in enumerate(linear):
        arrays[f"weight{index}"] = layer.weight.detach().numpy().copy()
        arrays[f"bias{index}"] = layer.bias.detach().numpy().copy()
    arrays["temperature"] = np.array([temperature(predict(model, known[0]), known[1])], np.float32)
    return arrays, curves, model


def standardized(rows: Array, arrays: dict[str, NDArray[Any]]) -> torch.Tensor:
    """Features as the network takes them."""
    values = np.clip((rows - arrays["mean"]) / arrays["scale"], -CLIP, CLIP)
    return torch.from_numpy(values.astype(np.float32))


def train(
    seed: int,
    clouds: Mapping[str, int],
    held_back: int,
    calibration: int,
    directory: Path,
    epochs: int = EPOCHS,
    processes: int = 1,
    cache: Path | None = None,
) -> tuple[Card, Curves]:
    """Train, calibrate, score and write the weights with their card."""
    data = make_dataset(seed, clouds, processes=processes, cache=cache)
    validation = make_dataset(seed + 2, calibration, processes=processes, cache=cache)
    test = make_dataset(seed + 1, held_back, processes=processes, cache=cache)
    arrays, curves, _ = build(data, validation, seed, epochs)
    served = NetworkClassifier(arrays)
    scores: dict[str, Any] = metrics(served.probabilities(test.rows), test)
    raw = softmax(served.logits(test.rows))
    for family in scores:
        chosen = test.families == family
        before = calibration_error(raw[chosen], test.labels[chosen])
        scores[family]["calibration_error_before"] = round(before, 4)
    recipe = {
        "command": f"python -m primfit.models.training.network --seed {seed} --clouds {option(clouds)} "
        f"--held-back {held_back} --calibration {calibration} --epochs {epochs}",
        "clouds": dict(clouds),
        "held_back_seed": seed + 1,
        "calibration_seed": seed + 2,
        "seen_points": NORMAL_POINTS,
        "feature_blocks": BLOCKS,
        "widths": list(WIDTHS),
        "epochs": epochs,
        "batch": BATCH,
        "learning_rate": LEARNING_RATE,
        "weight_decay": WEIGHT_DECAY,
        "dropout": DROPOUT,
        "noise": NOISE,
        "temperature": round(float(arrays["temperature"][0]), 4),
    }
    return save(arrays, "network", recipe, seed, scores, directory), curves


def options(description: str) -> argparse.ArgumentParser:
    """The options of a training command."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument(
        "--clouds", type=numbers, default=TRAINING_CLOUDS, help="to learn from, of each family or of all"
    )
    parser.add_argument("--held-back", type=int, default=HELD_BACK_CLOUDS, help="a family, from seed + 1")
    parser.add_argument("--calibration", type=int, default=CALIBRATION_CLOUDS, help="a family, from seed + 2")
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument("--processes", type=int, default=1, help="that draw clouds")
    parser.add_argument("--cache", type=Path, help="directory for datasets, to share them in one build")
    parser.add_argument("--curves", type=Path, help="JSON file for the learning curves")
    return parser


def main(arguments: list[str] | None = None) -> None:
    parser = options(__doc__)
    parser.add_argument("--out", type=Path, default=DIRECTORY)
    given = parser.parse_args(arguments)
    start = time.perf_counter()
    card, curves = train(
        given.seed,
        given.clouds,
        given.held_back,
        given.calibration,
        given.out,
        given.epochs,
        given.processes,
        given.cache,
    )
    if given.curves:
        given.curves.write_text(json.dumps(curves), encoding="utf-8")
    print(f"{given.out / 'network.npz'}: sha256 {card.sha256}")
    for family, scores in card.metrics.items():
        print(f"{family}: top-1 {scores['top1']}, top-2 {scores['top2']} on {scores['clouds']} clouds")
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
