"""Consumers of a stream of frames that write result files."""

from spacar_formats.sinks.results import ResultSink, begin, result_sinks, write_steps

__all__ = ["ResultSink", "begin", "result_sinks", "write_steps"]
