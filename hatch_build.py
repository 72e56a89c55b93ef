"""Builds what is made when the package is built: text of elements by SymPy, the compiled engine, the stub of `Model`.

Hatch calls `EngineHook` for wheels (`pip install .`), editable installations (`pip install -e .`, `make crank`) and
source distributions. `python hatch_build.py` builds in place.

    spacar/compiled/generated/    kernels.c, derivatives.c, derived by SymPy from the definitions of the elements, with
                                  the digest of these: once, then whenever it differs. A source distribution has them,
                                  so that it is built without SymPy
    spacar/compiled/engine.so     C text -> one shared library, loaded with ctypes, so that one wheel serves all
                                  versions of Python: its tag is py3-none-PLATFORM
    spacar/deck/keyword_methods.pyi    the methods of `spacar.Model`, for editors and type checkers

Without a C compiler that knows GNU C nothing is derived, the library is left out with one line, and the program works
without it. CC names the compiler (default: cc, gcc or clang), CFLAGS, LDFLAGS and ARCHFLAGS are added to its words.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HOUSE = Path(__file__).resolve().parent
HOME = HOUSE / "spacar" / "compiled"
GENERATED = HOME / "generated"
TEXTS = ("kernels.c", "derivatives.c")
LEFT_OUT = "left_out.txt"  # why there is no library
STUB = HOUSE / "spacar" / "deck" / "keyword_methods.pyi"
SYMPY = "1.14.0"  # its common subexpressions decide the last digits
TO_DERIVE = (f"sympy=={SYMPY}", "numpy>=1.26")
FLAGS = ("-O3", "-fno-math-errno", "-fno-trapping-math", "-std=gnu11", "-fvisibility=hidden", "-Wno-psabi")
# name_LANES -> flags; the longest first
BUILDS = {"any_2": ("-DELEMENTS=any_elements",), "any_1": ()}
OF_X86_64 = {
    "v3_4": ("-march=x86-64-v3", "-DELEMENTS=v3_elements"), "v3_1": ("-march=x86-64-v3",),
    "v4_8": ("-march=x86-64-v4",),
}  # fmt: skip
# the texts of elements
GENERATED_FROM = (  # two modules for GUARD and LARGE_ANGLE, which enter the texts
    "compiled/generator/*.py", "elements/**/*_symbolic.py", "elements/family.py", "elements/spatial/beam.py",
)  # fmt: skip
LIBRARY = {"win32": "engine.dll", "darwin": "engine.dylib"}.get(sys.platform, "engine.so")


def source_digest(folder: Path = HOME) -> str:
    """Of the C text and what it is generated from, in the order of the names: `spacar.compiled.library` compares it."""
    return digest((*sorted(folder.glob("*.[ch]")), *generating(folder)))


def generating(folder: Path = HOME) -> list[Path]:
    """What the texts of elements are derived from."""
    return [path for pattern in GENERATED_FROM for path in sorted(folder.parent.glob(pattern))]


def digest(paths: Iterable[Path], start: str = "") -> str:
    text = hashlib.sha256(start.encode())
    for path in paths:
        text.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return text.hexdigest()[:16]


def head() -> str:
    """First line of the texts of elements: what they are derived from."""
    made_of = digest(generating(), SYMPY)
    return f"/* derived by spacar.compiled.generator.element_texts from {made_of}; do not edit */\n"


def is_derived() -> bool:
    """Whether the texts are there, of today's definitions."""
    first = head().encode()
    try:
        return all((GENERATED / name).read_bytes().startswith(first) for name in TEXTS)
    except OSError:
        return False


def derive() -> str | None:
    """Write the texts of elements where they are missing or of other definitions; None, or why there are none."""
    if is_derived():
        return None
    with tempfile.TemporaryDirectory() as name:
        failure = run([sys.executable, "-c", f"import numpy, sympy; assert sympy.__version__ == '{SYMPY}'"], HOUSE)
        if failure is not None:
            return f"the functions of the elements are derived with SymPy {SYMPY}, which is not here"
        failure = run([sys.executable, "-m", "spacar.compiled.generator.element_texts", name], HOUSE)
        if failure is not None:
            return f"the functions of the elements could not be derived: {failure}"
        try:
            GENERATED.mkdir(exist_ok=True)
            for text in TEXTS:
                made = GENERATED / f".{text}.{os.getpid()}"
                made.write_bytes(head().encode() + (Path(name) / text).read_bytes())
                made.replace(GENERATED / text)  # in one step: another build may read it
        except OSError as error:
            return f"the functions of the elements cannot be stored: {error}"
    return None


def write_stub() -> None:
    """The methods of `spacar.Model` as they are declared; without them programs run as well."""
    with tempfile.TemporaryDirectory() as name, contextlib.suppress(OSError):
        made = Path(name) / STUB.name
        failure = run([sys.executable, "-m", "spacar.deck.model_methods", str(made)], HOUSE)
        if failure is None and not (STUB.is_file() and STUB.read_bytes() == made.read_bytes()):
            shutil.copyfile(made, STUB)


def build(target: Path) -> str | None:
    """Write the shared library; None, or why there is none, which stands in its place. An old one goes away first."""
    note = target.with_name(LEFT_OUT)
    target.unlink(missing_ok=True)
    note.unlink(missing_ok=True)
    try:
        reason = compiled(target)
    except (OSError, ValueError) as error:
        reason = str(error)
    if reason is not None:
        reason = " ".join(reason.split())  # one line of what a compiler says in many
        note.write_text(reason, "utf-8")
    return reason


def compiled(target: Path) -> str | None:
    """The same, without a place for the reason."""
    words = compiler()
    if isinstance(words, str):
        return words
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        extra = [*words_of("CFLAGS"), *words_of("ARCHFLAGS")]
        failure = tried(words, extra, folder) or derive()
        if failure:
            return failure
        position = [] if sys.platform == "win32" else ["-fPIC"]
        levels = for_x86_64(words, extra)
        builds = BUILDS | (OF_X86_64 if levels else {})
        known = [f'-DSOURCE="{source_digest()}"', *(["-DLEVELS"] if levels else [])]
        calls = [[*words, *FLAGS, *position, *extra, *known, "cpu_dispatch.c"]]
        for build_name, level in builds.items():
            lanes = build_name.rsplit("_", 1)[1]
            defined = [f"-DBUILD={build_name}", f"-DLANES={lanes}", f"-I{GENERATED.name}"]
            calls.append([*words, *FLAGS, *position, *extra, *level, *defined, "engine.c"])
        objects = [folder / f"{k}.o" for k in range(len(calls))]
        compile_calls = [[*call, "-c", "-o", str(path)] for call, path in zip(calls, objects, strict=True)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            failures = [text for text in pool.map(run, compile_calls) if text]
        if failures:
            return f"the C compiler '{words[0]}' failed: {failures[0]}"
        made = folder / LIBRARY
        link = [*words, *extra, "-shared", *map(str, objects), "-o", str(made), "-lm"]
        failure = run([*link, *words_of("LDFLAGS")])
        if failure or not made.is_file():
            return f"the C compiler '{words[0]}' could not link: {failure or 'it wrote nothing'}"
        if "ARCHFLAGS" not in os.environ:  # for another processor otherwise
            failure = run([sys.executable, "-I", "-c", "import ctypes, sys; ctypes.CDLL(sys.argv[1])", str(made)])
        if failure:
            return f"the C compiler '{words[0]}' wrote a library that cannot be loaded: {failure}"
        made.chmod(0o755)
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        shutil.copy(made, beside)
        beside.replace(target)  # in one step: a run may begin meanwhile
    return None


def compiler() -> list[str] | str:
    """The words of CC or of the first compiler that is there; else why there is none."""
    try:
        words = words_of("CC")
    except ValueError as error:
        return str(error)
    for found in [words] if words else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(found[0]):
            return found
    return f"no C compiler ({words[0] if words else 'cc, gcc, clang'}) was found"


def words_of(variable: str) -> list[str]:
    """Of an environment variable. Raises ValueError where quotes do not match."""
    try:
        return shlex.split(os.environ.get(variable, ""))
    except ValueError as error:
        raise ValueError(f"the environment variable {variable} cannot be read: {error}") from None


def tried(words: list[str], extra: list[str], folder: Path) -> str | None:
    """None when the compiler makes an object of GNU C, else what is wrong: before anything is derived for it."""
    text, made = folder / "trial.c", folder / "trial.o"
    text.write_text("typedef double real __attribute__((vector_size(16)));\nreal twice(real x) { return x + x; }\n")
    failure = run([*words, *extra, "-c", str(text), "-o", str(made)])
    if failure is None and not made.is_file():
        failure = "it wrote nothing"
    return failure and f"the C compiler '{words[0]}' failed: {failure}"


def for_x86_64(words: list[str], extra: list[str]) -> bool:
    """Whether the compiler makes code for x86-64 and knows its levels."""
    if platform.machine().lower() not in ("x86_64", "amd64") and "x86_64" not in extra:
        return False
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "a.c").write_text("#ifndef __x86_64__\n#error\n#endif\n")
        test = [*words, *extra, "-march=x86-64-v4", "-c", str(Path(name) / "a.c"), "-o", str(Path(name) / "a.o")]
        return run(test) is None


def run(words: list[str], folder: Path = HOME) -> str | None:
    """None when a program ends well, else the end of what it says. Python finds this package first."""
    path = os.pathsep.join(filter(None, (str(HOUSE), os.environ.get("PYTHONPATH"))))
    environment = {**os.environ, "PYTHONPATH": path}
    try:
        done = subprocess.run(
            words, cwd=folder, env=environment, capture_output=True, stdin=subprocess.DEVNULL, check=False
        )
    except OSError as error:
        return f"{words[0]}: {error.strerror or error}"
    if not done.returncode:
        return None
    return done.stderr.decode("utf-8", "replace").strip()[-400:] or f"it ended with status {done.returncode}"


def left_out(reason: str) -> str:
    """The one line."""
    return f"spacar: built without the compiled engine ({reason}): runs take longer, results are the same"


try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # `python hatch_build.py` needs nothing but Python
    BuildHookInterface = object  # type: ignore[assignment,misc]


class EngineHook(BuildHookInterface):  # type: ignore[type-arg]
    """The build hook of all packages."""

    def dependencies(self) -> list[str]:
        """What must be there to derive the texts of elements, where they have to be."""
        needed = self.target_name == "sdist" or not isinstance(compiler(), str)
        return list(TO_DERIVE) if needed and not is_derived() else []

    def initialize(self, version: str, build_data: dict) -> None:  # type: ignore[type-arg]
        """Make what the package has beside the files of git; `version` is 'standard' or 'editable'."""
        write_stub()
        if self.target_name == "sdist":
            reason = derive()
            if reason is not None:
                raise RuntimeError(f"a source distribution has the functions of the elements: {reason}")
            return
        if version == "editable":
            reason = build(HOME / LIBRARY)
        else:
            self.folder = tempfile.TemporaryDirectory()
            made = Path(self.folder.name) / LIBRARY
            reason = build(made)
            packed = made if reason is None else made.with_name(LEFT_OUT)
            build_data["force_include"][str(packed)] = f"spacar/compiled/{packed.name}"
        if reason is not None:
            self.app.display_warning(left_out(reason))
            return
        build_data["pure_python"] = False
        tag = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{tag}"


if __name__ == "__main__":
    write_stub()
    why = build(HOME / LIBRARY)
    print(left_out(why) if why else f"spacar: built the compiled engine {HOME / LIBRARY}")
