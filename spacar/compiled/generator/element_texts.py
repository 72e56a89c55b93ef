"""Write kernels.c and derivatives.c: hatch_build.py calls it with a folder.

Needs SymPy and NumPy. A type of element is derived by itself, the longest first, in as many processes as there are
processors, without the collection of garbage, which takes a sixth of the time and finds little.
"""

from __future__ import annotations

import gc
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from spacar.compiled.generator import derivative_kernels, generate
from spacar.elements import definitions

FILES = {"kernels.c": generate, "derivatives.c": derivative_kernels}
Job = tuple[str, int]  # file, number of the definition


def functions_of(job: Job) -> list[str]:
    """C text of the functions of one type that belong into one file."""
    file, k = job
    return list(FILES[file].functions(definitions()[k]))


def texts() -> dict[str, str]:
    """Both files."""
    types = definitions()
    jobs = [(file, k) for file in FILES for k in range(len(types))]
    jobs.sort(key=lambda job: -types[job[1]].n_coordinates)
    try:
        with ProcessPoolExecutor(os.cpu_count(), initializer=gc.disable) as pool:
            made = dict(zip(jobs, pool.map(functions_of, jobs), strict=True))
    except (OSError, ImportError):  # a machine without semaphores
        made = {job: functions_of(job) for job in jobs}
    own = {file: {d.name: made[file, k] for k, d in enumerate(types)} for file in FILES}
    return {file: module.text(own[file]) for file, module in FILES.items()}


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for name, text in texts().items():
        (folder / name).write_text(f"{text}\n", encoding="ascii")
