"""Input files of the modes as symbolic models: their motion is that of mode 1, which shares no equations with them."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import call as spacar
from tests.examples import DATA

# a rigid part that hangs on a flexible beam, welded rotations, a spring, a preloaded hinge, constant loads, gravity
ARM = """
PLBEAM 1  1 2  3 4   PLBEAM 2  3 5  6 7   PLTOR  3  8 2   PLTOR  4  4 5   PLRBEAM 5 6 7 9
PLTRUSS 6 9 10   X 1 0. 0.   X 3 0.5 0.2   X 6 0.9 0.6   X 9 1.0 0.9   X 10 1.5 0.9
FIX 1   FIX 8   FIX 10   DYNE 1 2 3   DYNE 3 1   DYNE 4 1   RLSE 6 1   END HALT
EM 1 0.8   EM 2 1.2 0.01   EM 5 0.4   XM 9 0.3   XM 7 0.02   XF 9 1. -2.   XF 4 0.1
GRAVITY 0. -9.81   ESTIFF 1 0. 40.   ESTIFF 3 12.   EDAMP 3 0.3   ESIG 3 1.5   ESTIFF 4 5.
ESTIFF 6 3.   EDAMP 6 0.2   STARTDE 3 1 0.1 0.5   STARTDE 1 2 0.01 0.1   TIMESTEP 0.1 10   END END
"""
# two ways to the same point, one of them over a prescribed hinge; the reached end of a beam is its q
LOOP = """
PLBEAM 1  1 2  3 4   PLBEAM 2  5 6  3 7   PLTOR  3  8 2   PLTRUSS 4 5 9
X 1 0. 0.   X 3 0.3 0.4   X 5 0.9 0.6   X 9 1.2 0.   FIX 1   FIX 8   FIX 9   INPUTE 3 1   END HALT
EM 2 2.   EM 4 1.5   XM 3 0.1   INPUTE 3 1 0. 2. 1.   TIMESTEP 0.1 10   END END
"""
SLIDER = """
PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 0.6 0.8   FIX 1   DYNE 1 1   DYNX 2 1   END HALT
XM 3 1.5   XM 2 0.1   ESTIFF 1 30.   EDAMP 1 0.5   GRAVITY 0. -9.81
STARTDX 2 1 0.2 3.   TIMESTEP 0.3 10   END END
"""
# a free body of two rods, on it a hinge about a skew axis with spring, damper and preload, a rod with rotary inertia
# and products of inertia of its section, an elastic truss to the ground, a force, gravity, inertias of a node
FREE = """
RBEAM 1 1 2 3   RBEAM 2 1 2 4   HINGE 3 2 5 1. 2. 2.   BEAM 4 3 5 6 7 0. 1. 0.3   TRUSS 5 6 8
X 1 0. 0. 0.   X 3 0.5 0.1 0.2   X 4 -0.2 0.4 0.   X 6 1.0 0.3 0.6   X 8 1.4 0.6 1.0
FIX 8   DYNE 3 1   DYNX 1   DYNX 2 2 3 4   RLSE 5 1   END HALT
EM 1 0.8 0.01 0.005 0.004   EM 2 1.2   EM 4 0.5 0.01 0.002 0.003 0.001   XM 4 0.3
XM 2 0.02 0.001 0. 0.03 0.002 0.04   XF 6 1. -2. 0.5   ESTIFF 5 30.   EDAMP 5 0.2   ESTIFF 3 2.
EDAMP 3 0.1   ESIG 3 0.4   GRAVITY 0. 0. -9.81
STARTDE 3 1 0.2 0.5   STARTDX 2 2 0.1 0.3   STARTDX 2 3 0.05 -0.2   TIMESTEP 0.3 10   END END
"""
# a beam that bends in both planes and twists, on a driven column
COLUMN = """
HINGE 1 1 2 0. 0. 1.   BEAM 2 3 2 4 5 0. 1. 0.5   X 3 0. 0. 0.   X 4 0.6 0.2 0.3
FIX 1   FIX 3   DYNE 1 1   DYNE 2 2 3 4 5 6   END HALT
EM 2 2. 0.02   XM 4 1.   XM 5 0.01 0. 0. 0.01 0. 0.01   XF 4 0. 0. -3.   ESTIFF 2 0. 60. 90. 120.
STARTDE 1 1 0.1 2.   TIMESTEP 0.1 10   END END
"""
# the same beam from its tip to the column, whose sections have a product of inertia about axes that turn with it
BACKWARDS = COLUMN.replace("BEAM 2 3 2 4 5", "BEAM 2 4 5 3 2").replace("EM 2 2. 0.02", "EM 2 2. 0.02 0.01 0.03 0.008")
# the same beam, thrown: it hangs on nothing
THROWN = (
    COLUMN.replace("HINGE 1 1 2 0. 0. 1.", "")
    .replace("FIX 1   FIX 3   DYNE 1 1 ", "DYNX 3   DYNX 2 2 3 4 ")
    .replace("STARTDE 1 1 0.1 2.", "STARTDX 2 4 0.05 1.")
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def exported(folder: Path, source: str, *options: str) -> tuple[str, list[float]]:
    """What `spacar symbolic export` says of an example or a text, and by how much results differ from mode 1."""
    path = folder / "m.dat"
    path.write_text(source if " " in source else (DATA / f"{source}.dat").read_text())
    out = spacar.done("symbolic", "export", path, *options).out
    return out, [float(v) for v in re.findall(r"differ by at most (\S+)", out)]


SLOW = {"fourbar", "lever", "loop", "arm", "free", "column", "backwards", "thrown"}
# Text or example, options, words, limits of the difference of positions [m] and of all differences. Both runs have
# the tolerance 1e-9. Flexible models have the same shapes: what is left is of second order, 1e-4 of the deflection.
RIGID = ("the parts are rigid", 1e-7, 1e-7)
MOTIONS = {
    "crank": ("crank", ("--time", "0.02"), *RIGID),
    "slider": ("slider", (), *RIGID),
    "fourbar": ("fourbar", ("--time", "0.2"), *RIGID),
    "lever": ("lever", ("--time", "0.1"), *RIGID),
    "loop": (LOOP, (), "", 1e-7, 1e-7),
    "sliding": (SLIDER, (), "", 1e-7, 1e-7),
    "robotsim": ("robotsim", ("--time", "0.05"), "3 coordinates, 0 constraints", 1e-8, np.inf),
    "free": (FREE, (), "", 1e-8, np.inf),
    "arm": (ARM, (), "largest deflection 0.01", 5e-6, np.inf),
    "column": (COLUMN, (), "largest deflection 0.009", 2e-6, np.inf),
    "backwards": (BACKWARDS, (), "largest deflection 0.004", 2e-6, np.inf),
    "thrown": (THROWN, (), "largest deflection 0.0001", 1e-8, np.inf),
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in SLOW)) for n in MOTIONS])
def test_models_move_as_in_mode_1(folder, name):
    source, options, words, of_positions, of_all = MOTIONS[name]
    out, differences = exported(folder, source, *options)
    assert words in out
    assert differences[0] < of_positions
    assert max(differences) < of_all


@pytest.mark.slow
def test_the_flexible_slider_crank_of_the_manual(folder):
    """Two elements and two beams of two shapes; over 0.1 s (15 rad) the export says 2.3 µm of 4.2 mm."""
    assert exported(folder, "crankfl", "--time", "0.02")[1][0] < 5e-6
    spacar.done("symbolic", "simulate", "m.toml", "--time", "0.01", "--steps", "4", "--compiled")
    assert spacar("draw", "m", "-o", "c.png")[0] == 0


def test_what_is_written_is_a_model_and_a_program(folder):
    shutil.copy(DATA / "crank.dat", folder)
    assert spacar("symbolic", "export", "crank.dat", "--language", "c", "--jacobian", "--time", "0.01")[0] == 0
    assert "int jac(" in (folder / "crank.c").read_text()
    assert not (folder / "crank.toml").exists()
    (folder / "crank.toml").write_text("# made by spacar symbolic export, long ago\n")  # its own file is replaced
    assert spacar("symbolic", "export", "crank.dat", "--time", "0.01")[0] == 0
    spacar.done("symbolic", "simulate", "crank.toml", "--steps", "4")
    from spacar_drawing.picture_source import open_source

    named = open_source("crank").named
    assert np.hypot(named["P3.x"], named["P3.y"]) == pytest.approx(np.full(5, 0.15), abs=1e-12)
    (folder / "crank.toml").write_text("[system]\ntitle = 'mine'\n")
    assert "a model of yours" in spacar.refused("symbolic", "export", "crank.dat")
    assert "mine" in (folder / "crank.toml").read_text()


@pytest.mark.parametrize(
    ("source", "old", "new", "words"),
    [
        ("finger.dat", "", "", "PLBELT 4 cannot be exported: only PLBEAM, PLRBEAM, PLTRUSS, PLTOR can"),
        ("cardan.dat", "", "", "HINGE 4 cannot be exported: it closes a loop of orientations"),
        (ARM, "ESTIFF 4 5.", "EDAMP 1 0. 1.", "PLBEAM 1 cannot be exported: its damping EDAMP"),
        (ARM, "ESTIFF 1 0. 40.", "ESTIFF 1 0. 40. 0.1", "PLBEAM 1 cannot be exported: it has shear flexibility"),
        (ARM, "DYNE 1 2 3", "DYNE 1 2", "PLBEAM 1 cannot be exported: deformations that are fixed, dynamic, fixed"),
        (SLIDER, "ESTIFF 1 30.", "EM 1 2.\nESTIFF 1 30.", "it changes its length and has mass"),
    ],
)
def test_what_cannot_be_exported_is_named(folder, source, old, new, words):
    text = (DATA / source).read_text() if source.endswith(".dat") else source
    assert old in text
    (folder / "m.dat").write_text(text.replace(old, new, 1))
    assert words in spacar.refused("symbolic", "export", "m.dat")
    assert not (folder / "m.toml").exists()


def test_other_commands_say_what_to_do_with_a_deck(folder):
    shutil.copy(DATA / "crank.dat", folder)
    assert "spacar symbolic export crank.dat makes a model of it" in spacar.refused("symbolic", "simulate", "crank.dat")
    (folder / "m.toml").write_text('[coordinates]\nq = { speed = "s" }\n')
    assert "choose the language of the program" in spacar.refused("symbolic", "export", "m.toml")
