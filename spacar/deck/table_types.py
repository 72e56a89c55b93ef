"""The records of which the keyword table is made: blocks, parameters, variants of a statement, keywords,
element types; which blocks a mode uses (reference/input-language.md section 2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from spacar import modes

NODE_OR_ELEMENT = "node or element"  # what TRFRONT names: that which has a path in its trajectory
COORDINATES = {"position": (2, 3), "orientation": (1, 4), "warping": (0, 1)}
"""Number of coordinates of a node by its role, in planar and in spatial models."""


def coordinates_of(role: str, planar: bool) -> int:
    return COORDINATES[role][0 if planar else 1]


NODE_CLASSES = {"FIX": "fixed", "INPUTX": "prescribed", "DYNX": "dynamic", "KINX": "kinematic"}
ELEMENT_CLASSES = {"RLSE": "calculable", "INPUTE": "prescribed", "DYNE": "dynamic", "KINE": "kinematic"}
"""Statement of the kinematics block -> the class that it gives to coordinates, or to deformations."""


def independent_of(role: str, planar: bool) -> tuple[int, ...]:
    """Coordinates of a node with this role that a statement without coordinate numbers means: all, but of Euler
    parameters not lambda0."""
    count = coordinates_of(role, planar)
    return (2, 3, 4) if count == 4 else tuple(range(1, count + 1))


class BlockKind(Enum):
    """A kind of input block. The third block of a file has one of the last three kinds."""

    KINEMATICS = "kinematics block"
    DYNAMICS = "dynamics block"
    TRAJECTORY = "block of trajectories, nominal inputs and reference outputs (modes 2 and 3)"
    LINEARIZATION = "block of linearization inputs and outputs (modes 4 and 9)"
    SIMULATION = "block of simulation inputs and outputs"

    __hash__ = object.__hash__  # of the object, not of its name in Python: tables of keywords are asked often

    @property
    def number(self) -> int:
        """Place of the block in the file: 1, 2 or 3."""
        return {"KINEMATICS": 1, "DYNAMICS": 2}.get(self.name, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """One position of a statement.

    `kind` is integer, real or name. `of` says what a number refers to: element, node, position node, orientation node,
    NODE_OR_ELEMENT, coordinate, mode, input, output. `default` None means that the value must be given.
    """

    meaning: str
    kind: str = "real"
    unit: str = ""
    default: float | None = None
    of: str = ""

    @property
    def text(self) -> str:
        """Meaning with unit, for messages and the reference."""
        return f"{self.meaning} ({self.unit})" if self.unit else self.meaning


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """One form of a statement: which models, nodes or elements it is for, its parameters and allowed counts.

    `space` (planar, spatial), `role` (position, orientation, warping) and `types` (element keywords) restrict the
    variant; empty means any. `counts` are the allowed numbers of arguments. `components` marks forms whose last values
    are vector components, where a surplus zero third component of a planar model is dropped with a warning.
    """

    parameters: tuple[Parameter, ...]
    counts: tuple[int, ...]
    space: str = ""
    role: str = ""
    types: tuple[str, ...] = ()
    components: bool = False

    def fits(self, space: str, role: str, kind: str) -> bool:
        """Whether the variant applies; an unknown ("") property of the statement excludes nothing."""
        return (
            (not self.space or not space or self.space == space)
            and (not self.role or not role or self.role == role)
            and (not self.types or not kind or kind in self.types)
        )

    @property
    def scope(self) -> list[str]:
        """What it is for, in words: planar, orientation node, element types; none when for all."""
        words = self.space, f"{self.role} node" if self.role else "", ", ".join(self.types)
        return [word for word in words if word]


@dataclass(frozen=True, eq=False)
class Keyword:
    """One keyword of one block.

    `unique` leading arguments identify a statement that may be given only once (0: once per file, -1: all arguments but
    the last, None: may be repeated). `classes` are the classes (fixed, calculable, prescribed, dynamic, kinematic) to
    which the coordinate or deformation of the statement may belong, empty means any; `holonomic` excludes slips.
    """

    name: str
    block: BlockKind
    help: str
    variants: tuple[Variant, ...]
    unique: int | None = None
    aliases: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    classes: tuple[str, ...] = ()
    holonomic: bool = False

    @property
    def most(self) -> int:
        """Largest number of arguments of any variant."""
        return max(v.counts[-1] for v in self.variants)

    @cached_property
    def fewest(self) -> int:
        """Smallest number of arguments of any variant."""
        return min(n for v in self.variants for n in v.counts)

    @cached_property
    def longest(self) -> tuple[Parameter, ...]:
        """The parameters of the variant that has most of them."""
        return max((v.parameters for v in self.variants), key=len)

    @cached_property
    def subject(self) -> int | None:
        """Index of the argument that names the node or element that the statement is about."""
        named = (i for i, p in enumerate(self.variants[0].parameters) if p.of == "element" or p.of.endswith("node"))
        return next(named, None)

    @cached_property
    def of_element(self) -> bool:
        """Whether that is an element."""
        return self.subject is not None and self.variants[0].parameters[self.subject].of == "element"


COEFFICIENTS = {
    "stretch": (2,), "planar beam": (2, 3, 3), "spatial beam": (2, 3, 4, 4, 5, 5),
    "spatial beam with warping": (2, 3, 4, 4, 5, 5, 8, 8),
}  # fmt: skip
"""Form of ESTIFF that is not one coefficient a mode -> the position of that of each mode."""


@dataclass(frozen=True, eq=False)
class ElementType:
    """One element type: everything about it that other rooms ask for.

    `nodes` are the roles (position, orientation, warping) in the order of the statement, `node_names` their names
    there, `counts` the allowed numbers of arguments, empty: as of `form`. `modes` are (name, unit), `slips` the
    0-based non-holonomic modes, `code` the number in the array `it`.
    `length` says when the distance between the position nodes must not be zero: always, with direction, or never.
    `direction` is (first argument number, number of components, role) of the direction vector, with the role plane (a
    vector in the x'y' plane, not parallel to pq), axis (any direction) or spin (not parallel to pq).

    `family` is "module:Class" in `spacar.elements`, empty for a type that is not supported, `angle_family` that of the
    angle measure (ADEFORM) of types that have one. `shape` says what the element is like: beam, truss, hinge, body, or
    a shape of its own; pictures are chosen by it, and beams have strains of second order. `coefficients` and `mass`
    name the forms of ESTIFF, EDAMP and of EM in `table_dynamics` (one per mode; no EM). `statements` are those of both
    blocks that apply to some types only. `axial`: mode 1 is the change of the length between the position nodes.
    `normal_mode` is the mode (from 1) whose stress is the force on the ground, 0 without. `split` are the pairs of
    bending modes (at p, at q) of a type that can be divided along its chord. `released` are the modes (from 1) that are
    calculable whatever a statement says. `counterpart` is the planar type that a spatial one is in the x-y plane.
    """

    keyword: str
    title: str
    code: int
    planar: bool
    nodes: tuple[str, ...]
    node_names: tuple[str, ...]
    modes: tuple[tuple[str, str], ...]
    geometry: tuple[Parameter, ...] = ()
    counts: tuple[int, ...] = ()
    slips: tuple[int, ...] = ()
    length: str = "never"
    direction: tuple[int, int, str] | None = None
    notes: tuple[str, ...] = ()
    family: str = ""
    angle_family: str = ""
    shape: str = ""
    coefficients: str = "modes"
    mass: str = ""
    statements: tuple[str, ...] = ()
    axial: bool = False
    normal_mode: int = 0
    split: tuple[tuple[int, int], ...] = ()
    released: tuple[int, ...] = ()
    counterpart: str = ""

    @property
    def supported(self) -> bool:
        """Whether there is a family that evaluates it."""
        return bool(self.family)

    @cached_property
    def stiffness(self) -> tuple[int, ...]:
        """For each mode the position of its coefficient in ESTIFF (argument number, 1 = element), by the form of that
        statement; none where every mode is a slip."""
        if not self.supported or len(self.slips) == len(self.modes):
            return ()
        return COEFFICIENTS.get(self.coefficients) or span(2, 1 + len(self.modes))

    @cached_property
    def classed(self) -> tuple[int, ...]:
        """Modes (from 1) that a statement without mode numbers gives a class to."""
        return tuple(m for m in range(1, len(self.modes) + 1) if m not in self.released)

    @cached_property
    def position_places(self) -> list[int]:
        """Arguments (from 0) of the statement that are position nodes."""
        return [i for i, role in enumerate(self.nodes, 1) if role == "position"]

    @property
    def carries_flow(self) -> bool:
        """Whether a fluid flows through it, so that EM says how much."""
        return "DELOMF" in self.statements

    @property
    def ends(self) -> tuple[int | None, int | None, int | None, int | None]:
        """Places (from 0) in `nodes` of p position, p orientation, q position, q orientation; None: it has none. (Those
        of warping nodes: `warping`.)

        A node that is not named after its end is at p when it is the first of its role, else at q.
        """
        found: dict[tuple[str, str], int] = {}
        for place, (role, name) in enumerate(zip(self.nodes, self.node_names, strict=True)):
            end = name[0] if name[1:2] == " " else "q" if ("p", role) in found else "p"
            found[end, role] = place
        return (
            found.get(("p", "position")), found.get(("p", "orientation")), found.get(("q", "position")),
            found.get(("q", "orientation")),
        )  # fmt: skip

    @cached_property
    def warping(self) -> tuple[int, ...]:
        """Places (from 0) in `nodes` of the warping nodes at p and q; none for most types."""
        return tuple(place for place, role in enumerate(self.nodes) if role == "warping")

    @cached_property
    def traits(self) -> frozenset[str]:
        """What a check asks of all elements of a model at once."""
        found = {
            "not supported": not self.supported, "slips": self.slips, "axial": self.axial, "warping": self.warping,
            "released": self.released, "carries flow": self.carries_flow,
        }  # fmt: skip
        return frozenset([trait for trait, has in found.items() if has])


def integer(meaning: str, of: str = "", default: float | None = None) -> Parameter:
    return Parameter(meaning, "integer", "", default, of)


def real(meaning: str, unit: str = "", default: float | None = None) -> Parameter:
    return Parameter(meaning, "real", unit, default)


def vector(meaning: str, names: str, unit: str = "", default: float | None = None) -> tuple[Parameter, ...]:
    """One real position for every name: `vector("start of", "x y")` -> "start of x", "start of y"."""
    return tuple(real(f"{meaning} {name}".strip(), unit, default) for name in names.split())


def several(meanings: Iterable[str], unit: str = "") -> tuple[Parameter, ...]:
    """Real positions of which the first must be given; the others are zero when they are left out."""
    return tuple(real(meaning, unit, 0.0 if i else None) for i, meaning in enumerate(meanings))


def span(first: int, last: int) -> tuple[int, ...]:
    """The allowed counts first ... last."""
    return tuple(range(first, last + 1))


def form(
    parameters: tuple[Parameter, ...], *counts: int, space: str = "", role: str = "", types: str = "",
    components: bool = False,
) -> Variant:  # fmt: skip
    """A variant; without counts every parameter up to the last one without default is needed."""
    if not counts:
        needed = max((i + 1 for i, p in enumerate(parameters) if p.default is None), default=0)
        counts = span(needed, len(parameters))
    return Variant(parameters, counts, space, role, tuple(types.split()), components)


ELEMENT = integer("element number", "element")
NODE = integer("node number", "node")
POSITION = integer("position node", "position node")
ORIENTATION = integer("orientation node", "orientation node")
COORDINATE = integer("coordinate number", "coordinate")
MODE = integer("mode number", "mode")
SURPLUS = "Surplus zeros are ignored; a surplus value that is not zero is an error."  # a note of some rows

Purpose = int | str | None
"""A mode number, "simulation" for the controlled simulation, or None for checking a file without a mode."""


def facts(mode: Purpose) -> modes.Mode | None:
    """The row of the table of modes; None for no mode and for the controlled simulation, which has no row."""
    return modes.MODES.get(mode) if isinstance(mode, int) else None


def third_block(mode: Purpose) -> BlockKind | None:
    """Kind of the third block in this mode, None when the mode does not use it or is not known."""
    if mode == "simulation":
        return BlockKind.SIMULATION
    row = facts(mode)
    return None if row is None or row.third is None else BlockKind[row.third.upper()]


def uses(mode: Purpose, block: int) -> bool:
    if mode is None or block == 1:
        return True
    if block == 2:
        row = facts(mode)
        return row is None or row.forces
    return third_block(mode) is not None
