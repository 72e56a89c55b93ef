"""`spacar loadsbd FILE [ID ...]`."""

from __future__ import annotations

from spacar_cli.exporting import export_command

command = export_command("sbd")
