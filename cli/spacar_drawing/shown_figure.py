"""A matplotlib figure that a notebook shows by itself, without pyplot or a magic line."""

from io import BytesIO

from matplotlib.figure import Figure

from spacar_drawing.defaults import plain

NOTEBOOK_DPI = 80.0


class ShownFigure(Figure):
    """What `draw` and `plot` return."""

    @plain
    def _repr_png_(self) -> bytes:
        data = BytesIO()
        self.savefig(data, format="png", dpi=NOTEBOOK_DPI)
        return data.getvalue()
