"""`spacar loadsbd FILE [ID ...]`."""

from spacar_cli.exporting import export_command

command = export_command("sbd")
