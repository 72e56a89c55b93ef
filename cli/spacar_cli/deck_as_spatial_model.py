"""A spatial input file of the numeric core as a model file of the symbolic part.

As in the plane, parts become links of a tree. Orientation nodes that rigid beams join are one frame; a HINGE turns the
frame of one node about its axis against that of the other; an orientation that hangs on nothing is a quaternion. A
flexible BEAM has assumed shapes and is clamped in the frame at p (or q). Points that are reached twice close a loop;
loops of orientations are refused. Frames lie along N in the reference configuration (theory-spatial.md, section 2), so
that an axis has the same components in the frames of both nodes; a turn about an axis a that is none of N is

    turns z, y, z', y', z' by α, β, φ, −β, −α,   a = (sin β cos α, sin β sin α, cos β)

A beam bends in its x'z' plane (modes 3, 4; EIy) along axis 3 and in its x'y' plane (modes 5, 6; EIz) along axis 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spacar.elements.rotations.rotation import rotate
from spacar.errors import UsageError
from spacar_cli.deck_as_text import DeckText
from spacar_cli.deck_parts import Part

Components = list[str]


@dataclass
class SpatialModel(DeckText):
    """The model file of a spatial input file. `frames`: of the orientation nodes."""

    frames: dict[int, str] = field(default_factory=dict)

    # -- orientations --------------------------------------------------------------------------------------------

    def orientation(self, node: int) -> None:
        if all(self.class_of(node, k) == "fixed" for k in (1, 2, 3)):
            self.frames[node] = "N"

    def drive_orientation(self, node: int) -> None:
        if node not in self.frames:
            self._turn(node)

    def turning_loads(self, node: int) -> None:
        xx, xy, xz, yy, yz, zz = self.values("XM", node, 6)
        if any((xx, xy, xz, yy, yz, zz)) and self.frames[node] != "N":
            pairs = zip(("xx", "yy", "zz", "xy", "yz", "xz"), (xx, yy, zz, xy, yz, xz), strict=True)
            inertia = [self.parameter(f"J{pair}{node}", value) for pair, value in pairs]
            self.table("body", name=f"inertia{node}", frame=self.frames[node], at="O", mass=0, inertia=inertia)
        loads, row = self.mechanism.loads, int(self.numbering.lnp[node - 1, 0]) - 1
        moment = loads.moment[loads.moment_rows[0] == row].sum(0)
        if moment.any():
            names = self.named(f"M*{node}", moment)
            self.table("torque", name=f"mom{node}", frame=self.frames[node], vector=names)

    def turning_outputs(self) -> list[str]:
        return []

    def turned_about_z(self) -> list[int]:
        return []

    def turned(self, direction: np.ndarray, rows: np.ndarray) -> np.ndarray:
        unit = direction / np.linalg.norm(direction)
        return rotate(rows.T, np.tile(unit[:, None], len(rows))).T

    def parameters_of(self, node: int, x: Any) -> np.ndarray:
        """λ (4,) of an orientation node."""
        return np.array([x[i - 1] for i in self.numbering.lnp[node - 1]])

    def _turn(self, node: int) -> str:
        """The frame of a node, free to turn when it is new."""
        if node not in self.frames:
            if any(self.class_of(node, k) == "input" for k in range(4)):
                where = self.deck.source
                raise UsageError(f"{where}: prescribed Euler parameters (node {node}) cannot be exported", "export")
            now, rate = self.parameters_of(node, self.x), self.parameters_of(node, self.xd)
            spin = 2.0 * _product(_conjugate(now), rate)[1:]
            self.table(
                "attitude", name=f"B{node}", parent="N", quaternion=f"e{node}_", speed=f"w{node}_",
                start=now.tolist(), speed_start=spin.tolist(),
            )  # fmt: skip
            self.frames[node] = f"B{node}"
        return self.frames[node]

    def _turned(self, name: str, parent: str, axis: np.ndarray, angle: str, stem: str) -> None:
        """A frame that is turned about an axis given in its parent."""
        k = int(np.argmax(np.abs(axis)))
        if np.abs(np.delete(axis, k)).max() == 0.0:
            self.table("frame", name=name, parent=parent, axis=k + 1, angle=angle if axis[k] > 0 else f"-({angle})")
            return
        alpha = self.parameter(f"alpha{stem}", float(np.arctan2(axis[1], axis[0])))
        beta = self.parameter(f"beta{stem}", float(np.arctan2(np.hypot(*axis[:2]), axis[2])))
        turns = [(3, alpha), (2, beta), (3, angle), (2, f"-{beta}"), (3, f"-{alpha}")]
        self._sequence(name, parent, [(a, v) for a, v in turns if v not in ("0", "-0")])

    def _sequence(self, name: str, parent: str, turns: list[tuple[int, str]]) -> None:
        axes, angles = "".join(str(a) for a, _ in turns), [v for _, v in turns]
        self.table("frame", name=name, parent=parent, axis=axes, angle=angles)

    # -- the tree ------------------------------------------------------------------------------------------------

    def readiness(self, part: Part) -> tuple[int, int]:
        """What needs no new coordinate first, then what hangs on a known orientation, then on a known point."""
        p, turn_p, q, turn_q = part.nodes
        kind = self.kind(part)
        turned = turn_p in self.frames or turn_q in self.frames
        if kind == "spring" or part.is_truss:
            return (0, -part.number)
        if kind == "hinge":
            return (4 if turned else 1, -part.number)
        here = p in self.points or q in self.points
        return (5 if here and turned else 3 if turned else 2 if here else 1, -part.number)

    def add(self, part: Part) -> None:
        kind = self.kind(part)
        if kind == "spring":
            self.spring(part)
        elif part.is_truss:
            self._bar(part)
        elif kind == "hinge":
            self._hinge(part)
        elif kind == "beam":
            self._beam(part)
        else:
            self._link(part)

    def _link(self, part: Part) -> None:
        """A rigid body between p and q."""
        p, turn_p, q, turn_q = part.nodes
        if p not in self.points and q not in self.points:
            self.float_point(p)
        frame = self._turn(turn_p if turn_p in self.frames or turn_q not in self.frames else turn_q)
        for other in (turn_p, turn_q):
            if other and self.frames.setdefault(other, frame) != frame:
                raise self.cannot(part, "it closes a loop of orientations")
        offset = self.named(f"d*{part.number}", self.span(part))
        self.reach(part, frame, p, q, offset)
        self._rod(part, frame, p, offset)

    def _rod(self, part: Part, frame: str, p: int, offset: Components) -> None:
        """The distributed mass of a rigid part as a body: ρL³/12 (1 − x'x'ᵀ), and J' of its sections."""
        n = part.number
        rho, *rotary = self.values("EM", n, 5)
        if not rho and not any(rotary):
            return
        R, length = self._local(part), float(np.linalg.norm(self.span(part)))
        m, L = self.parameter(f"rho{n}", rho), self.parameter(f"L{n}", length)
        tensor = _tensor(R, np.array(rotary))
        slender = np.eye(3) - np.outer(R[:, 0], R[:, 0])
        inertia = []
        for i, j, pair in ((0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (1, 2, "yz"), (0, 2, "xz")):
            terms = [(f"s{pair}{n}", slender[i, j], f"{m}*{L}**3/12"), (f"j{pair}{n}", tensor[i, j], L)]
            inertia.append(" + ".join(f"{self.parameter(s, v)}*{unit}" for s, v, unit in terms if v) or "0")
        half = [f"{v}/2" if v != "0" else v for v in offset]
        self.table("point", name=f"G{n}", base=self.points[p], offset=half, **{"in": frame})
        self.table("body", name=f"rod{n}", frame=frame, at=f"G{n}", mass=f"{m}*{L}", inertia=inertia)

    def _bar(self, part: Part) -> None:
        """A rigid truss: a distance."""
        p, _, q, _ = part.nodes
        if self.values("EM", part.number, 1)[0]:
            raise self.cannot(part, "a rigid truss with mass has no orientation of its own")
        for node in (p, q):
            if node not in self.points:
                self.float_point(node)
        self.distance(part)

    def _hinge(self, part: Part) -> None:
        """The frame of one node turned against that of the other; a torque of stiffness, damping and preload."""
        _, p, _, q = part.nodes
        n, kind = part.number, part.classes[0]
        if p in self.frames and q in self.frames:
            raise self.cannot(part, "it closes a loop of orientations")
        if p not in self.frames and q not in self.frames:
            self._turn(p)
        known, other, sign = (p, q, "") if p in self.frames else (q, p, "-")
        if kind == "fixed":
            self.frames[other] = self.frames[known]
            return
        axis, name = self._axis(part), f"a{n}"
        if kind == "input":
            name = f"({self.driven_deformation(part)})"
        else:
            start, rate = _with_rate(lambda x: self._rotation(part, axis, x), self.x, self.xd)
            self.coordinate(name, start, rate)
        self._turned(f"B{other}", self.frames[known], axis, f"{sign}{name}", str(n))
        self.frames[other] = f"B{other}"
        law = self.joint_law(part, name, f"{name}_t") if kind != "input" else ""
        if law:
            vector = [f"-({law})*{a}" if a != "0" else "0" for a in self.named(f"n*{n}", axis)]
            self.table(
                "torque", name=f"T_{n}", frame=self.frames[q], reaction=self.frames[p], vector=vector,
                **{"in": self.frames[known]},
            )  # fmt: skip

    def _rotation(self, part: Part, axis: np.ndarray, x: np.ndarray) -> Any:
        """φ of a hinge within half a turn: tan φ/2 = a·μ/μ0 of the relative rotation μ."""
        _, p, _, q = part.nodes
        mu = _product(_conjugate(self.parameters_of(p, x)), self.parameters_of(q, x))
        sine, cosine = mu[1:] @ axis, mu[0]
        turn = np.arctan2(sine.real, cosine.real)
        if np.iscomplexobj(mu):
            turn = turn + 1j * (cosine.real * sine.imag - sine.real * cosine.imag)
        return 2.0 * turn

    # -- beams ---------------------------------------------------------------------------------------------------

    def _beam(self, part: Part) -> None:
        """A flexible beam from p, clamped in the frame there; its tip carries the frame at q."""
        n = part.number
        self.no_preload(part)
        rho, *rotary = self.values("EM", n, 5)
        EA, GJ, EIy, EIz, *shear = self.values("ESTIFF", n, 6)
        if any(self.values("EDAMP", n, 6)):
            raise self.cannot(part, "its damping EDAMP has no counterpart in the damping of assumed fields")
        if any(shear):
            raise self.cannot(part, "it has shear flexibility")
        p, turn_p, q, turn_q = part.nodes
        R = self._local(part)
        if p not in self.points or turn_p not in self.frames:
            if q not in self.points or turn_q not in self.frames:
                raise self.cannot(part, "neither of its ends is placed with its orientation")
            p, turn_p, q, turn_q = q, turn_q, p, turn_p
            R = R * [-1.0, -1.0, 1.0]  # from q to p
        if turn_q in self.frames:
            raise self.cannot(part, "it closes a loop of orientations")
        turns = [(k, self.parameter(f"r{k}_{n}", v)) for k, v in zip((3, 2, 1), _yaw_pitch_roll(R), strict=True)]
        turns = [(k, name) for k, name in turns if name != "0"]
        frame = self.frames[turn_p]
        if turns:
            self._sequence(f"F{n}", frame, turns)
            frame = f"F{n}"
        classes = part.classes
        bends = [axis for axis, pair in ((3, classes[2:4]), (2, classes[4:6])) if pair[0] == "dynamic"]
        EI = [self.parameter(f"EI{'yz'[axis == 2]}{n}", EIy if axis == 3 else EIz) for axis in bends]
        length = float(np.linalg.norm(self.span(part)))
        start, rates = self._amplitudes((p, turn_p, q, turn_q), R, length, bends, classes)
        keys: dict[str, Any] = {}
        if classes[1] == "dynamic":
            keys |= {"twist": 1, "GJ": self.parameter(f"GJ{n}", GJ)}
        if classes[0] == "dynamic":
            keys |= {"stretch": 1, "EA": self.parameter(f"EA{n}", EA)}
        self.table(
            "beam", name=f"beam{n}", frame=frame, root=self.points[p], length=self.parameter(f"L{n}", length),
            mass=self.parameter(f"rho{n}", rho), bends=bends, EI=EI, field=self.shapes,
            start=start, speed_start=rates, **keys,
        )  # fmt: skip
        tip = f"beam{n}.tip"
        if turns:
            self._sequence(f"B{turn_q}", tip, [(k, f"-{name}") for k, name in reversed(turns)])
        self.frames[turn_q] = f"B{turn_q}" if turns else tip
        if q in self.points:
            self.close(tip, q)
        else:
            self.points[q] = tip
        if any(rotary):  # lumped to the orientation nodes
            tensor = _tensor(R, np.array(rotary))
            for k, node in enumerate((turn_p, turn_q)):
                if self.frames[node] != "N":
                    places = ((0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (1, 2, "yz"), (0, 2, "xz"))
                    half = [self.parameter(f"j{pair}{n}", tensor[i, j]) for i, j, pair in places]
                    inertia = [f"{v}*L{n}/2" if v != "0" else v for v in half]
                    self.table("body", name=f"disc{n}_{k}", frame=self.frames[node], at="O", mass=0, inertia=inertia)

    def _amplitudes(
        self, nodes: tuple[int, int, int, int], R: np.ndarray, length: float, bends: list[int],
        classes: tuple[str, ...],
    ) -> tuple[list[float], list[float]]:  # fmt: skip
        """Amplitudes and rates that give the tip its start deflection and slope (small against one radian)."""
        import sympy as sp

        from spacar.symbolic.beam_shapes import X, orthogonal

        p, turn_p, q, turn_q = nodes
        shapes = orthogonal(2)(X, sp.Float(length))
        A = np.array([[float(psi.diff(X, k).subs(X, length)) for psi in shapes] for k in (0, 1)])
        rows = [[int(i) - 1 for i in self.numbering.lnp[n - 1, :3]] for n in (p, q)]

        def found(x: np.ndarray) -> np.ndarray:
            lam_p, lam_q = self.parameters_of(turn_p, x), self.parameters_of(turn_q, x)
            d = R.T @ _back(lam_p, x[rows[1]] - x[rows[0]])
            turn = R.T @ (2.0 * _product(_conjugate(lam_p), lam_q)[1:])
            values: list[Any] = []
            for axis in bends:
                slope = turn[2] if axis == 2 else -turn[1]
                values += [*np.linalg.solve(A, np.array([d[axis - 1], slope])), *[0.0] * (self.shapes - 2)]
            values += [turn[0]] if classes[1] == "dynamic" else []
            return np.array([*values, d[0] - length] if classes[0] == "dynamic" else values)

        now, rate = _with_rate(found, self.x, self.xd)
        return now.tolist(), rate.tolist()

    # -- frames of elements ----------------------------------------------------------------------------------------

    def _frame_rows(self, part: Part) -> np.ndarray:
        """x', y', z' of an element as rows, (3, 3)."""
        for batch in self.mechanism.batches:
            family = batch.family
            numbers = list(family.numbers)
            if family.keyword == part.keyword and family.frame_p is not None and part.number in numbers:
                return np.array(family.frame_p[numbers.index(part.number)]).reshape(3, 3)
        raise self.cannot(part, "it has no local frame")

    def _local(self, part: Part) -> np.ndarray:
        """R0 with x', y', z' as columns."""
        return self._frame_rows(part).T

    def _axis(self, part: Part) -> np.ndarray:
        """The axis of a hinge; what rounding left of a component that is zero is dropped."""
        axis = self._frame_rows(part)[0]
        return np.where(np.abs(axis) < 4 * np.finfo(float).eps, 0.0, axis)


def _conjugate(lam: np.ndarray) -> np.ndarray:
    return np.array([lam[0], *(-lam[1:])])


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The rotation b after a in the frame of a: quaternion product a∘b."""
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def _back(lam: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R(λ)ᵀ v."""
    u = -lam[1:]
    return v + 2.0 * np.cross(u, np.cross(u, v) + lam[0] * v)


def _tensor(R: np.ndarray, j: np.ndarray) -> np.ndarray:
    """R0 J' R0ᵀ per length; j are Jx'x', Jy'y', Jz'z', Jy'z'."""
    J = np.diag(j[:3])
    J[1, 2] = J[2, 1] = j[3]
    return np.asarray(R @ J @ R.T)


def _yaw_pitch_roll(R: np.ndarray) -> tuple[float, float, float]:
    """Angles of turns about 3, 2, 1 that make R; zero where only rounding is left."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) > np.finfo(float).eps ** 0.5:
        yaw, roll = np.arctan2(R[1, 0], R[0, 0]), np.arctan2(R[2, 1], R[2, 2])
    else:
        yaw, roll = np.arctan2(-R[0, 1], R[1, 1]), 0.0
    cleaned = [0.0 if abs(a) < 8 * np.finfo(float).eps else float(a) for a in (yaw, pitch, roll)]
    return cleaned[0], cleaned[1], cleaned[2]


def _with_rate(function: Callable[[np.ndarray], Any], x: np.ndarray, xd: np.ndarray) -> tuple[Any, Any]:
    """A function of x and its rate along xd, by a complex step."""
    step = 1e-30
    return function(np.asarray(x)), np.imag(function(x + 1j * step * xd)) / step
