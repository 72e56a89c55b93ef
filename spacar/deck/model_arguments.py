"""How statements become calls: the arguments of the methods of `Model`, from the keyword table.

Forms of a statement that continue each other are one list of arguments, numbers that repeat are `*numbers`, and
forms that differ take numbers in the order of the deck or by name. The nodes of an element at one end, and the
components of a vector, are one argument.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from keyword import iskeyword

from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS, blocks_of
from spacar.deck.table_types import BlockKind, Keyword, Parameter

TYPES = {"integer": "int", "real": "float", "name": "str"}
# Short names where the meaning is a sentence; all others follow from the meaning (see `argument_name`).
NAMES = {
    "initial direction of the principal y' axis": "y_axis", "initial direction of the spin axis": "spin_axis",
    "initial direction of the x' axis (axis of rotation)": "axis", "tangent at p (local x')": "tangent_p",
    "tangent at q": "tangent_q", "direction of the local y' axis at q": "y_axis_q", "wheel radius": "radius",
    "position node": "node", "orientation node": "node", "node or element number": "number",
    "undeformed projection on direction": "projection", "mass per length": "mass", "tube mass per length": "mass",
    "fluid mass per length": "fluid_mass", "mass flow rate": "flow", "flow shape factor": "shape_factor",
    "end condition 0-3": "end_condition", "J per length": "J", "warping inertia Jw per length": "Jw",
    "angle wound over the first pulley": "wound_p", "angle wound over the second pulley": "wound_q",
    "increment of the mass flow rate": "increment", "increment of the moment": "moment",
    "increment of the bimoment": "bimoment", "preload stress of mode": "stress",
    "increment of the stress of mode": "increment", "density rho": "rho", "absolute error": "absolute",
    "relative error": "relative", "extra mass": "mass", "length of the time interval": "duration",
    "number of time steps": "steps", "type of integrator": "method", "step size or initial step size": "step",
    "maximum number of iterations": "iterations", "number of load steps": "load_steps",
    "error tolerance: largest force out of balance": "tolerance",
    "number of steps between output steps": "store_every", "type of analysis 0-3": "analysis",
    "number of load steps for the initial solution": "initial_steps",
    "follow the equilibrium path beyond limit points: 0 no, 1 yes": "follow_path", "level of the log": "log",
    "level of the .sbd file": "sbd", "torsion-elongation coupling f": "coupling",
    "constant acceleration": "acceleration",
    "start value (when left out: the value given with X, for lambda0 1)": "start", "start value": "start",
    "start rate": "rate", "increment of the start value": "increment", "pitch, displacement per radian": "pitch",
    "shear modulus G, or Poisson's ratio up to 0.5": "G", "moment of inertia J": "J", "rotor inertia J": "J",
    "warping inertia J": "J", "type: 0 free, 1 prescribed": "prescribed",
    "base circle radius of the first pulley": "radius_p", "base circle radius of the second pulley": "radius_q",
    "initial rotation of the tangent at p from the line pq": "tangent_p",
    "initial rotation of the tangent at q from the line pq": "tangent_q", "radius in the equatorial plane": "radius",
    "transverse (tread) radius": "tread_radius", "number of steps with an extended analysis": "steps",
    "number of intermediate steps within each": "intermediate_steps", "total time of this trajectory": "duration",
    "total displacement (angle or elongation)": "displacement",
    "front type: 0 constant acceleration, 1 sine, 2 squared sine": "front", "name of the function": "function",
    "name of a section": "section", "name of a material": "material", "number of beams in its place": "parts",
    "unit: m or mm": "unit",
}  # fmt: skip
_NUMBERED = re.compile(r"\d+( \(see below\))?\Z")
MANY = 4  # numbered parameters that are one repeated argument
_LEFT_OUT = {"of", "the", "a", "an", "on", "in", "per", "from", "number", "initial", "total", "component", "and"}


@dataclass(frozen=True)
class Argument:
    """An argument of a method: its name, type, how many values of the statement it stands for, and its parameters."""

    name: str
    kind: str
    parameters: tuple[Parameter, ...]
    required: bool

    @property
    def count(self) -> int:
        return len(self.parameters)

    @property
    def text(self) -> str:
        first = self.parameters[0]
        meaning = without_component(first.meaning) if self.count > 1 and not first.of else first.meaning
        if self.count > 1 and first.of:
            meaning = ", ".join(p.meaning for p in self.parameters)
        unit = f" [{first.unit}]" if first.unit else ""
        default = "" if self.required or first.default is None else f" (default {first.default:g})"
        return f"{meaning}{unit}{default}"

    @property
    def repeated_text(self) -> str:
        first = self.parameters[0]
        if first.of:
            return f"{first.meaning}s; none: all"
        return f"{_NUMBERED.sub('', first.meaning)}1, 2, ...{f' [{first.unit}]' if first.unit else ''}"


def method_name(keyword: str, block: int) -> str:
    """`plbeam` of PLBEAM. INPUTX and INPUTE stand in two blocks: the time functions are `inputx_motion`."""
    twice = block == 2 and any(b is BlockKind.KINEMATICS for b in blocks_of(keyword))
    return keyword.lower() + "_motion" * twice


def argument_name(parameter: Parameter) -> str:
    """A short name: the symbol that the meaning ends with (`EIy`, `Fx`), else its words."""
    meaning = without_component(parameter.meaning)
    if meaning in NAMES:
        return NAMES[meaning]
    stem, _, digit = meaning.rpartition(" ")
    if stem in NAMES and digit.isdigit():
        return f"{NAMES[stem]}_{digit}"
    if meaning.startswith("shear parameter"):
        return {"EI/(GAk)": "shear", "EIy/(GAkz)": "shear_z", "EIz/(GAky)": "shear_y"}[meaning.split()[-1]]
    head = re.split(r"[(,:;]", meaning)[0].replace("'", "").strip()
    words = head.split()
    if re.fullmatch(r"[A-Za-z]+\d?", words[-1]) and re.search(r"[A-Z0-9]|^g[xyz]$", words[-1]):
        return words[-1]
    name = "_".join(w for w in re.findall(r"\w+", head.lower()) if w not in _LEFT_OUT) or words[0].lower()
    return f"{name}_" if iskeyword(name) else name


def without_component(meaning: str) -> str:
    return re.sub(r", [xyz]\Z", "", meaning)


def grouped(parameters: Sequence[Parameter], needed: int) -> list[Argument]:
    """Parameters to arguments; components of one vector are one. The first `needed` must be given."""
    stems = [without_component(p.meaning) for p in parameters]
    vectors = [stem if stem != p.meaning else "" for stem, p in zip(stems, parameters, strict=True)]
    found: list[Argument] = []
    for parts in _together(parameters, vectors):
        name = argument_name(parts[0])
        kind = "Vector" if len(parts) > 1 else TYPES[parts[0].kind]
        required = sum(a.count for a in found) + len(parts) <= needed and parts[0].default is None
        found.append(Argument(name, kind, tuple(parts), required))
    return found


def _together(parameters: Sequence[Parameter], keys: Sequence[str]) -> list[list[Parameter]]:
    """Those with the same key that follow each other together; one without a key is alone."""
    found: list[list[Parameter]] = []
    for p, key, before in zip(parameters, keys, ("", *keys), strict=False):
        if key and key == before:
            found[-1].append(p)
        else:
            found.append([p])
    return found


def element_arguments(keyword: str) -> list[Argument]:
    """Number, nodes (one argument an end) and geometry of an element."""
    kind, row = ELEMENT_TYPES[keyword], KEYWORDS[keyword, BlockKind.KINEMATICS]
    longest = row.longest
    found = [Argument("number", "int", longest[:1], True)]
    count = 1 + len(kind.nodes)
    ends = [name[0] if name[1:2] == " " else "" for name in kind.node_names]
    for nodes in _together(longest[1:count], ends):
        first = nodes[0].meaning
        inside = re.search(r"\((?:wheel )?(\w+)(?: \w+)*\)", first)
        name = first[0] if first[1:2] == " " else inside[1] if inside else argument_name(nodes[0])
        types = "int" if len(nodes) == 1 else f"tuple[{', '.join(['int'] * len(nodes))}]"
        found.append(Argument(name, types, tuple(nodes), True))
    return found + grouped(longest[count:], row.fewest - count)


def statement_arguments(row: Keyword) -> tuple[list[Argument], list[Argument], Argument | None]:
    """Arguments in order, arguments that are given by name or in order, and the repeated last one."""
    variants = row.variants
    if is_one_list(row):
        head, repeated = _repeated(row.longest)
        return grouped(head, row.fewest), [], repeated
    common = in_common(row)
    named: dict[str, Argument] = {}
    for v in variants:
        for p in v.parameters[common:]:
            if p.meaning != "not used":
                name = argument_name(p)
                named.setdefault(name, Argument(name, TYPES[p.kind], (p,), False))
    plain = not any(without_component(p.meaning) != p.meaning for v in variants for p in v.parameters)
    plain = plain and not any(p.of for v in variants for p in v.parameters[common:])
    return grouped(row.longest[:common], common), list(named.values()) if plain else [], None


def in_common(row: Keyword) -> int:
    """How many of its first parameters all forms of a statement share, of those that must be given."""
    common = 0
    while common < row.fewest and len({v.parameters[common].meaning for v in row.variants}) == 1:
        common += 1
    return common


def is_one_list(row: Keyword) -> bool:
    """Whether all forms of a statement are the beginning of the longest one."""
    return all(p.meaning == q.meaning for v in row.variants for p, q in zip(v.parameters, row.longest, strict=False))


def _repeated(parameters: Sequence[Parameter]) -> tuple[Sequence[Parameter], Argument | None]:
    """The parameters before a last one that repeats (coordinates, modes, numbered dimensions), and that one."""
    last = parameters[-1]
    if last.of in ("coordinate", "mode"):
        same = [p for p in parameters if p == last]
        if len(same) > 1 or len(parameters) == 2:
            return parameters[: -len(same)], Argument(f"{last.of}s", "int", (last,), False)
    stem = _NUMBERED.sub("", last.meaning)
    same = [p for p in parameters if _NUMBERED.sub("", p.meaning) == stem]
    if len(same) < MANY or stem == last.meaning:
        return parameters, None
    name = _NUMBERED.sub("", argument_name(last)).rstrip("_")
    several = f"{name}es" if name.endswith("s") else f"{name}s"
    return parameters[: -len(same)], Argument(several, "float", (last,), False)
