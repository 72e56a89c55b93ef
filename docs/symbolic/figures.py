"""The four figures of the tutorial: joint angles and tip deflections of the two-link manipulator (figures 2 to 5 of
the paper, docs/reference/bibliography.md), and the torque of the motor of the closed slider-crank.

    python docs/symbolic/figures.py     writes q1.png, q4.png, tip1.png, tip2.png, slider_crank.png beside this file
"""

from __future__ import annotations

from pathlib import Path

from spacar_cli.symbolic_plot import plot

from spacar.symbolic.model_reader import read_model

HERE = Path(__file__).parent
MODELS = HERE.parents[1] / "data" / "symbolic"
LABELS = {
    "q1": "base angle $q_1$ [rad]",
    "q4": "second angle $q_4$ [rad]",
    "tip1": "tip deflection of beam 1 [m]",
    "tip2": "tip deflection of beam 2 [m]",
}
# 1: consistent SI units with gravity (case R1), over after 5 s; 2: mass in pounds taken for slugs and no gravity
# (case H0), the slow swing of 40 s that the paper shows.
CASES = {"R1": {}, "H0": {"g": 0.0, "rho": 2.612898 * 9.80665 / 0.3048}}


def main() -> None:
    model = read_model(MODELS / "manipulator.toml")
    program = model.system.derive("recursive").program(model.outputs)
    runs = {
        case: program.simulate(model.values | change, model.start, t_end=40.0, steps=4000, rtol=1e-8)
        for case, change in CASES.items()
    }
    for name, figure in zip(LABELS, plot(runs["R1"], LABELS, LABELS), strict=True):
        axes = figure.axes[0]
        axes.lines[0].set_label("R1: SI units, gravity")
        axes.plot(
            runs["H0"].time, runs["H0"][name], linewidth=1.0, color="tab:red", label="H0: mass × 32.174, no gravity"
        )
        axes.legend(frameon=False)
        figure.savefig(HERE / f"{name}.png", dpi=110)
        print(f"{name}.png: R1 ends at {runs['R1'][name][-1]:.10g}, H0 at {runs['H0'][name][-1]:.10g}")
    slider_crank()


def slider_crank() -> None:
    """Torque of the motor that turns the crank at 150 rad/s, with a flexible rod."""
    model = read_model(MODELS / "slider_crank.toml")
    program = model.system.derive("recursive").program(model.outputs)
    run = program.simulate(model.values, model.start, t_end=0.1, steps=400, integrator="dop853", rtol=1e-8)
    (figure,) = plot(run, ["motor"], {"motor": "torque of the motor [N m]"})
    figure.savefig(HERE / "slider_crank.png", dpi=90)


if __name__ == "__main__":
    main()
