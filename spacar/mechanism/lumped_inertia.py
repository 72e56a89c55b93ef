"""Lumped inertia: XM of all node types, rotary inertia that elements put on orientation nodes, XGYRO, MEE.

A lumped mass is an entry m of M per coordinate [kg or kg m^2], constant, without convective terms. All tensors of one
spatial orientation node are summed first: the node is then one rigid body (theory-spatial.md section 1).
"""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import Deck
from spacar.elements.family import Configuration, Family
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import NO_ENTRIES
from spacar.mechanism.numbering import Numbering


class LumpedMass(Family):
    """One entry per coordinate; `positions` tells which of them are position coordinates (they feel gravity)."""

    n_coordinates: ClassVar[int] = 1
    keyword = "XM"
    has_mass = True
    constant_mass = True

    def __init__(self, nodes: NDArray[np.int64], m: Array) -> None:
        self.numbers = nodes
        self.m = m

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Configuration:
        return None

    def mass(self, c: Configuration, out: Array) -> None:
        out[0, 0] = self.m

    def inertia_force(self, c: Configuration, v: Array, a: Array | None) -> Array:
        return np.zeros_like(v) if a is None else self.m * a


def lumped(deck: Deck, numbering: Numbering, batches: list[Batch]) -> list[tuple[Family, Index]]:
    """Families of node inertia with their indices into x."""
    masses: dict[int, tuple[int, float]] = {}  # coordinate: node, mass
    tensors: list[tuple[Any, Array]] = []  # nodes (n,) and what they get (n, 3, 3)
    for node, *values in deck.index.rows("XM", 2):
        if numbering.planar or numbering.role(node) != "orientation":
            for place in numbering.x_places[node].tolist():
                if place >= 0:
                    masses[place] = node, values[0]
        else:
            tensors.append(([node], symmetric(np.array(values))[None]))
    for batch in batches:
        for row, J in batch.family.orientation_inertia():
            tensors.append((numbering.x_node.take(batch.x[row]), J))
        for row, J in batch.family.lumped_inertia():
            for place, value in zip(batch.x[row].tolist(), J.tolist(), strict=True):
                node, mass = masses.get(place, (numbering.x_node.item(place), 0.0))
                masses[place] = node, mass + value
    result: list[tuple[Family, Index]] = []
    if masses:
        places = sorted(masses)
        owners, sizes = map(np.array, zip(*[masses[i] for i in places], strict=True))
        result.append((LumpedMass(owners, sizes), np.array([places], np.int64)))
    rotors = [(node, np.array(values)) for node, *values in deck.index.rows("XGYRO", 2)]
    if rotors:
        from spacar.elements.spatial.node_inertia import GyrostatNode, prescribed_rotor_tensor

        nodes = np.array([node for node, _ in rotors])
        h = np.array([rotor[3] * rotor[:3] for _, rotor in rotors])
        for node, rotor in rotors:
            if len(rotor) > 4 and rotor[4].real == 1.0:
                tensors.append(([node], prescribed_rotor_tensor(rotor[None, :3], rotor[3:4])))
        result.append((GyrostatNode(nodes, h), numbering.x_places.T.take(nodes, 1)))
    if tensors:
        from spacar.elements.spatial.node_inertia import RigidBodyNode

        nodes, which = np.unique(np.concatenate([of for of, _ in tensors]), return_inverse=True)
        parts = np.concatenate([J for _, J in tensors])
        total = np.zeros((len(nodes), 3, 3), parts.dtype)
        np.add.at(total, which, parts)
        result.append((RigidBodyNode(nodes, total), numbering.x_places.T.take(nodes, 1)))
    return result


def symmetric(values: Array) -> Array:
    """3 x 3 tensor from Jxx Jxy Jxz Jyy Jyz Jzz; missing values are zero."""
    xx, xy, xz, yy, yz, zz = np.pad(values, (0, 6 - len(values)))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def deformation_inertia(deck: Deck, numbering: Numbering) -> tuple[Index, Index, Array]:
    """MEE: entries of the symmetric matrix M_e as rows, columns, values."""
    given = deck.block(2).get("MEE", ())
    if not given:
        return NO_ENTRIES
    rows, columns, values = [], [], []
    for s in given:
        *places, value = s.values
        i = numbering.e_index(int(places[0]), int(places[1]))
        j = numbering.e_index(int(places[2]), int(places[3])) if len(places) == 4 else i
        for a, b in {(i, j), (j, i)}:
            rows.append(a)
            columns.append(b)
            values.append(value)
    return np.array(rows, np.int64), np.array(columns, np.int64), np.array(values)
