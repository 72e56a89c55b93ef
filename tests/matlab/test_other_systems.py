"""What can be known of MATLAB and Windows without either: a linter for MATLAB's language, and the C file compiled.

The C file sees the documented prototypes of the C Matrix and MEX library only (mex.h of neither program).
"""

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest
from spacar_formats.mex import FOLDER

from .octave import need, run_octave

DOCUMENTED = """\
#include <stddef.h>
#include <stdbool.h>
typedef struct mxArray_tag mxArray;
mxArray *mxCreateString(const char *str);
mxArray *mxCreateDoubleScalar(double value);
bool mxIsEmpty(const mxArray *pm);
int mxGetNumberOfFields(const mxArray *pm);
const char *mxGetFieldNameByNumber(const mxArray *pm, int fieldnumber);
mxArray *mxGetFieldByNumber(const mxArray *pm, size_t index, int fieldnumber);
int mexPutVariable(const char *workspace, const char *varname, const mxArray *pm);
mxArray *mexGetVariable(const char *workspace, const char *varname);
void mexWarnMsgIdAndTxt(const char *warningid, const char *warningmsg, ...);
int mexCallMATLAB(int nlhs, mxArray *plhs[], int nrhs, mxArray *prhs[], const char *functionName);
void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[]);
"""
LIBRARY = """\
#include "mex.h"
mxArray *mxCreateString(const char *str) { (void) str; return NULL; }
mxArray *mxCreateDoubleScalar(double value) { (void) value; return NULL; }
bool mxIsEmpty(const mxArray *pm) { (void) pm; return true; }
int mxGetNumberOfFields(const mxArray *pm) { (void) pm; return 0; }
const char *mxGetFieldNameByNumber(const mxArray *pm, int k) { (void) pm; (void) k; return NULL; }
mxArray *mxGetFieldByNumber(const mxArray *pm, size_t i, int k) { (void) pm; (void) i; (void) k; return NULL; }
int mexPutVariable(const char *w, const char *name, const mxArray *pm) { (void) w; (void) name; (void) pm; return 0; }
mxArray *mexGetVariable(const char *w, const char *name) { (void) w; (void) name; return NULL; }
void mexWarnMsgIdAndTxt(const char *id, const char *text, ...) { (void) id; (void) text; }
int mexCallMATLAB(int nlhs, mxArray *plhs[], int nrhs, mxArray *prhs[], const char *functionName)
{ (void) nlhs; (void) plhs; (void) nrhs; (void) prhs; (void) functionName; return 0; }
"""
STRICT = ("-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic")
# The shims for Octave replace functions of Octave, which is what the linter warns of.
SHIMS = {"error.m", "warning.m"}


def test_a_linter_for_matlab_finds_nothing():
    linter = shutil.which("mh_lint") or shutil.which("mh_lint", path=sysconfig.get_path("scripts"))
    if linter is None:
        pytest.skip("mh_lint is not installed (pip install miss_hit)")
    done = subprocess.run(
        [linter, "--single", "--brief", str(FOLDER)], capture_output=True, text=True, check=False, timeout=120
    )
    lines = [line for line in done.stdout.splitlines() if not line.startswith("MISS_HIT Lint Summary")]
    found = [line for line in lines if Path(line.split(":")[0]).name not in SHIMS]
    assert not found, "\n".join(found)
    assert f"{len(list(FOLDER.rglob('*.m')))} file(s) analysed" in done.stdout


@pytest.mark.parametrize("path", sorted(FOLDER.rglob("*.m")), ids=lambda p: p.name)
def test_a_function_has_the_name_of_its_file(path):
    """MATLAB calls a function by the name of its file."""
    if path.stem == "Contents":
        return
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("function ")
    assert first.split("=")[-1].removeprefix("function ").split("(")[0].strip() == path.stem


@pytest.mark.parametrize("compiler", ["gcc", "x86_64-w64-mingw32-gcc"])
def test_the_c_file_needs_the_documented_interface_only(tmp_path, compiler):
    """As a library that exports mexFunction; the other functions come from the program that loads it."""
    need(compiler)
    (tmp_path / "mex.h").write_text(DOCUMENTED)
    (tmp_path / "library.c").write_text(LIBRARY)
    made = tmp_path / "spacar.mexw64"
    shared = ["-shared", "-fPIC"] if compiler == "gcc" else ["-shared"]
    words = [compiler, *STRICT, *shared, "-I.", str(FOLDER / "spacar.c"), "library.c", "-o", str(made)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert b"mexFunction" in made.read_bytes()


def test_names_of_windows(tmp_path):
    """Drives and shares are absolute wherever the functions run; a word goes through the shell as it stands."""
    need("octave-cli")
    for name in ("full_name.m", "quoted_word.m", "engine_messages.m"):
        shutil.copy(FOLDER / "private" / name, tmp_path)
    names = [r"C:\My Models\a.dat", "D:/models/a b", r"\\host\share\my model.dat", "/posix/a b"]
    script = "names = {" + ", ".join(f"'{name}'" for name in names) + "};\n"
    script += """
for k = 1:numel(names), out.full{k} = full_name(names{k}); out.words{k} = quoted_word(names{k}, true); end
out.relative = full_name('my model');
try, quoted_word('a"b', true); catch e, out.refused = e.identifier; end
out.last = quoted_word('C:\\my models\\', true);
[errors, warnings] = engine_messages(sprintf('error: one\\r\\n  more\\r\\nwarning: two\\r\\n'));
out.errors = errors; out.warnings = warnings;
"""
    octave = run_octave(script, tmp_path)
    assert list(octave["full"]) == names
    assert list(octave["words"]) == [f'"{name}"' for name in names]
    assert octave["relative"] == str(tmp_path / "my model")
    assert octave["refused"] == "spacar:name"
    assert octave["last"] == '"C:\\my models\\\\"'
    assert octave["errors"] == "one\n  more"
    assert octave["warnings"] == "two"
