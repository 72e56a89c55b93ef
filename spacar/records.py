"""How small records are made: a run of a small model makes dozens of them.

`quickly_made` goes above `@dataclass(frozen=True)`. The `__init__` that dataclasses write calls `object.__setattr__`
for every field; the one here writes the dictionary of the object, in half the time. `cached_property` is that of
functools without the lock that Python 3.11 and before take at first use.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, TypeVar

T = TypeVar("T")

if TYPE_CHECKING:
    from functools import cached_property as cached_property
else:

    class cached_property:
        """A property that is computed when it is asked for first; the dictionary of the object keeps it."""

        def __init__(self, compute: Callable[[Any], Any]) -> None:
            self.compute, self.name, self.__doc__ = compute, compute.__name__, compute.__doc__

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            found = instance.__dict__[self.name] = self.compute(instance)
            return found


def quickly_made(kind: type[T]) -> type[T]:
    """The frozen dataclass with an `__init__` of the same arguments that takes half the time."""
    plain = kind.__init__
    known: dict[str, Any] = {"MISSING": MISSING}
    arguments, lines = ["self"], ["own = self.__dict__"]
    for f in fields(kind):  # type: ignore[arg-type]
        value = f.name
        if f.default_factory is not MISSING:
            known[f"made_{f.name}"] = f.default_factory
            arguments.append(f"{f.name}=MISSING")
            value = f"made_{f.name}() if {f.name} is MISSING else {f.name}"
        elif f.default is not MISSING:
            known[f"default_{f.name}"] = f.default
            arguments.append(f"{f.name}=default_{f.name}")
        else:
            arguments.append(f.name)
        lines.append(f"own['{f.name}'] = {value}")
    if hasattr(kind, "__post_init__"):
        lines.append("self.__post_init__()")
    exec(f"def __init__({', '.join(arguments)}):\n " + "\n ".join(lines), known)
    made = known["__init__"]
    made.__annotations__, made.__qualname__ = plain.__annotations__, plain.__qualname__
    kind.__init__ = made  # type: ignore[method-assign]
    return kind
