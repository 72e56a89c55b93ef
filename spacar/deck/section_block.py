"""SECTION, MATERIAL and BEAMSEC to the plain statements that they stand for (sections.md section 1)."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from spacar.deck.cross_section import (
    LEAST,
    MATERIALS,
    SHAPES,
    ZERO_ALLOWED,
    BeamSection,
    Expansion,
    Material,
    SectionConstants,
    isotropic,
    planar_rows,
    spatial_rows,
    warping_rows,
)
from spacar.deck.findings import Findings, alternatives, nearest
from spacar.deck.outline import Outline
from spacar.deck.rewrite.divide import PAIRS, divided, obstacles, stiffness_modes
from spacar.deck.rewrite.references import made
from spacar.deck.statement import Statement, StatementGroup, again
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_kinematics import WORDS

ROWS = {"planar beam": planar_rows, "spatial beam": spatial_rows, "spatial beam with warping": warping_rows}


class _GivenSection(NamedTuple):
    shape: str
    dims: tuple[float, ...]


def expand(statements: Sequence[Statement], outline: Outline, findings: Findings) -> Expansion:
    """Replace the statements of this block; errors go to the findings, and leave the others as they are."""
    plain = [s for s in statements if s.keyword not in WORDS]
    uses = [s for s in statements if s.keyword == "BEAMSEC"]
    before = len(findings.errors)
    sections = _sections([s for s in statements if s.keyword == "SECTION"], outline.metre, findings)
    materials = _materials([s for s in statements if s.keyword == "MATERIAL"], findings)
    _once([s for s in statements if s.keyword == "UNITS"], findings)
    chosen = {s.integer(0): _use(s, plain, sections, materials, outline, findings) for s in uses}
    _once(uses, findings)
    # what a wrong BEAMSEC stands for is not missed
    outline.broken.update((word, n) for n, use in chosen.items() if use is None for word in ("ESTIFF", "EM"))
    if len(findings.errors) > before or not uses or None in chosen.values():
        return Expansion(tuple(plain), outline, (), ())
    pieces = {s.integer(0): s.integer(3) if len(s.values) > 3 else 1 for s in uses}
    by = {s.integer(0): s for s in uses}
    for number, s in by.items():
        _, material, constants = chosen[number]  # type: ignore[misc]
        stiffness, mass = ROWS[outline.types[number].coefficients](constants, material)
        plain.append(made(s, number, *stiffness, keyword="ESTIFF", block=2))
        if material.rho:
            plain.append(made(s, number, *mass, keyword="EM", block=2))
    several = [number for number, n in pieces.items() if n > 1]
    for number, about, reason in obstacles(plain, several, stiffness_modes(plain)):
        findings.error(about or by[number], 3, f"beam {number} cannot be divided: {reason}", "section")
    if len(findings.errors) > before:
        return Expansion(tuple(plain), outline, (), ())
    full, parts = divided(plain, pieces)
    found, drawn = [], []
    for s in uses:
        number = s.integer(0)
        section, material, constants = chosen[number]  # type: ignore[misc]
        names = str(s.values[1]), str(s.values[2])
        its = tuple(parts.get(number, (number,)))
        found.append(BeamSection(number, its, *names, section.shape, section.dims, constants, material))
        drawn += _drawn(found[-1])
    return Expansion(tuple(full), _outline_of(full, outline), tuple(found), tuple(drawn))


def _sections(statements: Sequence[Statement], metre: float, findings: Findings) -> dict[str, _GivenSection | None]:
    """Sections by name in small letters; None for a wrong one, about which an error was said."""
    _once(statements, findings)
    found: dict[str, _GivenSection | None] = {}
    for s in statements:
        name, word = str(s.values[0]), str(s.values[1]).upper()
        found.setdefault(name.casefold(), None)
        shape = SHAPES.get(word)
        dims = s.reals(2, len(s.values) - 2)
        if shape is None:
            near = nearest(word, SHAPES, 0.5)
            looks = f"; nearest: {near}" if near else ""
            text = f"there is no shape '{s.values[1]}'{looks}; shapes: {', '.join(SHAPES)}"
            findings.error(s, 1, text, "section")
            continue
        names = [what for what, _ in shape.dims]
        least = LEAST.get(word, len(names))
        if not least <= len(dims) <= len(names):
            counts = alternatives(set(range(least, len(names) + 1)))
            text = f"{len(dims)} numbers for a {shape.title}; expected {counts}: {', '.join(names)}"
            findings.error(s, len(s.values) - 1, text, "section")
            continue
        dims += (0.0,) * (len(names) - len(dims))
        bad = [k for k, v in enumerate(dims) if v < 0.0 or (v == 0.0 and names[k] not in ZERO_ALLOWED)]
        shown = [v / metre**power for v, (_, power) in zip(dims, shape.dims, strict=True)]  # as in the file
        wrong = "" if bad else shape.wrong("m" if metre == 1.0 else "mm", *shown)
        if bad:
            text = f"{names[bad[0]]} of a {shape.title} is {shown[bad[0]]:g}; it must be positive"
            findings.error(s, 2 + bad[0], text, "section")
        elif wrong:
            findings.error(s, 2, wrong, "section")
        else:
            found[name.casefold()] = _GivenSection(word, dims)
    return found


def _materials(statements: Sequence[Statement], findings: Findings) -> dict[str, Material | None]:
    """Materials by name in small letters, the known ones too; None for a wrong one, about which an error was said."""
    _once(statements, findings)
    found: dict[str, Material | None] = dict(MATERIALS)
    for s in statements:
        found[str(s.values[0]).casefold()] = None
        E, G, rho = s.reals(1, 3)
        if E <= 0.0:
            findings.error(s, 1, f"Young's modulus {E:g} must be positive", "material")
        elif G <= -1.0:
            findings.error(s, 2, f"Poisson's ratio {G:g} must be above -1 and at most 0.5", "material")
        elif rho < 0.0:
            findings.error(s, 3, f"density {rho:g} must not be negative", "material")
        else:
            found[str(s.values[0]).casefold()] = isotropic(E, G, rho) if G <= 0.5 else Material(E, G, rho)
    return found


def _once(statements: Sequence[Statement], findings: Findings) -> None:
    """The same name, element or unit again is an error."""
    for s, first in again(("" if s.keyword == "UNITS" else str(s.values[0]).casefold(), s) for s in statements):
        findings.error(s, 0, f"already given at line {first.line}; give it once", "repeated")


def _use(
    s: Statement, plain: Sequence[Statement], sections: Mapping[str, _GivenSection | None],
    materials: Mapping[str, Material | None], outline: Outline, findings: Findings,
) -> tuple[_GivenSection, Material, SectionConstants] | None:  # fmt: skip
    """Section, material and constants of a BEAMSEC; None after an error."""
    number = s.integer(0)
    kind = outline.types.get(number)
    if kind is None:
        return None
    if kind.keyword not in PAIRS or kind.coefficients not in ROWS:
        able = ", ".join(k for k in PAIRS if ELEMENT_TYPES[k].coefficients in ROWS)
        findings.error(s, 0, f"element {number} is a {kind.keyword} ({kind.title}); BEAMSEC is for {able}", "section")
        return None
    for other in plain:
        if other.block == 2 and other.keyword in ("ESTIFF", "EM") and other.values[0] == number:
            text = f"{other.keyword} {number} at line {other.line} is given too; BEAMSEC stands for it: give one"
            findings.error(s, 0, text, "section")
    if len(s.values) > 3 and s.integer(3) < 1:
        findings.error(s, 3, f"number of beams {s.values[3]} must be at least 1", "range")
    found: list[object] = []
    for place, table, noun in ((1, sections, "SECTION"), (2, materials, "MATERIAL")):
        name = str(s.values[place])
        thing = table.get(name.casefold())
        if thing is None:
            if name.casefold() in table or any(keyword == noun for keyword, _ in outline.broken):
                return None  # its own statement is wrong
            near = nearest(name.casefold(), table, 0.6)
            known = f"; nearest: {near}" if near else f"; known: {', '.join(table) or 'none'}"
            findings.error(s, place, f"there is no {noun} '{name}'{known}", "section")
            return None
        found.append(thing)
    section, material = found
    assert isinstance(section, _GivenSection)
    assert isinstance(material, Material)
    return section, material, SHAPES[section.shape].constants(*section.dims, material.nu)


def _outline_of(statements: Sequence[Statement], before: Outline) -> Outline:
    outline = Outline(
        complete=before.complete, broken=before.broken, broken_blocks=before.broken_blocks, metre=before.metre
    )
    for s in sorted((s for s in statements if s.keyword in ELEMENT_TYPES), key=lambda s: s.line):
        outline.add(StatementGroup.of(s))
    return outline


def _drawn(use: BeamSection) -> list[str]:
    """Lines of the visualization section for the parts of a beam."""
    if use.picture is None:
        return []
    word, dims = use.picture
    numbers = " ".join(map(str, use.parts))
    return [f"BEAMPROPS {numbers}", f"CROSSTYPE {word}", f"CROSSDIM {' '.join(repr(d) for d in dims)}"]
