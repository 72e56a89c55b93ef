"""Many cases: `python -m tests.combinations.campaign --count 5000 --first 100000` (make fuzz).

`--array`: those of `array.txt` with the relations of the fast test, to the first failure with `--first-failure`.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path

from .case import Spec, drawn
from .coverage import FACTORS, excuse, specs, wanted, written
from .known import KNOWN
from .relations import RELATIONS, disagreements


def spec_of(seed: int) -> Spec:
    """A case with a random pair of values."""
    rng = random.Random(f"campaign {seed}")
    while True:
        f, g = rng.sample(sorted(FACTORS), 2)
        pair = sorted(((f, rng.choice(FACTORS[f])), (g, rng.choice(FACTORS[g]))), key=lambda v: [*FACTORS].index(v[0]))
        if not excuse(*pair):
            return wanted(rng, seed, (pair[0], pair[1]), set())


def chosen(spec: Spec, count: int) -> list[str]:
    """The relations of a case."""
    names = [name for name, relation in RELATIONS.items() if spec.mode in relation.modes]
    return random.Random(spec.seed).sample(names, min(count, len(names)))


def finding(spec: Spec, relations: int, draw: bool) -> str:
    """What does not hold; empty: everything does."""
    with tempfile.TemporaryDirectory() as name:
        try:
            if draw:
                spec, case = drawn(spec, Path(name))
            else:
                case = spec.case(Path(name))
                if case is None:
                    return f"{written(spec)}: refused"
            bad = disagreements(case, chosen(spec, relations))
            bad = {k: v for k, v in bad.items() if (spec.seed, k) not in KNOWN}
            return f"{written(spec)}: {bad}" if bad else ""
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            return f"{written(spec)}: {type(error).__name__} {last.filename}:{last.lineno}: {str(error)[:300]}"


def main() -> int:
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--count", type=int, default=5000)
    p.add_argument("--first", type=int, default=100_000, help="First seed: other numbers are other cases.")
    p.add_argument("--relations", type=int, default=4, help="Relations of each case.")
    p.add_argument("--array", action="store_true", help="The cases of the fast test.")
    p.add_argument("--first-failure", action="store_true", help="End at the first failure.")
    a = p.parse_args()
    cases = specs() if a.array else map(spec_of, range(a.first, a.first + a.count))
    modes: Counter = Counter()
    found = 0
    for spec in cases:
        modes[spec.mode] += 1
        if text := finding(spec, 2 if a.array else a.relations, draw=not a.array):
            found += 1
            print(text, flush=True)
            if a.first_failure:
                return 1
    print(f"{modes.total()} cases ({', '.join(f'mode {m}: {n}' for m, n in sorted(modes.items()))}), {found} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
