"""Stresses of a bar in tension, bending and torsion against a solid model of CalculiX (skipped without `ccx`).

Bar 100 x 20 x 2 mm, one end clamped, the other a rigid face, so that neither can warp: 100 N along, 1 N across the
thickness, 0.5 N m. Measured with 60 x 12 x 4 elements C3D20R at mid-length: von Mises 36.35 MPa, beam 35.13; shear
20.67, beam 20.01; turn of the end 0.011210 rad, beam 0.011194. The solid comes down to the beam as its mesh gets finer:
38.34 MPa with the 30 x 8 x 2 elements of this test, which takes seconds instead of half a minute.
"""

import shutil
import subprocess
from itertools import product

import numpy as np
import pytest

import spacar

LENGTH, WIDTH, THICKNESS = 0.1, 0.02, 0.002
MESH = (30, 8, 2)
AXIAL, ACROSS, TORQUE = 100.0, 1.0, 0.5
# corners, middles of the edges of a C3D20R, in half elements
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
MIDDLES = [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
           (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]  # fmt: skip

pytestmark = [pytest.mark.slow, pytest.mark.skipif(shutil.which("ccx") is None, reason="no ccx")]

BEAM = f"""SECTION s RECT {WIDTH} {THICKNESS}   MATERIAL m 210e9 0.3   BEAMW 1  1 2 3  4 5 6  0 1 0
BEAMSEC 1 s m 16   X 4 {LENGTH}   DYNE 1   FIX 1   FIX 2   FIX 3   FIX 6   END HALT
XF 4 {AXIAL} 0. {ACROSS}   XF 5 {TORQUE} 0. 0.   END END
"""


def solid(folder):
    """Places (n, 3), stresses xx yy zz xy yz zx (n, 6) and the displacements of the two reference nodes."""
    ids, places = {}, []
    half = [2 * n for n in MESH]

    def node(*at):
        if at not in ids:
            ids[at] = len(ids) + 1
            x, y, z = (i / n for i, n in zip(at, half, strict=True))
            places.append((LENGTH * x, WIDTH * (y - 0.5), THICKNESS * (z - 0.5)))
        return ids[at]

    elements = [
        [node(*(2 * i + k for i, k in zip(cell, corner, strict=True))) for corner in CORNERS + MIDDLES]
        for cell in product(*map(range, MESH))
    ]
    ends = [[n for at, n in ids.items() if at[0] == end] for end in (0, half[0])]
    ref = len(ids) + 1
    lines = ["*NODE,NSET=ALL", *(f"{n},{x:.10g},{y:.10g},{z:.10g}" for n, (x, y, z) in enumerate(places, 1))]
    lines += [f"{ref},{LENGTH},0,0", f"{ref + 1},{LENGTH},0,0", "*ELEMENT,TYPE=C3D20R,ELSET=E"]
    for n, e in enumerate(elements, 1):
        lines += [f"{n},{','.join(map(str, e[:15]))},", ",".join(map(str, e[15:]))]
    for name, of in zip("LR", ends, strict=True):
        lines += [f"*NSET,NSET={name}", *(f"{n}," for n in of)]
    lines += ["*MATERIAL,NAME=M", "*ELASTIC", "210e9,0.3", "*SOLID SECTION,ELSET=E,MATERIAL=M"]
    lines += [f"*RIGID BODY,NSET=R,REF NODE={ref},ROT NODE={ref + 1}", "*BOUNDARY", "L,1,3"]
    lines += ["*STEP", "*STATIC", "*CLOAD"]
    lines += [f"{ref},1,{AXIAL}", f"{ref},3,{ACROSS}", f"{ref + 1},1,{TORQUE}"]
    lines += ["*NODE PRINT,NSET=ALL", "U", "*EL FILE", "S", "*END STEP"]
    (folder / "bar.inp").write_text("\n".join(lines) + "\n")
    subprocess.run(["ccx", "bar"], cwd=folder, check=True, capture_output=True, timeout=600)
    stress, reading = {}, False
    for line in (folder / "bar.frd").read_text().splitlines():
        if line.startswith(" -4"):
            reading = line.split()[1] == "STRESS"
        elif reading and line.startswith(" -1"):
            stress[int(line[3:13])] = [float(line[13 + 12 * i : 25 + 12 * i]) for i in range(6)]
    rows = [line.split() for line in (folder / "bar.dat").read_text().splitlines()]
    moved = {int(r[0]): [float(v) for v in r[1:]] for r in rows if len(r) == 4 and r[0].isdigit()}
    values = np.array([stress[n] for n in range(1, len(places) + 1)])
    return np.array(places), values, moved[ref], moved[ref + 1]


def test_bar_against_a_solid(tmp_path):
    """At mid-length, where the ends are not felt; the coarse mesh costs 9 %."""
    places, s, shift, turn = solid(tmp_path)
    here = np.abs(places[:, 0] - LENGTH / 2) < 1e-9
    shear2 = np.sum(s[:, 3:] ** 2, axis=1)
    differences = (s[:, 0] - s[:, 1]) ** 2 + (s[:, 1] - s[:, 2]) ** 2 + (s[:, 2] - s[:, 0]) ** 2
    mises = np.sqrt(0.5 * differences + 3 * shear2)
    r = spacar.run(8, spacar.parse_deck(BEAM, mode=8))
    found = r.stress(points=2)
    middle = found.elements.tolist().index(8), 1
    assert found["mises"][-1][middle] == pytest.approx(mises[here].max(), rel=0.1)
    assert found["shear"][-1][middle] == pytest.approx(np.sqrt(shear2[here]).max(), rel=0.1)
    assert 2 * np.arcsin(r.node(5, 2)[-1]) == pytest.approx(turn[0], rel=0.01)
    assert r.node(4, 1)[-1] == pytest.approx(shift[0] + LENGTH, rel=1e-5)
