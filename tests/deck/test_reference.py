"""docs/keywords.md is the page that the table makes, and the table is complete."""

from __future__ import annotations

from pathlib import Path

import pytest

from spacar.deck.reference import markdown
from spacar.deck.table import KEYWORDS
from spacar.deck.table_types import Block

PAGE = Path(__file__).parents[2] / "docs" / "keywords.md"
NAMES = {
    Block.KINEMATICS: """PLBEAM PLTRUSS PLTOR PLBEAR PLPINBOD PLRBEAM PLWHEEL PLBELT PLTUBE BEAM TRUSS HINGE
    PINBODY RBEAM WHEEL TWHEEL TUBE SCREW X FIX INPUTX DYNX KINX RLSE INPUTE DYNE KINE LDEFORM ORPINBOD
    DRPINBOD ORTUBE OUTLEVEL""",
    Block.DYNAMICS: """XM EM XGYRO MEE XF USERSIG GRAVITY ESTIFF EDAMP ESIG
    TIMESTEP INPUTX INPUTE STARTDX STARTDE USERINP INTEGRAT ERROR ITERSTEP DELXF DELGRAV DELOMF DELESIG
    DELINPX DELINPE""",
    Block.TRAJECTORY: """TRAJECT TROT TRANS TRCIRL TRE USERTRAJ TRTIME TREPMAX TRVMAX
    TRFRONT TRM TRF NOMS NOMF REFE REFEP REFEDP REFX REFXP REFXDP REFES REFXS""",
    Block.LINEARIZATION: """INPUTS INPUTF INE INEP INEDP INX INXP INXDP OUTS OUTE OUTEP OUTEDP OUTF OUTX
    OUTXP OUTXDP""",
    Block.SIMULATION: "INPUTS INPUTF OUTE OUTEP OUTEDP OUTX OUTXP OUTXDP",
}


def test_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == markdown(), (
        "run: python -m spacar.deck.reference > docs/keywords.md"
    )


@pytest.mark.parametrize("block", list(Block), ids=lambda b: b.name)
def test_all_keywords_are_there(block: Block) -> None:
    assert {name for name, b in KEYWORDS if b is block} == set(NAMES[block].split())


@pytest.mark.parametrize("keyword", list(KEYWORDS.values()), ids=lambda k: f"{k.block.name}-{k.name}")
def test_variants_are_consistent(keyword) -> None:
    for variant in keyword.variants:
        assert variant.counts == tuple(sorted(variant.counts))
        assert variant.counts[-1] == len(variant.parameters)
        assert all(p.meaning and p.kind in ("integer", "real", "name") for p in variant.parameters)
    assert keyword.help
