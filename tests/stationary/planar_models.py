"""Input texts of planar flexures: chains of PLBEAM between position nodes, for the tests of the equilibrium path."""

from dataclasses import dataclass, field


@dataclass
class Planar:
    """Collects statements; nodes and elements get numbers in the order of the calls."""

    kinematics: list[str] = field(default_factory=list)
    dynamics: list[str] = field(default_factory=list)
    elements: int = 0
    nodes: int = 0
    at: dict[int, tuple[float, float]] = field(default_factory=dict)

    def position(self, x: float, y: float) -> int:
        self.nodes += 1
        self.kinematics.append(f"X {self.nodes} {x!r} {y!r}")
        self.at[self.nodes] = (x, y)
        return self.nodes

    def angle(self) -> int:
        self.nodes += 1
        return self.nodes

    def beam(self, p: int, rp: int, q: int, rq: int, n: int, EA: float, EI: float) -> list[int]:
        """n equal elements from p to q; their numbers."""
        (x0, y0), (x1, y1) = self.at[p], self.at[q]
        numbers, a, ra = [], p, rp
        for k in range(1, n + 1):
            b, rb = (q, rq) if k == n else (self.position(x0 + k * (x1 - x0) / n, y0 + k * (y1 - y0) / n), self.angle())
            self.elements += 1
            numbers.append(self.elements)
            self.kinematics.append(f"PLBEAM {self.elements} {a} {ra} {b} {rb}")
            self.dynamics += [f"EM {self.elements} 0.01", f"ESTIFF {self.elements} {EA!r} {EI!r}"]
            a, ra = b, rb
        return numbers

    def rigid(self, p: int, r: int, q: int) -> None:
        self.elements += 1
        self.kinematics.append(f"PLRBEAM {self.elements} {p} {r} {q}")

    def text(
        self, beams: list[int], released: dict[int, tuple[int, ...]], kinematics: list[str], dynamics: list[str]
    ) -> str:
        lines = list(self.kinematics)
        for e in beams:
            free = released.get(e, ())
            kept = [k for k in (1, 2, 3) if k not in free]
            lines += [f"DYNE {e} " + " ".join(map(str, kept))] if kept else []
            lines += [f"RLSE {e} " + " ".join(map(str, free))] if free else []
        return "\n".join([*lines, *kinematics, "END", "HALT", *self.dynamics, *dynamics, "END", "END", ""])


E, WIDTH = 210e9, 0.05
RELEASES = {
    "last": lambda A, B: {B[-1]: (1, 2, 3), A[-1]: (3,)},
    "first": lambda A, B: {B[0]: (1, 2, 3), A[0]: (2,)},
    "spread": lambda A, B: {B[-1]: (1, 3), B[0]: (2,), A[0]: (3,)},
    "dead": lambda A, B: {B[-1]: (1, 2, 3), A[-1]: (1,)},  # singular while the leaves of a guide are straight
}


def section(t: float) -> tuple[float, float]:
    """EA [N], EI [N m^2] of a steel leaf of thickness t."""
    return E * WIDTH * t, E * WIDTH * t**3 / 12.0


def two_leaves(
    ends: tuple[tuple[float, float], ...], body: tuple[float, float], t: float, n: int, drive: list[str], release: str
) -> tuple[str, int]:
    """Leaves ends[0]-ends[1], ends[2]-ends[3], the second ends in a rigid body with the node `body`, whose number is
    the second result and stands for {b} in `drive`, the body's orientation for {r}."""
    m = Planar()
    p1, q1, p2, q2 = (m.position(*e) for e in ends)
    a1, a2, r = m.angle(), m.angle(), m.angle()
    EA, EI = section(t)
    A, B = m.beam(p1, a1, q1, r, n, EA, EI), m.beam(p2, a2, q2, r, n, EA, EI)
    m.rigid(q1, r, q2)
    b = q1
    if body != ends[1]:
        b = m.position(*body)
        m.rigid(q1, r, b)
    fixed = [f"FIX {k}" for k in (p1, a1, p2, a2)]
    kinematics = [s.format(b=b, r=r) for s in drive if s.startswith("INPUT") and len(s.split()) <= 3]
    dynamics = [s.format(b=b, r=r) for s in drive if not (s.startswith("INPUT") and len(s.split()) <= 3)]
    return m.text(A + B, RELEASES[release](A, B), fixed + kinematics, dynamics), b


CROSS = ((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1))
GUIDE = ((-0.05, 0.0), (-0.05, 0.1), (0.05, 0.0), (0.05, 0.1))


def cross_hinge(n: int, d: float, steps: int = 5, release: str = "last") -> tuple[str, int]:
    """Body moved by d along x at (0.1, 0.1); leaves of 0.2 mm."""
    drive = ["INPUTX {b} 1", f"DELINPX {{b}} 1 {d!r}", f"ITERSTEP 20 {steps} 1e-7 1 2"]
    return two_leaves(CROSS, (0.1, 0.1), 2e-4, n, drive, release)


def turned_hinge(n: int, angle: float, steps: int = 5, release: str = "last") -> tuple[str, int]:
    """The body turned; the moment is at its orientation node, which is the node before the last position."""
    drive = ["INPUTX {r} 1", f"DELINPX {{r}} 1 {angle!r}", f"ITERSTEP 20 {steps} 1e-7 1 2"]
    return two_leaves(CROSS, (0.1, 0.1), 2e-4, n, drive, release)


def guide(n: int, t: float, d: float, steps: int = 4, release: str = "last") -> tuple[str, int]:
    """Parallel guide, the middle of the coupler moved by d."""
    drive = ["INPUTX {b} 1", f"DELINPX {{b}} 1 {d!r}", f"ITERSTEP 20 {steps} 1e-7 1 2"]
    return two_leaves(GUIDE, (0.0, 0.1), t, n, drive, release)


def lee(load: float, steps: int, n: int, follow: int = 0) -> tuple[str, int]:
    """Lee's frame: hinged bars of 120, EA 4320, EI 1440, load at 24 from the corner; n elements a bar (n/5 whole)."""
    m = Planar()
    a, ra, c, rc = m.position(0.0, 0.0), m.angle(), m.position(0.0, 120.0), m.angle()
    p, rp, e, re = m.position(24.0, 120.0), m.angle(), m.position(120.0, 120.0), m.angle()
    beams = m.beam(a, ra, c, rc, n, 4320.0, 1440.0)
    beams += m.beam(c, rc, p, rp, n // 5, 4320.0, 1440.0) + m.beam(p, rp, e, re, 4 * n // 5, 4320.0, 1440.0)
    dynamics = [f"XF {p} 0. {-load!r}", f"ITERSTEP 20 {steps} 1e-7 1 0 0 {follow}"]
    return m.text(beams, {beams[-1]: (1, 2)}, [f"FIX {a}", f"FIX {e}", f"DYNX {ra}"], dynamics), p


def buckled(steps: int, height: float = 0.008, push: float = 0.002, n: int = 16) -> tuple[str, int]:
    """Clamped beam of 0.1 m, one end pushed in, the middle held at a height and then moved to its negative."""
    m = Planar()
    a, ra, c, rc = m.position(0.0, 0.0), m.angle(), m.position(0.05, 0.0), m.angle()
    b, rb = m.position(0.1, 0.0), m.angle()
    EA, EI = 105e3, 7e-3
    A, B = m.beam(a, ra, c, rc, n // 2, EA, EI), m.beam(c, rc, b, rb, n // 2, EA, EI)
    kinematics = [f"FIX {a}", f"FIX {ra}", f"FIX {rb}", f"FIX {b} 2", f"INPUTX {b} 1", f"INPUTX {c} 2"]
    dynamics = [f"INPUTX {b} 1 {0.1 - push!r}", f"INPUTX {c} 2 {height!r}", f"DELINPX {c} 2 {-2 * height!r}"]
    dynamics += [f"ITERSTEP 10 {steps} 1e-7 1 2 {steps}"]
    return m.text(A + B, {B[-1]: (1, 2, 3), A[-1]: (2,)}, kinematics, dynamics), c
