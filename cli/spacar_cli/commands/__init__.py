"""One module a command, thin over the public API; `spacar_cli.table` names them."""
