"""The server of `spacar edit` and `spacar view --watch`: one file, one page, the loopback interface only.

A page of another origin must not read or change the file (threats: requests of other sites to 127.0.0.1, DNS names
that are made to point there, other users of the machine): every address begins with a random token, the Host header
must be our own, so must Origin be where it is given and always in calls, which are JSON. The policy of the page admits
our own scripts only; `style` of the editor component has a nonce. What the page may ask: the file, the tasks of
`model_tasks`, runs.
"""

import json
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from html import escape
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from threading import Event, Lock, Thread, Timer
from typing import Any
from urllib.parse import urlsplit

from spacar_drawing.viewer_page import STYLE, script_text, stage_html

from spacar.errors import SpacarError, UsageError
from spacar.modes import find_mode
from spacar_cli.editor.edited_file import EditedFile, result_file
from spacar_cli.editor.task_process import TaskProcess
from spacar_cli.environment import Environment
from spacar_cli.keyword_help import keywords_json

HOST = "127.0.0.1"
LARGEST = 32_000_000  # bytes of a call
OF_VIEWER = ("viewer.js", "viewer_controls.js")
SCRIPTS = ("codemirror.js", "language.js", "editor.js", "results.js", "curves.js", *OF_VIEWER)
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'nonce-{nonce}'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

TYPED = ("check", "picture")  # tasks that follow the keys
SECONDS = 120.0, 20.0  # for what a click asks for, and for what follows the keys
READING = ("state", "open", "task", "log", "end")  # what a page that watches may ask

PATIENCE = 5.0  # seconds after which a run that was asked to end is killed
# Ctrl-C at the server does not reach a run before the server has ended it
OWN_GROUP: Any = {"start_new_session": True}
STOP = signal.SIGINT
if sys.platform == "win32":
    OWN_GROUP = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    STOP = signal.CTRL_BREAK_EVENT
MOST_TOLD = 4000  # letters of what a run says


def page_file(name: str) -> str:
    if name in OF_VIEWER:
        return script_text(name)
    return files("spacar_cli.editor").joinpath("page", name).read_text("utf-8")


class ModeJob:
    """At most one run at a time of one file: `spacar MODE FILE --json` in a process of its own."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = Lock()
        self._process: subprocess.Popen[str] | None = None
        self._begun = 0.0
        self._state: dict[str, Any] = {"running": False, "mode": None}

    def start(self, mode: int) -> None:
        """Raises UsageError for a mode that there is not, and while another run goes on."""
        number = find_mode(mode).number
        with self._lock:
            if self._state["running"]:
                raise UsageError("a run goes on; abort it, or wait", "edit.running")
            words = [sys.executable, "-m", "spacar_cli.main", str(number), self._path.name, "--json"]
            self._begun = time.monotonic()
            self._process = subprocess.Popen(
                words, cwd=self._path.parent, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                text=True, encoding="utf-8", errors="backslashreplace", **OWN_GROUP,
            )  # fmt: skip
            self._state = {"running": True, "mode": number}
            Thread(target=self._wait, args=(self._process,), daemon=True).start()

    def _wait(self, process: subprocess.Popen[str]) -> None:
        out, told = process.communicate()
        try:
            summary = json.loads(out.splitlines()[-1])
        except (ValueError, IndexError):
            summary = {}
        ended = {"running": False, "status": process.returncode, "told": told[-MOST_TOLD:],
                 "seconds": time.monotonic() - self._begun}  # fmt: skip
        with self._lock:
            self._state |= ended | {name: summary.get(name) for name in ("steps", "error", "code")}

    def state(self) -> dict[str, Any]:
        """running, mode, and when it has ended status, told, steps, seconds, error, code."""
        with self._lock:
            return dict(self._state)

    def abort(self) -> None:
        """As Ctrl-C: what is stored so far is kept."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(STOP)
            kill = Timer(PATIENCE, self._process.kill)
            kill.daemon = True
            kill.start()

    def close(self) -> None:
        self.abort()
        if self._process is not None:
            self._process.wait()


class PageCalls:
    """The calls of one page; `ended` is set when it wants the server to end."""

    def __init__(self, path: Path, watch: bool = False) -> None:
        self.file = EditedFile(path)
        self.watch = watch
        self.ended = Event()
        self._processes = TaskProcess(), TaskProcess()  # as SECONDS
        self._job = ModeJob(path)
        self._calls: dict[str, Callable[..., Any]] = {
            "open": self.file.read, "save": self.file.save, "state": self._state, "run": self._job.start,
            "abort": self._job.abort, "log": self._log, "end": self.ended.set,
        }  # fmt: skip

    def call(self, name: str, arguments: dict[str, Any]) -> str:
        """The answer to one call, {"result": ...} or of a task {"error": text}. Raises SpacarError; TypeError and
        KeyError for what is no call."""
        if self.watch and name not in READING:
            raise UsageError("this page only watches", "edit.watch")
        if name == "task":
            return self._task(arguments["task"], arguments["arguments"])
        return json.dumps({"result": self._calls[name](**arguments)})

    def _state(self, progress: bool = False) -> dict[str, Any]:
        """What may change by itself: the digest of the file, the inode of its result (each is a new file), the run."""
        found = self._job.state() | {"digest": self.file.digest()}
        written = result_file(self.file.path, "sbd")
        found["result"] = written.stat().st_ino if written.is_file() else 0
        if progress and found["running"]:
            found["progress"] = json.loads(self._task("progress", {})).get("result")
        return found

    def _log(self) -> str:
        path = result_file(self.file.path, "log")
        return path.read_text("utf-8", "replace") if path.is_file() else ""

    def _task(self, task: str, arguments: dict[str, Any]) -> str:
        typed = task in TYPED
        return self._processes[typed].ask(task, {**arguments, "file": str(self.file.path)}, SECONDS[typed])

    def close(self) -> None:
        self._job.close()
        for process in self._processes:
            process.close()


class PageServer(ThreadingHTTPServer):
    """Serves `calls` (what the page may ask) until its `shutdown`."""

    daemon_threads = True

    def __init__(self, calls: PageCalls) -> None:
        super().__init__((HOST, 0), PageHandler)
        self.calls = calls
        self.token = secrets.token_urlsafe(24)
        self.hosts = {f"{name}:{self.server_port}" for name in (HOST, "localhost")}

    @property
    def address(self) -> str:
        return f"http://{HOST}:{self.server_port}/{self.token}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away is no error."""


class PageHandler(BaseHTTPRequestHandler):
    """One request; everything but the page, its files and its calls is refused."""

    server: PageServer
    server_version, sys_version = "spacar", ""
    protocol_version = "HTTP/1.1"
    timeout = 60

    def do_GET(self) -> None:
        if (name := self._name(False)) is None:
            return
        if name == "":
            nonce = secrets.token_urlsafe(16)
            self._send(HTTPStatus.OK, self._page(nonce), "text/html; charset=utf-8", nonce)
        elif name in SCRIPTS or name == "editor.css":
            kind = "css" if name == "editor.css" else "javascript"
            self._send(HTTPStatus.OK, page_file(name), f"text/{kind}; charset=utf-8")
        elif name == "keywords.json":
            self._send(HTTPStatus.OK, json.dumps(keywords_json()), "application/json")
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here")

    def do_POST(self) -> None:
        if (name := self._name(True)) is None:
            return
        length = self.headers.get("Content-Length", "")
        if self.headers.get_content_type() != "application/json" or not length.isdecimal() or int(length) > LARGEST:
            self._refuse(HTTPStatus.BAD_REQUEST, "a call is JSON of limited size")
            return
        try:
            arguments = json.loads(self.rfile.read(int(length)))
            answer = self.server.calls.call(name.removeprefix("call/"), arguments)
        except (ValueError, TypeError, KeyError):
            self._refuse(HTTPStatus.BAD_REQUEST, "a call that cannot be understood")
            return
        except SpacarError as error:
            answer = json.dumps({"error": str(error), "code": error.code})
        self._send(HTTPStatus.OK, answer, "application/json")

    def _name(self, call: bool) -> str | None:
        """What is asked for, behind the token; None when it was refused."""
        ours = {f"http://{host}" for host in self.server.hosts}
        origin, site = self.headers.get("Origin"), self.headers.get("Sec-Fetch-Site", "same-origin")
        if self.headers.get("Host") not in self.server.hosts:
            reason = "the Host header is not that of this server"
        elif (origin not in ours) if call or origin is not None else site not in ("same-origin", "none"):
            reason = "the request comes from another site"
        else:
            _, token, name = (*urlsplit(self.path).path.split("/", 2), "", "")[:3]
            if secrets.compare_digest(token.encode("utf-8", "replace"), self.server.token.encode()):
                return name
            reason = "the address has not the token that spacar printed"
        self._refuse(HTTPStatus.FORBIDDEN, reason)
        return None

    def _page(self, nonce: str) -> str:
        text = page_file("index.html")
        named = {
            "title": escape(self.server.calls.file.path.name), "nonce": nonce, "stage": stage_html(),
            "style": STYLE, "watch": "watch" if self.server.calls.watch else "edit",
        }  # fmt: skip
        for name, value in named.items():
            text = text.replace(f"[[{name}]]", value)
        return text

    def _refuse(self, status: HTTPStatus, text: str) -> None:
        self.close_connection = True
        self._send(status, f"{text}\n", "text/plain; charset=utf-8")

    def _send(self, status: HTTPStatus, text: str, kind: str, nonce: str = "") -> None:
        data = text.encode("utf-8", "replace")
        self.send_response(status)
        for name, value in {
            "Content-Type": kind, "Content-Length": str(len(data)), "Cache-Control": "no-store",
            "Content-Security-Policy": POLICY.format(nonce=nonce or "none"), "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer", "Cross-Origin-Resource-Policy": "same-origin",
            "Cross-Origin-Opener-Policy": "same-origin", "X-Frame-Options": "DENY",
        }.items():  # fmt: skip
            self.send_header(name, value)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing is told about requests."""


def serve(environment: Environment, path: Path, watch: bool, browser: bool) -> None:
    """Print the address, open it in the browser when that is asked for, and answer until Ctrl-C or the page ends it."""
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
