"""`spacar loadsbm FILE [ID ...]`."""

from spacar_cli.commands.loadsbd import export_command

command = export_command("sbm")
