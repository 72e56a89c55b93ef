"""Pictures of mechanisms: pure functions from result arrays to drawable geometry, then matplotlib.

source -> Scene and coordinates -> shapes (lines, faces, marks) -> paint on a matplotlib figure. The public functions
are `draw`, `animate`, `plot`, `report`, `stress`, `view`, `flexure_page` and `flexure_plot`; methods of results and of
answers call them. No window opens unless a function of `window` is called; matplotlib is imported where it draws.

>>> import spacar
>>> from spacar_drawing import draw
>>> figure = draw(spacar.run(1, "data/crank.dat"), strobe=5, traces=[3])
>>> figure.get_size_inches().min() > 1.0
True
"""

from spacar_drawing.drawing_calls import (
    animate,
    draw,
    flexure_page,
    flexure_plot,
    inline_model,
    inline_picture,
    plot,
    report,
    stress,
    view,
)
from spacar_drawing.study_figures import response_plot, sensitivity_plot, sweep_plot, trade_plot

__all__ = [
    "animate", "draw", "flexure_page", "flexure_plot", "inline_model", "inline_picture", "plot", "report",
    "response_plot", "sensitivity_plot", "stress", "sweep_plot", "trade_plot", "view",
]  # fmt: skip
