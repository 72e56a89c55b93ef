"""checksbf: what is in a result file, whether its run was complete, and whether its bytes are sound (files.md 7)."""

import os
from dataclasses import dataclass

import numpy as np

from spacar_formats.locate import notes, result_path
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import COMPLETE, KINDS, STOPPED, TYPE_NAMES, Record

STATES = {COMPLETE: "complete", STOPPED: "stopped early"}
SHOWN = 6  # values of a header variable that are listed


@dataclass(frozen=True, slots=True)
class SbfCheck:
    """The findings: records in the order of the file, shortened header values, damage, remarks."""

    path: str
    kind: str
    state: str
    steps: int
    header: tuple[Record, ...]
    step_variables: tuple[Record, ...]
    values: tuple[str, ...]
    damage: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def sound(self) -> bool:
        return not self.damage


def checksbf(name: str | os.PathLike[str]) -> SbfCheck:
    """Read the directory and verify every checksum of a result file, given with or without extension.

    Raises UsageError when the file is missing and SbfError when preamble or directory are damaged; damaged
    steps are listed in `damage`.
    """
    with SbfFile(result_path(name)) as file:
        damage = []
        if file.truncated:
            damage.append(f"it has {file.steps} of the {file.directory.committed} steps that it announces: cut off")
        elif file.state == COMPLETE and file.surplus:
            damage.append(f"{file.surplus} bytes follow the last step of a complete file")
        bad = file.damaged_steps()
        if bad.size:
            few = ", ".join(map(str, bad[:10])) + (", ..." if bad.size > 10 else "")
            damage.append(f"wrong checksum or number of step {few} ({bad.size} of {file.steps} steps)")
        values = []
        for ident, record in file.header_records.items():
            try:
                values.append(_shortened(file.header_value(ident)))
            except MemoryError:
                damage.append(f"{ident} ({record.rows} x {record.cols}) does not fit into memory")
                values.append("")
        return SbfCheck(
            str(file.path), file.kind, STATES.get(file.state, "being written, or killed while writing"), file.steps,
            file.directory.header, file.directory.steps, tuple(values), tuple(damage), tuple(notes(file)),
        )  # fmt: skip


def listing(check: SbfCheck) -> list[str]:
    lines = [f"{check.path}: SBF version 1, kind {check.kind} ({KINDS[check.kind]}), {check.state}"]
    rows = [(r.id, r.type, r.rows, r.cols, v) for r, v in zip(check.header, check.values, strict=True)]
    rows.append(("TDEF", 1, check.steps, len(check.step_variables), f"{check.steps} steps"))
    rows += [(r.id, r.type, r.rows, r.cols, "") for r in check.step_variables]
    rows.append(("TDAT", 1, 0, 0, ""))
    lines += [f"{'Id':<15} {'type':<9} {'rows':>6} {'cols':>6}  value"]
    lines += [f"{i:<15} {t} {TYPE_NAMES[t]:<7} {m:>6} {n:>6}  {v}".rstrip() for i, t, m, n, v in rows]
    lines.append(f"number of steps: {check.steps}")
    lines += list(check.notes)
    lines += [f"DAMAGED: {text}" for text in check.damage] or ["all checksums are right"]
    return lines


def as_json(check: SbfCheck) -> dict[str, object]:
    header, steps = (
        [{"id": r.id, "type": r.type, "rows": r.rows, "cols": r.cols} for r in records]
        for records in (check.header, check.step_variables)
    )
    header = [row | {"value": value} for row, value in zip(header, check.values, strict=True)]
    found = {"file": check.path, "kind": check.kind, "state": check.state, "steps": check.steps}
    return found | {"header": header, "step_variables": steps, "damage": list(check.damage), "notes": list(check.notes)}


def _shortened(value: np.ndarray | list[str]) -> str:
    items = value if isinstance(value, list) else value.ravel(order="F")[: SHOWN + 1]
    shown = [repr(v) if isinstance(v, str) else f"{v:.10g}" for v in items[:SHOWN]]
    return " ".join(shown) + (" ..." if len(items) > SHOWN else "")
