"""The names that an expression of a system may use, one set for model files and Python.

Coordinates, speeds, inputs and time `t`; of points `P.x`, `P.vx`, … in N; of sections the field values `B.tip.u`,
`.slope`, `.w`, `.slope_w`, `.twist`, `.stretch`; for outputs also accelerations `P.ax` and `SPEED_dot` and the forces
of constraints. Quantities of points are computed when they are asked for.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.system_parts import CrossSection, GeometricPoint
from spacar.symbolic.unit_vectors import TIME

KINDS = ("", "v", "a")
AXES = "xyz"


class ModelNames(Mapping[str, sp.Expr]):
    """Names of a description, with `more` of the caller; `outputs`: also what only solved equations give."""

    # `system` is a Description, which stands above
    def __init__(self, system: Any, more: Mapping[str, sp.Expr], outputs: bool) -> None:
        self.system, self.outputs = system, outputs
        self._scalars: dict[str, sp.Expr] = dict(system.parameters_declared or {})
        self._scalars |= {str(f.func): f for f in [*system.coordinates, *system.speeds]}
        self._scalars |= {s.name: s for s in system.inputs}
        self._scalars |= {str(f.func): f for p in system.pseudo for f in (p.coordinate, p.speed)}
        if outputs or system.parameters_declared is None:
            self._scalars |= {s.name: s for s in system.accelerations.values()}
            self._scalars |= {c.force.name: c.force for c in system.constraints}
        self._scalars |= {"t": TIME, **more}

    def __getitem__(self, name: str) -> sp.Expr:
        if name in self._scalars:
            return self._scalars[name]
        point, _, quantity = name.rpartition(".")
        found = next((p for p in self._points() if p.name == point), None) if point else None
        if found is None or quantity not in self._quantities(found):
            raise KeyError(name)
        if isinstance(found, CrossSection) and quantity in found.values:
            return found.values[quantity]
        kind, axis = quantity[:-1], AXES.index(quantity[-1]) + 1
        vector = found.velocity if kind else found.position
        if kind == "a":
            vector = self.system.ddt(self.system.N, vector)
        return vector & self.system.N[axis]

    def _points(self) -> list[GeometricPoint]:
        sections = (s for beam in self.system.beams for s in beam.sections.values())
        return [self.system.O, *self.system.points, *sections]

    def _quantities(self, point: GeometricPoint) -> list[str]:
        kinds = KINDS if self.outputs else KINDS[:2]
        values = list(point.values) if isinstance(point, CrossSection) else []
        return [*(f"{kind}{axis}" for kind in kinds for axis in AXES), *values]

    def __iter__(self) -> Iterator[str]:
        yield from self._scalars
        for point in self._points():
            yield from (f"{point.name}.{quantity}" for quantity in self._quantities(point))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and (name in self._scalars or self[name] is not None)
        except (KeyError, UsageError):
            return False
