"""Consumers of a stream of frames that write result files."""

from spacar_formats.sinks.results import ResultSink, begin, release, result_sinks

__all__ = ["ResultSink", "begin", "release", "result_sinks"]
