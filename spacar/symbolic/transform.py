"""The last step of a derivation: held products of unit vectors become cosines and sines of joint angles.

Direction cosines are products along the tree of frames; with a `ZTable` every cosine, sine and product is a memory
read (`co[1]`, `co[2,4]` of the paper, table 16). Consecutive turns about one axis are added before the cosine is
taken, so u_x(L) + q4 needs one cosine.
"""

from typing import Any

import sympy as sp
from sympy.physics import vector as sympy_vector

from spacar.errors import UsageError
from spacar.symbolic.collect import ZTable
from spacar.symbolic.reference_frames import ReferenceFrame
from spacar.symbolic.unit_vectors import UnevaluatedCross, UnevaluatedDot, Unit, UnitDot
from spacar.symbolic.vectors import ZERO, Vector


class DirectionCosines:
    """Direction cosine matrices between frames that are connected by turns (`ReferenceFrame.turned`).

    >>> q = sympy_vector.dynamicsymbols("q"); N = ReferenceFrame("N"); B = N.turned("B", 3, q)
    >>> DirectionCosines().matrix(N, B)[0, 1]
    -sin(q(t))
    """

    def __init__(self, table: ZTable | None = None) -> None:
        self.table = table
        self._known: dict[tuple[ReferenceFrame, ReferenceFrame], sp.Matrix] = {}

    def matrix(self, a: ReferenceFrame, b: ReferenceFrame) -> sp.Matrix:
        """C with C[i, j] = a_i·b_j. Raises UsageError when the orientation of the frames is not known."""
        if a is b:
            return sp.eye(3)
        if (a, b) not in self._known:
            if (b, a) in self._known:
                return self._known[b, a].T
            self._known[a, b] = self._from_parent(a, b)
        return self._known[a, b]

    def _from_parent(self, a: ReferenceFrame, b: ReferenceFrame) -> sp.Matrix:
        if a in (line := b.chain):
            if b.attitude is not None:
                return self._product(self.matrix(a, b.attitude.parent), b.attitude.matrix.applyfunc(self._read))
            base, axis, angle = merged_rotation(b, stop=a, everything=self.table is None)
            before, turns = self.matrix(a, base), (sp.cos(angle), sp.sin(angle))
            return self._product(before, turn_matrix(axis, *map(self._read, turns)))
        common = next((f for f in a.chain if f in line), None)
        if common is None:
            raise UsageError(
                f"the orientation of frame {b.name} relative to {a.name} is not known: use ReferenceFrame.turned"
            )
        return self._product(self.matrix(common, a).T, self.matrix(common, b))

    def _product(self, a: sp.Matrix, b: sp.Matrix) -> sp.Matrix:
        return (a * b).applyfunc(self._read)

    def _read(self, expression: sp.Expr) -> sp.Expr:
        return self.table.read(expression) if self.table is not None else expression

    def value(self, atom: UnevaluatedDot) -> sp.Expr:
        """The held dot or triple product in cosines and sines."""
        if isinstance(atom, UnitDot):
            a, b = atom.units
            return self.matrix(a.frame, b.frame)[a.index - 1, b.index - 1]
        a, b, c = atom.units
        columns = [self.matrix(a.frame, u.frame)[:, u.index - 1] for u in (a, b, c)]
        return self._read(columns[0].dot(columns[1].cross(columns[2])))

    def components(self, vector: Vector, frame: ReferenceFrame) -> sp.Matrix:
        """The three measure numbers of a vector in one frame."""
        total = sp.zeros(3, 1)
        for key, coefficient in vector.terms.items():
            units = (key.a, key.b) if isinstance(key, UnevaluatedCross) else (key,)
            first, *second = (self.matrix(frame, u.frame)[:, u.index - 1] for u in units)
            total += coefficient * (first.cross(second[0]) if second else first)
        return total


def turn_matrix(axis: int, c: sp.Expr, s: sp.Expr) -> sp.Matrix:
    """Direction cosines of a turn about an axis 1, 2 or 3 with this cosine and sine."""
    i, j = axis % 3, (axis + 1) % 3
    turn = sp.eye(3)
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def merged_rotation(
    frame: ReferenceFrame, stop: ReferenceFrame | None = None, everything: bool = False
) -> tuple[ReferenceFrame, int, sp.Expr]:
    """(base, axis, angle) of the turn that gives `frame`, added to the turns about the same axis just before it.

    Sections of beams and joints on them are merged this way; a frame that is an origin of its own chain of joints
    (`stop`) is not passed. `everything`: joints are merged too, as in the published cos(q1 + q2' + q4); memory reads
    multiply cosines along the tree instead.
    """
    assert frame.rotation is not None
    base, axis, angle = frame.rotation.parent, frame.rotation.axis, frame.rotation.angle
    while base is not stop and base.rotation is not None and base.rotation.axis == axis:
        if not (base.is_section or everything):
            break
        angle = base.rotation.angle + angle
        base = base.rotation.parent
    return base, axis, angle


def transform(expression: Any, cosines: DirectionCosines | None = None) -> sp.Expr:
    """Replace held dots and triple products by cosines and sines of the joint angles.

    >>> q = sympy_vector.dynamicsymbols("q"); N = ReferenceFrame("N"); B = N.turned("B", 3, q)
    >>> transform(3 * (N[2] & B[1]))
    3*sin(q(t))
    """
    expression = sp.sympify(expression)
    cosines = cosines or DirectionCosines()
    products = sorted(expression.atoms(UnevaluatedDot), key=str)
    return expression.xreplace({product: cosines.value(product) for product in products})


def to_sympy(vector: Vector, frames: dict[ReferenceFrame, sympy_vector.ReferenceFrame]) -> sympy_vector.Vector:
    """The vector in the classes of `sympy.physics.vector`; crosses are evaluated there.

    >>> N = ReferenceFrame("N"); R = sympy_vector.ReferenceFrame("N")
    >>> to_sympy(2 * N[1], {N: R})
    2*N.x
    """

    def unit(u: Unit) -> sympy_vector.Vector:
        r = frames[u.frame]
        return (r.x, r.y, r.z)[u.index - 1]

    total = sympy_vector.Vector(0)
    for key, c in vector.terms.items():
        total += c * ((unit(key.a) ^ unit(key.b)) if isinstance(key, UnevaluatedCross) else unit(key))
    return total


def from_sympy(vector: sympy_vector.Vector, frames: dict[sympy_vector.ReferenceFrame, ReferenceFrame]) -> Vector:
    """A vector of `sympy.physics.vector` as a held vector, frame by frame."""
    total = ZERO
    for components, frame in vector.args:
        total += sum((c * frames[frame][i] for i, c in enumerate(components, 1)), ZERO)
    return total
