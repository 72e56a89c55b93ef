"""A planar input file of the numeric core as a model file of the symbolic part.

Parts become links of a tree: a rigid PLBEAM, PLRBEAM or PLTRUSS is a body whose angle is a coordinate, orientation
nodes that rigid beams join are one frame, a flexible PLBEAM is a beam with assumed shapes clamped in the frame at p (or
q). What meets a part that is there already closes a loop. Numbers become parameters with the number of their element or
node. Frames lie along N in the reference configuration, as the angles of planar nodes do (theory-planar.md, section 1).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from spacar_cli.deck_as_text import DeckText
from spacar_cli.deck_parts import Part


class Angle(NamedTuple):
    """An orientation: its frame, its angle to N and the rate of that, as expressions."""

    frame: str
    angle: str
    rate: str


@dataclass
class PlanarModel(DeckText):
    """The model file of a planar input file."""

    angles: dict[int, Angle] = field(default_factory=dict)

    def orientation(self, node: int) -> None:
        if self.class_of(node, 0) == "fixed":
            self.angles[node] = Angle("N", "0", "0")

    def drive_orientation(self, node: int) -> None:
        if self.class_of(node, 0) == "input":
            drive = self.driven(node, 0)
            self.table("constraint", name=f"drive_{node}", expression=f"{self._turn(node).angle} - ({drive})")

    def turning_loads(self, node: int) -> None:
        if node not in self.angles:
            return
        inertia = self.values("XM", node, 1)[0]
        if inertia:
            self.inertia(f"inertia{node}", self.angles[node].frame, self.parameter(f"Jn{node}", inertia))
        moment = float(self.mechanism.loads.force[int(self.numbering.lnp[node - 1, 0]) - 1])
        if moment:
            value = self.parameter(f"M{node}", moment)
            self.table("torque", name=f"mom{node}", frame=self.angles[node].frame, vector=[0, 0, value])

    def turning_outputs(self) -> list[str]:
        return [f'"angle{n}" = "{self.angles[n].angle}"' for n in self.turned_about_z()]

    def turned_about_z(self) -> list[int]:
        return [n for n, a in self.angles.items() if a.frame != "N"]

    def turned(self, direction: np.ndarray, rows: np.ndarray) -> np.ndarray:
        angle = np.arctan2(direction[1], direction[0]) + rows[:, 0]
        return np.column_stack((np.cos(angle), np.sin(angle)))

    # -- the tree ----------------------------------------------------------------------------------------------

    def readiness(self, part: Part) -> tuple[int, int]:
        """The part that is taken next: what needs no new coordinate, then what hangs on a known point."""
        p, turn_p, q, turn_q = part.nodes
        kind = self.kind(part)
        if kind == "spring":
            return (0, -part.number)
        if kind == "hinge":
            welded = part.classes[0] in ("fixed", "input") and (turn_p in self.angles) != (turn_q in self.angles)
            return (6 if welded else 0, -part.number)
        here = p in self.points or q in self.points
        turned = turn_p in self.angles or turn_q in self.angles
        return (5 if here and turned else 4 if here else 3 if turned else 2, -part.number)

    def add(self, part: Part) -> None:
        kind = self.kind(part)
        if kind == "spring":
            self.spring(part)
        elif kind == "hinge":
            self._hinge(part)
        elif part.is_truss:
            self._bar(part)
        else:
            self._link(part, kind)

    def _turn(self, node: int) -> Angle:
        """The orientation of a node, with a coordinate of its own when it is new."""
        if node not in self.angles:
            i = int(self.numbering.lnp[node - 1, 0]) - 1
            name = f"a{node}"
            self.coordinate(name, float(self.x[i]), float(self.xd[i]))
            self.table("frame", name=f"B{node}", parent="N", axis=3, angle=name)
            self.angles[node] = Angle(f"B{node}", name, f"{name}_t")
        return self.angles[node]

    def _link(self, part: Part, kind: str) -> None:
        """A rigid body, a slider or a beam between p and q."""
        p, turn_p, q, turn_q = part.nodes
        if p not in self.points and q not in self.points:
            self.float_point(p)
        backwards = p not in self.points or (kind == "beam" and turn_p not in self.angles and turn_q in self.angles)
        if kind == "beam":
            if backwards and q in self.points:
                p, turn_p, q, turn_q = q, turn_q, p, turn_p
            elif p not in self.points:
                raise self.cannot(part, "neither of its ends is placed with its orientation")
            self._beam(part, p, turn_p, q, turn_q)
            return
        known = turn_p if turn_p in self.angles or turn_q not in self.angles else turn_q
        angle = self._turn(known)
        for other in (turn_p, turn_q):
            self._same(other, angle)
        span = self.place(q) - self.place(p)
        if kind == "slider":
            self._slider(part, angle, span)
            return
        offset = self.named(f"d*{part.number}", span)
        self.reach(part, angle.frame, p, q, offset)
        self._rod(part, angle, p, q, float(np.hypot(*span)), offset)

    def _same(self, node: int, angle: Angle) -> None:
        """An orientation node that has this angle: named, or a condition when it has one already."""
        if not node:
            return
        if node not in self.angles:
            self.angles[node] = angle
        elif self.angles[node].angle != angle.angle:
            self.table("constraint", expression=f"{self.angles[node].angle} - ({angle.angle})")

    def _rod(self, part: Part, angle: Angle, p: int, q: int, length: float, offset: list[str]) -> None:
        """The distributed mass of a rigid part, and the rotary inertia of its sections."""
        rho, rotary = self.values("EM", part.number, 2)
        if not rho and not rotary:
            return
        n = part.number
        m, L = self.parameter(f"rho{n}", rho), self.parameter(f"L{n}", length)
        j = self.parameter(f"J{n}", rotary)
        half = [f"{v}/2" if v != "0" else v for v in offset]
        self.table("point", name=f"G{n}", base=self.points[p], offset=[*half, 0], **{"in": angle.frame})
        self.table(
            "body", name=f"rod{n}", frame=angle.frame, at=f"G{n}", mass=f"{m}*{L}",
            inertia=[0, 0, f"{m}*{L}**3/12 + {j}*{L}"],
        )  # fmt: skip

    def _bar(self, part: Part) -> None:
        """A rigid truss: a body with an angle of its own, or a distance."""
        p, _, q, _ = part.nodes
        n, span = part.number, self.place(q) - self.place(p)
        length = float(np.hypot(*span))
        if p not in self.points and q not in self.points:
            self.float_point(p)
        if p in self.points and q in self.points and not self.values("EM", n, 1)[0]:
            self.distance(part)
            return
        now, rate = (self.place(q, x) - self.place(p, x) for x in (self.x, self.xd))
        start = float(np.arctan2(span[0] * now[1] - span[1] * now[0], span @ now))
        self.coordinate(f"r{n}", start, float((now[0] * rate[1] - now[1] * rate[0]) / (now @ now)))
        self.table("frame", name=f"T{n}", parent="N", axis=3, angle=f"r{n}")
        angle = Angle(f"T{n}", f"r{n}", f"r{n}_t")
        offset = self.named(f"d*{n}", span)
        self.reach(part, angle.frame, p, q, offset)
        self._rod(part, angle, p, q, length, offset)

    def _slider(self, part: Part, angle: Angle, span: np.ndarray) -> None:
        """A beam that only changes its length: a guide along it, with its stiffness as a spring."""
        p, _, q, _ = part.nodes
        n = part.number
        if any(self.values("EM", n, 2)):
            raise self.cannot(part, "it changes its length and has mass")
        along, L = span / np.hypot(*span), float(np.hypot(*span))
        if p in self.points and q in self.points:
            a, b, beta = self.points[p], self.points[q], self.parameter(f"beta{n}", float(np.arctan2(*along[::-1])))
            turn = f"{angle.angle} + {beta}"
            self.table("constraint", expression=f"({b}.y - {a}.y)*cos({turn}) - ({b}.x - {a}.x)*sin({turn})")
        else:
            here, there, sign = (p, q, 1.0) if p in self.points else (q, p, -1.0)
            now, rate = (self.place(q, x) - self.place(p, x) for x in (self.x, self.xd))
            length = float(np.hypot(*now))
            self.coordinate(f"l{n}", length, float(now @ rate / length))
            offset = [self.parameter(f"c{a}{n}", float(sign * v)) for a, v in zip("xy", along, strict=True)]
            self.point(there, self.points[here], [f"{v}*l{n}" if v != "0" else v for v in offset], angle.frame)
        self.elastic(part, L)

    def _hinge(self, part: Part) -> None:
        """A weld, a prescribed angle, or a torque of stiffness, damping and preload between two frames."""
        _, p, _, q = part.nodes
        n, kind = part.number, part.classes[0]
        if kind in ("fixed", "input") and p not in self.angles and q not in self.angles:
            self._turn(p)
        if kind == "fixed":
            known, other = (p, q) if p in self.angles else (q, p)
            self._same(other, self.angles[known])
            return
        if kind == "input":
            drive = self.driven_deformation(part)
            a, b = self._turn(p), self._turn(q)
            self.table("constraint", name=f"drive{n}", expression=f"{b.angle} - ({a.angle}) - ({drive})")
            return
        a, b = self._turn(p), self._turn(q)
        law = self.joint_law(part, f"{b.angle} - ({a.angle})", f"{b.rate} - ({a.rate})")
        if law:
            self.table("torque", name=f"T_{n}", frame=b.frame, reaction=a.frame, vector=[0, 0, f"-({law})"])

    def _beam(self, part: Part, p: int, turn_p: int, q: int, turn_q: int) -> None:
        """A flexible beam from p, clamped in the frame there; its tip carries the frame at q."""
        n = part.number
        self.no_preload(part)
        rho, rotary = self.values("EM", n, 2)
        EA, EI, shear = self.values("ESTIFF", n, 3)
        if any(self.values("EDAMP", n, 3)):
            raise self.cannot(part, "its damping EDAMP has no counterpart in the damping of assumed fields")
        if shear:
            raise self.cannot(part, "it has shear flexibility")
        span = self.place(q) - self.place(p)
        beta = float(np.arctan2(span[1], span[0]))
        length = float(np.hypot(*span))
        root, b = self._turn(turn_p), self.parameter(f"beta{n}", beta)
        frame = root.frame
        if b != "0":
            frame = f"F{n}"
            self.table("frame", name=frame, parent=root.frame, axis=3, angle=b)
        start, rate = self._amplitudes(p, turn_p, q, turn_q, beta, length)
        stretch = {"stretch": 1, "EA": self.parameter(f"EA{n}", EA)} if part.classes[0] == "dynamic" else {}
        axial = self._elongation(p, q, length) if stretch else ([], [])
        self.table(
            "beam", name=f"beam{n}", frame=frame, root=self.points[p], length=self.parameter(f"L{n}", length),
            mass=self.parameter(f"rho{n}", rho), EI=self.parameter(f"EI{n}", EI), field=self.shapes,
            start=start + axial[0], speed_start=rate + axial[1], **stretch,
        )  # fmt: skip
        tip = f"beam{n}.tip"
        if turn_q not in self.angles:
            name = f"B{turn_q}"
            self.table("frame", name=name, parent=tip, axis=3, angle=f"-{b}" if b != "0" else 0)
            slope, turn = f"{tip}.slope", f"beam{n}_uxt"
            angle = Angle(
                name, slope if root.angle == "0" else f"{root.angle} + {slope}",
                turn if root.rate == "0" else f"{root.rate} + {turn}",
            )  # fmt: skip
            self.angles[turn_q] = angle
        else:
            known = self.angles[turn_q].angle
            self.table("constraint", expression=f"{root.angle} + {tip}.slope - ({known})")
        if q in self.points:
            self.table("close", **{"from": tip, "to": self.points[q]}, directions=[1, 2])
        else:
            self.points[q] = tip
        if rotary:  # lumped to the orientation nodes
            j = self.parameter(f"J{n}", rotary)
            for k, node in enumerate((turn_p, turn_q)):
                self.inertia(f"disc{n}_{k}", self.angles[node].frame, f"{j}*L{n}/2")

    def _amplitudes(
        self, p: int, turn_p: int, q: int, turn_q: int, beta: float, length: float
    ) -> tuple[list[float], list[float]]:
        """Amplitudes and rates of the two lowest default shapes that give the tip its start deflection and slope."""
        import sympy as sp

        from spacar.symbolic.beam_shapes import X, orthogonal

        def of(x: Any) -> tuple[np.ndarray, float, float]:
            rows = [int(self.numbering.lnp[n - 1, 0]) - 1 for n in (turn_p, turn_q)]
            return self.place(q, x) - self.place(p, x), float(x[rows[0]]), float(x[rows[1]])

        (d, a, b), (v, w, s) = of(self.x), of(self.xd)
        across = np.array([-np.sin(a + beta), np.cos(a + beta)])
        along = np.array([np.cos(a + beta), np.sin(a + beta)])
        u, du = float(d @ across), float(v @ across - w * (d @ along))
        shapes = orthogonal(2)(X, sp.Float(length))
        A = np.array([[float(psi.diff(X, k).subs(X, length)) for psi in shapes] for k in (0, 1)])
        zeros = [0.0] * (self.shapes - 2)
        found = [np.linalg.solve(A, row).tolist() + zeros for row in ([u, b - a], [du, s - w])]
        return found[0], found[1]

    def _elongation(self, p: int, q: int, length: float) -> tuple[list[float], list[float]]:
        now, rate = (self.place(q, x) - self.place(p, x) for x in (self.x, self.xd))
        size = float(np.hypot(*now))
        return [size - length], [float(now @ rate) / size]

    def inertia(self, name: str, frame: str, value: str) -> None:
        if frame != "N":
            self.table("body", name=name, frame=frame, at="O", mass=0, inertia=[0, 0, value])
