"""Consumers of a stream of frames that write result files."""

from spacar_formats.sinks.results import ResultSink, result_sinks

__all__ = ["ResultSink", "result_sinks"]
