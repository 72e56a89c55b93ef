"""Records are frozen dataclasses like others; only their making is quicker."""

from __future__ import annotations

import inspect
from dataclasses import FrozenInstanceError, dataclass, field, replace

import pytest

from spacar.records import cached_property, quickly_made


@dataclass(frozen=True)
class Ordinary:
    a: int
    b: float = 2.0
    found: list[int] = field(default_factory=list)


@quickly_made
@dataclass(frozen=True)
class Quick:
    a: int
    b: float = 2.0
    found: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.found.append(self.a)

    @cached_property
    def twice(self) -> int:
        """2 a."""
        self.found.append(-1)
        return 2 * self.a


def test_arguments_are_those_of_the_dataclass():
    names = [list(inspect.signature(kind).parameters) for kind in (Ordinary, Quick)]
    assert names[0] == names[1]
    assert Quick.__init__.__annotations__ == Ordinary.__init__.__annotations__
    assert vars(Quick(1, b=3.0)) == {"a": 1, "b": 3.0, "found": [1]}
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'a'"):
        Quick()


def test_every_record_gets_a_new_default_and_ends_with_its_own_check():
    assert Quick(1).found == [1]
    assert Quick(2).found == [2]
    assert Quick(3, found=[7]).found == [7, 3]


def test_records_are_frozen_and_replaced():
    record = Quick(1)
    with pytest.raises(FrozenInstanceError):
        record.a = 2  # type: ignore[misc]
    other = replace(record, a=5, found=[])
    assert (other.a, other.b, other.found) == (5, 2.0, [5])
    assert other == Quick(5)
    assert repr(other) == "Quick(a=5, b=2.0, found=[5])"


def test_a_cached_property_is_computed_once():
    record = Quick(4)
    assert record.twice == 8
    assert record.twice == 8
    assert record.found == [4, -1]
    assert Quick.twice.__doc__ == "2 a."
