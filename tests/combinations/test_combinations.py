"""Random mechanisms that nobody wrote, and relations that need no reference."""

from __future__ import annotations

import random

import pytest

from .cases import TYPES
from .properties import PROPERTIES
from .relations import RELATIONS, drawn

COUNT = 90


@pytest.mark.parametrize("seed", range(COUNT))
def test_case(seed: int, tmp_path) -> None:
    rng = random.Random(seed)
    kind, mode = TYPES[seed % len(TYPES)], (1, 7)[seed // len(TYPES) % 2]
    case = drawn(seed, (kind,), tuple(rng.sample(PROPERTIES, 4)), mode, tmp_path)
    found = {name: RELATIONS[name](case) for name in rng.sample(sorted(RELATIONS), 2)}
    bad = {name: where for name, (ratio, where) in found.items() if not ratio <= 1.0}
    assert not bad, f"{bad}\n{case.model.text()}"
