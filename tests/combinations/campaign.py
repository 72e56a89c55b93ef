"""Many cases: `python -m tests.combinations.campaign --count 5000 --first 100000` (make fuzz).

`--array`: those of `array.txt`, as the fast test has them; `--first-failure` ends at the first one.
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

FAST = 2  # relations of a case of the fast test


def spec_of(seed: int) -> Spec:
    """A case with a random pair of values."""
    rng = random.Random(f"campaign {seed}")
    while True:
        f, g = rng.sample(sorted(FACTORS), 2)
        pair = sorted(((f, rng.choice(FACTORS[f])), (g, rng.choice(FACTORS[g]))), key=lambda v: [*FACTORS].index(v[0]))
        if not excuse(*pair):
            return wanted(rng, seed, (pair[0], pair[1]), set())


def chosen(spec: Spec, *first: str) -> list[str]:
    """The relations of its mode: these, both engines where it begins and the spatial twin, which see each number of an
    element, then the others in a random order."""
    names = [name for name, relation in RELATIONS.items() if spec.mode in relation.modes]
    others = random.Random(spec.seed).sample(names, len(names))
    return [name for name in dict.fromkeys((*first, "starts", "as spatial", *others)) if name in names]


def finding(spec: Spec, relations: int, refused: list[tuple[str, Spec]] | None) -> str:
    """What does not hold; empty: everything does. With `refused` the case is drawn, on both engines."""
    with tempfile.TemporaryDirectory() as name:
        try:
            names = chosen(spec)
            if refused is not None:
                spec, case = drawn(spec, Path(name), refused)
                names = chosen(spec, "engines")
            else:
                case = spec.case(Path(name))
                if case is None:
                    return f"{written(spec)}: refused"
            bad = disagreements(case, names, relations)
            bad = {k: v for k, v in bad.items() if (spec.seed, k) not in KNOWN}
            return f"{written(spec)}: {bad}" if bad else ""
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            return f"{written(spec)}: {type(error).__name__} {last.filename}:{last.lineno}: {str(error)[:300]}"


def main() -> int:
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--count", type=int, default=5000)
    p.add_argument("--first", type=int, default=100_000, help="First seed: other numbers are other cases.")
    p.add_argument("--relations", type=int, help="Relations of each case: 4, among them both engines; of --array 2.")
    p.add_argument("--refusals", action="store_true", help="Print every refused model.")
    p.add_argument("--array", type=int, nargs="*", metavar="SEED", help="Cases of the fast test: all, or these.")
    p.add_argument("--first-failure", action="store_true", help="End at the first failure.")
    a = p.parse_args()
    array = {s.seed: s for s in specs()} if a.array is not None else {}
    cases = [array[k] for k in a.array or array] if array else map(spec_of, range(a.first, a.first + a.count))
    modes: Counter = Counter()
    refused: list[tuple[str, Spec]] = []
    found = 0
    for spec in cases:
        modes[spec.mode] += 1
        if text := finding(spec, a.relations or (FAST if array else 4), None if array else refused):
            found += 1
            print(text, flush=True)
            if a.first_failure:
                return 1
    if a.refusals:
        print(*(f"refused {code}: {written(s)}" for code, s in refused), sep="\n")
    rows = ", ".join(f"mode {m}: {n}" for m, n in sorted(modes.items()))
    codes = ", ".join(f"{code} {n}" for code, n in Counter(code for code, _ in refused).most_common())
    print(f"{modes.total()} cases ({rows}), {found} findings; refused and drawn anew: {codes or 'none'}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
