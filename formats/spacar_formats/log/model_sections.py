"""Log sections 2 and 3: the mechanism, its numbering and classes, its dynamic data (reference/files.md 2);
sections and materials of beams, and what they give (sections.md section 2)."""

from collections.abc import Sequence
from dataclasses import astuple

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.cross_section import SHAPES, BeamSection
from spacar.deck.findings import ranges
from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.length_unit import shown_in
from spacar.deck.table_types import BlockKind, Keyword
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import CLASSES, Numbering
from spacar_formats.log.text_layout import real, shown_head, shown_values, table

LETTER = {"fixed": "O", "calculable": "C", "input": "M", "dynamic": "M", "kinematic": "K"}
WORDS = {
    "fixed": "fixed", "calculable": "calculable", "input": "prescribed (degrees of freedom, MM)",
    "dynamic": "dynamic (degrees of freedom)", "kinematic": "kinematic (non-holonomic systems)",
}  # fmt: skip
DYNAMICS = (
    "XM", "EM", "XGYRO", "MEE", "ESTIFF", "EDAMP", "ESIG", "XF", "GRAVITY", "USERSIG", "INPUTX", "INPUTE", "STARTDX",
    "STARTDE", "USERINP", "DELXF", "DELGRAV", "DELOMF", "DELESIG", "DELINPX", "DELINPE",
)  # fmt: skip
MEASURED = tuple(t.keyword for t in ELEMENT_TYPES.values() if t.angle_family)


def class_letters(n: Numbering) -> tuple[list[str], list[str]]:
    """The letter of the class of every coordinate and of every deformation."""
    x, e = [""] * n.nx, [""] * n.ne
    for letters, slices in ((x, n.x_class), (e, n.e_class)):
        for name, where in slices.items():
            letters[where] = [LETTER[name]] * (where.stop - where.start)
    return x, e


def elements(n: Numbering) -> list[str]:
    """Type, nodes and deformations of every element, with numbers in e (array le) and classes."""
    _, letters = class_letters(n)
    rows = []
    for number, keyword, nodes in n.elements:
        modes = [f"{i} {letters[i - 1]}" if i else "" for i in n.le[number - 1].tolist()]
        rows.append([number, keyword, " ".join(map(str, nodes)), *modes])
    used = max(len(ELEMENT_TYPES[keyword].modes) for _, keyword, _ in n.elements)
    heads = ["element", "type", "nodes", *(f"mode {k + 1}" for k in range(used))]
    lines = ["Elements: numbers of the deformations in e (array le) and classes,",
             "O fixed, C calculable, M degree of freedom, K kinematic", ""]  # fmt: skip
    lines += table(heads, [row[: 3 + used] for row in rows])
    if len(n.normalization):
        pairs = ", ".join(f"{row + 1} (node {node})" for node, row in n.normalization.tolist())
        lines += ["", f"  normalization of Euler parameters, fixed deformations: {pairs}"]
    return [*lines, ""]


def measures(mechanism: Mechanism) -> list[str]:
    """Which beams and tubes are measured by angles (ADEFORM), which by sines."""
    rows = []
    for name, text in (("angle", "angles, fourth order in the length of the elements"), ("", "sines, second order")):
        numbers = [
            int(i)
            for b in mechanism.batches
            if b.family.measure == name and b.family.keyword in MEASURED
            for i in b.family.numbers
        ]
        if numbers:
            rows.append([text, " ".join(map(str, sorted(numbers)))])
    return ["Deformations of beams and tubes", "", *table(["measured by", "elements"], rows), ""] if rows else []


def nodes(n: Numbering) -> list[str]:
    """Coordinates of every node with their numbers in x (array lnp) and classes."""
    letters, _ = class_letters(n)
    rows = [
        [node.number, node.kind, *(f"{i} {letters[i - 1]}" if i else "" for i in n.lnp[node.number - 1].tolist())]
        for node in n.nodes
    ]
    used = max(node.size for node in n.nodes)
    lines = ["Nodes: numbers of the coordinates in x (array lnp) and classes", ""]
    heads = ["node", "type", *(f"coordinate {k + 1}" for k in range(used))]
    return [*lines, *table(heads, [row[: 2 + used] for row in rows]), ""]


def degrees_of_freedom(n: Numbering) -> list[str]:
    """The list q with the dynamic ones marked, then the kinematic configuration coordinates."""
    if not n.ndof + n.nk:
        return ["Degrees of freedom: none", ""]
    dynamic = set(n.dynamic.tolist())
    rows = [[i + 1, name, "dynamic" if i in dynamic else "prescribed"] for i, name in enumerate(n.q_names)]
    rows += [[n.ndof + i + 1, name, "kinematic"] for i, name in enumerate(n.k_names)]
    title = f"Degrees of freedom: {n.ndof}, of which {n.nddof} dynamic"
    title += f"; kinematic configuration coordinates: {n.nk}" if n.nk else ""
    return [title, "", *table(["number", "degree of freedom", "class"], rows), ""]


def counts(n: Numbering) -> list[str]:
    """Numbers per class: NEO NEC NEMM NEM of deformations and NXO NXC NXMM NXM of coordinates, in words."""
    rows = [
        [WORDS[name], int(x), int(e)]
        for name, x, e in zip(CLASSES, n.nxp, n.nep, strict=True)
        if name != "kinematic" or x + e
    ]
    rows.append(["all", n.nx, n.ne])
    return ["Numbers per class", "", *table(["class", "coordinates (NX)", "deformations (NE)"], rows), ""]


def dynamics(mechanism: Mechanism) -> list[str]:
    """Inertia, stiffness, damping, loads and prescribed motion as the input gives them, the total mass."""
    lines = []
    for name in DYNAMICS:
        lines += statements(mechanism, name, BlockKind.DYNAMICS)
    return [*lines, *total_mass(mechanism), ""]


def statements(mechanism: Mechanism, name: str, block: BlockKind) -> list[str]:
    """All statements of one keyword as tables, one for every form of the statement that occurs."""
    keyword = KEYWORDS.get((name, block))
    if keyword is None:
        return []
    groups: dict[int, list[Statement]] = {}
    for s in mechanism.deck.of(name, block=block.number):
        groups.setdefault(variant_of(mechanism.numbering, keyword, s), []).append(s)
    lines = []
    for index, group in groups.items():
        count = max(len(s.values) for s in group)
        variant, metre = keyword.variants[index], mechanism.deck.metre
        heads = [shown_head(p, metre) for p in variant.parameters[:count]]
        values = [shown_values(s, variant, mechanism.numbering, metre) for s in group]
        rows = [[*v, *[""] * (count - len(v))] for v in values]
        lines += [f"{name}: {keyword.help}", "", *table(heads, rows), ""]
    return lines


def total_mass(mechanism: Mechanism) -> list[str]:
    """Lumped mass of position nodes and distributed mass times undeformed length (with the fluid of tubes) [kg]."""
    n = mechanism.numbering
    length = {int(i): float(l) for b in mechanism.batches if b.family.keyword in ELEMENT_TYPES
              for i, l in zip(b.family.numbers, b.family.length, strict=True)}  # fmt: skip
    lumped = sum(s.real(1) for s in mechanism.deck.of("XM", block=2) if n.kind[s.integer(0)] == "position")
    distributed = sum(
        (s.real(1) + (s.real(2) if ELEMENT_TYPES[n.keyword[s.integer(0)]].carries_flow else 0.0)) * length[s.integer(0)]
        for s in mechanism.deck.of("EM", block=2)
    )
    parts = [f"  in nodes {real(lumped)} kg, distributed over elements {real(distributed)} kg"] if distributed else []
    return [f"Total mass: {real(lumped + distributed)} kg", *parts]


def variant_of(n: Numbering, keyword: Keyword, s: Statement) -> int:
    """Index of the form of the statement that fits this model, node or element."""
    space = "planar" if n.planar else "spatial"
    role = kind = ""
    for value, parameter in zip(s.values, keyword.variants[0].parameters, strict=False):
        if parameter.of.endswith("node") and isinstance(value, int):
            role = n.kind.get(value, "")
            break
        if parameter.of == "element" and isinstance(value, int):
            kind = n.keyword.get(value, "")
            break
    fitting = [i for i, v in enumerate(keyword.variants) if v.fits(space, role, kind)]
    of_size = [i for i in fitting if len(s.values) in keyword.variants[i].counts]
    return (of_size or fitting or [0])[0]


def coordinates(n: Numbering, metre: float = 1.0) -> tuple[list[tuple[int, str]], list[tuple[int, str]]]:
    """(node, name of the coordinate) of all x and (element, mode with unit) of all e, in their order."""
    x = []
    for i in range(n.nx):
        node, _, name = n.x_name(i).removeprefix("node ").partition(" ")
        x.append((int(node), name))
    e = []
    for i in range(n.ne):
        element, mode = n.e_owner(i)
        if element < 0:
            e.append((-element, "normalization"))
        else:
            words, unit = ELEMENT_TYPES[n.keyword[element]].modes[mode - 1]
            e.append((element, f"e{mode} {words} [{shown_in(unit, metre)[1]}]"))
    return x, e


CONSTANTS = (
    ("A", "m^2"), ("Iy", "m^4"), ("Iz", "m^4"), ("It", "m^4"), ("ky", ""), ("kz", ""), ("Cw", "m^6"),
)  # fmt: skip
PROPERTIES = (("E", "N/m^2"), ("G", "N/m^2"), ("nu", ""), ("rho", "kg/m^3"))


def beam_sections(deck: Deck) -> list[str]:
    """Constants of every section with its material, and the elements that have it; nothing without BEAMSEC."""
    lines = []
    if deck.first("UNITS") is not None:
        unit = shown_in("m", deck.metre)[1]
        lines += [
            f"UNITS: sections, statements, coordinates, deformations, forces and compliances are shown in {unit}, N,"
            f" N {unit}, kg, s;",
            "transfer functions, matrices, modes and all result files are in SI (m, kg, s, N)",
            "",
        ]
    if not deck.sections:
        return lines
    groups: dict[tuple[str, str], list[BeamSection]] = {}
    for use in deck.sections:
        groups.setdefault((use.section.casefold(), use.material_name.casefold()), []).append(use)
    sections, materials = [], {}
    for (_, material), uses in groups.items():
        use = uses[-1]
        dims = ", ".join(
            f"{what} {real(v / deck.metre**power)}"
            for v, (what, power) in zip(use.dims, SHAPES[use.shape].dims, strict=True)
        )
        numbers = ranges({number for each in uses for number in each.parts}, 20)
        row = [use.section, use.material_name, numbers, f"{use.shape}: {dims}"]
        sections.append([*row, *_in_units(astuple(use.constants), CONSTANTS, deck.metre)])
        m = use.material
        materials[material] = [use.material_name, *_in_units((m.E, m.G, m.nu, m.rho), PROPERTIES, deck.metre)]
    lines += ["Sections of beams, from which ESTIFF and EM follow", ""]
    heads = ["section", "material", "elements", f"shape ({shown_in('m', deck.metre)[1]})"]
    lines += [*table([*heads, *_heads(CONSTANTS, deck.metre)], sections), ""]
    return [*lines, *table(["material", *_heads(PROPERTIES, deck.metre)], materials.values()), ""]


def _heads(quantities: Sequence[tuple[str, str]], metre: float) -> list[str]:
    return [f"{name} ({shown_in(unit, metre)[1]})" if unit else name for name, unit in quantities]


def _in_units(values: Sequence[float], quantities: Sequence[tuple[str, str]], metre: float) -> list[float]:
    return [value * shown_in(unit, metre)[0] for value, (_, unit) in zip(values, quantities, strict=True)]
