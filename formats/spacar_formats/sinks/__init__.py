"""Consumers of a stream of frames that write result files."""

from spacar_formats.sinks.results import ResultSink, begin, give_up, result_sinks

__all__ = ["ResultSink", "begin", "give_up", "result_sinks"]
