"""ADEFORM, --beams and the option beams: which beams are measured by angles, and where it is said."""

import numpy as np
import pytest
from spacar_cli.main import main
from spacar_formats.sbf import SbfFile

import spacar
from spacar import Deck
from spacar.compiled.numbers import without_form
from spacar.deck.rewrite.refine import refine
from spacar.errors import InputError, UsageError
from spacar.mechanism import build

ROWS = [
    ("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 4, 5, 6), ("PLTRUSS", 3, 1, 5), ("X", 3, 1.0, 0.0), ("X", 5, 2.0, 0.0),
    ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3), ("DYNE", 2, 2, 3), ("RLSE", 3, 1),
]  # fmt: skip
LOADS = [*(("ESTIFF", k, 0.0, 1.0) for k in (1, 2)), *(("EM", k, 1.0) for k in (1, 2)), ("XF", 5, 0.0, -1.0)]


def measures(deck: Deck, **options) -> dict[int, str]:
    families = [b.family for b in build(deck, 7, **options).batches if b.family.keyword in ("PLBEAM", "PLTRUSS")]
    return {int(n): f.measure for f in families for n in f.numbers}


@pytest.mark.parametrize(
    ("rows", "beams", "expected"),
    [
        ([], None, ("", "", "")),
        ([("ADEFORM",)], None, ("angle", "angle", "")),
        ([("ADEFORM", 2)], None, ("", "angle", "")),
        ([("ADEFORM", 2)], "angle", ("angle", "angle", "")),
        ([("ADEFORM",)], "sine", ("", "", "")),
    ],
)
def test_which_elements(rows, beams, expected):
    assert measures(Deck.build([*ROWS, *rows], LOADS), beams=beams) == dict(zip((1, 2, 3), expected, strict=True))


def test_both_measures_in_one_model():
    """Deformations of the elements of either batch are in the places of their numbers."""
    result = spacar.run(7, Deck.build([*ROWS, ("ADEFORM", 2)], LOADS))
    n, e = result.mechanism.numbering, result.frames[-1].e

    def at(node):
        return np.array([result.node(node, k)[-1] for k in (1, 2)])

    for element, p, q, measure in ((1, 1, 3, np.sin), (2, 3, 5, lambda a: a)):
        chord = at(q) - at(p)
        angle = result.node(p + 1, 1)[-1] - np.arctan2(chord[1], chord[0])
        assert abs(angle) > 0.01
        assert e[n.e_index(element, 2)] == pytest.approx(measure(angle), rel=1e-12)


def test_result_file_and_log_name_the_measure(tmp_path):
    (tmp_path / "m.dat").write_text(Deck.build([*ROWS, ("ADEFORM", 2)], LOADS).to_text())
    for options, kdform, words in (
        ((), (1, 2, 0), ("angles, fourth order in the length of the elements  2", "sines, second order")),
        (("--beams", "angle"), (2, 2, 0), ("angles, fourth order in the length of the elements  1 2", "--beams")),
    ):
        assert main(["7", str(tmp_path / "m.dat"), "--quiet", *options]) == 0
        with SbfFile(tmp_path / "m.sbd") as file:
            assert tuple(np.ravel(file.get("KDEF"))) == kdform
        log = (tmp_path / "m.log").read_text()
        assert all(w in " ".join(log.split("\n")) or w.replace("  ", " ") in " ".join(log.split()) for w in words), log


def test_wrong_input_is_told():
    with pytest.raises(InputError, match=r"PLTRUSS.*ADEFORM is for PLBEAM, PLTUBE, BEAM, BEAMW, TUBE"):
        Deck.build([*ROWS, ("ADEFORM", 3)], LOADS)
    with pytest.raises(InputError, match="already given"):
        Deck.build([*ROWS, ("ADEFORM", 1), ("ADEFORM", 1)], LOADS)
    with pytest.raises(UsageError, match="beams = 'cosine' is one of angle, sine"):
        spacar.run(7, Deck.build(ROWS, LOADS), beams="cosine")


def test_refined_beams_keep_the_measure():
    deck = refine(Deck.build([*ROWS, ("ADEFORM", 2)], LOADS), 2)
    assert sorted(measures(deck).values()) == ["", "", "", "angle", "angle"]


def test_both_measures_have_a_compiled_form():
    rows = [("PLTUBE", *r[1:]) if r[0] == "PLBEAM" else r for r in ROWS]
    for measure in ([], [("ADEFORM",)]):
        assert without_form(build(Deck.build([*rows, *measure], [*LOADS[:2], LOADS[4]]), 1)) == []
