"""A method for every keyword of the input language: the base of `Model`, made from the keyword table (`model_methods`).

For editors and type checkers the methods are declared in `keyword_methods.pyi`, which is written when the package is
built.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from spacar.arrays import Array
from spacar.deck.model_methods import methods
from spacar.deck.statement import Value

Vector = Sequence[float] | Array


class ModelStatements(ABC):
    """One method a keyword; `statement` and `of_section` are those of the model that collects them."""

    @abstractmethod
    def statement(
        self, keyword: str, block: int, *values: Value | None, named: Mapping[str, Value | None] | None = None
    ) -> None:
        """Take in one statement of a block (1, 2 or 3)."""

    @abstractmethod
    def of_section(self, number: int, section: str | None, material: str | None, parts: int) -> None:
        """The BEAMSEC of an element, when it has one."""


for method in methods():
    setattr(ModelStatements, method.__name__, method)
