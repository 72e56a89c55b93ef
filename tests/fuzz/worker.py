"""A piece of the long run in a process of its own: `python -m tests.fuzz.worker KIND FIRST COUNT FOLDER`.

Prints a line of JSON for every finding. FOLDER/at holds the number of the case under way: when this process dies, its
parent knows which one it was.
"""

import json
import resource
import sys
from pathlib import Path

from .cases import case
from .harness import finding

MEMORY = 4 << 30


def work(kind: str, first: int, count: int, folder: Path) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    results = {p.name: p.read_bytes() for p in (folder / "sound").iterdir()}
    at = folder / "at"
    for seed in range(first, first + count):
        at.write_text(str(seed))
        own = case(kind, seed, results)
        text = finding(own)
        if text is not None:
            print(json.dumps({"kind": kind, "seed": seed, "words": own.words, "text": text}), flush=True)


if __name__ == "__main__":
    work(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))
