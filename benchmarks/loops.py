"""Closed loops and mode 1 of the same mechanism in the same motion: user time of the commands, least of the repeats.

    python benchmarks/loops.py [REPEATS]

Mode 1 gets what the loop puts into the hinges: USERSIG interpolates the moments of a simulation by 595, stored every
millisecond. Alone they would drive an unstable open loop: so the gains P and D are also stiffness and damping of the
hinges, and P e + D e' is added to the moments. Tolerance of a step and outputs are those of the simulation.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from shutil import copy
from subprocess import run

import numpy as np
from spacar_formats.simfile import read_model

from spacar.simulation import simulate

DATA = Path(__file__).resolve().parents[1] / "data"
SPACAR = Path(sys.executable).with_name("spacar")
HINGES = (1, 2, 3, 5, 6, 8, 9)
# links of 0.4, 0.35 and 0.2 m behind three, two and two hinges about z, y, x, y, x, y, x; stretched along x
ARM = """
HINGE 1 1 3  0 0 1
HINGE 2 3 4  0 -1 0
HINGE 3 4 5  1 0 0
BEAM 4 2 5 6 7 0 1 0
HINGE 5 7 8  0 -1 0
HINGE 6 8 9  1 0 0
BEAM 7 6 9 10 11 0 1 0
HINGE 8 11 12  0 -1 0
HINGE 9 12 13  1 0 0
BEAM 10 10 13 14 15 0 1 0
X 2 0 0 0.
X 6 0.4 0 0.
X 10 0.75 0 0.
X 14 0.95 0 0.
FIX 1
FIX 2
DYNES
END
HALT
EM 4 17.1429 0.02 0.01 0.01
EM 7 8.57143 0.02 0.01 0.01
EM 10 4.28571 0.02 0.01 0.01
XM 6 3.0
XM 10 1.5
XM 14 0.75
XM 15 0.02 0. 0. 0.02 0. 0.02
XF 6 0. 0. -58.86
XF 10 0. 0. -29.43
XF 14 0. 0. -14.715
END
HALT
SIGNALS
END
END
"""
P, D = (4000, 4000, 800, 1500, 300, 300, 60), (300, 300, 40, 80, 12, 12, 2)
LIMIT = (300, 300, 100, 150, 60, 60, 20)
LOOP = """
[simulation]
time = 3
step = 0.01
[arm]
block = spasim
model = arm.dat
[path]
block = sine
amplitude = 0.5 0.4 0.3 0.4 0.3 0.4 0.3
frequency = 0.5 0.7 0.9 0.6 0.8 1.0 1.1
[pid]
block = pid
filter = {filter}
"""
NOTCH = """
[notch{k}]
block = transfer-function
numerator = 1 12 14400
denominator = 1 120 14400
"""
MOMENTS = """
import numpy as np
u = np.load("moments.npy")
def moments(t, ne, le, e, ep, nx, lnp, x, xp):
    k = min(int(1000 * t), len(u) - 2)
    w = 1000 * t - k
    return t, [[h, 1, -m] for h, m in zip({hinges}, ((1 - w) * u[k] + w * u[k + 1]).tolist())], []
"""


def write_arm(folder: Path, filter: float = 300.0) -> Path:
    """arm.dat, and arm.sim: PID with a filter of its derivative [rad/s], a notch for every hinge, a saturation; the
    wrist turns fast enough to limit explicit steps. The path of arm.sim."""
    signals = [f"INPUTS {k} {h} 1" for k, h in enumerate(HINGES, 1)]
    signals += [f"OUTE {k} {h} 1" for k, h in enumerate(HINGES, 1)] + ["OUTEP 8 3 1", "OUTX 9 14 3", "OUTEDP 10 1 1"]
    text = ARM.replace("DYNES", "\n".join(f"DYNE {h} 1" for h in HINGES)).replace("SIGNALS", "\n".join(signals))
    (folder / "arm.dat").write_text(text)

    def keys(size: int = 7, **values: object) -> str:
        rows = {k: " ".join(map(str, v)) if isinstance(v, tuple) else v for k, v in values.items()}
        return "".join(f"{k} = {v}\n" for k, v in {"size": size, **rows}.items())

    saturation = tuple(0.83 * m for m in LIMIT)
    ends = {"lower": tuple(-m for m in LIMIT), "upper": LIMIT}
    lines = [LOOP.format(filter=filter) + keys(kp=P, ki=P, kd=D, **ends), "[limit]\nblock = saturation"]
    lines += [keys(lower=tuple(-m for m in saturation), upper=saturation), *(NOTCH.format(k=k) for k in range(1, 8))]
    lines += ["[wires]\npath -> pid\narm:1-7 -> pid * -1\nlimit -> arm"]
    lines += [f"pid:{k} -> notch{k}\nnotch{k} -> limit:{k}" for k in range(1, 8)]
    path = folder / "arm.sim"
    path.write_text("\n".join(lines) + "\n")
    return path


def same_motion(
    sim: Path, plant: str, hinges: tuple[int, ...], p: tuple[float, ...], d: tuple[float, ...]
) -> np.ndarray:
    """The input file mode1.dat beside `sim`, of which the first outputs are the angles of the `hinges`; these angles
    (outputs, hinges) [rad]."""
    model = read_model(sim)
    end, folder = float(model.times[-1]), sim.parent
    found = simulate(model.diagram, np.linspace(0.0, end, round(1000 * end) + 1), method=595)
    e = found[plant][:, : len(hinges)]
    u = found.u[:, found.inputs[plant]]
    np.save(folder / "moments.npy", u + np.array(p) * e + np.array(d) * np.gradient(e, 0.001, axis=0, edge_order=2))
    (folder / "moments.py").write_text(MOMENTS.format(hinges=hinges))
    kinematics, dynamics = (folder / f"{sim.stem}.dat").read_text().split("HALT")[:2]
    lines = [f"{kinematics}HALT", dynamics.rstrip().removesuffix("END"), "USERSIG moments", "ERROR 1e-6 1e-4"]
    lines += [f"ESTIFF {h} {k}\nEDAMP {h} {c}" for h, k, c in zip(hinges, p, d, strict=True)]
    (folder / "mode1.dat").write_text("\n".join([*lines, f"TIMESTEP {end} {len(model.times) - 1}\nEND\nEND\n"]))
    return e[:: (len(e) - 1) // (len(model.times) - 1)]


def user_time(folder: Path, *words: str) -> float:
    """Of a command [s]."""
    before = getrusage(RUSAGE_CHILDREN).ru_utime
    run([SPACAR, *words], cwd=folder, check=True, capture_output=True)
    return getrusage(RUSAGE_CHILDREN).ru_utime - before


def main(repeats: int) -> None:
    for name in ("arm", "robotsim"):
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            if name == "arm":
                same_motion(write_arm(folder), "arm", HINGES, P, D)
            else:
                for file in ("robotinv.dat", "robotinvlin.dat", "robotsim.dat", "robotsim.sim"):
                    copy(DATA / file, folder)
                user_time(folder, "2", "robotinv")
                user_time(folder, "3", "robotinvlin")
                same_motion(folder / "robotsim.sim", "robot", (1, 2, 3), (5000, 8000, 3000), (400, 600, 250))
            times = [(user_time(folder, "sim", name), user_time(folder, "1", "mode1")) for _ in range(repeats)]
        sim, mode_1 = (min(column) for column in zip(*times, strict=True))
        print(f"{name:9s} sim {sim:.2f} s, mode 1 {mode_1:.2f} s, ratio {sim / mode_1:.1f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
