"""The log: what was read, what was done, what came out, in words and numbers."""

from spacar_formats.log.sink import LogSink

__all__ = ["LogSink"]
