"""mypy on a script as users write it, against the installed package: what is right passes, slips are found."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")

SCRIPT = '''
from pathlib import Path

import numpy as np

import spacar
from spacar.errors import AnalysisError, InputError

m = spacar.Model("cantilever")
a, b = m.node(1, (0.0, 0.0)), m.node(3, np.array([0.5, 0.0]))
beam: int = m.plbeam(1, (a, 2), (b, 4), section="strip", material="steel", parts=4)
m.section("strip", "RECT", 0.001, 0.02)
m.fix(a)
m.dyne(beam, 2, 3)
m.estiff(2, EA=1e6, EI=10.0)
m.xf(b, Fy=-0.1)
deck: spacar.Deck = m.deck(7)
path: Path = m.save("cantilever")

result: spacar.Result = spacar.run(7, m, rtol=1e-8)
tip = result.node(b, 2)[-1] * 1000.0
figure = result.draw()
files: tuple[Path, ...] = result.save("cantilever")
for frame in spacar.frames(1, deck):
    moment: float = frame.t
change = {"XF.3": [1.0, 2.0], "ESTIFF.1": "1:2:3", "XM.2": np.linspace(1.0, 2.0, 3)}
rows = spacar.sweep(m, change, "x[3,2]@end", mode=7)
first: float = rows[0]["seconds"]
answer = spacar.trade(deck, 1e-4)
if answer.best is not None:
    spacar.run(1, deck, **answer.options)
try:
    spacar.read_deck("x.dat").set("XM", 2, 2, 1.0)
except (InputError, AnalysisError) as error:
    print(error.code)
'''
# a line -> what mypy must say about it
SLIPS = {
    'm.plbeam("1", (1, 2), (3, 4))': 'Argument 1 to "plbeam"',
    "m.plbeam(1, (1, 2), 3)": 'Argument 3 to "plbeam"',
    "m.plbeem(1, (1, 2), (3, 4))": 'has no attribute "plbeem"',
    "m.timestep(1.0)": 'Missing positional argument "steps"',
    "m.xf(3, Fq=1.0)": 'Unexpected keyword argument "Fq"',
    "m.usersig(3)": 'Argument 1 to "usersig"',
    "result.nodes(3, 1)": 'has no attribute "nodes"',
    'spacar.run("one", deck)': 'Argument 1 to "run"',
    "spacar.sweep(m, ['XM'], 'x[3,1]')": 'Argument 2 to "sweep"',
}


def checked(text: str, folder: Path) -> str:
    """What mypy says; strict, away from the sources of the package and its settings."""
    (folder / "script.py").write_text(text)
    words = ["mypy", "--strict", "--config-file=", "--cache-dir", str(folder / "cache"), "script.py"]
    done = subprocess.run([sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True, check=False)
    return done.stdout


@pytest.mark.slow
def test_a_script_of_a_user(tmp_path):
    assert "Success" in checked(SCRIPT, tmp_path)
    lines = (SCRIPT + "\n".join(SLIPS)).splitlines()
    said = checked("\n".join(lines), tmp_path)
    for slip, sentence in SLIPS.items():
        number = lines.index(slip) + 1
        about = [line for line in said.splitlines() if line.startswith(f"script.py:{number}:")]
        assert any(sentence in line for line in about), (slip, about)
