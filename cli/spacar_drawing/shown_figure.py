"""A matplotlib figure that a notebook shows by itself, without pyplot or a magic line."""

from matplotlib.figure import Figure

from spacar_drawing.page_parts import png

NOTEBOOK_DPI = 80.0


class ShownFigure(Figure):
    """What `draw` and `plot` return."""

    def _repr_png_(self) -> bytes:
        return png(self, NOTEBOOK_DPI)
