"""Beam and flexure models as people write them: SI units, steel, any direction, any mesh; random ones from a seed."""

from dataclasses import dataclass

import numpy as np

STEEL, SHEAR, DENSITY = 210e9, 79e9, 7800.0


@dataclass(frozen=True)
class Strip:
    """Rectangular cross-section, width [m] along y', thickness [m]."""

    width: float
    thickness: float
    modulus: float = STEEL
    density: float = DENSITY

    @property
    def area(self) -> float:
        return self.width * self.thickness

    @property
    def stiffness(self) -> tuple[float, float, float, float]:
        """EA, G It, EIy (thin direction), EIz."""
        b, t = self.width, self.thickness
        torsion = SHEAR / STEEL * self.modulus * b * t**3 / 3 * (1 - 0.63 * t / b)
        return self.modulus * self.area, torsion, self.modulus * b * t**3 / 12, self.modulus * t * b**3 / 12

    @property
    def inertia(self) -> tuple[float, float, float, float]:
        """Mass, Jxx, Jyy, Jzz per length."""
        m, b, t = self.density * self.area, self.width, self.thickness
        return m, m * (b * b + t * t) / 12, m * t * t / 12, m * b * b / 12


Turn = np.ndarray
LEAF = Strip(0.02, 0.0005)  # with a length of 0.1 m


class Model:
    """Statements of the first two blocks, with the numbers of nodes and elements counted."""

    def __init__(self, planar: bool, rotary: bool = True) -> None:
        self.planar, self.rotary = planar, rotary
        self.kinematics: list[str] = []
        self.dynamics: list[str] = []
        self.nodes = self.elements = 0

    def node(self, point: np.ndarray) -> int:
        """Number of the position node; the rotation node is the next one."""
        self.nodes += 2
        self.kinematics.append(f"X {self.nodes - 1} " + " ".join(repr(float(c)) for c in point))
        return self.nodes - 1

    def leg(
        self, start: int, points: np.ndarray, strip: Strip, width: np.ndarray, end: int | None = None,
        released: str = "",
    ) -> int:  # fmt: skip
        """Beams from node `start` through the points; the last one ends at node `end` with modes `released`."""
        everything = "1 2 3" if self.planar else "1 2 3 4 5 6"
        before = start
        for k, point in enumerate(points):
            last = k == len(points) - 1
            after = end if last and end is not None else self.node(point)
            self.elements += 1
            e = self.elements
            if self.planar:
                self.kinematics.append(f"PLBEAM {e} {before} {before + 1} {after} {after + 1}")
                EA, _, EI, _ = strip.stiffness
                m, _, J, _ = strip.inertia
                self.dynamics += [f"ESTIFF {e} {EA!r} {EI!r}", f"EM {e} {m!r}" + f" {J!r}" * self.rotary]
            else:
                y = " ".join(repr(float(c)) for c in width)
                self.kinematics.append(f"BEAM {e} {before} {before + 1} {after} {after + 1} {y}")
                self.dynamics.append(f"ESTIFF {e} " + " ".join(repr(v) for v in strip.stiffness))
                self.dynamics.append(f"EM {e} " + " ".join(repr(v) for v in strip.inertia))
            loose = released if last else ""
            dynamic = " ".join(i for i in everything.split() if i not in loose.split())
            self.kinematics += [f"RLSE {e} {loose}"] * bool(loose) + [f"DYNE {e} {dynamic}"] * bool(dynamic)
            before = after
        return before

    def rigid(self, a: int, b: int, width: np.ndarray) -> None:
        self.elements += 1
        y = "" if self.planar else " " + " ".join(repr(float(c)) for c in width)
        self.kinematics.append(f"{'PL' * self.planar}BEAM {self.elements} {a} {a + 1} {b} {b + 1}{y}")

    def fix(self, node: int) -> None:
        self.kinematics += [f"FIX {node}", f"FIX {node + 1}"]

    def text(self) -> str:
        return "\n".join([*self.kinematics, "END", "HALT", *self.dynamics, "END", "END", ""])


def line(a: np.ndarray, b: np.ndarray, n: int) -> np.ndarray:
    """n points from behind a to b."""
    return a + (b - a) * (np.arange(1, n + 1) / n)[:, None]


def across(direction: np.ndarray) -> np.ndarray:
    """A unit vector perpendicular to the direction."""
    axis = np.eye(3)[np.argmin(np.abs(direction))]
    v = np.cross(direction, axis)
    return v / np.linalg.norm(v)


def cantilever_leaf(n: int, length: float = 0.1, strip: Strip = LEAF, direction: tuple[int, ...] = (1, 0, 0)) -> Model:
    """A clamped leaf spring of n beams (spatial)."""
    u = np.array(direction, float) / np.linalg.norm(direction)
    model = Model(False)
    start = model.node(np.zeros(3))
    model.leg(start, line(np.zeros(3), length * u, n), strip, across(u))
    model.fix(start)
    return model


def guide(model: Model, n: int, length: float, width: float, strip: Strip, turn: Turn, mass: float) -> int:
    """Two parallel leaf springs of n beams and a rigid stage, turned by the matrix `turn`; the number of its node.

    The last beam closes the loop, its deformations follow from the others and are released.
    """
    planar = model.planar
    d = 2 if planar else 3
    corners = np.array([[0, 0, 0], [0, length, 0], [width, length, 0], [width, 0, 0.0]]) @ turn.T
    a, b, c, e = corners[:, :d]
    y = turn[:, 2]
    ground = model.node(a)
    top = model.leg(ground, line(a, b, n), strip, y)
    other = model.node(c)
    model.rigid(top, other, y)
    foot = model.node(e)
    released = "1 2 3" if planar else "1 2 3 4 5 6"
    model.leg(other, line(c, e, n), strip, y, end=foot, released=released)
    model.fix(ground)
    model.fix(foot)
    model.dynamics.append(f"XM {other} {mass!r}")
    return other


def rotation(rng: np.random.Generator, planar: bool) -> np.ndarray:
    """A random direction: in the plane about z."""
    if planar:
        c, s = np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Q * np.sign(np.linalg.det(Q))


def random_model(seed: int) -> Model:
    """A beam chain (straight or kinked) or a guide of two leaf springs, planar for even seeds: random material,
    slenderness (10 to 500), size (5 mm to 5 m), mesh (1 to 6), direction and mass; half of them loaded.
    """
    rng = np.random.default_rng(seed)
    planar = seed % 2 == 0
    length = 10 ** rng.uniform(-2.3, 0.7)
    thickness = length / 10 ** rng.uniform(1, 2.7)
    material = ((STEEL, DENSITY), (70e9, 2700.0))[rng.integers(2)]
    strip = Strip(thickness * 10 ** rng.uniform(0, 1.7), thickness, *material)
    n, d, turn = int(rng.integers(1, 7)), 2 if planar else 3, rotation(rng, planar)
    mass = strip.density * strip.area * length * 10 ** rng.uniform(-2, 2)
    model = Model(planar, rotary=bool(rng.integers(2)))
    if seed % 8 >= 4:
        stage = guide(model, max(n, 2), length, length * rng.uniform(0.3, 2), strip, turn, mass)
    else:
        steps = np.tile([1.0, 0, 0], (n, 1)) + rng.choice([0.0, 0.4]) * rng.normal(size=(n, 3))
        steps[:, 2] *= not planar
        points = np.cumsum(steps * length / n, axis=0) @ turn.T
        start = model.node(np.zeros(d))
        stage = model.leg(start, points[:, :d], strip, turn[:, 2])
        model.fix(start)
        model.dynamics.append(f"XM {stage} {mass!r}")
    if seed % 4 in (1, 2):
        size = strip.stiffness[2] / length**2  # a tenth of it bends the beam by about 2 degrees
        force = rng.normal(size=d) * 0.05 * size
        model.dynamics.append(f"XF {stage} " + " ".join(repr(float(f)) for f in force))
        model.dynamics.append(f"ITERSTEP 30 1 {1e-9 * size!r}")
    return model
