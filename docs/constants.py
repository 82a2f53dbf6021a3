"""`make constants`: the table of constants in docs/pipeline.md from the code, and a count of its numbers.

Reads the sources only: neither this script nor its test imports what it describes.
"""

import ast
from dataclasses import dataclass
from math import pi
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "pipeline.md"
FILES = (
    "fitting/noise/rounding.py",
    "fitting/noise/scale.py",
    "fitting/noise/exact.py",
    "fitting/cloud/patches.py",
    "fitting/fields/fields.py",
    "fitting/uncertainty/agreement.py",
    "fitting/verdict/evidence.py",
    "fitting/verdict/judge.py",
)
"""The noise model and the verdict, in the order of the page."""

BEGIN, END = "<!-- constants: made by `make constants` -->\n", "<!-- end of constants -->\n"
"""What stands between these lines of the page is written anew."""

UNCOUNTED = (0, 1, 2, 0.5, pi)
"""Numbers that nobody chose."""


@dataclass(frozen=True)
class Constant:
    """A constant of a module: its value as written there, and the docstring below it."""

    file: str
    name: str
    value: str
    meaning: str


@dataclass(frozen=True)
class Number:
    """A number as it is written in the code, and where: in which function or constant."""

    file: str
    line: int
    text: str
    where: str


def constants_of(file: str, source: str) -> list[Constant]:
    """Of a module, in its order; constants without a docstring of their own share the next one."""
    found: list[Constant] = []
    waiting: list[tuple[str, str]] = []
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value:
            waiting += _assigned(node, source)
        elif waiting:
            meaning = _text(node)
            if not meaning:
                raise ValueError(f"{file}:{node.lineno}: {waiting[-1][0]} has no docstring")
            found += [Constant(file, name, value, meaning) for name, value in waiting]
            waiting = []
    if waiting:
        raise ValueError(f"{file}: {waiting[-1][0]} has no docstring")
    return found


def _assigned(node: ast.Assign | ast.AnnAssign, source: str) -> list[tuple[str, str]]:
    """Names and values of `A = 1` or `A, B = 1, 2`; names of constants are upper case."""
    (target,) = node.targets if isinstance(node, ast.Assign) else (node.target,)
    pairs = [(target, node.value)]
    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
        pairs = list(zip(target.elts, node.value.elts, strict=True))
    return [
        (name.id, " ".join((ast.get_source_segment(source, value) or "").split()))
        for name, value in pairs
        if isinstance(name, ast.Name) and value and name.id.isupper()
    ]


def _text(node: ast.stmt) -> str:
    """The paragraphs of a docstring as one line, or nothing."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return " ".join(str(node.value.value).split())
    return ""


def numbers_of(file: str, source: str) -> list[Number]:
    """Every numeric literal of a module but the uncounted ones, in its order.

    The sign is not part of it, digits within texts (docstrings, formats) are none, and truth values neither.
    """
    found: list[Number] = []

    def search(node: ast.AST, where: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                search(child, f"{where}.{child.name}" if where else child.name)
            elif isinstance(child, ast.Assign) and not where:
                search(child, ", ".join(ast.unparse(target) for target in child.targets))
            elif isinstance(child, ast.Constant) and type(child.value) in (int, float, complex):
                if child.value not in UNCOUNTED:
                    text = ast.get_source_segment(source, child) or repr(child.value)
                    found.append(Number(file, child.lineno, text, where))
            else:
                search(child, where)

    search(ast.parse(source), "")
    return found


def numbers() -> list[Number]:
    """Of the noise model and the verdict."""
    return [number for file in FILES for number in numbers_of(file, (ROOT / file).read_text())]


def table() -> str:
    """Every constant of the noise model and the verdict, in Markdown."""
    lines = ["| constant | value | meaning |", "|---|---|---|"]
    for file in FILES:
        lines.append(f"| **[`{file}`](../{file})** | | |")
        lines += [_row(each) for each in constants_of(file, (ROOT / file).read_text())]
    return "\n".join(lines) + "\n"


def _row(constant: Constant) -> str:
    meaning = constant.meaning.replace("|", r"\|")
    return f"| `{constant.name}` | `{constant.value}` | {meaning} |"


def renewed(page: str) -> str:
    """The page with the table as it is made now."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table()}\n{END}{after}"


def main() -> None:
    PAGE.write_text(renewed(PAGE.read_text()))
    found = numbers()
    for number in found:
        print(f"{number.file}:{number.line}: {number.text}  in {number.where}")
    for file in FILES:
        print(f"{file}: {sum(number.file == file for number in found)}")
    print(f"numbers in the noise model and the verdict: {len(found)}, without 0, 1, 2, 1/2 and pi")


if __name__ == "__main__":
    main()
