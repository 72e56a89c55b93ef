"""`spacar 0 --release`: over-constraints solved, the lines printed, the input file with them written."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacar.errors import UsageError
from spacar_cli.environment import Environment, ExitStatus, tell

if TYPE_CHECKING:
    from spacar.deck import Deck
    from spacar.kinematics.advice import OverconstraintPart
    from spacar.kinematics.diagnosis import Diagnosis
    from spacar.kinematics.release import Release


@dataclass(frozen=True)
class Done:
    """What was released, the lines for it, and the file with them when one was asked for."""

    release: Release
    lines: tuple[str, ...]
    written: Path | None = None

    @property
    def status(self) -> ExitStatus:
        return ExitStatus.FAILED if self.release.left else ExitStatus.DONE

    def tell(self, environment: Environment) -> None:
        found = self.release.diagnosis
        if self.release.parts:
            environment.wrote(f"released {len(self.release.parts)} flexible deformations; lines of the input file:")
            environment.wrote(*(f"  {line}" for line in self.lines))
            environment.wrote(*found.lines()[: None if self.release.left else 2])
        else:
            environment.wrote("no flexible deformation to release")
        if self.written is not None:
            environment.wrote(f"written: {self.written}")
        if self.release.left:
            which = "; ".join(f"RLSE {p.element} {p.mode} ({p.text})" for p in found.advice)
            text = f"{found.over} over-constraint{'s' * (found.over > 1)} left that no flexible deformation takes away"
            tell(environment, "error", f"{text}; by hand: {which}" if which else text)

    def record(self) -> dict[str, Any]:
        return {
            "released": [_part(p) for p in self.release.parts], "lines": list(self.lines),
            "written": str(self.written) if self.written is not None else None, "left": self.release.left,
            "constraints": as_record(self.release.diagnosis),
        }  # fmt: skip


def check_output(output: Path, source: Path) -> None:
    """Raises UsageError for an output that exists: an input file is never overwritten."""
    if output.exists():
        same = output.resolve() == source.resolve()
        what = "is the input file itself" if same else "exists"
        raise UsageError(f"--release {output}: the file {what}; choose a new name", "files.exists")


def solve(source: Path, output: str) -> Done:
    """Release what can be released in an input file; `output` is the name of the new file, empty for none."""
    from spacar_formats.safety import write_text

    from spacar.deck import read_deck

    done = solved(read_deck(source, 0))
    if output:
        done = replace(done, written=Path(output))
        write_text(Path(output), done.release.deck.text)
    return done


def solved(deck: Deck) -> Done:
    from spacar.kinematics.advice import paste_lines
    from spacar.kinematics.release import release

    found = release(deck)
    return Done(found, tuple(paste_lines(deck, list(found.parts))))


def as_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """The constraint analysis for --json: numbers, what takes part, what to do."""
    return {
        "over": diagnosis.over, "under": diagnosis.under,
        "condition": diagnosis.condition if diagnosis.condition < float("inf") else None,
        "deformations": [_part(p) for p in diagnosis.parts],
        "coordinates": [{"name": name, "share": share} for share, name in diagnosis.coordinates],
        "suggestions": [_part(p) for p in diagnosis.advice], "freedoms": list(diagnosis.freedoms),
        "lines": list(diagnosis.paste),
    }  # fmt: skip


def _part(part: OverconstraintPart) -> dict[str, Any]:
    from spacar.kinematics.advice import WORD

    return {
        "element": max(part.element, 0) or None,  # none: the normalization of a node
        "mode": part.mode or None,
        "share": part.share,
        "name": part.name,
        "effect": WORD[part.effect],
        "text": part.text,
    }
