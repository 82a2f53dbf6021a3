"""Which columns of a table are the coordinates, the normals and the labels, and in which unit they are."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import Unit

from .errors import UnreadableFileError, describe
from .units import agreed_unit, unit_in

_ALIASES = {
    "x": ("x", "px", "pos_x", "pointx", "point_x", "coord_x", "points:0", "points_0", "points_m_xyz:0"),
    "y": ("y", "py", "pos_y", "pointy", "point_y", "coord_y", "points:1", "points_1", "points_m_xyz:1"),
    "z": ("z", "pz", "pos_z", "pointz", "point_z", "coord_z", "points:2", "points_2", "points_m_xyz:2"),
    "nx": ("nx", "normal_x", "normalx", "normals:0", "normals_0"),
    "ny": ("ny", "normal_y", "normaly", "normals:1", "normals_1"),
    "nz": ("nz", "normal_z", "normalz", "normals:2", "normals_2"),
}
# Names of surveyors in several languages, which beside x, y and z are something else.
_SURVEYED = {
    name: meaning
    for meaning, names in {
        "x": "easting eastings east rechtswert rw ost est este",
        "y": "northing northings north hochwert hw nord norte",
        "z": "elevation elev el height h\u00f6he hoehe altitude alt quota cota up",
    }.items()
    for name in names.split()
}
# Their initials, which are names only where all three coordinates have one: `P,N,E,Z,D`, `Y X H`.
_INITIALS = {"e": "x", "n": "y", "h": "z"}
# A coordinate with a word for it or with its unit, as in `X-Koord`, `pos.y`, `CoordZ`, `Xm`, `x_mm`.
_POSITION = "(?:coord(?:inate)?s?|koord(?:inate)?|pos(?:ition)?|points?|loc(?:ation)?)"
_LOOSE = re.compile(
    rf"(?:{_POSITION}[\s_.:/-]*)?([xyz])(?:[\s_.-]*(?:{_POSITION}|([u\u00b5]m|mm|cm|m|inch|in|ft)))?[:=]?"
)
AUTO_LABELS = "auto"
_LABELS = ("label", "labels", "segment", "segment_id", "segments", "instance", "instance_id", "instances")
_XYZ, _NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
_NAME_OF = {alias: name for name, aliases in _ALIASES.items() for alias in aliases}
_NAME_LENGTH, _LISTED = 40, 12
MOST_COLUMNS = 4096
"""Each column is looked at by itself, so that a few very wide rows would cost more than a million usual ones;
the spectra that some scanners write beside each point have some hundred bands."""

_A_NAME = re.compile(r"[^\W\d][\w .:/\[\]()-]{0,23}|\d{1,3}")


@dataclass(frozen=True)
class Pick:
    """Which columns are asked for.

    Attributes
    ----------
    labels : name of the column that tells segments apart, or its number from 1 where columns have no names;
        `AUTO_LABELS` for one of the usual names, if there is one; None for none
    columns : those of x, y and z, and perhaps of nx, ny and nz, each by its name or its number from 1; None
        to find them by their names
    """

    labels: str | None = None
    columns: tuple[str | int, ...] | None = None

    @property
    def by_number(self) -> bool:
        """Whether all columns are picked by their numbers."""
        return self.columns is not None and all(str(each).isdecimal() for each in self.columns)


FOUND = Pick()
"""Coordinates are found by their names, and labels are not asked for."""


@dataclass(frozen=True)
class Columns:
    """Positions of x, y, z and, where present, nx, ny, nz in a table, and their names in the file.

    `label` and `label_name` are those of the column of labels, where it is asked for and there; `unit` is
    that of the coordinates, where their names tell it; `warnings` say where they tell one that is unknown.
    `spare`: columns have no names, and the three behind the first one may be the coordinates, too.
    """

    names: tuple[str, ...]
    points: tuple[int, ...]
    normals: tuple[int, ...] = ()
    label: int | None = None
    label_name: str | None = None
    unit: Unit | None = None
    warnings: tuple[str, ...] = ()
    spare: bool = False

    @property
    def used(self) -> tuple[int, ...]:
        return self.points + self.normals

    @property
    def wanted(self) -> tuple[int, ...]:
        """Those used, and that of the labels."""
        return self.used if self.label is None else (*self.used, self.label)

    def packed(self) -> "Columns":
        """The same columns in a table that holds only the used ones, in their order."""
        return replace(self, points=(0, 1, 2), normals=(3, 4, 5) if self.normals else ())

    def in_unit(self, told: Sequence[str]) -> "Columns":
        """The same columns, of which these texts tell the units."""
        unit, warnings = agreed_unit(told)
        return replace(self, unit=unit or self.unit, warnings=self.warnings + warnings)


XYZ = Columns(_XYZ, (0, 1, 2))


def as_columns(given: object) -> tuple[str | int, ...] | None:
    """The option `columns`: three names or numbers from 1, or six with normals; `2,3,4` in a text.

    Raises `InvalidOptionError` for anything else.
    """
    if given is None:
        return None
    if isinstance(given, str):
        given = [name.strip() for name in given.split(",")]
    if not isinstance(given, Iterable) or isinstance(given, bytes | dict):
        raise _no_columns("not a list")
    names = tuple(int(name) if isinstance(name, np.integer) else name for name in given)
    if len(names) not in (3, 6):
        raise _no_columns(f"{len(names)} of them")
    for name in names:
        if isinstance(name, bool) or not isinstance(name, str | int):
            raise _no_columns("one is neither a name nor a number")
        if not str(name).strip() or name == 0 or (isinstance(name, int) and name < 0):
            raise _no_columns("one is empty, or less than 1")
    if len(set(map(str, names))) < len(names):
        raise _no_columns("one is named twice")
    return names


def _no_columns(found: str) -> InvalidOptionError:
    wanted = "three names or numbers from 1 are needed, of x, y and z, or six with those of the normals"
    return InvalidOptionError(f"columns: {found}; {wanted}", "columns")


def canonical(name: str) -> str | None:
    """Which of x, y, z, nx, ny, nz a column name means: `X [mm]`, `//X` and `point_x` all mean x."""
    return _NAME_OF.get(_bare(name))


def meanings(names: Sequence[str]) -> list[str | None]:
    """What each of these names means: freer spellings and names of surveyors if no other means the same."""
    found: list[str | None] = [None] * len(names)
    for meaning in (canonical, _loosely, lambda name: _SURVEYED.get(_bare(name))):
        found = _completed(found, [meaning(name) for name in names])
    all_told = _completed(found, [_INITIALS.get(_bare(name)) for name in names])
    return all_told if {*_XYZ} <= {*all_told} else found


def _completed(found: Sequence[str | None], others: Sequence[str | None]) -> list[str | None]:
    return [a or (b if b not in found else None) for a, b in zip(found, others, strict=True)]


def _loosely(name: str) -> str | None:
    loose = _LOOSE.fullmatch(_bare(name))
    return loose[1] if loose else None


def suffixed_unit(name: str) -> str:
    """The unit at the end of the name of a column, as in `X_mm`; empty without."""
    loose = _LOOSE.fullmatch(_bare(name))
    return (loose[2] or "") if loose else ""


def _bare(name: str) -> str:
    bare = re.split(r"[\[(]", name.strip().strip("\"'").lstrip("/#").strip(), maxsplit=1)[0]
    return bare.strip().lower().replace(" ", "_")


def check_width(width: int, field: str = "file") -> None:
    """Raise `UnreadableFileError` where a table has more columns than are looked at."""
    if width > MOST_COLUMNS:
        raise UnreadableFileError(field, f"rows hold {width} values; at most {MOST_COLUMNS} are read")


def find_columns(names: Sequence[str], pick: Pick = FOUND) -> Columns:
    """The columns of a table whose columns have names: those picked, or by what their names mean.

    Raises `UnreadableFileError` where there is no such column, or several may be meant.
    """
    check_width(len(names))
    if pick.columns is None:
        places = _places(names)
        indices = [places[name] for name in (_XYZ + _NORMAL if places.keys() >= set(_NORMAL) else _XYZ)]
    else:
        indices = [_picked(names, each) for each in pick.columns]
        if len(set(indices)) < len(indices):
            raise UnreadableFileError("columns", "two of these columns are the same")
    used = tuple(names[i].strip()[:_NAME_LENGTH] for i in indices)
    label = find_label(names, pick.labels)
    label_name = None if label is None else names[label].strip()[:_NAME_LENGTH]
    columns = Columns(used, tuple(indices[:3]), tuple(indices[3:]), label, label_name)
    return columns.in_unit([unit_in(names[i]) or suffixed_unit(names[i]) for i in indices[:3]])


def check_no_columns(pick: Pick, what: str) -> None:
    """Raise `UnreadableFileError` where columns or labels are asked for of something that has none."""
    if pick.columns is not None:
        raise UnreadableFileError("columns", f"{what} has no columns to choose from")
    if pick.labels not in (None, AUTO_LABELS):
        raise UnreadableFileError("labels", f"{what} has no labels")


def find_label(names: Sequence[str], wanted: str | None) -> int | None:
    """The position of the column of labels: the wanted one by its name, or one of the usual names.

    Raises `UnreadableFileError` where no column has the wanted name, or several may be meant.
    """
    if wanted is None:
        return None
    if wanted == AUTO_LABELS:
        found = [i for i, name in enumerate(names) if _bare(name) in _LABELS]
    else:
        found = _named(names, wanted)
        if not found:
            raise _unknown("labels", names, wanted)
    if len(found) > 1:
        raise UnreadableFileError("labels", f"{len(found)} columns may be the labels; name one of them")
    return found[0] if found else None


def _named(names: Sequence[str], wanted: str) -> list[int]:
    """Columns of this very name, or else those of a name that means the same."""
    found = [i for i, name in enumerate(names) if name.strip() == wanted.strip()]
    return found or [i for i, name in enumerate(names) if _bare(name) == _bare(wanted)]


def _picked(names: Sequence[str], wanted: str | int) -> int:
    """The position of a column by its name, or by its number from 1."""
    found = _named(names, wanted) if isinstance(wanted, str) else []
    if len(found) > 1:
        raise UnreadableFileError("columns", f"{len(found)} columns have this name; give the number of one")
    if found:
        return found[0]
    number = int(wanted) if isinstance(wanted, int) or re.fullmatch(r"\d{1,9}", wanted) else 0
    if not 1 <= number <= len(names):
        raise _unknown("columns", names, wanted)
    return number - 1


def _unknown(field: str, names: Sequence[str], wanted: str | int) -> UnreadableFileError:
    message = f"there is no such column; the {len(names)} columns are {listed(names)}"
    return UnreadableFileError(field, message, describe(wanted))


def listed(names: Sequence[str]) -> str:
    """The names of columns for a message: the first of them; what does not look like a name by its number."""
    shown = [
        name.strip() if _A_NAME.fullmatch(name.strip()) else f"({i})"
        for i, name in enumerate(names[:_LISTED], 1)
    ]
    return ", ".join(shown) + (", ..." if len(names) > _LISTED else "")


def _places(names: Sequence[str]) -> dict[str, int]:
    """Where x, y and z stand, and nx, ny and nz where they are there."""
    places: dict[str, list[int]] = {}
    for index, meaning in enumerate(meanings(names)):
        if meaning is not None:
            places.setdefault(meaning, []).append(index)
    for meaning, found in places.items():
        if len(found) > 1:
            raise UnreadableFileError("header", f"{len(found)} columns are named {meaning}; keep one of them")
    missing = [name for name in _XYZ if name not in places]
    if missing:
        raise UnreadableFileError(
            "header",
            f"no column named {', '.join(missing)} among {listed(names)}; say which are x, y and z: "
            "columns=NAME,NAME,NAME, or by their numbers from 1",
            no_cloud=True,
        )
    return {meaning: index for meaning, (index,) in places.items()}
