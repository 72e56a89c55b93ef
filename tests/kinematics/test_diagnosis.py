"""Mode 0: counts, names and suggestions for mechanisms with several redundancies and free motions at once."""

import re

import pytest

import spacar
from spacar.errors import AnalysisError
from spacar.kinematics.diagnosis import Diagnosis
from spacar.mechanism import build


def diagnosis(rows: list[tuple]) -> Diagnosis:
    return spacar.run(0, spacar.Deck.build(rows)).header["diagnosis"]


def scaled(rows: list[tuple], factor: float) -> list[tuple]:
    """The same mechanism in other units of length."""
    return [(r[0], r[1], *(factor * v for v in r[2:])) if r[0] == "X" else r for r in rows]


def released(rows: list[tuple], d: Diagnosis) -> list[tuple]:
    """The rows with the suggestions of the diagnosis carried out."""
    rows = list(rows)
    for name in d.releases:
        element, mode = re.fullmatch(r"element (\d+) \(\w+\) e(\d) .*", name).groups()
        rows.append(("RLSE", int(element), int(mode)))
    for name in d.freedoms:
        node, which = re.fullmatch(r"node (\d+) (\w+)", name).groups()
        number = {"x": 1, "y": 2, "z": 3, "phi": 1, "lambda1": 2, "lambda2": 3, "lambda3": 4}[which]
        rows.append(("DYNX", int(node), number))
    return rows


# A planar square of 1 m with both diagonals and both lower nodes fixed: one bar too many.
FRAME = [
    ("PLTRUSS", 1, 1, 3), ("PLTRUSS", 2, 2, 4), ("PLTRUSS", 3, 3, 4), ("PLTRUSS", 4, 1, 4), ("PLTRUSS", 5, 2, 3),
    ("X", 1, 0.0, 0.0), ("X", 2, 1.0, 0.0), ("X", 3, 0.0, 1.0), ("X", 4, 1.0, 1.0), ("FIX", 1), ("FIX", 2),
]  # fmt: skip
# Two such squares side by side, in the second one the bar 13 is missing too: it is a mechanism twice.
TWO = [
    *FRAME,
    ("PLTRUSS", 11, 11, 13), ("PLTRUSS", 12, 12, 14),
    ("X", 11, 3.0, 0.0), ("X", 12, 4.0, 0.0), ("X", 13, 3.0, 1.0), ("X", 14, 4.0, 1.0), ("FIX", 11), ("FIX", 12),
]  # fmt: skip
# A spatial door with three hinges on the same line: each further one is redundant in five ways.
DOOR = [
    ("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("RBEAM", 2, 3, 2, 4, 1.0, 0.0, 0.0), ("RBEAM", 3, 3, 2, 5, 1.0, 0.0, 0.0),
    ("HINGE", 4, 6, 2, 0.0, 0.0, 1.0),
    ("X", 3, 0.0, 0.0, 0.0), ("X", 4, 0.0, 0.0, 1.0), ("X", 5, 0.0, 0.0, 2.0),
    ("FIX", 1), ("FIX", 3), ("FIX", 4), ("FIX", 5), ("FIX", 6), ("INPUTE", 1, 1), ("RLSE", 4, 1),
]  # fmt: skip
# A planar four-bar parallelogram with a third crank on the same motion: over-constrained once, a true mechanism.
PARALLEL = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 4, 5, 6), ("PLRBEAM", 3, 7, 8, 9), ("PLRBEAM", 4, 3, 10, 6),
    ("PLPINBOD", 5, 3, 10, 9),
    ("X", 3, 0.0, 1.0), ("X", 4, 1.0, 0.0), ("X", 6, 1.0, 1.0), ("X", 7, 2.0, 0.0), ("X", 9, 2.0, 1.0),
    ("FIX", 1), ("FIX", 4), ("FIX", 7), ("INPUTX", 2),
]  # fmt: skip


@pytest.mark.parametrize(
    ("rows", "over", "under"),
    [(FRAME, 1, 0), (TWO, 1, 2), (DOOR, 8, 0), (PARALLEL, 1, 0)],
    ids=["frame", "two", "door", "parallel"],
)
def test_counts_and_repair(rows: list[tuple], over: int, under: int) -> None:
    d = diagnosis(rows)
    assert (d.over, d.under) == (over, under)
    assert len(d.releases) == over
    assert len(d.freedoms) == under
    repaired = diagnosis(released(rows, d))
    assert (repaired.over, repaired.under) == (0, 0)
    # Not only regular but well conditioned: the largest component is released first.
    assert repaired.condition < 100


@pytest.mark.parametrize("rows", [FRAME, TWO, DOOR, PARALLEL], ids=["frame", "two", "door", "parallel"])
@pytest.mark.parametrize("factor", [1e3, 1e-3, 1e-6])
def test_units_do_not_matter(rows: list[tuple], factor: float) -> None:
    a, b = diagnosis(rows), diagnosis(scaled(rows, factor))
    assert (a.over, a.under, a.releases, a.freedoms) == (b.over, b.under, b.releases, b.freedoms)
    for (wa, na), (wb, nb) in zip(a.deformations, b.deformations, strict=True):
        assert wa == pytest.approx(wb, abs=1e-9)
        assert na == nb
    assert a.singular == pytest.approx(b.singular, abs=1e-12)


def test_the_state_of_self_stress_is_named() -> None:
    """The braced square: the bars 3, 4, 5 carry 1, -sqrt 2, -sqrt 2, the posts 1, 2 carry 1."""
    d = diagnosis(FRAME)
    weights = {int(name.split()[1]): weight for weight, name in d.deformations}
    expected = {1: 1 / 7, 2: 1 / 7, 3: 1 / 7, 4: 2 / 7, 5: 2 / 7}
    assert weights == pytest.approx(expected, abs=1e-9)  # weights are rounded so that ties are stable
    assert [w for w, _ in d.deformations] == sorted((w for w, _ in d.deformations), reverse=True)
    assert d.deformations[0][1] == "element 4 (PLTRUSS) e1 elongation"


def test_what_is_named_and_suggested() -> None:
    """In the second square both upper nodes can move sideways. Normalizations take part in over-constraints of spatial
    mechanisms but have no keyword, and lambda0 is no degree of freedom."""
    d = diagnosis(TWO)
    assert {name for _, name in d.coordinates} == {"node 13 x", "node 14 x"}
    assert set(d.freedoms) == {"node 13 x", "node 14 x"}
    assert all(name.startswith("element") for name in diagnosis(DOOR).releases)
    d = diagnosis([("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("FIX", 1), ("RLSE", 1)])
    assert d.under == 3
    assert set(d.freedoms) == {"node 2 lambda1", "node 2 lambda2", "node 2 lambda3"}


def test_regular_mechanism() -> None:
    d = diagnosis([("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2)])
    assert (d.over, d.under, d.releases, d.freedoms) == (0, 0, (), ())
    assert d.condition == pytest.approx(1.0)
    assert d.lines()[-1] == "the mechanism is neither over- nor under-constrained"


def test_the_report_is_a_ranked_list_with_suggestions() -> None:
    text = "\n".join(spacar.run(0, spacar.Deck.build(TWO)).report)
    for line in (
        "over-constrained 1 time; deformations that take part:",
        "under-constrained 2 times; coordinates that move:",
        "suggestion: release element 4 (PLTRUSS) e1 elongation (RLSE)",
        "suggestion: make node 13 x a degree of freedom (DYNX, INPUTX) or support it (FIX)",
    ):
        assert line in text


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (FRAME, ("5 fixed", "4 calculable", "+1", "over-constrained", "element 4 (PLTRUSS) e1", "spacar 0")),
        (TWO, ("7 fixed", "8 calculable", "-1", "under-constrained", "node 13 x", "spacar 0")),
    ],
)
def test_other_modes_refuse_an_ill_defined_mechanism(rows: list[tuple], words: tuple[str, ...]) -> None:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, spacar.Deck.build(rows))
    assert caught.value.code == "mechanism.count"
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_equal_counts_but_singular() -> None:
    """One bar too many here, one too few there: counted right, and named all the same."""
    rows = [*TWO, ("PLTRUSS", 13, 13, 14)]
    d = diagnosis(rows)
    assert (d.over, d.under) == (1, 1)
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, spacar.Deck.build(rows))
    assert caught.value.code == "position.singular"
    assert "element 4 (PLTRUSS) e1 elongation" in str(caught.value)
    assert re.search(r"node 1[34] x", str(caught.value))


def test_a_singular_position_with_rounding_is_seen() -> None:
    """A bar that is almost a diagonal of nothing: singular to 1e-9 counts as singular, 1e-6 does not."""

    def folded(angle: float) -> list[tuple]:
        return [
            ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("X", 2, 1.0, angle), ("X", 3, 2.0), ("FIX", 1), ("FIX", 3),
        ]  # fmt: skip

    assert diagnosis(folded(1e-9)).under == 1
    assert diagnosis(folded(1e-6)).under == 0


def test_bigd_is_stored_with_the_rows_and_columns_of_e_and_x() -> None:
    deck = spacar.Deck.build(FRAME)
    n = build(deck).numbering
    bigd = spacar.run(0, deck)["bigd"][0]
    assert bigd.shape == (n.ne, n.nx)
    # element 5 from node 2 (1, 0) to node 3 (0, 1): unit vector (-1, 1)/sqrt 2
    row = bigd[n.e_index(5, 1)]
    assert row[n.x_index(3, 1)] == pytest.approx(-(0.5**0.5))
    assert row[n.x_index(2, 1)] == pytest.approx(0.5**0.5)
    assert abs(row).sum() == pytest.approx(4 * 0.5**0.5)
