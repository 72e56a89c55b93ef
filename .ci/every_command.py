"""Every mode and every command of an installation once, in an empty folder: `python every_command.py`.

Run by the Python of the environment that is tried (`.ci/installed`), outside of the repository. Status 1 with the words
that failed; a command that asks for an extra which is not installed says so in a sentence and has not failed.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

FOLLOWED = """
examples
examples all
help
help 7
help studies
keywords ESTIFF
check crank -v
0 crank
1 crank
1 robotflexsim
2 robotinv
3 robotinvlin
2 robotflexinv
3 robotflexinvlin
4 crankfl
7 lateral4
8 column2
9 lever
10 plbeam5buck
sweep crank --set XM.6=0.03:0.04:2 --result x[6,1]@end -o rows.csv
sensitivity plbeam5buck -p ESTIFF.1[EI] --of lmult[1]
trade crank --target 1e-2
draw crank -o draw.png
spadraw crank -o spadraw.svg
visual lateral4 -o visual.png
spavisual lateral4 -o spavisual.png
plot crank x[6,1] -o plot.png
view crank -o view.html
report crank -o report.html
checksbf crank.sbd
getfrsbf crank.sbd TIME 1:3
repinsbf crank.sbd NDDOF 0
loadsbd crank -o crank.npz
loadsbm lateral4 -o lateral4.mat
combsbd crank.sbd crank.sbd twice.sbd
eigen lateral4
bode lever -o bode.png
stress robotflexsim
compliance lateral4 3
flexure leafguide --move 7x=0.001
getss lever
sim robotopen
spasim robotopen
fmu robotsim
ltv robotinvlin
mrltv robotflexinvlin 2
spacntrl robotinvlin --omega 10
matlab
symbolic check slider_crank.toml
completion bash
edit --help
"""


def main() -> int:
    spacar = Path(sys.executable).with_name("spacar.exe" if os.name == "nt" else "spacar")
    from spacar_cli.command_table import COMMANDS, OF_THE_MANUAL

    from spacar.modes import MODES

    missing = {*COMMANDS, *OF_THE_MANUAL, *map(str, MODES)} - {line.split()[0] for line in FOLLOWED.strip().split("\n")}
    failed = [f"{name}: not tried" for name in sorted(missing)]
    with tempfile.TemporaryDirectory() as name:
        for line in filter(None, FOLLOWED.splitlines()):
            done = subprocess.run([spacar, *line.split()], cwd=name, capture_output=True, text=True, timeout=600)
            extra = done.returncode == 2 and re.search(r"pip install ['\"]spacar\[", done.stderr)
            if (done.returncode and not extra) or "Traceback" in done.stderr:
                failed.append(f"spacar {line}: status {done.returncode}: {(done.stderr or done.stdout).strip()[-400:]}")
    print(*failed, sep="\n", end="\n" if failed else "")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
