"""A mechanism as a functional mock-up unit: FMI 2.0 for co-simulation, packed by pythonfmu (extra `fmu`).

The unit holds the input file, the files of functions that USERSIG, USERINP and USERTRAJ name, a list of its signals,
and the fixed script fmu_slave.py, which runs the mechanism by the spacar of the Python that opens it: that Python needs
spacar installed (needsExecutionTool). Variables have the names of the signals with '_' for what FMI does not allow.
"""

import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from spacar.errors import AnalysisError, UsageError
from spacar.expressions import Dimensions, unit_text
from spacar.mechanism.numbering import owners
from spacar.mechanism.user_files import STATEMENTS, function_file
from spacar.simulation.plant import QUANTITY, Spasim
from spacar_formats.safety import replacing

SCRIPT = "fmu_slave.py"
DESCRIPTION = "modelDescription.xml"


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
    inputs, outputs = variables(plant.inputs), variables(plant.outputs_)
    words = {
        "name": identifier(model.stem), "title": model.stem, "model": model.name, "rtol": rtol, "atol": atol,
        "inputs": inputs, "outputs": outputs,
        "input_texts": plant.inputs, "output_texts": plant.outputs_,
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        files = [place / "plant.json", place / model.name]
        files[0].write_text(json.dumps(words), encoding="utf-8")
        shutil.copyfile(model, files[1])
        deck = plant.mechanism.deck
        for functions in dict.fromkeys(function_file(deck, s) for s in deck.of(*STATEMENTS)):
            files.append(place / functions.name)
            shutil.copyfile(functions, files[-1])
        script = place / SCRIPT
        shutil.copyfile(Path(__file__).with_name(SCRIPT), script)
        try:
            made = FmuBuilder.build_FMU(script, dest=place / "made.fmu", project_files=files)
        except Exception as cause:  # whatever stops pythonfmu is one error here
            text = f"pythonfmu could not pack {target.name}: {type(cause).__name__}: {cause}"
            raise AnalysisError(text, "fmu.build") from cause
        _completed(made, dict(zip(inputs + outputs, units(plant), strict=True)))
        with replacing(target) as side:
            shutil.copyfile(made, side)
    return plant


def units(plant: Spasim) -> list[str]:
    """Units of the inputs, then of the outputs; empty for a pure number."""
    n, known = plant.numbering, Dimensions.of(plant.numbering, False)
    x, e = owners(n.x_places, n.nx), owners(n.e_places, n.ne)
    names = {kind: ("x", "xd", "xdd")[k] if "X" in kind else ("e", "ed", "edd")[k] for kind, k in QUANTITY.items()}
    names |= {"INPUTS": "sig", "INPUTF": "fx"}
    signals = (*plant.u_signals, *plant.y_signals)
    return [unit_text(known(names[s.kind], (e if names[s.kind][0] in "es" else x)[s.index])) for s in signals]


def _completed(unit: Path, texts: dict[str, str]) -> None:
    """Write what pythonfmu leaves out of the description of a unit: units, and the outputs as InitialUnknowns."""
    with zipfile.ZipFile(unit) as packed:
        content = {name: packed.read(name) for name in packed.namelist()}
    root = ElementTree.fromstring(content[DESCRIPTION])
    definitions = ElementTree.Element("UnitDefinitions")
    for text in sorted(set(filter(None, texts.values()))):
        ElementTree.SubElement(definitions, "Unit", name=text)
    kinds = [child.tag for child in root]
    root.insert(1 + max(k for k, tag in enumerate(kinds) if tag in ("ModelExchange", "CoSimulation")), definitions)
    for variable in root.iter("ScalarVariable"):
        real, text = variable.find("Real"), texts.get(variable.get("name", ""), "")
        if real is not None and text:
            real.set("unit", text)
    for structure in root.iter("ModelStructure"):
        ElementTree.SubElement(structure, "InitialUnknowns").extend(structure.findall("Outputs/Unknown"))
    content[DESCRIPTION] = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    with zipfile.ZipFile(unit, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in content.items():
            packed.writestr(name, data)


def identifier(text: str) -> str:
    """A name that FMI allows: letters, digits and '_', not first a digit."""
    clean = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_") or "plant"
    return f"_{clean}" if clean[0].isdigit() else clean


def variables(names: Sequence[str]) -> list[str]:
    """Every name as an identifier, with its number where two would be the same."""
    clean = [identifier(name) for name in names]
    return [name if clean.count(name) == 1 else f"{name}_{k + 1}" for k, name in enumerate(clean)]
