"""Speed of the SBF container: 1e5 steps of 100 doubles written, read as a whole and read one by one.

usage: python benchmarks/sbf.py [STEPS]. Every step is committed as it is appended (a kill loses none).
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from spacar_formats.sbf import SbfFile, SbfWriter


def main() -> None:
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    x = np.arange(99.0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.sbd"
        with SbfWriter(path, "sbd", {"NX": 99}, {"T": (1, 1), "X": (99, 1)}) as out:
            start = time.perf_counter()
            for k in range(steps):
                out.append({"T": float(k), "X": x})
            written = time.perf_counter()
        report("append (and commit) a step of 100 doubles", written - start, steps)
        print(f"{'fsync and close':<45}{(time.perf_counter() - written) * 1e3:10.1f} ms")

        # The same bytes without structure or commits: what is left is the cost of the container.
        block = bytes(816)
        start = time.perf_counter()
        with open(Path(folder) / "raw", "wb", buffering=0) as raw:
            for _ in range(steps):
                raw.write(block)
        report("unstructured write of as many bytes", time.perf_counter() - start, steps)

        size = path.stat().st_size
        for verify in (True, False):
            start = time.perf_counter()
            with SbfFile(path, verify=verify) as file:
                opened = time.perf_counter()
                file.get("T")
                short = time.perf_counter()
                file.get("X")
                done = time.perf_counter()
            times = zip(("open", "all T", "all X"), np.diff([start, opened, short, done]) * 1e3, strict=True)
            print(
                f"verify={verify}, {size / 1e6:.0f} MB: " + ", ".join(f"{n} {ms:.2f} ms" for n, ms in times)
            )
        chosen = np.random.default_rng(1).integers(1, steps + 1, 2000).tolist()
        with SbfFile(path) as file:
            start = time.perf_counter()
            for k in chosen:
                file.get("X", k)
            report("read X of a random step", time.perf_counter() - start, len(chosen))


def report(what: str, seconds: float, count: int) -> None:
    print(f"{what:<45}{seconds / count * 1e6:10.2f} µs")


if __name__ == "__main__":
    main()
