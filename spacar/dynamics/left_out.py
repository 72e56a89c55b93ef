"""Runs of a mechanism without its rigid parts (`spacar.mechanism.rigid_parts`), and their frames with these.

A body moves as its masters P (position) and O (orientation, R): x_i = x_P + R r_i, lambda_i = lambda_O. In the axes of
the body, where it stands as at the reference, all matrices are constant, as deformations and kinetic energy do not
change with a motion of everything: with L = [lambda, Lambda^T] (4 x 4, orthogonal) for Euler parameters,
V(x) = V0 diag(R^T, L^T), and the inertia forces less gravity are

    f = diag(R, L) C z,    z = (a_P - g, alpha, products of omega) in these axes  (`spacar.dynamics.body_inertia`)

(planar: R(phi), and L = 1). What is left out (index l) and what stands in for it (s: ties, mass, tensor) meet the same
elements and loads at the nodes that stay. At all nodes of a body but its masters, and for lambda0 of these,

    V_l0^T sigma_l = V_s0^T sigma_s + (C_s - C_l) z,

which is square and regular, and is solved once: sigma_l = A sigma_s + B z. A node that is left out has the external
force M_l g; one that stays has M_l g besides what the reduced model says; what is fixed and left out has V_l^T sigma_l.
Immovable elements have constant deformations and stresses.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import Deck
from spacar.dynamics.body_inertia import BodyInertia, NotRigid
from spacar.dynamics.loaded_mechanism import StressLaw
from spacar.dynamics.rigid_motion import BodyMotion, Masters, Weight
from spacar.errors import AnalysisError, Report
from spacar.frame import E_FIELDS, X_FIELDS, Frame, FramesInRows
from spacar.kinematics import Kinematics
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism import build
from spacar.mechanism.mechanism import NO_ENTRIES, Mechanism
from spacar.mechanism.numbering import Numbering, places_in
from spacar.mechanism.rigid_parts import RigidParts
from spacar.modes import registered
from spacar.stream import Run

MOST = 4_000_000  # numbers of A
MOST_DENSE = 500  # unknowns of which a dense matrix takes less time than loading SciPy
SIGMA = 3  # place among E_FIELDS
GRAVITY, TOTAL = 4, 5  # among X_FIELDS


def frames(run: Run, parts: RigidParts) -> Iterator[Sequence[Frame]]:
    """The blocks of frames of a run, computed without its rigid parts. Where that fails everything is evaluated."""
    analysis = registered(run.mode.analysis)
    try:
        left = LeftOut(run.mechanism, parts, run.mode.number)
    except (NotRigid, SingularMatrixError):
        yield from analysis(run)
        return
    reduced, done = replace(run, mechanism=left.reduced), 0
    try:
        for block in analysis(reduced):
            run.n_frames = reduced.n_frames
            yield left.whole(block)
            done += len(block)
    except AnalysisError:  # the whole mechanism says why, with the names of its own nodes and elements
        for block in analysis(run):
            if done < len(block):
                yield block[done:] if done else block
            done = max(done - len(block), 0)


class _Law(NamedTuple):
    """sigma = A sigma_s + B z of the rows of one body."""

    rows: Index
    given: Index  # rows of sigma of the reduced model
    A: Array
    B: Array


class Stiffness(NamedTuple):
    """K of the degrees of freedom and the transfer functions of some coordinates."""

    stiffness: Array
    W: Array


class LeftOut:
    """The reduced mechanism, and how its frames become those of the whole one. Bodies are those that move, and behind
    them everything at rest as one. Raises NotRigid, SingularMatrixError.
    """

    def __init__(self, mechanism: Mechanism, parts: RigidParts, mode: int) -> None:
        self.n = n = mechanism.numbering
        d, beams = 2 if n.planar else 3, mechanism.settings.beams
        points = np.array([body.point for body in parts.moving], np.int64)
        origin = np.zeros((len(points) + 1, d))
        origin[:-1][points > 0] = mechanism.x0[n.x_places[points[points > 0], :d]]
        left = build(parts.left(), beams=beams)
        inertia = BodyInertia(left, parts.owners[:, 1], origin)
        positions = {k: mechanism.x0[n.x_places[k, :d]] for k in np.flatnonzero(n.roles == 1).tolist()}
        deck = parts.stand_in(positions, inertia.masses(len(points)))
        made = build(parts.reduced(deck), mode, beams=beams)
        self.reduced = replace(made, drive=mechanism.drive, settings=mechanism.settings, length=mechanism.length)
        self._map(parts, left.numbering)
        C = inertia.forces()
        stood = self._stood_in(parts, deck, origin, beams)
        self._solve(left, inertia, *self._ties(left.numbering, stood, C))
        self.masters = Masters(mechanism.x0, n, self.reduced.numbering, parts)
        self.weight = Weight(inertia, C[:, :d], mechanism.loads.gravity)

    def _map(self, parts: RigidParts, l: Numbering) -> None:
        """Places of what stays and of what is left out: in the whole, in their own numbering."""
        n, m = self.n, self.reduced.numbering
        self.x_kept = _common(n.x_places, m.x_places)
        places = n.x_places[parts.owners[: len(l.x_places), 0]]
        places[0] = -1
        self.x_left = _common(places, l.x_places)
        e_places = m.e_places.copy()
        e_places[[k for k in parts.body_of if k < len(e_places)]] = -1
        own = dict(n.normalization.tolist())
        kept = [(own[node], row) for node, row in m.normalization.tolist() if node in own]
        self.e_kept = _joined(_common(n.e_places, e_places), kept)
        self.e_left = _common(n.e_places, l.e_places)
        norms = [(own[int(parts.owners[node, 0])], row) for node, row in l.normalization.tolist()]
        self.norms = _joined((np.zeros(0, np.int64),) * 2, norms)
        self.row_of = dict(zip(self.e_kept[1].tolist(), self.e_kept[0].tolist(), strict=True))

    def _stood_in(self, parts: RigidParts, deck: Deck, origin: Array, beams: str) -> BodyInertia | None:
        """What stands in for the bodies, None where nothing does."""
        if not deck.statements:
            return None
        tied = {n for s in deck.statements if s.keyword not in ("X", "XM") for n in s.values[1:]}
        if not tied.issuperset(s.values[0] for s in deck.statements if s.keyword == "XM"):
            raise NotRigid  # a tensor at an orientation that nothing is tied to
        made = build(deck, beams=beams)
        body_of = np.zeros(len(made.numbering.x_places), np.int64)
        for number, _, nodes in made.numbering.elements:
            body_of[list(nodes)] = parts.body_of[number]
        return BodyInertia(made, body_of, origin)

    def _ties(self, l: Numbering, stood: BodyInertia | None, C: Array) -> tuple[Array, Index, Index, Array]:
        """C_s - C, and entries of V_s: rows of sigma of the reduced model, columns of what is left out, values."""
        if stood is None:
            return -C, *NO_ENTRIES
        to, own = _common(l.x_places, stood.numbering.x_places)
        difference = -C
        difference[to] += stood.forces()[own]
        column = places_in(stood.numbering.nx, own, to)[stood.sweep.v_columns]
        to, own = _common(self.reduced.numbering.e_places, stood.numbering.e_places)
        row = places_in(stood.numbering.ne, own, to)[stood.sweep.v_rows]
        there = (row >= 0) & (column >= 0)
        return difference, row[there], column[there], stood.sweep.v_entries[there]

    def _solve(
        self, left: Mechanism, inertia: BodyInertia, C: Array, rows: Index, columns: Index, values: Array
    ) -> None:
        """A and B, what never changes of immovable elements, and the forces on what is fixed."""
        l, sweep, n_bodies = left.numbering, inertia.sweep, len(inertia.origin)
        kind = "dense" if len(l.velocity_unknowns) <= MOST_DENSE else None
        kinematics = Kinematics(left, kind, sweep)
        kinematics.refactor()
        active = StressLaw.of(left, left.loads)(sweep.e, np.zeros(l.ne))
        body = inertia.column_body[columns]
        given = [np.flatnonzero(np.bincount(rows[body == k])) for k in range(n_bodies)]  # np.unique loads numpy.ma
        size = C.shape[1]
        width = size + 1 + max(map(len, given))
        if l.ne * width > MOST:
            raise NotRigid
        right = np.zeros((l.nx, width))
        right[:, :size] = C
        right[:, size] = -sweep.rate_transposed(active)
        for k, own in enumerate(given):
            np.add.at(right, (columns[body == k], size + 1 + np.searchsorted(own, rows[body == k])), values[body == k])
        E = l.velocity_equations
        found = np.zeros((l.ne, width))
        found[E] = kinematics.velocity_system.solve_transposed(right[l.velocity_unknowns])
        if not np.isfinite(found).all():
            raise NotRigid
        self.constant = active + found[:, size]
        row_body = np.zeros(l.ne, np.int64)
        row_body[sweep.v_rows] = inertia.column_body[sweep.v_columns]
        self.laws = []
        for k, own in enumerate(given):
            mine = np.flatnonzero(row_body == k)
            self.laws.append(_Law(mine, own, found[mine, size + 1 : size + 1 + len(own)], found[mine, :size]))
        resting = inertia.column_body[self.x_left[1]] == n_bodies - 1
        fixed = resting & ~np.isin(self.x_left[1], l.velocity_unknowns)
        self.reaction_to, ground = (places[fixed] for places in self.x_left)
        self.carried = self.x_left[0][~fixed], self.x_left[1][~fixed]
        self.reaction, self.tied = sweep.gradient()[:, ground], np.zeros((len(given[-1]), len(ground)))
        place = places_in(l.nx, ground)[columns]
        there = place >= 0
        np.add.at(self.tied, (np.searchsorted(given[-1], rows[there]), place[there]), -values[there])
        still = self.e_left[1] >= l.e_class["calculable"].start
        self.deformed = self.e_left[0][still], sweep.e[self.e_left[1][still]]

    # -- frames -------------------------------------------------------------------------------------------------------
    def whole(self, block: Sequence[Frame]) -> Sequence[Frame]:
        """The frames of the whole mechanism."""
        if not isinstance(block, FramesInRows):
            return tuple(map(self._frame, block))
        rows = self._rows(*_fields(block.rows, self.reduced.numbering))
        made = FramesInRows(block.t, rows, (self.n.nx, self.n.ne), list(map(self._lost, block.lost)))
        made.statistics = block.statistics
        return made

    def _rows(self, x: Array, e: Array) -> Array:
        """X_FIELDS and E_FIELDS of the whole, (steps, 6 nx + 4 ne); x (steps, 6, nx), e (steps, 4, ne) reduced."""
        n, steps = self.n, len(x)
        rows = np.zeros((steps, 6 * n.nx + 4 * n.ne))
        X, S = _fields(rows, n)
        X[:, :, self.x_kept[0]] = x[:, :, self.x_kept[1]]
        S[:, :, self.e_kept[0]] = e[:, :, self.e_kept[1]]
        S[:, 0, self.deformed[0]] = self.deformed[1]
        motion = self.masters.motion(x)
        motion.put(X)
        z = motion.z(self.weight.field)
        sigma = np.tile(self.constant, (steps, 1))
        for k, law in enumerate(self.laws):
            sigma[:, law.rows] += e[:, SIGMA, law.given] @ law.A.T + z[:, k] @ law.B.T
        S[:, SIGMA, self.e_left[0]] = sigma[:, self.e_left[1]]
        for to, own in zip(*map(np.ndarray.tolist, self.norms), strict=True):
            S[:, SIGMA, to] += sigma[:, own]
        if self.weight.field.any():
            weight = self.weight.forces(motion)
            for field, (to, own) in ((GRAVITY, self.x_left), (TOTAL, self.carried)):
                added = np.zeros((n.nx, steps))
                np.add.at(added, to, weight.T[own])
                X[:, field] += added.T
        X[:, TOTAL, self.reaction_to] += sigma @ self.reaction + e[:, SIGMA, self.laws[-1].given] @ self.tied
        return rows

    def _lost(self, found: dict[int, str]) -> dict[int, str]:
        return {self.row_of.get(row, row): text for row, text in found.items()}

    def _frame(self, f: Frame) -> Frame:
        x, e = (np.array([[getattr(f, name) for name in names]]) for names in (X_FIELDS, E_FIELDS))
        X, S = _fields(self._rows(x, e), self.n)
        whole = dict(zip((*X_FIELDS, *E_FIELDS), (*X[0], *S[0]), strict=True))
        made = replace(f, lost=self._lost(f.lost), log=dict(f.log), **whole)
        motion = self.masters.motion(x)
        for name in ("dx", "dxc", "de", "dec"):
            given = getattr(f, name)
            if given is not None:
                setattr(made, name, self._transfer(name, given, motion))
            if name in f.log:
                made.log[name] = self._transfer(name, f.log[name], motion)
        if f.xcompl is not None:
            made.xcompl = self._compliances(f.xcompl, made)
        return made

    def _compliances(self, given: Array, made: Frame) -> Array:
        """(nx,) those of the whole; nan for what is left out where no linearized equations are known."""
        n = self.n
        found = np.zeros(n.nx)
        found[self.x_kept[0]] = given[self.x_kept[1]]
        moving = self.masters.to
        if len(n.dynamic):
            found[moving] = np.nan
        if made.dxc is not None and "k0" in made.matrices:
            K = np.add.reduce([made.matrices[name][:, -n.nddof :] for name in ("k0", "n0", "g0")])
            equations = Stiffness(K, made.dxc[moving][:, n.dynamic])
            found[moving] = registered("directional_compliances")(equations, np.arange(n.nddof), Report())
        return found

    def _transfer(self, name: str, given: Array, motion: BodyMotion) -> Array:
        """Transfer functions of coordinates (nx, k), or of deformations (ne, k)."""
        of_x = name.startswith("dx")
        to, own = self.x_kept if of_x else self.e_kept
        out = np.zeros((self.n.nx if of_x else self.n.ne, given.shape[1]))
        out[to] = given[own]
        if of_x:
            motion.put_transfer(out, given)
        return out


def _fields(rows: Array, n: Numbering) -> tuple[Array, Array]:
    """X_FIELDS (steps, 6, nx) and E_FIELDS (steps, 4, ne) where they stand in rows of them."""
    steps, split = len(rows), 6 * n.nx
    return rows[:, :split].reshape(steps, 6, n.nx), rows[:, split : split + 4 * n.ne].reshape(steps, 4, n.ne)


def _common(whole: Index, part: Index) -> tuple[Index, Index]:
    """Places in the whole and in a part of what both tables of places have."""
    size = min(len(whole), len(part)), min(whole.shape[1], part.shape[1])
    a, b = whole[: size[0], : size[1]], part[: size[0], : size[1]]
    both = (a >= 0) & (b >= 0)
    return a[both], b[both]


def _joined(places: tuple[Index, Index], more: list[tuple[int, int]]) -> tuple[Index, Index]:
    """The same with more pairs."""
    added = np.array(more, np.int64).reshape(-1, 2)
    return np.append(places[0], added[:, 0]), np.append(places[1], added[:, 1])
