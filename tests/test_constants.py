"""docs/constants.py: the table of constants follows the code, and the numbers in the verdict are counted."""

import pytest

from docs.constants import FILES, PAGE, ROOT, constants_of, numbers, numbers_of, renewed

NUMBERS = 21
"""In the noise model and the verdict today. Lower it when some go; a new one needs its reason beside it."""


def test_the_page_has_the_table_of_the_code() -> None:
    page = PAGE.read_text()
    assert renewed(page) == page, "run `make constants`"


def test_the_numbers_do_not_grow_unnoticed() -> None:
    assert len(numbers()) == NUMBERS, "run `make constants`: it lists them"


def test_every_file_is_counted() -> None:
    for file in FILES:
        assert constants_of(file, (ROOT / file).read_text()), file


def test_constants_share_the_docstring_below_them() -> None:
    source = (
        '"""Module."""\nA = 0.5\nB = (1.0,\n     3.0)\n"""Both:\n\nof these."""\nC, D = 4, 5\n"""Two."""\n'
    )
    found = [(each.name, each.value, each.meaning) for each in constants_of("x.py", source)]
    assert found == [
        ("A", "0.5", "Both: of these."),
        ("B", "(1.0, 3.0)", "Both: of these."),
        ("C", "4", "Two."),
        ("D", "5", "Two."),
    ]


@pytest.mark.parametrize("source", ["A = 3\n", "A = 3\ndef f(): ...\n", "A = 3\nx = 4\n"])
def test_a_constant_without_meaning_is_an_error(source: str) -> None:
    with pytest.raises(ValueError, match="A has no docstring"):
        constants_of("x.py", source)


def test_every_number_counts_but_the_usual_ones() -> None:
    source = (
        '"""Module with 7."""\n'
        "A = (0, 1, 2.0, 0.5, -1, True, 0.3)\n"
        "class K:\n"
        "    b: float = 1e-3\n"
        "    def f(self, x=4):\n"
        '        """With 9."""\n'
        "        return x * -8.0 + 3.14159265358979311600 + f'{x:.3g}' + 0x10\n"
    )
    found = [(each.line, each.text, each.where) for each in numbers_of("x.py", source)]
    assert found == [
        (2, "0.3", "A"),
        (4, "1e-3", "K"),
        (5, "4", "K.f"),
        (7, "8.0", "K.f"),
        (7, "0x10", "K.f"),
    ]
