"""Decks of the speed and accuracy measurements, as text. SI units."""

from __future__ import annotations

from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "data"

# A stiff arm that carries a soft one: at each frequency of the first, steps of explicit methods would be short.
STIFF_AND_SOFT_ARM = """
PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
X 3 0.5 0.
X 5 1. 0.
FIX 1
FIX 2
DYNE 1 2 3
DYNE 2 2 3
END HALT
EM 1 1.
EM 2 1.
ESTIFF 1 0. 1e4
ESTIFF 2 0. 1.
XF 5 0. 0.2
TIMESTEP 0.5 5
END END
"""


def deck(kinematics: list[str], dynamics: list[str]) -> str:
    """Both blocks of an input file."""
    return "\n".join([*kinematics, "END", "HALT", *dynamics, "END", "END", ""])


def example(name: str) -> str:
    """The text of an example of `data/`."""
    return (DATA / f"{name}.dat").read_text()


def free_slider_crank(duration: float, steps: int) -> str:
    """Rigid slider-crank, 0.15 m and 0.30 m, falling under gravity from a horizontal crank that turns with 10 rad/s."""
    return deck(
        ["PLBEAM 1 1 2 3 4", "PLBEAM 2 3 5 6 7", "X 3 0.15 0.", "X 6 0.45 0.", "FIX 1", "FIX 6 2", "DYNX 2 1"],
        ["XM 6 0.033375", "EM 1 0.2225", "EM 2 0.2225", "GRAVITY 0. -9.81", "STARTDX 2 1 0. 10.",
         f"TIMESTEP {duration} {steps}"],
    )  # fmt: skip


def slider_crank(n: int, duration: float = 0.1, steps: int = 100) -> str:
    """crankfl.dat with n equal elements in the rod: crank at 150 rad/s, inextensible flexible rod of 0.30 m."""
    node = [3] + [2 * i + 4 for i in range(1, n + 1)]  # crank pin, then every second number from 6
    turn = [5 + 2 * i for i in range(n + 1)]
    kinematics = ["PLBEAM 1 1 2 3 4"]
    kinematics += [f"PLBEAM {i + 2} {node[i]} {turn[i]} {node[i + 1]} {turn[i + 1]}" for i in range(n)]
    kinematics += [f"X {node[i]} {0.15 + 0.3 * i / n!r} 0." for i in range(n + 1)]
    kinematics += ["FIX 1", f"FIX {node[n]} 2", "INPUTX 2 1", *(f"DYNE {i + 2} 2 3" for i in range(n))]
    dynamics = [f"XM {node[n]} 0.033375", "INPUTX 2 1 0. 150. 0.", f"TIMESTEP {duration} {steps}"]
    dynamics += [f"EM {i + 2} 0.2225" for i in range(n)] + [f"ESTIFF {i + 2} 0. 13.359623" for i in range(n)]
    return deck(kinematics, dynamics)


def pendulum(links: int, duration: float, steps: int) -> str:
    """Chain of uniform rods of 1 m and 1 kg, straight, 30 degrees from the vertical, released under gravity."""
    n, sine, cosine = links, 0.5, 0.8660254037844386
    kinematics = [f"PLRBEAM {i + 1} {i + 1} {n + 2 + i} {i + 2}" for i in range(n)]
    kinematics += [f"X {i + 1} {sine * i!r} {-cosine * i!r}" for i in range(n + 1)]
    kinematics += ["FIX 1", *(f"DYNX {n + 2 + i} 1" for i in range(n))]
    return deck(kinematics, [*(f"EM {i + 1} 1." for i in range(n)), "GRAVITY 0. -9.81", f"TIMESTEP {duration} {steps}"])


def spatial_pendulum(links: int, duration: float, steps: int, branches: int = 1) -> str:
    """Spatial rigid rods, rotary inertia, hinges of alternating axes: a chain, 1 m together, or a tree with `branches`
    rods at the end of every rod."""
    n = links
    parent = [0, *((k - 2) // branches + 1 for k in range(2, n + 1))]  # of rod k = 1 ... n; 0: the ground
    place = [(0.0, 0.0)]
    for k in range(1, n + 1):
        x, y = place[parent[k - 1]]
        place.append((x + 1.0 / n, y + 0.3 * ((k - 2) % branches - 0.5 * (branches - 1)) / n))
    ground = 2 * n + 2
    kinematics = [f"RBEAM {k} {parent[k - 1] + 1} {n + 1 + k} {k + 1}" for k in range(1, n + 1)]
    axes = ("0 0 1", "0 1 0")
    before = [ground, *(n + 1 + p for p in parent[1:])]
    kinematics += [f"HINGE {n + k} {before[k - 1]} {n + 1 + k} {axes[k % 2]}" for k in range(1, n + 1)]
    kinematics += [f"X {k + 1} {x!r} {y!r} 0." for k, (x, y) in enumerate(place)]
    kinematics += ["FIX 1", f"FIX {ground}", *(f"DYNE {n + k} 1" for k in range(1, n + 1))]
    dynamics = [f"EM {k} 1. 0.01 0.005 0.005" for k in range(1, n + 1)]
    return deck(kinematics, [*dynamics, "GRAVITY 1. 2. -9.81", f"TIMESTEP {duration} {steps}"])


def manipulator(duration: float = 1.4, steps: int = 14) -> str:
    """robotsim.dat as forward dynamics: the arm with three hinges falls under its weights."""
    text = example("robotsim").split("HALT")
    dynamics = text[1].replace("END", f"STARTDE 1 1 0. 1.\nTIMESTEP {duration} {steps}\nEND\nEND")
    return f"{text[0]}HALT{dynamics}"


def cantilever(
    n: int, *, load: str = "", mass: float = 1.0, extensible: str = "2 3", EI: float = 102.0, length: float = 10.0,
    dynamics: tuple[str, ...] = (),
) -> str:  # fmt: skip
    """n equal planar beams along x, clamped at the origin; `load` is put on the tip."""
    kinematics = [f"PLBEAM {i + 1} {2 * i + 1} {2 * i + 2} {2 * i + 3} {2 * i + 4}" for i in range(n)]
    kinematics += [f"X {2 * i + 1} {length * i / n!r} 0." for i in range(1, n + 1)]
    kinematics += ["FIX 1", "FIX 2", *(f"DYNE {i + 1} {extensible}" for i in range(n))]
    rows = [f"ESTIFF {i + 1} 0. {EI!r}" for i in range(n)]
    if mass:
        rows += [f"EM {i + 1} {mass!r}" for i in range(n)]
    if load:
        rows.append(f"XF {2 * n + 1} {load}")
    return deck(kinematics, [*rows, *dynamics])


def spatial_chain(n: int) -> str:
    """n equal spatial beams along x, clamped, with bending and torsion, rotary inertia and gravity."""
    kinematics = [f"BEAM {i + 1} {2 * i + 1} {2 * i + 2} {2 * i + 3} {2 * i + 4} 0 1 0" for i in range(n)]
    kinematics += [f"X {2 * i + 1} {i / n!r} 0 0" for i in range(1, n + 1)]
    kinematics += ["FIX 1", "FIX 2", *(f"DYNE {i + 1} 2 3 4 5 6" for i in range(n))]
    dynamics = [f"EM {i + 1} 1. 0.01 0.005 0.005" for i in range(n)]
    dynamics += [f"ESTIFF {i + 1} 0. 1. 1. 1." for i in range(n)]
    return deck(kinematics, [*dynamics, "GRAVITY 0 0 -9.81", "TIMESTEP 0.01 1"])
