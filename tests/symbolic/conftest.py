"""The two-link manipulator of the paper (bibliography.md) with its variants, and numbers for it."""

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import pytest

pytest.importorskip("sympy")

VALUES = {
    "g": 9.80665, "rho": 2.612898, "L": 0.9144, "EI": 2048.639047875, "gam": 0.44482216152605,
    "K1": 54.232717933256, "K2": 40.674538449942, "D1": 20.337269224971, "D2": 13.558179483314, "Q1": 0.5, "Q4": 0.0,
}  # fmt: skip


@dataclass(frozen=True)
class Arm:
    system: Any
    link1: Any
    link2: Any
    values: dict[str, float]
    derived: dict[str, Any] = field(default_factory=dict)

    def equations(self, strategy: str) -> Any:
        """Derived once."""
        if strategy not in self.derived:
            self.derived[strategy] = self.system.derive(strategy)
        return self.derived[strategy]

    def program(self, strategy: str) -> Any:
        return self.equations(strategy).program({"tip1": self.link1.tip.u, "tip2": self.link2.tip.u})


@cache
def build(
    reaction: str = "tip", boundary: bool = True, gravity: bool = True, number: int = 3, foreshortening: bool = False
) -> Arm:
    from spacar.symbolic import MultibodySystem, beam_shapes

    S = MultibodySystem(gravity=("0", "-g", "0") if gravity else (0, 0, 0))
    L, rho, EI, gam = S.parameters("L rho EI gam")
    q1, _s1 = S.coordinate("q1", speed="s1")
    q4, _s4 = S.coordinate("q4", speed="s4")
    beam = {
        "length": L, "mass": rho, "EI": EI, "field": beam_shapes.monomial(*range(2, 2 + number)) if number else (),
        "damping": gam, "damping_boundary": boundary, "foreshortening": foreshortening,
    }  # fmt: skip
    B1 = S.frame("B1", parent=S.N, axis=3, angle=q1)
    link1 = S.beam("link1", frame=B1, root=S.O, **beam)
    B2 = S.frame("B2", parent=link1.tip, axis=3, angle=q4)
    link2 = S.beam("link2", frame=B2, root=link1.tip, **beam)
    Ta1 = S.input("Ta1", "-D1*s1 - K1*(q1 - Q1)")
    Ta2 = S.input("Ta2", "-D2*s4 - K2*(q4 - Q4)")
    S.torque(B1, Ta1 * B1[3], reaction=S.N)
    S.torque(B2, Ta2 * B2[3], reaction=link1.tip if reaction == "tip" else B1)
    return Arm(S, link1, link2, VALUES)


@pytest.fixture(scope="session")
def arm() -> Any:
    """The builder `arm(reaction, boundary, gravity, number, foreshortening)`; equal calls give one object."""
    return build


@pytest.fixture(scope="session")
def programs() -> Any:
    """The program of a variant and a strategy, derived once: programs(strategy, **variant)."""

    @cache
    def derived(strategy: str, **variant: Any) -> Any:
        return build(**variant).program(strategy)

    return derived
