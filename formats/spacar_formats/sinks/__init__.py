"""Consumers of a stream of frames that write result files."""

from spacar_formats.sinks.results import ResultSink, Sink, begin, release, result_sinks

__all__ = ["ResultSink", "Sink", "begin", "release", "result_sinks"]
