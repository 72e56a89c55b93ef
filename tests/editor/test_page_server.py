"""The server of the page: what it refuses, what its policy admits, the calls; over real connections."""

import http.client
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from threading import Thread

import pytest
from spacar_cli.editor.page_server import SCRIPTS, PageCalls, PageServer

from tests.command_line import call
from tests.examples import DATA

CRANK = DATA / "crank.dat"


@contextmanager
def serving(path: Path, **options: bool) -> Iterator[PageServer]:
    made = PageServer(PageCalls(path, **options))
    Thread(target=made.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
    yield made
    made.shutdown()
    made.server_close()
    made.calls.close()


@pytest.fixture
def crank(tmp_path) -> Path:
    return Path(shutil.copy(CRANK, tmp_path))


@pytest.fixture
def server(crank) -> Iterator[PageServer]:
    with serving(crank) as made:
        yield made


def asked(server: PageServer, method: str, name: str, body: object = None, path: str | None = None, **headers: str):
    """Status, headers and text of the answer; a header that is empty is not sent."""
    host = f"127.0.0.1:{server.server_port}"
    told = {"Host": host, "Content-Type": "application/json"} if body is not None else {"Host": host}
    if method == "POST":
        told["Origin"] = f"http://{host}"
    told |= {key.replace("_", "-"): value for key, value in headers.items()}
    data = json.dumps(body).encode() if body is not None else b""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    connection.putrequest(method, path or f"/{server.token}/{name}", skip_host=True)
    for key, value in told.items():
        if value:
            connection.putheader(key, value)
    connection.putheader("Content-Length", str(len(data)))
    connection.endheaders(data)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, answer.headers, text


def test_it_listens_on_the_loopback_interface_only(server):
    assert server.server_address[0] == "127.0.0.1"
    assert len(server.token) >= 32
    assert server.address.endswith(f"/{server.token}/")


@pytest.mark.parametrize("headers", [
    {"Host": "evil.example"}, {"Host": "evil.example:{port}"}, {"Host": ""}, {"Host": "127.0.0.1"},
    {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"},
    {"Origin": "https://127.0.0.1:{port}"},
])  # fmt: skip
@pytest.mark.parametrize("call", [("GET", ""), ("POST", "call/open")])
def test_foreign_hosts_and_origins_are_refused(server, call, headers):
    told = {key: value.replace("{port}", str(server.server_port)) for key, value in headers.items()}
    status, _, text = asked(server, *call, {} if call[0] == "POST" else None, **told)
    assert status == 403
    assert "PLBEAM" not in text


def test_a_call_without_an_origin_and_a_page_asked_by_another_site_are_refused(server):
    assert asked(server, "POST", "call/open", {}, Origin="")[0] == 403
    assert asked(server, "GET", "", Sec_Fetch_Site="cross-site")[0] == 403
    assert asked(server, "GET", "", Sec_Fetch_Site="none")[0] == 200


@pytest.mark.parametrize("path", ["/", "//", "/call/open", "/wrong/call/open", "/wrong/", "/?{token}", "/%e9/"])
def test_without_the_token_nothing_is_told(server, path):
    for method, body in (("GET", None), ("POST", {})):
        status, _, text = asked(server, method, "", body, path.replace("{token}", server.token))
        assert status == 403
        assert server.token not in text
        assert "PLBEAM" not in text


@pytest.mark.parametrize("name", ["../editor.py", "..%2f..%2fmain.py", "page_server.py", "crank.dat", "call/open"])
def test_only_the_files_of_the_page_are_given(server, name):
    assert asked(server, "GET", name)[0] == 404


def test_calls_are_json_of_limited_size(server):
    assert asked(server, "POST", "call/open", {})[0] == 200
    assert asked(server, "POST", "call/open", {}, Content_Type="text/plain")[0] == 400
    wrong = ("open", {"path": "/etc/passwd"}), ("nothing", {}), ("open", [1]), ("task", {"task": "check"})
    assert [asked(server, "POST", f"call/{name}", given)[0] for name, given in wrong] == [400] * len(wrong)
    assert asked(server, "PUT", "call/open", {})[0] == 501


def test_the_policy_admits_our_own_scripts_only(server):
    _, headers, page = asked(server, "GET", "")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    nonce = re.search(r"'nonce-([^']+)'", policy)[1]
    assert f'nonce="{nonce}"' in page
    assert nonce != re.search(r"'nonce-([^']+)'", asked(server, "GET", "")[1]["Content-Security-Policy"])[1]
    assert not re.findall(r"<script(?! src=)|\son\w+=|https?://", page)
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"] == "no-referrer"
    for name in (*SCRIPTS, "editor.css"):
        status, told, text = asked(server, "GET", name)
        assert status == 200
        assert told["Content-Type"].startswith("text/javascript" if name.endswith(".js") else "text/css")
        assert "innerHTML" not in text or name == "codemirror.js"


def test_the_name_of_the_file_stays_text(tmp_path):
    with serving(tmp_path / "<img src=x onerror=alert(1)>.dat") as made:
        assert "<img" not in asked(made, "GET", "")[2]


def test_the_page_saves_only_over_what_it_read(server):
    path = server.calls.file.path

    def call(name: str, **given: object) -> dict:
        return json.loads(asked(server, "POST", f"call/{name}", given)[2])

    read = call("open")["result"]
    assert read["text"] == path.read_text()
    given = {key: read[key] for key in ("digest", "newline", "marked")}
    digest = call("save", text="% mine\n", **given)["result"]
    assert path.read_text() == "% mine\n"
    assert digest == sha256(path.read_bytes()).hexdigest() == call("state")["result"]["digest"]
    path.write_text("% another\n")
    refused = call("save", text="% mine again\n", **given | {"digest": digest})
    assert refused["code"] == "edit.changed"
    assert path.read_text() == "% another\n"
    call("save", text="% mine again\n", **given | {"digest": call("state")["result"]["digest"]})
    assert path.read_text() == "% mine again\n"


def test_a_watching_page_changes_nothing(crank):
    calls = ("run", {"mode": 1}), ("save", {"text": "", "digest": "", "newline": "\n", "marked": False})
    with serving(crank, watch=True) as made:
        for name, given in calls:
            assert json.loads(asked(made, "POST", f"call/{name}", given)[2])["code"] == "edit.watch"
    assert crank.read_bytes() == CRANK.read_bytes()


@pytest.mark.parametrize("name", ["", ".", "/"])
def test_a_folder_is_no_file_to_edit(name):
    assert "it is a folder" in call.refused("edit", name, "--no-browser")


def test_the_command_prints_the_address_and_the_page_ends_it(tmp_path):
    """`--no-browser`; a file that is not there begins with an example that has no errors, and is not made."""
    command = [sys.executable, "-m", "spacar_cli.main", "edit", "new", "--no-browser"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        host, token = re.fullmatch(r"new\.dat: http://(127\.0\.0\.1:\d+)/([\w-]+)/\n", line).groups()
        connection = http.client.HTTPConnection(host, timeout=30)

        def call(name: str, **given: object) -> dict:
            told = {"Origin": f"http://{host}", "Content-Type": "application/json"}
            connection.request("POST", f"/{token}/call/{name}", json.dumps(given), told)
            return json.loads(connection.getresponse().read())["result"]

        opened = call("open")
        assert opened["digest"] == ""
        found = call("task", task="check", arguments={"text": opened["text"]})
        assert found["messages"] == []
        assert 1 in [mode["number"] for mode in found["modes"]]
        assert not (tmp_path / "new.dat").exists()
        call("end")
        assert process.wait(20) == 0
