"""Serve a page until Ctrl-C or until the page ends it."""

from __future__ import annotations

from pathlib import Path
from threading import Thread

from spacar_cli.editor.page_calls import PageCalls
from spacar_cli.editor.page_server import PageServer
from spacar_cli.environment import Environment


def serve(environment: Environment, path: Path, watch: bool, browser: bool) -> None:
    """Print the address, open it in the browser when that is asked for, and answer until the end."""
    calls = PageCalls(path.resolve(), watch)
    server = PageServer(calls)
    Thread(target=server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True).start()
    try:
        environment.say(f"{path.name}: {server.address}")
        environment.wrote("Ctrl-C ends it")
        if browser:
            import webbrowser

            webbrowser.open(server.address)
        while not calls.ended.wait(0.5):  # a wait without end would not see Ctrl-C on every system
            pass
    except KeyboardInterrupt:
        pass
    finally:
        server.shutdown()
        server.server_close()
        calls.close()
