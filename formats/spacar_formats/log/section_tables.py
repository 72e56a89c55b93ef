"""Log: the sections and materials of beams, and what they give (sections.md section 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple

from spacar.deck import Deck
from spacar.deck.cross_section import SHAPES
from spacar.deck.findings import ranges
from spacar.deck.length_unit import shown_in
from spacar_formats.log.text_layout import real, table

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
    groups: dict[tuple[str, str], list[int]] = {}
    of = {}
    for use in deck.sections:
        key = use.section.casefold(), use.material_name.casefold()
        groups.setdefault(key, []).extend(use.parts)
        of[key] = use
    sections, materials = [], {}
    for key, numbers in groups.items():
        use = of[key]
        dims = ", ".join(
            f"{what} {real(v / deck.metre**power)}"
            for v, (what, power) in zip(use.dims, SHAPES[use.shape].dims, strict=True)
        )
        row = [use.section, use.material_name, ranges(set(numbers), 20), f"{use.shape}: {dims}"]
        sections.append([*row, *_shown(astuple(use.constants), CONSTANTS, deck.metre)])
        m = use.material
        materials[key[1]] = [use.material_name, *_shown((m.E, m.G, m.nu, m.rho), PROPERTIES, deck.metre)]
    lines += ["Sections of beams, from which ESTIFF and EM follow", ""]
    heads = ["section", "material", "elements", f"shape ({shown_in('m', deck.metre)[1]})"]
    lines += [*table([*heads, *_heads(CONSTANTS, deck.metre)], sections), ""]
    return [*lines, *table(["material", *_heads(PROPERTIES, deck.metre)], materials.values()), ""]


def _heads(quantities: Sequence[tuple[str, str]], metre: float) -> list[str]:
    return [f"{name} ({shown_in(unit, metre)[1]})" if unit else name for name, unit in quantities]


def _shown(values: Sequence[float], quantities: Sequence[tuple[str, str]], metre: float) -> list[float]:
    return [value * shown_in(unit, metre)[0] for value, (_, unit) in zip(values, quantities, strict=True)]
