"""Every table that depends on the element types, asked for every element; and no list of elements anywhere else."""

import ast
import re
from pathlib import Path

import pytest
from spacar_drawing.element_pictures import PARTS
from spacar_drawing.scene import ROUND

from spacar.deck import ELEMENT_TYPES, KEYWORDS, BlockKind
from spacar.deck.table_dynamics import MASS_FORMS
from spacar.elements import definitions, family_of

HOUSE = Path(__file__).resolve().parents[2]
TYPES = [t for t in ELEMENT_TYPES.values() if t.supported]
SIZES = {(True, "position"): 2, (True, "orientation"): 1, (False, "position"): 3, (False, "orientation"): 4}
SIZES[False, "warping"] = 1
# Who else may name an element than its family and its symbolic model, and why
NAMED = {
    "spacar/deck/table_elements.py": "its row",
    "spacar/deck/checks_geometry.py": "checks of its own numbers",
    "cli/spacar_drawing/element_pictures.py": "pictures of its own",
    "spacar/deck/cross_section.py": "TUBE is a shape there",
    "cli/spacar_cli/deck_as_text.py": "what it is in a symbolic model; others are refused by name",
}  # fmt: skip

every_type = pytest.mark.parametrize("kind", TYPES, ids=lambda t: t.keyword)


def coordinates(kind):
    return sum(SIZES[kind.planar, role] for role in kind.nodes)


@every_type
def test_family(kind):
    family = family_of(kind.family)
    assert (family.n_coordinates, family.n_deformations) == (coordinates(kind), len(kind.modes))
    assert family.slips == kind.slips
    starts = [sum(SIZES[kind.planar, r] for r in kind.nodes[:k]) for k in range(len(kind.nodes))]
    places = [
        s + i for s, r in zip(starts, kind.nodes, strict=True) if r == "position" for i in range(SIZES[kind.planar, r])
    ]
    assert family.position_rows == tuple(places)


def forms(statement, kind):
    return [v for v in KEYWORDS[statement, BlockKind.DYNAMICS].variants if kind.keyword in v.types]


@every_type
def test_forms_of_stiffness_damping_mass_and_preload(kind):
    """One form each; ESTIFF has every position that the row names, and a type that only slips has none."""
    stiffness, damping, mass = (forms(name, kind) for name in ("ESTIFF", "EDAMP", "EM"))
    assert len(stiffness) == (1 if kind.stiffness else 0)
    assert not stiffness or stiffness[0].counts[-1] >= max(kind.stiffness)
    assert len(damping) == 1
    assert len(mass) == (1 if kind.mass else 0)
    (preload,) = forms("ESIG", kind)
    assert preload.counts[-1] == 1 + len(kind.modes)
    assert not kind.released or all(len(kind.stiffness) >= m for m in (2, *kind.released))
    if kind.coefficients == "modes" and kind.stiffness:
        assert kind.stiffness == tuple(range(2, 2 + len(kind.modes)))


def test_every_form_and_statement_of_a_row_exists_and_every_form_is_used():
    assert {t.mass for t in TYPES} - {""} == set(MASS_FORMS)
    known = {name for name, _ in KEYWORDS}
    assert {name for t in TYPES for name in t.statements} <= known
    for name, block in KEYWORDS:
        for variant in KEYWORDS[name, block].variants:
            assert set(variant.types) <= set(ELEMENT_TYPES), name


@every_type
def test_statements_for_some_types(kind):
    """A statement has a form with this type when the row says so, and no other restricted statement has."""
    common = {"ESTIFF", "EDAMP", "EM", "ESIG", "DELESIG"}
    found = {name for (name, _), k in KEYWORDS.items() if any(kind.keyword in v.types for v in k.variants)}
    assert found - common == set(kind.statements)


@every_type
def test_facts_agree_with_the_modes(kind):
    first = kind.modes[0]
    assert not kind.axial or (first == ("elongation", "m") and kind.length == "always")
    assert not kind.normal_mode or kind.modes[kind.normal_mode - 1][0].startswith("height of the contact point")
    for p, q in kind.split:
        assert (kind.modes[p - 1][0][:12], kind.modes[q - 1][0][:12]) == ("bending at p", "bending at q")
    assert not kind.carries_flow or kind.mass.endswith("tube")


@every_type
def test_ends(kind):
    """Every node is at one end, with its role; warping nodes are listed apart, one for each released deformation."""
    assert sorted(p for p in (*kind.ends, *kind.warping) if p is not None) == list(range(len(kind.nodes)))
    assert len(kind.warping) == len(kind.released)
    for place, role in zip(kind.ends, ("position", "orientation") * 2, strict=True):
        assert place is None or kind.nodes[place] == role


def test_the_ends_of_the_types_of_the_reference():
    """Written down once more, from section 3 of the input language."""
    expected = {
        (0, 1, 2, 3): "PLBEAM PLTUBE PLBELT PLBEAR BEAM TUBE SCREW",
        (0, None, 1, None): "PLTRUSS TRUSS",
        (None, 0, None, 1): "PLTOR HINGE",
        (0, 1, 2, None): "PLRBEAM PLPINBOD RBEAM PINBODY WHEEL TWHEEL",
        (0, 1, None, 2): "PLWHEEL",
        (0, 1, 3, 4): "BEAMW",
    }
    for ends, words in expected.items():
        assert {ELEMENT_TYPES[word].ends for word in words.split()} == {ends}


def test_shapes():
    """Each drawing belongs to some element; an element without one is drawn as `plain`."""
    shapes = {t.shape for t in TYPES}
    assert set(ROUND) <= set(PARTS) <= shapes


@every_type
def test_compiled_form(kind):
    """Every element has one in each measure, with the coordinates, modes and parameters of the family."""
    pytest.importorskip("sympy")
    from spacar.compiled.generator.generate import rows_of

    for family in filter(None, (kind.family, kind.angle_family)):
        (definition,) = [d for d in definitions() if d.name == family_of(family).definition]
        assert definition.n_coordinates == coordinates(kind)
        assert rows_of(definition) == (len(kind.modes) - len(kind.slips), len(kind.slips))
        assert (definition.line is not None) == (kind.shape == "beam")
        assert (definition.flow is not None) == kind.carries_flow


def test_no_other_module_names_an_element():
    """A list of elements somewhere else is a list that a new element must be added to."""
    bad = []
    for room in ("spacar", "formats", "cli"):
        for path in sorted((HOUSE / room).rglob("*.py")):
            place = path.relative_to(HOUSE).as_posix()
            if place in NAMED or place.startswith(("spacar/elements/", "spacar/symbolic/")):
                continue
            text = path.read_text(encoding="utf-8")
            if not set(re.findall(r"[A-Z]+", text)) & set(ELEMENT_TYPES):
                continue
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    words = node.value.split()
                    if words and set(words) <= set(ELEMENT_TYPES):
                        bad.append(f"{place}:{node.lineno} {node.value}")
    assert not bad, "\n".join(bad)
