"""A mechanism as a functional mock-up unit: FMI 2.0 for co-simulation, packed by pythonfmu (extra `fmu`).

The unit holds the input file (and NAME.py with its user functions), a list of its signals, and the fixed script
fmu_slave.py, which runs the mechanism by the spacar of the Python that opens it: that Python needs spacar installed
(needsExecutionTool). Variables have the names of the signals with '_' for what FMI does not allow.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from spacar.errors import AnalysisError, UsageError
from spacar.simulation.plant import Spasim
from spacar_formats.safety import replacing

SCRIPT = "fmu_slave.py"


def export_fmu(model: Path, target: Path, rtol: float = 1e-6, atol: float = 1e-8) -> Spasim:
    """Write `target` (.fmu) for the input file `model`, and return the mechanism.

    Raises UsageError without pythonfmu, for another extension and a model that cannot be simulated; InputError;
    AnalysisError when pythonfmu cannot pack it.
    """
    try:
        from pythonfmu import FmuBuilder
    except ImportError:
        raise UsageError("pythonfmu is not installed: pip install 'spacar[fmu]'", "fmu.missing") from None
    if target.suffix.lower() != ".fmu":
        raise UsageError(f"cannot write {target}: the name of a functional mock-up unit ends in .fmu", "fmu.name")
    plant = Spasim(model)
    words = {
        "name": identifier(model.stem), "title": model.stem, "model": model.name, "rtol": rtol, "atol": atol,
        "inputs": variables(plant.inputs), "outputs": variables(plant.outputs_),
        "input_texts": plant.inputs, "output_texts": plant.outputs_,
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        files = [place / "plant.json", place / model.name]
        files[0].write_text(json.dumps(words), encoding="utf-8")
        shutil.copyfile(model, files[1])
        functions = model.with_suffix(".py")
        if functions.is_file():
            files.append(place / functions.name)
            shutil.copyfile(functions, files[-1])
        script = place / SCRIPT
        shutil.copyfile(Path(__file__).with_name(SCRIPT), script)
        try:
            made = FmuBuilder.build_FMU(script, dest=place / "made.fmu", project_files=files)
        except Exception as cause:  # whatever stops pythonfmu is one error here
            text = f"pythonfmu could not pack {target.name}: {type(cause).__name__}: {cause}"
            raise AnalysisError(text, "fmu.build") from cause
        with replacing(target) as side:
            shutil.copyfile(made, side)
    return plant


def identifier(text: str) -> str:
    """A name that FMI allows: letters, digits and '_', not first a digit."""
    clean = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_") or "plant"
    return f"_{clean}" if clean[0].isdigit() else clean


def variables(names: Sequence[str]) -> list[str]:
    """Every name as an identifier, with its number where two would be the same."""
    clean = [identifier(name) for name in names]
    return [name if clean.count(name) == 1 else f"{name}_{k + 1}" for k, name in enumerate(clean)]
