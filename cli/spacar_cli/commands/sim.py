"""`spacar sim FILE`: a controlled simulation from a model file."""

import time
from pathlib import Path

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell, tell_notes
from spacar_cli.progress import Bar
from spacar_cli.row_output import show_scopes, signal_options, sorted_files

LONG = 5.0  # seconds of a run that is told what it waits for


@words.command("sim")
@words.option("compiled", default=True)
@signal_options("FILE_sim.npz")
def command(environment: Environment, file: Path, output: tuple[Path, ...], compiled: bool, show: bool) -> None:
    """Simulate the blocks and wires of a model file (`spacar help simulation`).

    Writes the signals, FILE_sim.log, and FILE_sim.sbd with signals and the motion of the mechanism for draw, plot and
    report. Pictures and the window show the scopes; without a scope the outputs of the mechanisms, or of all blocks.
    """
    from spacar_formats.safety import write_text
    from spacar_formats.signal_tables import export_signals, panels_by_quantity, table_of, write_motions, write_table
    from spacar_formats.simfile import read_model

    from spacar.simulation.engine import simulate
    from spacar.simulation.plant import Spasim

    if not file.name:
        raise UsageError(f"'{file}' is not the name of a model file", "files.not-readable")
    source = file if file.is_file() else file.with_name(f"{file.name}.sim")
    model = read_model(source)
    tables, pictures = sorted_files(output, show)
    targets = tables or [source.with_name(f"{source.stem}_sim.npz")]
    tell_notes(environment, model.warnings)
    plants = {name: block for name, block in model.diagram.blocks.items() if isinstance(block, Spasim)}
    if not compiled:
        for plant in plants.values():
            plant.choose(False)
    first, duration = float(model.times[0]), float(model.times[-1] - model.times[0])
    bar, begun = Bar(environment), time.perf_counter()

    def progress(t: float) -> None:
        if bar.due:
            bar.show_time(t, t - first, duration)

    try:
        response = simulate(model.diagram, model.times, **model.options, progress=progress)
    finally:
        bar.close()
    seconds = time.perf_counter() - begun
    for name, plant in plants.items():
        if plant.doubt:
            tell(environment, "warning", f"{name}: {plant.doubt}")
    table = table_of(response)
    signals = {name: table.values[:, table.columns(name)] for name in dict.fromkeys(table.blocks)}
    for target in targets:
        export_signals({"t": response.t} | signals, target)
    stem = targets[0].with_suffix("")
    if stem.with_suffix(".dat").is_file():  # the results of the model itself stay
        stem = stem.with_name(f"{stem.name}_sim")
    motions = write_motions(response, stem) or [write_table(stem, response.t, table, source)]
    lines = [f"simulation of {source.name}: {len(response.t)} times up to t = {response.t[-1]:.9g} s"]
    for name, block in model.diagram.blocks.items():
        kind = type(block).__name__
        lines.append(f"block {name} ({kind}): {block.n_in} inputs, {block.n_out} outputs, {block.n_states} states")
        if name in plants:
            lines.append("  engine: {} ({})".format(*plants[name].engine))
        lines += [f"  output {k + 1}: {text}" for k, text in enumerate(block.outputs_)]
    lines += [f"warning: {text}" for text in model.warnings] + [f"note: {text}" for text in response.notes]
    lines += [f"event at t = {t:.12g}: {text}" for t, text in response.events]
    lines.append("work: " + ", ".join(f"{count} {what}" for what, count in response.statistics.items()))
    write_text(targets[0].with_suffix(".log"), "\n".join(lines) + "\n")
    files = " ".join(str(path) for path in (*targets, *motions))
    rate = (response.t[-1] - response.t[0]) / seconds
    environment.wrote(f"{source.name}: {len(response.t)} times in {seconds:.2f} s ({rate:.3g} s/s): {files}")
    if response.hint and seconds > LONG:
        tell(environment, "hint", response.hint)
    if show or pictures:
        panels = table.panels or tuple(p for name in plants or signals for p in panels_by_quantity(table, name))
        show_scopes(environment, table, response.t, panels, source.stem, show, pictures)
