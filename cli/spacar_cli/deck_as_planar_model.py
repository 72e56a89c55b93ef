"""A planar input file as a model file: an orientation is an angle to N, the sum of the angles that lead to it.

A rigid PLBEAM, PLRBEAM or PLTRUSS is a body whose angle is a coordinate; a loop of orientations is a condition on
angles; a PLTOR that is free leaves two angles, with a torque between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar_cli.deck_as_model import HELD, DeckModel, Ends, Orientation
from spacar_cli.deck_parts import Part


def _across(a: Array, b: Array) -> Any:
    return a[0] * b[1] - a[1] * b[0]


@dataclass
class PlanarModel(DeckModel):
    """The model file of a planar input file."""

    # -- orientations ------------------------------------------------------------------------------------------------

    def drive_orientation(self, node: int) -> None:
        if self.class_of(node, 0) == "input":
            open_by = f"{self.turn(node).angle} - ({self.driven(node, 0)})"
            self.table("constraint", name=f"drive_{node}", expression=open_by)

    def turning_loads(self, node: int) -> None:
        inertia = self.values("XM", node, 1)[0]
        if inertia:
            self.inertia(f"inertia{node}", node, [0, 0, self.parameter(f"Jn{node}", inertia)])
        moment = float(self.mechanism.loads.force[self.row(node)])
        if moment:
            vector = [0, 0, self.parameter(f"M{node}", moment)]
            self.table("torque", name=f"mom{node}", frame=self.frames[node].frame, vector=vector)

    def turned(self, direction: Array, rows: Array) -> Array:
        angle = np.arctan2(direction[1], direction[0]) + rows[:, 0]
        return np.column_stack((np.cos(angle), np.sin(angle)))

    def turn(self, node: int) -> Orientation:
        if node not in self.frames:
            i = self.row(node)
            self.frames[node] = self._turning(f"B{node}", f"a{node}", self.x[i], self.xd[i])
        return self.frames[node]

    def _turning(self, frame: str, name: str, start: float, rate: float) -> Orientation:
        """A frame by an angle to N that is a coordinate."""
        self.coordinate(name, start, rate)
        self.frame(frame, "N", [(3, name)])
        return Orientation(frame, name, f"{name}_t")

    def same(self, part: Part, node: int, found: Orientation) -> None:
        known = self.frames.setdefault(node, found)
        if known.angle != found.angle:
            self.table("constraint", expression=f"{known.angle} - ({found.angle})")

    # -- the tree ----------------------------------------------------------------------------------------------------

    def hinge(self, part: Part) -> None:
        """A weld, a prescribed angle, or a torque of stiffness, damping and preload between two frames."""
        _, p, _, q = part.nodes
        n, kind = part.number, part.classes[0]
        if kind in HELD and p not in self.frames and q not in self.frames:
            self.turn(p)
        if kind == "fixed":
            known, other = (p, q) if p in self.frames else (q, p)
            self.same(part, other, self.frames[known])
            return
        drive = self.driven_deformation(part) if kind == "input" else ""
        a, b = self.turn(p), self.turn(q)
        if drive:
            self.table("constraint", name=f"drive{n}", expression=f"{b.angle} - ({a.angle}) - ({drive})")
        elif law := self.joint_law(part, f"{b.angle} - ({a.angle})", f"{b.rate} - ({a.rate})"):
            self.table("torque", name=f"T_{n}", frame=b.frame, reaction=a.frame, vector=[0, 0, f"-({law})"])

    def bar(self, part: Part) -> None:
        """A body with an angle of its own, or a distance."""
        p, _, q, _ = part.nodes
        if q not in self.points:
            self.float_point(p)
        if p in self.points and q in self.points and not self.values("EM", part.number, 1)[0]:
            self.distance(part)
            return
        span, now, rate = self.span(part), self.span(part, self.x), self.span(part, self.xd)
        angle = float(np.arctan2(_across(span, now), span @ now)), float(_across(now, rate) / (now @ now))
        self.carry(part, self._turning(f"T{part.number}", f"r{part.number}", *angle))

    def carry(self, part: Part, found: Orientation) -> None:
        if self.kind(part) == "slider":
            self._slider(part, found)
        else:
            super().carry(part, found)

    def _slider(self, part: Part, angle: Orientation) -> None:
        """A beam that only changes its length: a guide along it, with its stiffness as a spring."""
        n, (p, _, q, _), span = part.number, part.nodes, self.span(part)
        if any(self.values("EM", n, 2)):
            raise self.cannot(part, "it changes its length and has mass")
        if p in self.points and q in self.points:
            a, b, beta = self.points[p], self.points[q], self.parameter(f"beta{n}", float(np.arctan2(*span[::-1])))
            turn = f"{angle.angle} + {beta}"
            self.table("constraint", expression=f"({b}.y - {a}.y)*cos({turn}) - ({b}.x - {a}.x)*sin({turn})")
        else:
            here, there, sign = (p, q, 1.0) if p in self.points else (q, p, -1.0)
            now, rate = self.span(part, self.x), self.span(part, self.xd)
            length = float(np.linalg.norm(now))
            self.coordinate(f"l{n}", length, float(now @ rate / length))
            offset = self.named(f"c*{n}", sign * span / self.length(part))
            self.point(there, self.points[here], [f"{v}*l{n}" if v != "0" else v for v in offset], angle.frame)
        self.elastic(part)

    # -- beams and rods ----------------------------------------------------------------------------------------------

    def sections(self, part: Part, axes: Array, rotary: Sequence[float]) -> list[Any]:
        return [0, 0, self.parameter(f"J{part.number}", rotary[0])]

    def rod_inertia(self, part: Part, mass: str, length: str, rotary: Sequence[float]) -> list[Any]:
        return [0, 0, f"{mass}*{length}**3/12 + {self.sections(part, np.eye(2), rotary)[2]}*{length}"]

    def axes_of(self, part: Part, backwards: bool) -> Array:
        along = self.span(part) * (-1.0 if backwards else 1.0)
        along = along / np.linalg.norm(along)
        return np.array([[along[0], -along[1]], [along[1], along[0]]])

    def mounting(self, part: Part, axes: Array) -> list[tuple[int, str]]:
        beta = self.parameter(f"beta{part.number}", float(np.arctan2(axes[1, 0], axes[0, 0])))
        return [(3, beta)] if beta != "0" else []

    def bending(self, part: Part, stiffness: Sequence[float]) -> tuple[list[int], dict[str, Any]]:
        return [2], {"EI": self.parameter(f"EI{part.number}", stiffness[1])}

    def tip(self, number: int, root: Orientation, frame: str) -> Orientation:
        terms = ((root.angle, f"beam{number}.tip.slope"), (root.rate, f"beam{number}_uxt"))
        return Orientation(frame, *(more if of == "0" else f"{of} + {more}" for of, more in terms))

    def deflection(self, ends: Ends, axes: Array, x: Array) -> tuple[Array, Array]:
        p, turn_p, q, turn_q = ((self.numbering.lnp[n - 1, :2] - 1) for n in ends)
        a, b = x[turn_p[0]], x[turn_q[0]]
        back = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        return axes.T @ back @ (x[q] - x[p]), np.array([0.0, 0.0, b - a])
