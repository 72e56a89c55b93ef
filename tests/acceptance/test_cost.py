"""What a process may cost: `--version` next to nothing, `spacar 1 crank` no heavy imports."""

import os
import subprocess
import sys
import time

import pytest

from spacar.compiled.library import why_off
from tests.examples import DATA

from .processes import ENVIRONMENT, SPACAR

LOADED = """
import sys
from spacar_cli.main import main
main(sys.argv[1:])
print(*sys.modules, file=sys.stderr)
"""


def seconds(*words: str) -> float:
    begun = time.perf_counter()
    subprocess.run(words, check=True, capture_output=True, env=ENVIRONMENT)
    return time.perf_counter() - begun


def processor_seconds(*words: str, folder) -> float:
    """User and system time of a process: what else the machine does hardly changes it."""
    kept = {name: value for name, value in ENVIRONMENT.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before = os.times()
    subprocess.run(words, check=True, capture_output=True, env=kept, cwd=folder)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def modules(*words: str, folder) -> set[str]:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], cwd=folder, capture_output=True, text=True,
                          env=ENVIRONMENT, check=True)  # fmt: skip
    return set(done.stderr.split())


@pytest.mark.slow
def test_version_costs_at_most_one_and_a_half_imports_of_numpy():
    """A ratio of the best of five pairs measured in turn, so that a busy machine slows both alike."""
    pairs = [(seconds(str(SPACAR), "--version"), seconds(sys.executable, "-c", "import numpy")) for _ in range(5)]
    version, numpy = (min(times) for times in zip(*pairs, strict=True))
    assert version <= 1.5 * numpy, (version, numpy)


@pytest.mark.parametrize("word", ["--version", "--help"])
def test_help_imports_no_numpy(word, tmp_path):
    loaded = modules(word, folder=tmp_path)
    assert "click" in loaded
    assert not loaded & {"numpy", "scipy", "rich", "matplotlib", "spacar.frame", "spacar.deck"}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not tell the processor time of children")
@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_a_run_of_the_crank_costs_at_most_two_and_a_half_imports_of_numpy(tmp_path):
    """Reading, checking, computing and writing 101 steps; the best of four runs measured in turn, with bytecode."""
    (tmp_path / "crank.dat").write_text((DATA / "crank.dat").read_text())
    pairs = [
        (
            processor_seconds(str(SPACAR), "1", "crank", folder=tmp_path),
            processor_seconds(sys.executable, "-c", "import numpy", folder=tmp_path),
        )
        for _ in range(4)
    ]
    crank, numpy = (min(times) for times in zip(*pairs, strict=True))
    assert crank <= 2.5 * numpy, (crank, numpy)


def test_a_run_imports_nothing_heavy(tmp_path):
    (tmp_path / "crank.dat").write_text((DATA / "crank.dat").read_text())
    loaded = modules("1", "crank", folder=tmp_path)
    assert (tmp_path / "crank.sbd").exists()
    # ours that a run seldom needs
    late = {"spacar.result", "spacar.expressions", "spacar.deck.section_block", "spacar.kinematics.diagnosis",
            "spacar.linearization", "spacar_cli.releasing"}  # fmt: skip
    assert not loaded & late, loaded & late
    heavy = {
        "matplotlib",
        "rich",
        "scipy.integrate",
        "scipy.linalg",
        "scipy.sparse",
        "sympy",
        "pandas",
        "asyncio",
    }
    assert not loaded & heavy, loaded & heavy
