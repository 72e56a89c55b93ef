"""`spacar examples`: the models and simulations of `data/`, listed or copied."""

import re
import shutil
from pathlib import Path

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment

HERE = Path(__file__).resolve().parent.parent
PLACES = (HERE / "examples", HERE.parent.parent / "data")  # in an installed wheel, in a checkout

ENDING = re.compile(r"\.(dat|sim|toml|py)\Z")


@words.command("examples")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@words.option("output_dir", "; default the current one.", default=Path())
@words.option("overwrite")
def command(environment: Environment, names: tuple[str, ...], output_dir: Path, overwrite: bool) -> None:
    """List the example models, or copy those that are named (`all` for every one) to a folder.

    A simulation (.sim) is copied with the models that it needs.
    """
    from spacar_formats.safety import replacing

    alone = {path.stem: path for path in sorted(_home().glob("*.sim"))}
    models = alone | {path.stem: path for path in sorted(_home().glob("*.dat"))}
    # those in folders go by FOLDER/NAME
    within = sorted((p for p in _home().glob("*/*") if ENDING.search(p.name)), key=lambda p: p.suffix != ".py")
    models = dict(sorted(models.items())) | dict(sorted((f"{p.parent.name}/{p.stem}", p) for p in within))
    if not names:
        width = max(map(len, models))
        for name, path in models.items():
            environment.say(f"{name:<{width}}  {_title(path)}")
            if name in alone and path.suffix == ".dat":
                environment.say(f"{'':<{width}}  {alone[name].name}: {_title(alone[name])}")
        return
    chosen = list(models) if names == ("all",) else [ENDING.sub("", name) for name in names]
    for name in chosen:
        if name not in models:
            raise UsageError(f"there is no example '{name}'; `spacar examples` lists them", "usage.example")
        for path in _files(name):
            if (output_dir / path.name).exists() and not overwrite:
                raise UsageError(f"{output_dir / path.name} exists; --overwrite replaces it", "files.exists")
    output_dir.mkdir(parents=True, exist_ok=True)
    needed = [other for name in chosen if name in alone for other in _needed(alone[name], models)]
    missing = [name for name in needed if overwrite or not (output_dir / f"{name}.dat").exists()]
    for name in dict.fromkeys((*chosen, *missing)):
        for path in _files(name):
            if name not in chosen and not overwrite and (output_dir / path.name).exists():
                continue
            with replacing(output_dir / path.name) as side:
                shutil.copyfile(path, side)
        environment.wrote(output_dir / models[name].name)


def _home() -> Path:
    for place in PLACES:
        if place.is_dir():
            return place
    raise UsageError("the example models are not installed", "files.examples")


def _files(name: str) -> list[Path]:
    """All files of an example: with the user functions of the model, when it has some."""
    return sorted(_home().glob(f"{name}.*"))


def _title(path: Path) -> str:
    """The first comment of the model."""
    with open(path, encoding="utf-8") as file:
        return file.readline().strip().strip('%#;" ')


def _needed(simulation: Path, models: dict[str, Path]) -> list[str]:
    """Models of a simulation: those it names, and those they are linearized along (their names shortened)."""
    text = simulation.read_text(encoding="utf-8")
    named = {Path(word).stem for word in re.findall(r"^(?:model|file)\s*=\s*(\S+)", text, flags=re.MULTILINE)}
    nominal = {m for m in models for name in named if m != name and name.startswith(m)}
    return [m for m in models if m in named | nominal]
