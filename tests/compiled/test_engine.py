"""How the engine is built, loaded, chosen and switched off; what log and JSON say of it."""

import io
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from spacar_cli.environment import Environment
from spacar_cli.main import main

import spacar
from spacar.compiled import library
from spacar.compiled.interface import constants
from spacar.dynamics import loaded_mechanism
from spacar.elements import definitions
from spacar.errors import UsageError
from tests.docs.documents import module_of

HOUSE = Path(__file__).parents[2]
DATA = HOUSE / "data"
here = pytest.mark.skipif(library.unavailable() is not None, reason=str(library.unavailable()))


@pytest.fixture(scope="module")
def recipe():
    """The build hook as a module."""
    return module_of(HOUSE / "hatch_build.py")


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """The package's folder is another one, without a library."""
    home = tmp_path / "compiled"
    home.mkdir()
    monkeypatch.setattr(library, "HERE", home)
    monkeypatch.delenv(library.GENERAL, raising=False)
    caches = library._loaded, library.engine
    for cached in caches:
        cached.cache_clear()
    yield home
    for cached in caches:
        cached.cache_clear()


def test_there_is_an_engine_where_there_is_a_compiler():
    """Else every test below would be skipped and nobody would notice."""
    if shutil.which(os.environ.get("CC", "cc")):
        assert library.unavailable() is None


@here
def test_the_engine_is_that_of_the_text(recipe):
    assert library.source_digest() == recipe.source_digest() == library._loaded().spacar_source().decode()


@here
def test_the_level_is_one_of_the_processor():
    flags = Path("/proc/cpuinfo")
    known = flags.read_text() if flags.exists() else ""
    assert (library.level() == "x86-64-v4") <= ("avx512f" in known)
    assert (library.level() == "x86-64-v3") <= ("avx2" in known)
    assert library.lanes_of_processor() in (2, 4, 8)
    assert library.engine(library.lanes_of_processor()).lanes == library.lanes_of_processor()


def test_without_a_compiler_the_build_says_one_line_and_does_not_fail(tmp_path):
    environment = {**os.environ, "CC": "no-such-compiler"}
    house = tmp_path / "house"
    (house / "spacar" / "compiled").mkdir(parents=True)
    shutil.copy(HOUSE / "hatch_build.py", house)
    words = [sys.executable, "hatch_build.py"]
    done = subprocess.run(words, cwd=house, env=environment, capture_output=True, text=True)
    assert done.returncode == 0
    assert done.stdout == (
        "spacar: built without the compiled engine (no C compiler (no-such-compiler) was found):"
        " runs take longer, results are the same\n"
    )


def test_a_compiler_that_fails_is_said_and_an_old_library_goes(tmp_path, monkeypatch, recipe):
    script = tmp_path / "broken"
    script.write_text("#!/bin/sh\necho out of >&2; echo licences >&2; exit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    (tmp_path / "engine.so").write_text("old")
    assert "failed: out of licences" in recipe.build(tmp_path / "engine.so")
    assert not (tmp_path / "engine.so").exists()


@pytest.mark.parametrize(
    ("variable", "words", "sentence"),
    [
        ("CC", "true", "the C compiler 'true' failed: it wrote nothing"),
        ("CC", f"{sys.executable} -c 1/0", "failed: "),
        ("CC", "cc 'open", "the environment variable CC cannot be read: No closing quotation"),
        ("CFLAGS", "--no-such-flag", "the C compiler 'cc' failed"),
        ("CFLAGS", '"', "the environment variable CFLAGS cannot be read"),
    ],
)
def test_an_absurd_compiler_is_a_sentence_before_anything_is_derived(
    tmp_path, monkeypatch, recipe, variable, words, sentence
):
    monkeypatch.setenv(variable, words)
    monkeypatch.setattr(recipe, "derive", lambda: pytest.fail("derived"))
    if variable == "CFLAGS" and shutil.which("cc") is None:
        pytest.skip("no cc")
    assert sentence in recipe.build(tmp_path / "engine.so")
    assert sentence in (tmp_path / "left_out.txt").read_text()


def test_the_reason_of_the_installation_is_said_by_every_run(elsewhere):
    (elsewhere / "left_out.txt").write_text("the C compiler 'true' failed: it wrote nothing")
    assert "left out when spacar was installed (the C compiler 'true' failed" in library.unavailable()


@here
def test_what_is_derived_is_not_derived_again(recipe, monkeypatch):
    monkeypatch.setattr(recipe, "run", lambda *words: pytest.fail("derived"))
    assert recipe.is_derived()
    assert recipe.derive() is None


@here
def test_other_definitions_or_another_sympy_derive_again(tmp_path, recipe, monkeypatch):
    """Here without SymPy, so that it is one sentence."""
    monkeypatch.setattr(recipe, "SYMPY", "0.1")
    assert not recipe.is_derived()
    assert recipe.derive() == "the functions of the elements are derived with SymPy 0.1, which is not here"


@here
def test_the_sympy_that_is_here_is_found(tmp_path, recipe, monkeypatch):
    """The folder of the engine has modules with names of the standard library."""
    sympy = pytest.importorskip("sympy")
    monkeypatch.setattr(recipe, "GENERATED", tmp_path)
    monkeypatch.setattr(recipe, "SYMPY", sympy.__version__)
    real = recipe.run
    monkeypatch.setattr(recipe, "run", lambda words, folder: "stopped" if "-m" in words else real(words, folder))
    assert recipe.derive() == "the functions of the elements could not be derived: stopped"


def test_the_core_says_which_steps_are_inspected_as_the_engine_does():
    names = "NEVER", "AT_DETERMINANTS", "AT_VELOCITIES", "ALWAYS"
    assert constants(*(f"LOOK_{name}" for name in names)) == tuple(getattr(loaded_mechanism, name) for name in names)


@here
def test_the_derived_text_is_that_of_the_definitions():
    """Of one short type; the digest in the first line stands for all."""
    pytest.importorskip("sympy")
    from spacar.compiled.generator.element_texts import FILES, functions_of

    [k] = [k for k, definition in enumerate(definitions()) if definition.name == "pltruss"]
    for file in FILES:
        text = (HOUSE / "spacar" / "compiled" / "generated" / file).read_text()
        assert all(function in text for function in functions_of((file, k)))


@here
@pytest.mark.slow
@pytest.mark.skipif(shutil.which("clang") is None, reason="no clang")
def test_clang_builds_it_too(tmp_path, monkeypatch, recipe):
    monkeypatch.setenv("CC", "clang")
    assert recipe.build(tmp_path / "engine.so") is None


def test_a_missing_library_is_a_reason(elsewhere):
    assert "left out" in library.unavailable()
    with pytest.raises(UsageError, match="left out"):
        library.engine()
    run = spacar.frames(1, DATA / "crank.dat")
    assert len(list(run)) == 101
    assert run.header["engine"] == ("general", library.unavailable())


def test_a_broken_library_is_a_reason(elsewhere):
    (elsewhere / library.NAME).write_bytes(b"garbage")
    assert "cannot be loaded" in library.unavailable()


@here
def test_a_library_of_another_text_is_not_used(elsewhere):
    shutil.copy(HOUSE / "spacar" / "compiled" / library.NAME, elsewhere)
    library._loaded.cache_clear()
    assert library.unavailable() is None  # an installation: no text beside it
    library._loaded.cache_clear()
    (elsewhere / "engine.c").write_text("/* changed */")
    assert "another C text" in library.unavailable()


@here
def test_a_library_of_other_element_definitions_is_not_used(elsewhere):
    """A row that was added, and not built: a run says so and takes the general path."""
    home = HOUSE / "spacar"
    for pattern in ("compiled/*.[ch]", f"compiled/{library.NAME}", *library.GENERATED_FROM):
        for path in home.glob(pattern):
            copy = elsewhere.parent / path.relative_to(home)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)
    library._loaded.cache_clear()
    assert library.unavailable() is None
    library._loaded.cache_clear()
    (elsewhere.parent / "elements" / "planar" / "plcam_symbolic.py").write_text("DEFINITIONS = ()\n")
    run = spacar.frames(1, DATA / "crank.dat")
    assert len(list(run)) == 101
    assert "other element definitions" in run.header["engine"][1]


@here
def test_log_and_json_say_which_engine_and_why(tmp_path, monkeypatch):
    program = ["1", str(DATA / "crank.dat"), "--output-dir", str(tmp_path), "--json", "--steps", "2"]

    def engine(*words, **variables):
        out, err = io.StringIO(), io.StringIO()
        monkeypatch.delenv(library.GENERAL, raising=False)
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        assert main([*program, *words], Environment(io.StringIO(), out, err, os.environ)) == 0, err.getvalue()
        said = json.loads(out.getvalue())
        assert f"Engine: {said['engine']} ({said['engine_note']})" in (tmp_path / "crank.log").read_text()
        return said["engine"], said["engine_note"]

    assert engine() == engine("--compiled") == ("compiled", library.level())
    assert engine("--general") == ("general", "--general or compiled=False asks for it")
    asked = ("general", "the environment variable SPACAR_GENERAL asks for it")
    assert engine(SPACAR_GENERAL="1") == engine("--compiled", SPACAR_GENERAL="1") == asked
    assert engine(SPACAR_GENERAL="0")[0] == engine(SPACAR_GENERAL="")[0] == "compiled"
