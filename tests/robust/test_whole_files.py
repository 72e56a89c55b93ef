"""Everything that writes goes through one door: a file is the old one or the new one, never a piece."""

import ast
import os
import re
import resource
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from spacar_formats import safety

from spacar.errors import UsageError

from .processes import ENVIRONMENT, done, model, until

HOUSE = Path(__file__).resolve().parents[2]
WRITES = {"write_text", "write_bytes", "savefig", "savez", "save", "savemat", "tofile"}
DOOR = "formats/spacar_formats/safety.py"
# Written under a name beside the target that `replacing` gave, or growing files that are whole line by line.
ALLOWED = {
    DOOR, "formats/spacar_formats/safety.py", "spacar/locks.py", "formats/spacar_formats/exports.py",
    "formats/spacar_formats/combsbd.py", "formats/spacar_formats/getss.py", "formats/spacar_formats/repinsbf.py",
    "formats/spacar_formats/sbf/sbf_writer.py", "formats/spacar_formats/log/sink.py", "cli/spacar_drawing/files.py",
    "cli/spacar_cli/environment.py", "cli/spacar_cli/editor/edited_file.py",
    "spacar/studies/runs/rows.py", "spacar/compiled/library.py",
    "spacar/native/store.py", "spacar/symbolic/compiled_program.py", "spacar/symbolic/program.py",
}  # fmt: skip


def writers(path):
    """Lines of calls that write files."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if re.search(rf"\b({'|'.join(WRITES)}|open)\s*\(", text) else ():
        if not isinstance(node, ast.Call):
            continue
        function = node.func
        name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
        mode = next((a.value for a in [*node.args[:2], *(k.value for k in node.keywords)]
                     if isinstance(a, ast.Constant) and isinstance(a.value, str)), "r")  # fmt: skip
        opens = name == "open" and set(mode) & set("wax+") and set(mode) <= set("rwabxt+")
        if (name in WRITES and isinstance(function, ast.Attribute)) or opens:
            yield node.lineno


def test_there_is_one_door():
    found = {}
    for folder in ("spacar", "formats", "cli"):
        for path in (HOUSE / folder).rglob("*.py"):
            name = path.relative_to(HOUSE).as_posix()
            if name not in ALLOWED and (lines := list(writers(path))):
                found[name] = lines
    # pictures in memory; an FMU and a result in folders of their own; text that is made when the package is built
    assert set(found) <= {
        "cli/spacar_drawing/page_parts.py", "cli/spacar_drawing/drawing_calls.py", "formats/spacar_formats/fmu.py",
        "spacar/deck/model_methods.py", "spacar/compiled/generator/element_texts.py",
        "cli/spacar_drawing/shown_figure.py", "formats/spacar_formats/compliance.py",
    }, found  # fmt: skip


def limited():
    """No file may grow beyond 2 kB: what a full disk does in the middle of a picture.

    Such a process may write no bytecode: an older Python leaves half of it behind, and every later import fails.
    """
    resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


OUTPUTS = {
    "png": ("draw", "crank", "-o", "a.png"), "svg": ("draw", "crank", "-o", "a.svg"),
    "plot": ("plot", "crank", "x[6,1]", "-o", "a.pdf"), "csv": ("plot", "crank", "x[6,1]", "--csv", "a.csv"),
    "html": ("report", "crank", "-o", "a.html"), "npz": ("loadsbd", "crank", "-o", "a.npz"),
    "gif": ("draw", "crank", "--frames", "3", "-o", "a.gif"),
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = model(tmp_path_factory.mktemp("results"))
    assert done(folder, 1, "crank")[0] == 0
    return folder


@pytest.mark.parametrize("words", [
    pytest.param(words, id=kind, marks=[pytest.mark.slow] * (kind in ("html", "gif", "plot", "png")))
    for kind, words in OUTPUTS.items()
])  # fmt: skip
def test_a_full_disk_leaves_the_old_file_and_no_other(results, words):
    target = results / words[-1]
    target.write_text("old")
    before = sorted(p.name for p in results.iterdir())
    status, _, err = done(results, *words, preexec_fn=limited, env={**ENVIRONMENT, "PYTHONDONTWRITEBYTECODE": "1"})
    assert status in (1, 2)
    assert err.startswith("error: cannot write")
    assert len(err.splitlines()) == 1
    assert target.read_text() == "old"
    assert sorted(p.name for p in results.iterdir()) == before
    target.unlink()


# A disk that takes a minute: the side file is complete, and not yet in its place.
NEVER_ON_DISK = """
import os, sys, time
os.fsync = lambda file: time.sleep(60)
from spacar_cli.main import main
main(sys.argv[1:])
"""


@pytest.mark.parametrize("kind", ["svg", pytest.param("html", marks=pytest.mark.slow)])
def test_a_kill_leaves_the_old_file_and_the_next_run_cleans_up(results, kind):
    words = OUTPUTS[kind]
    target = results / words[-1]
    target.write_text("old")
    process = subprocess.Popen([sys.executable, "-c", NEVER_ON_DISK, *words], cwd=results, stdin=subprocess.DEVNULL)
    until(lambda: list(results.glob(".*spacar-side*")), process)
    process.kill()
    process.wait()
    assert list(results.glob(".*spacar-side*"))
    assert target.read_text() == "old"
    assert done(results, *words)[0] == 0
    assert not list(results.glob(".*spacar-side*"))
    assert len(target.read_text()) > 1000
    target.unlink()


def test_side_files_of_living_processes_stay(tmp_path):
    program = "import sys, pathlib; from spacar_formats.safety import replacing\n"
    program += "with replacing(pathlib.Path('a.txt')) as side: print(side, flush=True); sys.stdin.read()"
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, **streams)
    side = tmp_path / process.stdout.readline().strip()
    (tmp_path / ".b.4194305-1.spacar-side.txt").write_text("left by a killed process")
    safety._swept.clear()
    safety.write_text(tmp_path / "c.txt", "c")
    assert side.exists()
    assert not (tmp_path / ".b.4194305-1.spacar-side.txt").exists()
    process.kill()
    process.wait()
    safety._swept.clear()
    safety.write_text(tmp_path / "c.txt", "c")
    assert [p.name for p in tmp_path.iterdir()] == ["c.txt"]


def test_permissions_links_and_pipes_are_kept(tmp_path):
    target, link = tmp_path / "a.txt", tmp_path / "link.txt"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    safety.write_text(link, "new")
    assert link.is_symlink()
    assert (target.read_text(), stat.S_IMODE(target.stat().st_mode)) == ("new", 0o640)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True)
    safety.write_text(pipe, "through the pipe")
    assert reader.communicate()[0] == "through the pipe"
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    with pytest.raises(UsageError, match="folder"):
        safety.write_text(tmp_path, "x")
    safety.write_text(Path("/dev/null"), "x")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
