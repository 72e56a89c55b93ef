"""Input files as model files, in the plane and in space.

In the plane an orientation is an angle to N, the sum of the angles that lead to it. A rigid PLBEAM, PLRBEAM or PLTRUSS
is a body whose angle is a coordinate; a loop of orientations is a condition on angles; a PLTOR that is free leaves two
angles, with a torque between them.

In space an orientation that hangs on nothing is a quaternion.

A HINGE turns the frame of one node about its axis against that of the other; loops of orientations are refused. As
frames lie along N in the reference configuration, an axis has the same components in the frames of both nodes; a turn
about an axis a that is none of N is

    turns z, y, z', y', z' by α, β, φ, −β, −α,   a = (sin β cos α, sin β sin α, cos β)

A beam bends in its x'z' plane (modes 3, 4; EIy) along axis 3 and in its x'y' plane (modes 5, 6; EIz) along axis 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import EPS, Array
from spacar.elements.rotations.rotation import body_matrix, rotate
from spacar.errors import UsageError
from spacar_cli.deck_as_model import HELD, DeckModel, Ends, Orientation, with_rate
from spacar_cli.deck_as_text import Part

TENSOR = ((0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (1, 2, "yz"), (0, 2, "xz"))  # as in [[body]]
BACK = np.array([1.0, -1.0, -1.0, -1.0])  # times Euler parameters: the rotation back


def _across(a: Array, b: Array) -> Any:
    return a[0] * b[1] - a[1] * b[0]


@dataclass
class PlanarModel(DeckModel):
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

    def sections(self, part: Part, rotary: Sequence[float]) -> list[Any]:
        return [0, 0, self.parameter(f"J{part.number}", rotary[0])]

    def rod_inertia(self, part: Part, mass: str, length: str, rotary: Sequence[float]) -> list[Any]:
        return [0, 0, f"{mass}*{length}**3/12 + {self.sections(part, rotary)[2]}*{length}"]

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


@dataclass
class SpatialModel(DeckModel):
    def drive_orientation(self, node: int) -> None:
        if any(self.class_of(node, k) == "input" for k in range(4)):
            where = self.deck.source
            raise UsageError(f"{where}: prescribed Euler parameters (node {node}) cannot be exported", "export")

    def turning_loads(self, node: int) -> None:
        xx, xy, xz, yy, yz, zz = values = self.values("XM", node, 6)
        if any(values):
            pairs = zip(TENSOR, (xx, yy, zz, xy, yz, xz), strict=True)
            self.inertia(f"inertia{node}", node, [self.parameter(f"J{pair}{node}", v) for (*_, pair), v in pairs])
        loads, row = self.mechanism.loads, self.row(node)
        moment = loads.moment[loads.moment_rows[0] == row].sum(0)
        if moment.any():
            names = self.named(f"M*{node}", moment)
            self.table("torque", name=f"mom{node}", frame=self.frames[node].frame, vector=names)

    def turned(self, direction: Array, rows: Array) -> Array:
        unit = direction / np.linalg.norm(direction)
        return rotate(rows.T, np.tile(unit[:, None], len(rows))).T

    def _parameters(self, node: int, x: Array) -> Array:
        """λ (4,) of an orientation node."""
        return x[self.numbering.lnp[node - 1] - 1]

    def turn(self, node: int) -> Orientation:
        if node not in self.frames:
            now, rate = self._parameters(node, self.x), self._parameters(node, self.xd)
            self.table(
                "attitude", name=f"B{node}", parent="N", quaternion=f"e{node}_", speed=f"w{node}_",
                start=now.tolist(), speed_start=(2.0 * body_matrix(now) @ rate).tolist(),
            )  # fmt: skip
            self.frames[node] = Orientation(f"B{node}")
        return self.frames[node]

    def same(self, part: Part, node: int, found: Orientation) -> None:
        if self.frames.setdefault(node, found) != found:
            raise self.cannot(part, "it closes a loop of orientations")

    def _turned(self, name: str, parent: str, axis: Array, angle: str, number: int) -> None:
        """A frame that is turned about an axis given in its parent."""
        k = int(np.argmax(np.abs(axis)))
        if np.abs(np.delete(axis, k)).max() == 0.0:
            self.frame(name, parent, [(k + 1, angle if axis[k] > 0 else f"-({angle})")])
            return
        alpha = self.parameter(f"alpha{number}", float(np.arctan2(axis[1], axis[0])))
        beta = self.parameter(f"beta{number}", float(np.arctan2(np.hypot(*axis[:2]), axis[2])))
        turns = [(3, alpha), (2, beta), (3, angle), (2, f"-{beta}"), (3, f"-{alpha}")]
        self.frame(name, parent, [(a, v) for a, v in turns if v not in ("0", "-0")])

    def hinge(self, part: Part) -> None:
        """The frame of one node turned against that of the other; a torque of stiffness, damping and preload."""
        _, p, _, q = part.nodes
        n, kind = part.number, part.classes[0]
        if p in self.frames and q in self.frames:
            raise self.cannot(part, "it closes a loop of orientations")
        if p not in self.frames and q not in self.frames:
            self.turn(p)
        known, other, sign = (p, q, "") if p in self.frames else (q, p, "-")
        if kind == "fixed":
            self.frames[other] = self.frames[known]
            return
        axis, name = self._frame_rows(part)[0], f"a{n}"
        axis = np.where(np.abs(axis) < 4 * EPS, 0.0, axis)  # of a component that is zero
        if kind == "input":
            name = f"({self.driven_deformation(part)})"
        else:
            self.coordinate(name, *with_rate(lambda x: self._rotation(part, axis, x), self.x, self.xd))
        self._turned(f"B{other}", self.frames[known].frame, axis, f"{sign}{name}", n)
        self.frames[other] = Orientation(f"B{other}")
        if kind != "input" and (law := self.joint_law(part, name, f"{name}_t")):
            vector = [f"-({law})*{a}" if a != "0" else "0" for a in self.named(f"n*{n}", axis)]
            self.table(
                "torque", name=f"T_{n}", frame=self.frames[q].frame, reaction=self.frames[p].frame, vector=vector,
                **{"in": self.frames[known].frame},
            )  # fmt: skip

    def _rotation(self, part: Part, axis: Array, x: Array) -> Any:
        """φ of a hinge within half a turn: tan φ/2 = a·μ/μ0 of the relative rotation μ."""
        p, q = (self._parameters(node, x) for node in (part.nodes[1], part.nodes[3]))
        sine, cosine = axis @ (body_matrix(p) @ q), p @ q
        turn = np.arctan2(sine.real, cosine.real)
        if np.iscomplexobj(x):
            turn = turn + 1j * (cosine.real * sine.imag - sine.real * cosine.imag)
        return 2.0 * turn

    def bar(self, part: Part) -> None:
        """A distance."""
        if self.values("EM", part.number, 1)[0]:
            raise self.cannot(part, "a rigid truss with mass has no orientation of its own")
        for node in (part.nodes[0], part.nodes[2]):
            self.float_point(node)
        self.distance(part)

    def _frame_rows(self, part: Part) -> Array:
        """x', y', z' of an element as rows, (3, 3)."""
        for batch in self.mechanism.batches:
            family = batch.family
            numbers = list(family.numbers)
            if family.keyword == part.keyword and family.frame_p is not None and part.number in numbers:
                return np.array(family.frame_p[numbers.index(part.number)]).reshape(3, 3)
        raise self.cannot(part, "it has no local frame")

    def axes_of(self, part: Part, backwards: bool) -> Array:
        return self._frame_rows(part).T * ([-1.0, -1.0, 1.0] if backwards else 1.0)

    def sections(self, part: Part, rotary: Sequence[float]) -> list[Any]:
        tensor = _tensor(self.axes_of(part, False), rotary)  # of p and q as they are, whichever is the root
        return [self.parameter(f"j{pair}{part.number}", tensor[i, j]) for i, j, pair in TENSOR]

    def rod_inertia(self, part: Part, mass: str, length: str, rotary: Sequence[float]) -> list[Any]:
        """ρL³/12 (1 − x'x'ᵀ), and J' of its sections."""
        R, n = self.axes_of(part, False), part.number
        tensor, slender = _tensor(R, rotary), np.eye(3) - np.outer(R[:, 0], R[:, 0])
        inertia = []
        for i, j, pair in TENSOR:
            terms = ((f"s{pair}{n}", slender[i, j], f"{mass}*{length}**3/12"), (f"j{pair}{n}", tensor[i, j], length))
            inertia.append(" + ".join(f"{self.parameter(s, v)}*{unit}" for s, v, unit in terms if v) or "0")
        return inertia

    def mounting(self, part: Part, axes: Array) -> list[tuple[int, str]]:
        turns = zip((3, 2, 1), _yaw_pitch_roll(axes), strict=True)
        found = [(axis, self.parameter(f"r{axis}_{part.number}", angle)) for axis, angle in turns]
        return [(axis, name) for axis, name in found if name != "0"]

    def bending(self, part: Part, stiffness: Sequence[float]) -> tuple[list[int], dict[str, Any]]:
        n, classes = part.number, part.classes
        bends = [axis for axis, first in ((3, 2), (2, 4)) if classes[first] == "dynamic"]
        EI = [self.parameter(f"EI{'yz'[axis == 2]}{n}", stiffness[2 + (axis == 2)]) for axis in bends]
        twist = {"twist": 1, "GJ": self.parameter(f"GJ{n}", stiffness[1])} if classes[1] == "dynamic" else {}
        return bends, {"bends": bends, "EI": EI, **twist}

    def deflection(self, ends: Ends, axes: Array, x: Array) -> tuple[Array, Array]:
        p, turn_p, q, turn_q = ends
        root, tip = self._parameters(turn_p, x), self._parameters(turn_q, x)
        here, there = (x[self.numbering.lnp[n - 1, :3] - 1] for n in (p, q))
        return axes.T @ rotate(root * BACK, there - here), axes.T @ (2.0 * body_matrix(root) @ tip)


def _tensor(R: Array, j: Sequence[float]) -> Array:
    """R0 J' R0ᵀ per length; j are Jx'x', Jy'y', Jz'z', Jy'z'."""
    J = np.diag(j[:3])
    J[1, 2] = J[2, 1] = j[3]
    return np.asarray(R @ J @ R.T)


def _yaw_pitch_roll(R: Array) -> list[float]:
    """Angles of turns about 3, 2, 1 that make R; zero where only rounding is left."""
    level = np.hypot(R[0, 0], R[1, 0])
    if level > EPS**0.5:
        yaw, roll = np.arctan2(R[1, 0], R[0, 0]), np.arctan2(R[2, 1], R[2, 2])
    else:
        yaw, roll = np.arctan2(-R[0, 1], R[1, 1]), 0.0
    return [0.0 if abs(a) < 8 * EPS else float(a) for a in (yaw, np.arctan2(-R[2, 0], level), roll)]
