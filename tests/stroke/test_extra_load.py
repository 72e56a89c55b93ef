"""The multiplier of one extra load alone against closed forms, and against the multiplier of all loads."""

import json

import numpy as np
import pytest
from spacar_cli.main import main

import spacar
from spacar.deck import parse_deck
from spacar.errors import UsageError

from . import stroke_models as models
from .stroke_models import EI, LENGTH

EULER = np.pi**2 * EI / LENGTH**2


def column(n: int, spatial: bool) -> str:
    """A cantilever along y of n beams, bending in xy, of the leaf's stiffness, ten times stiffer in the other plane."""
    lines, stiff = [], []
    for k in range(n + 1):
        place = f"0 {LENGTH * k / n!r}"
        lines.append(f"X {2 * k + 1} {place}" + " 0" * spatial)
    for k in range(1, n + 1):
        nodes = f"{2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}"
        lines += [f"BEAM {k} {nodes} 0 0 1" if spatial else f"PLBEAM {k} {nodes}", f"DYNE {k}"]
        more = f" {EI!r} {EI!r} {10 * EI!r} 0 0" if spatial else f" {EI!r}"
        stiff += [f"ESTIFF {k} {models.EA!r}" + more, f"EM {k} 0.2" + " 1e-6 5e-7 5e-7" * spatial]
    return "\n".join([*lines, "FIX 1", "FIX 2", "END", "HALT", *stiff, f"XM {2 * n + 1} 0.1", "END", "END"]) + "\n"


@pytest.mark.parametrize("beams", ["sine", "angle"])
@pytest.mark.parametrize("spatial", [False, True])
def test_a_preloaded_column_bears_the_rest(beams, spatial):
    """lambda = P_cr - P: pi^2 EI/(4 L^2) free at its end, 2.0457 pi^2 EI/L^2 with the end held (clamped, pinned)."""
    n, P = 8, 0.6 * EULER / 4.0
    deck = parse_deck(column(n, spatial))
    loads = {"loads": [f"17y={-P!r}"], "extra": ["17y=-2"]}
    study = spacar.flexure(deck, move="17x=1e-7", steps=1, beams=beams, **loads)
    for name, factor in (("extra_free", 0.25), ("extra", 2.045748)):
        limit = 3e-4 if beams == "angle" else 0.02
        assert 2.0 * study.of(name)[0] + P == pytest.approx(factor * EULER, rel=limit)
    # the same column, all loads multiplied: straight, its stresses are proportional to the load
    for extra, whole in (("extra_free", "margin_free"), ("extra", "margin")):
        assert 2.0 * study.of(extra)[0] == pytest.approx((study.of(whole)[0] - 1.0) * P, rel=1e-6)


def test_a_tension_cannot_buckle_it():
    deck = parse_deck(column(4, False))
    study = spacar.flexure(deck, move="9x=1e-7", steps=1, extra=["9y=1"])
    assert np.isinf(study.of("extra_free")[0])


def test_a_guide_under_stroke():
    """Two leaves with a payload P: drive free 2 pi^2 EI/L^2 - P, held 8 pi^2 EI/L^2 - P, less at 2 % of stroke."""
    P = 0.5 * EULER
    deck = parse_deck(models.two_leaves(models.GUIDE, 8))
    study = spacar.flexure(deck, move="9x=0.002", steps=2, loads=[f"9y={-P!r}"], extra=["9y=-4"], beams="angle")
    assert 4.0 * study.of("extra_free") == pytest.approx(2.0 * EULER - P, rel=0.01)
    assert 4.0 * study.of("extra")[0] == pytest.approx(8.0 * EULER - P, rel=0.01)


def test_the_extra_load_counts_as_given():
    """Twice the load, half the multiplier; two loads are one case; a load that acts beside gives what is left."""
    deck = parse_deck(models.two_leaves(models.GUIDE, 3))
    margins = [
        spacar.flexure(deck, move="9x=0.001", steps=1, extra=extra).of("extra_free")[-1]
        for extra in (["9y=-4"], ["9y=-8"], ["9y=-3", "9y=-1"])
    ]
    assert margins[1] == pytest.approx(margins[0] / 2, rel=1e-9)
    assert margins[2] == pytest.approx(margins[0], rel=1e-9)


@pytest.mark.parametrize("load", ["14rx", "14ry", "13z"])
def test_a_moment_brings_its_own_gradient(load):
    """Lateral buckling of the column with its end held along x, by moments of constant direction and by a force: the
    multiplier of the extra load without other loads is that of all loads when a small one of its kind is the only one.
    """
    small, unit = 1e-4, 0.1
    deck = parse_deck(column(6, True))
    extra = spacar.flexure(deck, move="13x=1e-9", steps=1, extra=[f"{load}={unit!r}"]).of("extra")[0]
    whole = spacar.flexure(deck, move="13x=1e-9", steps=1, loads=[f"{load}={small!r}"]).of("margin")[0]
    assert unit * extra == pytest.approx(small * whole, rel=1e-4)


def test_lateral_buckling_by_a_force_at_the_end():
    """4.0126 sqrt(EI GIt)/L^2 of a deep cantilever (Timoshenko and Gere); a depth of ten in stiffness is 1 % off."""
    study = spacar.flexure(parse_deck(column(8, True)), move="17y=1e-9", steps=1, extra=["17z=2"])
    assert 2.0 * study.of("extra_free")[0] == pytest.approx(4.0126 * EI / LENGTH**2, rel=0.02)


def test_the_command(tmp_path, capsys):
    """A column of the table, the columns of csv and json, the sentence below the table; a wrong load is refused."""
    (tmp_path / "guide.dat").write_text(models.two_leaves(models.GUIDE, 3))
    words = ["flexure", str(tmp_path / "guide.dat"), "--move", "9x=0.002", "--steps", "1", "--extra", "9y=-4"]
    assert main([*words, "--json"]) == 0
    columns = json.loads(capsys.readouterr().out)["columns"]
    assert 4 * columns["margin_extra_free"][0] == pytest.approx(2 * EULER, rel=0.06)
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "margin extra free" in said
    assert "of 9y=-4 alone" in said
    for wrong in ("9y=-1:1", "e[1,1]=3", "99y=1"):
        assert main([*words, "--extra", wrong]) == 2
        assert "--extra" in capsys.readouterr().err
    with pytest.raises(UsageError, match="--extra"):
        spacar.flexure(tmp_path / "guide.dat", move="9x=0.002", extra=["9q=1"])
