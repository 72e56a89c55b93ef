"""What a designer of flexures asks of a mechanism over its range of motion (docs/flexures.md)."""

from spacar.stroke.flexure_results import Flexure
from spacar.stroke.range_of_motion import flexure
from spacar.stroke.stroke_move import StrokeMove, parse_move

__all__ = ["Flexure", "StrokeMove", "flexure", "parse_move"]
