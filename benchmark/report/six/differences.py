"""What differs from the paper: from the heads of the methods' files, and the cards of their weights."""

import ast
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ... import sources
from ..markdown import NOTHING, commands, table

FOLDER = "paper"


def differences(methods: Iterable[str], root: Path = sources.ROOT) -> Iterator[str]:
    """For each method what the paper leaves open and what was chosen, and which run made its weights.

    Nothing where the files are not: wheels leave them out.
    """
    known = [method for method in methods if (root / FOLDER / f"{method}.py").is_file()]
    if not known:
        return
    yield "## What differs from the paper"
    yield ""
    yield (
        "The paper leaves much open, and its networks learned from its 46,000 training clouds, most on GPUs. "
        "These learn from fewer clouds of the same laws on two processor cores, and are small: "
        "at most 8 MB a method. [paper.md](paper.md) has what they are trained with."
    )
    yield ""
    for method in known:
        yield f"- {_told(method, head_of(root / FOLDER / f'{method}.py'))}"
    yield ""
    yield from _weights([card for method in known for card in cards(method, root)])


def head_of(path: Path) -> dict[str, str]:
    """The first paragraph of a file's head as `""`, and what is indented below each later line, by it."""
    lines = (ast.get_docstring(ast.parse(path.read_text())) or "").splitlines()
    parts: dict[str, list[str]] = {"": []}
    for line in lines[: lines.index("")]:
        parts[""].append(line)
    title = ""
    for line in lines[lines.index("") + 1 :]:
        if line and not line.startswith(" "):
            title = line
            parts[title] = []
        else:
            parts[title].append(line.strip())
    return {name: " ".join(filter(None, said)) for name, said in parts.items()}


def _told(method: str, head: dict[str, str]) -> str:
    open_, chosen = head["It leaves open"], head["Chosen"]
    return f"[{method}](../{FOLDER}/{method}.py): {head['']} *Left open:* {open_} *Chosen:* {chosen}"


def cards(method: str, root: Path) -> list[dict[str, Any]]:
    """Those beside the weights of a method, in the order of their names."""
    found = sorted((root / FOLDER / "weights").glob(f"{method}*.json"))
    return [json.loads(path.read_text()) for path in found]


def _weights(found: list[dict[str, Any]]) -> Iterator[str]:
    if not found:
        return
    yield "The weights were made by these runs (M1 needs none):"
    yield ""
    header = ["weights", "clouds", "epochs", "seed", "on clouds of another seed", "SHA-256"]
    yield from table(header, [_card(card) for card in found], left=1)
    yield ""
    yield from commands(dict.fromkeys(card["recipe"]["command"] for card in found))


def _card(card: dict[str, Any]) -> list[str]:
    recipe = card["recipe"]
    return [
        f"`{card['name']}`",
        f"{recipe['clouds']:,}",
        str(recipe.get("epochs", NOTHING)),
        str(card["seed"]),
        _reached(card["metrics"].get("benchmark", {})),
        f"`{card['sha256'][:8]}`",
    ]


def _reached(metrics: dict[str, Any]) -> str:
    """What a card says of clouds that were not learned from."""
    if "top1" in metrics:
        return f"{metrics['top1']:.1%} right"
    if "l2_quartiles" in metrics:
        return f"L2 {', '.join(f'{value:.2g}' for value in metrics['l2_quartiles'])}"
    return NOTHING
