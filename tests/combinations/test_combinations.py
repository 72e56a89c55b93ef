"""Random mechanisms and relations that need no reference: the cases of `array.txt`, in which every pair of element
type, load or property, mode and option occurs. `make fuzz` runs thousands more."""

from __future__ import annotations

from pathlib import Path

import pytest

from .campaign import FAST, chosen
from .case import Spec
from .coverage import FACTORS, excuse, occurring, required, specs, written
from .known import KNOWN
from .relations import disagreements

SPECS = specs()


@pytest.mark.parametrize("spec", SPECS, ids=[f"{s.seed}" for s in SPECS])
def test_case(spec: Spec, tmp_path: Path) -> None:
    """Some relations that hold in its mode, in turn."""
    case = spec.case(tmp_path)
    assert case is not None, f"{written(spec)}: refused, or badly conditioned"
    bad = disagreements(case, chosen(spec), FAST)
    known = {name: KNOWN[spec.seed, name] for name in bad if (spec.seed, name) in KNOWN}
    if known and known.keys() == bad.keys():
        pytest.xfail(str(known))
    assert not bad, f"{written(spec)}\n{bad}\n{case.model.text()}"


def test_every_pair_occurs() -> None:
    """In the array; a new keyword, type, mode or option asks for `python -m tests.combinations.coverage`."""
    missing = set(required())
    for spec in SPECS:
        model = spec.model()
        assert model is not None
        missing -= occurring(spec, model)
    assert not missing


def test_pairs_that_cannot_occur_have_a_reason() -> None:
    """Each follows from a table; none is excused because the generator lacks it."""
    for f in FACTORS:
        for g in FACTORS:
            if f < g:
                reasons = {excuse((f, v), (g, w)) for v in FACTORS[f] for w in FACTORS[g]}
                assert all(len(reason.split()) > 3 for reason in reasons - {""})
