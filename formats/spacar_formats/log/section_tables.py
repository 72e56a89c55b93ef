"""Log: the sections and materials of beams, and what they give (sections.md section 2)."""

from __future__ import annotations

from dataclasses import astuple

from spacar.deck import Deck
from spacar.deck.cross_section import SHAPES
from spacar.deck.findings import ranges
from spacar_formats.log.text_layout import real, table


def beam_sections(deck: Deck) -> list[str]:
    """Constants of every section with its material, and the elements that have it; nothing without BEAMSEC."""
    lines = []
    if deck.first("UNITS") is not None:
        lines += ["UNITS: lengths of the input were converted; everything from here on is in SI (m, kg, s, N)", ""]
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
            f"{what} {real(v)}" for v, (what, _) in zip(use.dims, SHAPES[use.shape].dims, strict=True)
        )
        c = use.constants
        row = [use.section, use.material_name, ranges(set(numbers), 20)]
        sections.append([*row, f"{use.shape}: {dims}", *astuple(c)])
        m = use.material
        materials[key[1]] = [use.material_name, m.E, m.G, m.nu, m.rho]
    heads = ["section", "material", "elements", "shape (m)", "A (m^2)", "Iy (m^4)", "Iz (m^4)", "It (m^4)", "ky", "kz"]
    lines += ["Sections of beams, from which ESTIFF and EM follow", ""]
    lines += [*table([*heads, "Cw (m^6)"], sections), ""]
    heads = ["material", "E (N/m^2)", "G (N/m^2)", "nu", "rho (kg/m^3)"]
    return [*lines, *table(heads, materials.values()), ""]
