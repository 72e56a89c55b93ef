"""One module a command, thin over the public API; `spacar_cli.command_table` names them."""
