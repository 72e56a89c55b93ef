"""Builds the compiled engine when the package is built: C text -> one shared library in spacar/compiled.

Hatch calls `EngineHook` for wheels (`pip install .`) and editable installations (`pip install -e .`, `make crank`);
without a C compiler that knows GNU C the library is left out with one line, and the program works without it. The
library is loaded with ctypes, so that one wheel serves all versions of Python: its tag is py3-none-PLATFORM.

`python hatch_build.py` builds in place. CC names the compiler (default: cc, gcc or clang), CFLAGS, LDFLAGS and
ARCHFLAGS are added to its words.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HOME = Path(__file__).resolve().parent / "spacar" / "compiled"
FLAGS = ("-O3", "-fno-math-errno", "-fno-trapping-math", "-std=gnu11", "-fvisibility=hidden", "-Wno-psabi")
# name_LANES -> flags; the longest first
BUILDS = {"any_2": ("-DELEMENTS=any_elements",), "any_1": ()}
OF_X86_64 = {
    "v3_4": ("-march=x86-64-v3", "-DELEMENTS=v3_elements"), "v3_1": ("-march=x86-64-v3",),
    "v4_8": ("-march=x86-64-v4",),
}  # fmt: skip
GENERATED_FROM = (  # kernels.c, derivatives.c
    "definitions.py", "planar_definitions.py", "spatial_definitions.py", "element_parameters.py", "generate.py",
    "derivative_kernels.py",
)  # fmt: skip
LIBRARY = {"win32": "engine.dll", "darwin": "engine.dylib"}.get(sys.platform, "engine.so")


def source_digest(folder: Path = HOME) -> str:
    """Of the C text and what it is generated from, in the order of the names: `spacar.compiled.library` compares it."""
    text = hashlib.sha256()
    entering = (folder / name for name in GENERATED_FROM)
    for path in sorted((*folder.glob("*.c"), *filter(Path.is_file, entering))):
        text.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return text.hexdigest()[:16]


def build(target: Path) -> str | None:
    """Write the shared library; None, or why there is none. An old one goes away first."""
    target.unlink(missing_ok=True)
    words = compiler()
    if isinstance(words, str):
        return words
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        extra = [*shlex.split(os.environ.get("CFLAGS", "")), *shlex.split(os.environ.get("ARCHFLAGS", ""))]
        position = [] if sys.platform == "win32" else ["-fPIC"]
        levels = for_x86_64(words, extra)
        builds = BUILDS | (OF_X86_64 if levels else {})
        known = [f'-DSOURCE="{source_digest()}"', *(["-DLEVELS"] if levels else [])]
        calls = [[*words, *FLAGS, *position, *extra, *known, "levels.c"]]
        for build_name, level in builds.items():
            lanes = build_name.rsplit("_", 1)[1]
            defined = [f"-DBUILD={build_name}", f"-DLANES={lanes}"]
            calls.append([*words, *FLAGS, *position, *extra, *level, *defined, "engine.c"])
        objects = [folder / f"{k}.o" for k in range(len(calls))]
        compile_calls = [[*call, "-c", "-o", str(path)] for call, path in zip(calls, objects, strict=True)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            failures = [text for text in pool.map(run, compile_calls) if text]
        if failures:
            return f"the C compiler '{words[0]}' failed: {failures[0]}"
        made = folder / LIBRARY
        link = [*words, *extra, "-shared", *map(str, objects), "-o", str(made), "-lm"]
        failure = run([*link, *shlex.split(os.environ.get("LDFLAGS", ""))])
        if failure:
            return f"the C compiler '{words[0]}' could not link: {failure}"
        made.chmod(0o755)
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        shutil.copy(made, beside)
        beside.replace(target)  # in one step: a run may begin meanwhile
    return None


def compiler() -> list[str] | str:
    """The words of CC or of the first compiler that is there; else why there is none."""
    words = shlex.split(os.environ.get("CC", ""))
    for found in [words] if words else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(found[0]):
            return found
    return f"no C compiler ({words[0] if words else 'cc, gcc, clang'}) was found"


def for_x86_64(words: list[str], extra: list[str]) -> bool:
    """Whether the compiler makes code for x86-64 and knows its levels."""
    if platform.machine().lower() not in ("x86_64", "amd64") and "x86_64" not in extra:
        return False
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "a.c").write_text("#ifndef __x86_64__\n#error\n#endif\n")
        test = [*words, *extra, "-march=x86-64-v4", "-c", str(Path(name) / "a.c"), "-o", str(Path(name) / "a.o")]
        return run(test) is None


def run(words: list[str]) -> str | None:
    """None when a program ends well, else the end of what it says."""
    try:
        done = subprocess.run(words, cwd=HOME, capture_output=True, stdin=subprocess.DEVNULL, check=False)
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
    """The build hook of wheels."""

    def initialize(self, version: str, build_data: dict) -> None:  # type: ignore[type-arg]
        """Build the library; `version` is 'standard' or 'editable'."""
        if version == "editable":
            reason = build(HOME / LIBRARY)
        else:
            self.folder = tempfile.TemporaryDirectory()
            made = Path(self.folder.name) / LIBRARY
            reason = build(made)
            if reason is None:
                build_data["force_include"][str(made)] = f"spacar/compiled/{LIBRARY}"
        if reason is not None:
            self.app.display_warning(left_out(reason))
            return
        build_data["pure_python"] = False
        tag = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{tag}"


if __name__ == "__main__":
    why = build(HOME / LIBRARY)
    print(left_out(why) if why else f"spacar: built the compiled engine {HOME / LIBRARY}")
