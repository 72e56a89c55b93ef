"""Columns under forces that have no potential, as functions of the user (USERSIG), with results of the literature."""

from pathlib import Path

import spacar

HEAD = "import math\ndef push(t, ne, le, e, ep, nx, lnp, x, xp):\n"


def deck_of(folder: Path, text: str, body: str, mode: int = 7) -> spacar.Deck:
    """The model with the user function `push` of this body beside it."""
    (folder / "push.py").write_text(HEAD + "".join(f"    {line}\n" for line in body.splitlines()))
    (folder / "model.dat").write_text(text)
    return spacar.read_deck(folder / "model.dat", mode)


def ziegler(folder: Path, load: float, damping: float) -> spacar.Deck:
    """Two bars of length 1 with hinges of stiffness 1 and this damping, masses 2 and 1, and a force `load` at the tip
    along the second bar: H. Ziegler, Ing.-Arch. 20 (1952) 49-56; G. Herrmann, Appl. Mech. Rev. 20 (1967) 103-108."""
    text = f"""
PLRBEAM 1 1 2 3   PLRBEAM 2 3 4 5   PLTOR 3 6 2   PLTOR 4 2 4   X 1 0 0   X 3 1 0   X 5 2 0
FIX 1   FIX 6   DYNE 3 1   DYNE 4 1   END HALT
XM 3 2.   XM 5 1.   ESTIFF 3 1.   ESTIFF 4 1.   EDAMP 3 {damping}   EDAMP 4 {damping}   USERSIG push
END END
"""
    body = f"a = x[lnp[3, 0]]\nreturn t, [], [[5, 1, -{load} * math.cos(a)], [5, 2, -{load} * math.sin(a)]]"
    return deck_of(folder, text, body)


def column(n: int, ends: str, loads: str) -> str:
    """n beams of length 1/n along x with EI = 1 and mass 1 in all, rigid in tension; sections of the deck beside."""
    lines = [f"X 1 0 0\nFIX 1\n{ends}"]
    for k in range(n):
        a = 2 * k + 1
        lines += [f"PLBEAM {k + 1} {a} {a + 1} {a + 2} {a + 3}", f"X {a + 2} {(k + 1) / n} 0", f"DYNE {k + 1} 2 3"]
    lines += ["END HALT"]
    lines += [f"EM {k + 1} 1. \nESTIFF {k + 1} 0 1." for k in range(n)]
    return "\n".join([*lines, loads, "USERSIG push", "END END\n"])


def growth(deck: spacar.Deck) -> float:
    """The largest real part of the eigenvalues."""
    return float(spacar.run(7, deck)["eigval"][0][:, 0].max())


def critical(grows, low: float, high: float, n: int = 40) -> float:
    """The load between these at which `grows(load)` becomes true."""
    for _ in range(n):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return 0.5 * (low + high)
