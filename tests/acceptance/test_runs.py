"""Runs as real processes: what is left when they end well, fail, are interrupted or killed, cannot write."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from spacar_formats.checksbf import checksbf
from spacar_formats.sbf import SbfFile

from spacar.compiled.library import why_off
from tests.examples import DATA

from .processes import ENVIRONMENT, SPACAR, many, prepare, spacar

LONG = ["--time", "1000", "--steps", "1000000"]  # far longer than any test waits


@pytest.fixture
def folder(tmp_path):
    for name in ("crank", "crank2", "crankfl", "slider", "fourbar", "massspring", "robotinvlin"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    return tmp_path


def start(folder, *words):
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    words = [str(SPACAR), *map(str, words)]
    # tests that run in the background of a shell inherit that SIGINT is ignored
    return subprocess.Popen(words, cwd=folder, env=ENVIRONMENT, text=True, preexec_fn=listen, **streams)


def listen():
    """As a terminal starts its programs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def wait_for_steps(path, process, least=50):
    """Wait until the growing file has so many steps."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and process.poll() is None:
        if path.exists() and path.stat().st_size > 64:
            with SbfFile(path) as file:
                if file.steps >= least:
                    return
        time.sleep(0.02)
    raise AssertionError(process.communicate())


def names(folder):
    return {p.name for p in folder.iterdir() if p.suffix != ".dat"}


def test_a_run_writes_log_and_result_and_says_nothing(folder):
    done = spacar("1", "crank", folder=folder)
    assert (done.status, done.out, done.err) == (0, "", "")
    assert names(folder) == {"crank.log", "crank.sbd"}
    with SbfFile(folder / "crank.sbd") as file:
        assert file.complete
        assert file.steps == 101


def test_minus_is_a_mode_not_an_option(folder):
    words = ["1", "-1", "+1", "01"]
    ended = many([[word, "crank.dat", "--quiet", "--output-dir", f"of{word}"] for word in words], folder)
    assert [done.status for done in ended] == [0] * 4
    assert all((folder / f"of{word}" / "crank.sbd").exists() for word in words)


def test_output_dir_is_made_and_used(folder):
    assert spacar("1", "crank", "--output-dir", "a/b", folder=folder).status == 0
    assert names(folder / "a" / "b") == {"crank.log", "crank.sbd"}
    assert names(folder) == {"a"}


def test_the_second_run_keeps_the_first_result(folder):
    prepare(folder)
    first = (folder / "crank.sbd").read_bytes()
    spacar("1", "crank", folder=folder)
    assert (folder / "crank.sbd.bak").read_bytes() == first
    assert names(folder) == {"crank.log", "crank.log.bak", "crank.sbd", "crank.sbd.bak"}


def test_a_failed_run_is_never_mistaken_for_a_success(folder):
    """The input error comes after a good run: the old result steps aside, the log explains."""
    prepare(folder)
    text = (folder / "crank.dat").read_text()
    (folder / "crank.dat").write_text(text.replace("XM 6", "XM 99"))
    done = spacar("1", "crank", folder=folder)
    assert done.status == 2
    assert "crank.dat:13: XM: node 99" in done.err
    assert "crank.sbd" not in names(folder)
    assert "crank.sbd.bak" in names(folder)
    assert "nothing was analysed" in (folder / "crank.log").read_text()


def test_a_failing_analysis_keeps_what_was_computed(folder):
    """The rod of 0.12 m cannot reach the slider's guide when the crank of 0.15 m has turned by 53 degrees."""
    text = (DATA / "crank.dat").read_text().replace("X 6 0.45 0.", "X 6 0.27 0.")
    (folder / "short.dat").write_text(text.replace("TIMESTEP 0.1 100", "TIMESTEP 0.02 200"))
    done = spacar("1", "short", folder=folder)
    assert done.status == 1, done.err
    assert "Traceback" not in done.err
    assert done.err.startswith("error: ")
    assert names(folder) == {"short.log", "short.sbd.part"}
    log = (folder / "short.log").read_text()
    assert "The analysis failed." in log
    with SbfFile(folder / "short.sbd.part") as file:
        assert file.state == 2
        reached = float(np.ravel(file.get("t"))[-1]) * 150.0
    # sin(angle) = 0.12/0.15 at the limit; one output step is 0.015 rad
    assert np.arcsin(0.8) - 0.06 < reached < np.arcsin(0.8)


def test_an_interrupted_run_keeps_what_was_computed(folder):
    prepare(folder)
    process = start(folder, "1", "crank", *LONG)
    part = folder / "crank.sbd.part"
    wait_for_steps(part, process)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert out == ""
    assert err.startswith("error: interrupted after ")
    assert "Traceback" not in err
    with SbfFile(part) as file:
        assert file.state == 2
        assert file.steps >= 50
    assert names(folder) == {"crank.log", "crank.log.bak", "crank.sbd.bak", "crank.sbd.part"}
    assert "interrupted by the user" in (folder / "crank.log").read_text()


def test_a_killed_run_leaves_a_readable_file(folder):
    process = start(folder, "1", "crank", *LONG)
    part = folder / "crank.sbd.part"
    wait_for_steps(part, process)
    process.kill()
    process.communicate()
    with SbfFile(part) as file:
        assert (file.state, file.complete, file.truncated) == (0, False, False)
        assert 0 <= file.surplus <= file.directory.stride
        steps = file.steps
        t = np.ravel(file.get("t"))
    np.testing.assert_allclose(np.diff(t), 1e-3, rtol=1e-6)  # t = k/1000 rounded at t up to 1000
    assert checksbf(part).sound
    assert not (folder / "crank.sbd").exists()
    # Every stored step but the last is in the log: its line is written before the next step begins.
    log = (folder / "crank.log").read_text()
    assert f"\n{steps - 1:8d}  " in log
    check = spacar("checksbf", "crank.sbd.part", folder=folder)
    assert f"incomplete: stopped after step {steps} at t = {t[-1]:.12g}" in check.out
    # The next run starts afresh.
    assert spacar("1", "crank", folder=folder).status == 0
    assert "crank.sbd.part" not in names(folder)


def test_a_full_disk_is_a_failure_with_the_reason(folder):
    """A limit on the size of files stands for a full disk: bytes are refused in the middle of the run."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))

    done = subprocess.run([str(SPACAR), "1", "crank", *LONG], cwd=folder, env=ENVIRONMENT, text=True,
                          capture_output=True, preexec_fn=limit, timeout=60)  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "cannot write" in done.stderr
    assert "Traceback" not in done.stderr
    with SbfFile(folder / "crank.sbd.part") as file:
        assert file.steps == (60_000 - file.directory.data_offset) // file.directory.stride > 50
        assert f"step {file.steps + 1}" in done.stderr
        assert file.state == 2
    assert checksbf(folder / "crank.sbd.part").sound
    assert not (folder / "crank.sbd").exists()


def test_a_folder_that_cannot_be_used(folder):
    places = ["crank.dat", "/proc/nowhere", "crank.dat/x"]
    for done in many([["1", "crank", "--output-dir", place] for place in places], folder):
        assert done.status == 2
        assert done.err.startswith("error: cannot use the folder")
        assert len(done.err.splitlines()) == 1


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(folder):
    folder.chmod(0o500)
    done = spacar("1", "crank", folder=folder)
    folder.chmod(0o700)
    assert done.status == 2
    assert "Permission denied" in done.err


def test_wrong_calls(folder):
    (folder / "adir.dat").mkdir()
    cases = [
        (["5", "crank"], "modes 5 and 6 were experimental"),
        (["6", "crank"], "modes 5 and 6 were experimental"),
        (["12", "crank"], "mode 12 does not exist; the modes are 0, 1, 2, 3, 4, 7, 8, 9, 10"),
        (["1", "nofile"], "nofile.dat: no such file"),
        (["check", "nofile"], "nofile.dat: no such file"),
        (["1", "adir"], "adir.dat: it is a folder"),
        (["1", os.devnull], "- reads standard input"),
        (["check", "crank", "--expand", "--json"], "exclude each other"),
        (["1"], "Missing argument 'FILE'"),
        (["1", "crank", "crank2"], "unexpected extra argument"),
        (["1", "crank", "--wrong"], "No such option '--wrong'"),
        (["7", "crank", "--steps", "5"], "No such option '--steps'"),
        (["1", "crank", "--atol", "-1"], "Invalid value for '--atol'"),
        (["1", "crank", "--steps", "0"], "Invalid value for '--steps'"),
        (["1", "crank", "--integrator", "7"], "--integrator 7 does not exist; the methods are -1, 0, 130"),
        (["1", "massspring", "--time", "1"], "--time needs --steps"),
        (["chek", "crank"], "did you mean 'check'?"),
        (["crank"], "'crank' is neither a mode nor a command"),
        ([], "Missing command"),
        (["keywords", "XYZZY"], "there is no keyword XYZZY"),
        (["examples", "nothing"], "there is no example 'nothing'"),
        (["3", "robotinvlin"], "no mode 2 result to linearize along for robotinvlin.dat"),
    ]
    for (words, text), done in zip(cases, many([words for words, _ in cases], folder), strict=True):
        assert done.status == 2, words
        assert words_of(text) in words_of(done.err), (words, done.err)
        assert "error: " in done.err.splitlines()[-1]
        assert "Traceback" not in done.err
    assert {n for n in names(folder) if n.endswith((".sbd", ".part"))} == set()


def words_of(text):
    """Without punctuation: click 8.2 writes `No such option: --wrong`, later versions `No such option '--wrong'`."""
    return text.replace("'", "").replace(":", "")


def test_settings_of_the_deck_are_overridden_and_echoed(folder):
    given = {"--atol": "1e-8", "--rtol": "1e-7", "--integrator": "155", "--time": "0.002", "--steps": "4"}
    done = spacar("1", "crankfl", *(word for pair in given.items() for word in pair), "--json", folder=folder)
    assert done.status == 0, done.err
    report = json.loads(done.out)
    assert (report["mode"], report["status"], report["steps"], report["t"]) == (1, 0, 5, 0.002)
    assert report["results"] == ["crankfl.sbd"]
    log = (folder / "crankfl.log").read_text()
    for flag, value in given.items():
        line = next(line for line in log.splitlines() if line.strip().startswith(flag))
        assert float(line.split()[1]) == float(value)
    assert "INTEGRAT 155" in log
    assert "absolute 1e-08, relative 1e-07" in log
    with SbfFile(folder / "crankfl.sbd") as file:
        np.testing.assert_array_equal(np.ravel(file.get("t")), np.linspace(0, 0.002, 5))


def test_json_also_reports_a_failure(folder):
    (folder / "bad.dat").write_text("FIX 1\nEND END\n")
    report = json.loads(spacar("0", "bad", "--json", folder=folder).out)
    assert report["status"] == 2
    assert report["code"] == "input"


def test_parallel_runs_share_nothing(folder):
    """Four processes at once, on four files in one folder, give the bytes that a run alone gives."""
    for k in range(2):
        for name in ("crank", "slider"):
            shutil.copy(DATA / f"{name}.dat", folder / f"{name}_{k}.dat")
    together = [start(folder, "1", path.stem) for path in sorted(folder.glob("*_?.dat"))]
    assert [p.wait(timeout=120) for p in together] == [0] * 4
    for name in ("crank", "slider"):
        values = []
        for k in range(2):
            with SbfFile(folder / f"{name}_{k}.sbd") as file:
                assert file.complete
                values.append((file.get("x").tobytes(), file.get("fxt").tobytes()))
        assert values[0] == values[1]


def test_a_changed_input_is_noticed(folder):
    prepare(folder)
    with open(folder / "crank.dat", "a") as file:
        file.write("% changed\n")
    done = spacar("getfrsbf", "crank", "t", folder=folder)
    assert done.status == 0
    assert "warning: crank.sbd is older than crank.dat" in done.err


# What a process may cost: `--version` next to nothing, `spacar 1 crank` no heavy imports.
LOADED = """
import sys
from spacar_cli.main import main
main(sys.argv[1:])
print(*sys.modules, file=sys.stderr)
"""


def seconds(*words: str) -> float:
    begun = time.perf_counter()
    subprocess.run(words, check=True, capture_output=True, env=ENVIRONMENT)
    return time.perf_counter() - begun


def processor_seconds(*words: str, folder) -> float:
    """User and system time of a process: what else the machine does hardly changes it."""
    kept = {name: value for name, value in ENVIRONMENT.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before = os.times()
    subprocess.run(words, check=True, capture_output=True, env=kept, cwd=folder)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def modules(*words: str, folder) -> set[str]:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], cwd=folder, capture_output=True, text=True,
                          env=ENVIRONMENT, check=True)  # fmt: skip
    return set(done.stderr.split())


@pytest.mark.slow
def test_version_costs_at_most_one_and_a_half_imports_of_numpy():
    """A ratio of the best of five pairs measured in turn, so that a busy machine slows both alike."""
    pairs = [(seconds(str(SPACAR), "--version"), seconds(sys.executable, "-c", "import numpy")) for _ in range(5)]
    version, numpy = (min(times) for times in zip(*pairs, strict=True))
    assert version <= 1.5 * numpy, (version, numpy)


@pytest.mark.parametrize("word", ["--version", "--help"])
def test_help_imports_no_numpy(word, tmp_path):
    loaded = modules(word, folder=tmp_path)
    assert "click" in loaded
    assert not loaded & {"numpy", "scipy", "rich", "matplotlib", "spacar.frame", "spacar.deck"}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not tell the processor time of children")
@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_a_run_of_the_crank_costs_at_most_two_and_a_half_imports_of_numpy(tmp_path):
    """Reading, checking, computing and writing 101 steps; the best of four runs measured in turn, with bytecode."""
    shutil.copy(DATA / "crank.dat", tmp_path)
    programs = (str(SPACAR), "1", "crank"), (sys.executable, "-c", "import numpy")
    pairs = [[processor_seconds(*words, folder=tmp_path) for words in programs] for _ in range(4)]
    crank, numpy = (min(times) for times in zip(*pairs, strict=True))
    assert crank <= 2.5 * numpy, (crank, numpy)


def test_a_run_imports_nothing_heavy(tmp_path):
    shutil.copy(DATA / "crank.dat", tmp_path)
    loaded = modules("1", "crank", folder=tmp_path)
    assert (tmp_path / "crank.sbd").exists()
    # ours that a run seldom needs
    late = {"spacar.result", "spacar.expressions", "spacar.deck.section_block", "spacar.kinematics.diagnosis",
            "spacar.linearization", "spacar_cli.releasing"}  # fmt: skip
    assert not loaded & late, loaded & late
    heavy = {"matplotlib", "rich", "scipy.integrate", "scipy.linalg", "scipy.sparse", "sympy", "pandas", "asyncio"}
    assert not loaded & heavy, loaded & heavy
