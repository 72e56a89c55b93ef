"""The table of integration codes (INTEGRAT position 1): what each is, how it is run, where it comes from.

The tolerance of one step is the same part of ERROR for every code with variable steps (theory-system.md section 9). The
error of a result adds up over the steps, more or less, as the motion decides:
`spacar.studies.policies.accuracy` estimates and keeps it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from spacar.errors import UsageError

from .adams import Adams
from .automatic import Automatic
from .implicit import Rosenbrock, SinglyDiagonallyImplicit
from .nystrom import RungeKuttaNystrom
from .radau import Radau
from .runge_kutta import DormandPrince853, ExplicitRungeKutta
from .tableaus import BOGACKI_SHAMPINE, DORMAND_PRINCE, KUTTA


@dataclass(frozen=True, slots=True)
class Method:
    """One integration code. `order` 0: variable; `original` is False for codes that the original program lacks."""

    code: int
    name: str
    order: int
    variable_step: bool
    needs_jacobian: bool
    citation: str
    build: Callable[..., Any] = field(repr=False)
    original: bool = True


AUTOMATIC = -1  # the method chooses itself

_ROWS = (
    Method(AUTOMATIC, "Adams predictor-corrector, or Radau IIA of order 9 where a vibration limits the steps",
           0, True, False, "automatic.py", Automatic, original=False),
    Method(0, "Adams predictor-corrector, order 1 to 12", 0, True, False, "Shampine & Gordon 1975", Adams),
    Method(130, "explicit Runge-Kutta, order 3", 3, False, False, "Bogacki & Shampine 1989",
           partial(ExplicitRungeKutta, BOGACKI_SHAMPINE)),
    Method(135, "explicit Runge-Kutta 3(2)", 3, True, False, "Bogacki & Shampine 1989",
           partial(ExplicitRungeKutta, BOGACKI_SHAMPINE)),
    Method(140, "explicit Runge-Kutta, order 4", 4, False, False, "Kutta 1901",
           partial(ExplicitRungeKutta, KUTTA)),
    Method(155, "explicit Runge-Kutta 5(4)", 5, True, False, "Dormand & Prince 1980",
           partial(ExplicitRungeKutta, DORMAND_PRINCE)),
    Method(220, "explicit Runge-Kutta for second order systems, order 2", 2, False, False, "Nystrom 1925",
           partial(RungeKuttaNystrom, 220)),
    Method(225, "explicit Runge-Kutta for second order systems, order 2", 2, True, False, "Nystrom 1925",
           partial(RungeKuttaNystrom, 225)),
    Method(310, "linearly implicit Euler", 1, False, True, "Rosenbrock 1963", partial(Rosenbrock, 310)),
    Method(320, "Rosenbrock, order 2", 2, False, True, "Rosenbrock 1963", partial(Rosenbrock, 320)),
    Method(330, "Rosenbrock, order 3", 3, False, True, "Sandu et al. 1997", partial(Rosenbrock, 330)),
    Method(410, "implicit Euler", 1, False, True, "Euler 1768", partial(SinglyDiagonallyImplicit, 410)),
    Method(420, "singly diagonally implicit Runge-Kutta, order 2", 2, False, True, "Alexander 1977",
           partial(SinglyDiagonallyImplicit, 420)),
    Method(430, "singly diagonally implicit Runge-Kutta, order 3", 3, False, True, "Alexander 1977",
           partial(SinglyDiagonallyImplicit, 430)),
    Method(553, "Radau IIA, order 5, for stiff models", 5, True, True, "Hairer & Wanner 1996",
           partial(Radau, 3), original=False),
    Method(595, "Radau IIA, order 9, for stiff models and undamped vibration", 9, True, True, "Hairer & Wanner 1996",
           partial(Radau, 5), original=False),
    Method(853, "explicit Runge-Kutta 8(5,3) for tight tolerances", 8, True, False,
           "Prince & Dormand 1981; Hairer, Norsett & Wanner 1993", DormandPrince853, original=False),
)  # fmt: skip

METHODS: dict[int, Method] = {row.code: row for row in _ROWS}
# The manual (bibliography.md) calls code 225 also 255.
ALIASES = {255: 225}
# The names of these methods in SciPy, which model files of simulations (.sim) and older scripts use. BDF stands for
# "stiff"; its place is taken by Radau IIA.
NAMES = {"AUTO": AUTOMATIC, "RK23": 135, "RK45": 155, "DOP853": 853, "RADAU": 553, "BDF": 553}


def method(code: int) -> Method:
    """The row of `code`, aliases resolved. Raises UsageError `integrator.code`."""
    try:
        return METHODS[ALIASES.get(code, code)]
    except KeyError:
        known = " ".join(str(code) for code in METHODS)
        raise UsageError(f"unknown integration code {code}; known are {known}", "integrator.code") from None


def named(word: int | str) -> Method:
    """The row of a code (155 or "155") or of a name in NAMES, small or capital. Raises UsageError `integrator.code`."""
    text = str(word).strip()
    if text == str(AUTOMATIC):
        return METHODS[AUTOMATIC]
    if text.isdecimal() and text.isascii() and len(text) <= 4:
        return method(int(text))
    code = NAMES.get(text.upper())
    if code is None:
        known = f"{' '.join(str(code) for code in METHODS)}, or {' '.join(NAMES)}"
        raise UsageError(f"method '{word}' does not exist; known are {known}", "integrator.code")
    return METHODS[code]
