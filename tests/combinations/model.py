"""A model as typed rows: every number says whether it names a node or an element, or belongs to a vector.

Transformations (`transformations.py`) rewrite the rows by these types; nothing is looked up in the program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.deck import parse


class Node(int):
    """The number of a node."""


class Element(int):
    """The number of an element."""


class Vector(tuple):
    """Components of a vector: a `Place`, or a `Vector` that is the same wherever the model stands."""


class Place(Vector):
    """A point in the frame of reference."""


class Axial(Vector):
    """A moment, an angular velocity, an axis of rotation: keeps its sense when the model is mirrored."""


class Tensor(Vector):
    """Jxx Jxy Jxz Jyy Jyz Jzz."""


class Pitch(float):
    """Changes its sign when the model is mirrored."""


class Side(float):
    """The same of a planar model: left or right, an angle."""


class Along(float):
    """A deformation that an element goes through: its sign is that of the deformation."""


class Ends(int):
    """End condition of the flow in a tube: bit 0 at p, bit 1 at q."""


class Flow(float):
    """Changes its sign when p and q are exchanged."""


Row = tuple[Any, ...]
Rows = tuple[Row, ...]


@dataclass(frozen=True)
class Push:
    """One force (or stress) of the user function: c + a sin(w t) - k (z - z0) - d z', z the coordinate (or mode)."""

    owner: int
    index: int
    c: float = 0.0
    a: float = 0.0
    w: float = 0.0
    k: float = 0.0
    z0: float = 0.0
    d: float = 0.0

    def turned(self, index: int, sign: float, shift: float = 0.0) -> Push:
        """The same about another coordinate: z -> sign z + shift."""
        return replace(self, index=index, c=sign * self.c, a=sign * self.a, z0=sign * self.z0 + shift)


@dataclass(frozen=True)
class Drive:
    """One prescribed motion of the user function: z0 + a sin(w t)."""

    owner: int
    index: int
    z0: float
    a: float
    w: float

    def turned(self, index: int, sign: float, shift: float = 0.0) -> Drive:
        """The same of another coordinate: z -> sign z + shift."""
        return replace(self, index=index, z0=sign * self.z0 + shift, a=sign * self.a)


@dataclass(frozen=True)
class Model:
    """Rows of the three blocks, what user functions do, mode and options of the run, and what the array asks of it."""

    blocks: tuple[Rows, Rows, Rows] = ((), (), ())
    pushes: tuple[Push, ...] = ()
    drives: tuple[Drive, ...] = ()
    mode: int = 1
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def types(self) -> dict[int, str]:
        """Element -> keyword."""
        return {int(r[1]): r[0] for r in self.blocks[0] if r[0] in ELEMENT_TYPES}

    @property
    def planar(self) -> bool:
        return next(ELEMENT_TYPES[k].planar for k in self.types.values())

    @property
    def roles(self) -> dict[int, str]:
        """Node -> role."""
        return {
            int(n): role
            for r in self.blocks[0]
            if r[0] in ELEMENT_TYPES
            for n, role in zip(r[2:], ELEMENT_TYPES[r[0]].nodes, strict=False)
        }

    def rows(self, *keywords: str, block: int = 0) -> list[Row]:
        """Rows with one of the keywords (of one block)."""
        given = self.blocks if not block else self.blocks[block - 1 : block]
        return [r for rows in given for r in rows if r[0] in keywords]

    def has(self, *keywords: str) -> bool:
        return bool(self.rows(*keywords))

    def mapped(self, change: Callable[[Row, int], Iterable[Row]], **more: Any) -> Model:
        """Every row replaced by what `change(row, block)` gives."""
        blocks = tuple(tuple(new for r in rows for new in change(r, b)) for b, rows in enumerate(self.blocks, 1))
        return replace(self, blocks=blocks, **more)

    def more(self, block: int, *rows: Row, **changes: Any) -> Model:
        """With further rows at the end of a block."""
        blocks = list(self.blocks)
        blocks[block - 1] = (*blocks[block - 1], *rows)
        return replace(self, blocks=tuple(blocks), **changes)

    def without(self, *keywords: str) -> Model:
        return self.mapped(lambda r, b: () if r[0] in keywords else (r,))

    def text(self) -> str:
        """The input file."""
        blocks = ["".join(" ".join(map(word, flat(r))) + "\n" for r in rows) for rows in self.blocks]
        return "END\nHALT\n".join(blocks) + "END\nEND\n"

    def functions(self) -> dict[str, str]:
        """The user functions, by name."""
        found = {}
        if self.pushes:
            rows: dict[str, list[str]] = {"f": [], "sig": []}
            for p in self.pushes:
                force = isinstance(p.owner, Node)
                table, z, zd = ("lnp", "x", "xp") if force else ("le", "e", "ep")
                i = f"{table}[{p.owner - 1}][{p.index - 1}]"
                value = f"{p.c!r} + {p.a!r}*sin({p.w!r}*t) - {p.k!r}*({z}[{i}] - {p.z0!r}) - {p.d!r}*{zd}[{i}]"
                known = f"{p.k!r}, {p.d!r}" if force else f"{-p.k!r}, {-p.d!r}"
                rows["f" if force else "sig"].append(f"[{int(p.owner)}, {p.index}, {value}, {known}]")
            head = "def push(t, ne, le, e, ep, nx, lnp, x, xp):\n"
            found["push"] = f"{head}    return t, [{', '.join(rows['sig'])}], [{', '.join(rows['f'])}]\n"
        if self.drives:
            moves: dict[str, list[str]] = {"e": [], "x": []}
            for d in self.drives:
                s, c = (f"{name}({d.w!r}*t)" for name in ("sin", "cos"))
                terms = f"{d.z0!r} + {d.a!r}*{s}, {d.a * d.w!r}*{c}, {-d.a * d.w**2!r}*{s}"
                moves["x" if isinstance(d.owner, Node) else "e"].append(f"[{int(d.owner)}, {d.index}, {terms}]")
            found["drive"] = f"def drive(t, i):\n    return t, [{', '.join(moves['e'])}], [{', '.join(moves['x'])}]\n"
        return {name: f"from math import cos, sin\n\n\n{text}" for name, text in found.items()}

    def deck(self, folder: Path, mode: int | None = None) -> Deck:
        """The checked deck; the folder holds its user functions."""
        for name, text in self.functions().items():
            (folder / f"{name}.py").write_text(text)
        return parse(self.text(), "case.dat", self.mode if mode is None else mode, path=folder / "case.dat")


def flat(row: Row) -> list[Any]:
    """The words of a statement."""
    return [w for v in row for w in (v if isinstance(v, Vector) else (v,))]


def word(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value)) if isinstance(value, float) else str(int(value))
