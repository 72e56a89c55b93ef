"""Names that the pages document, one a line: `python -m tests.docs.documented [BEFORE]`.

Keywords, modes, options, codes of messages, names in back quotes (file variables, functions, settings), formulas,
sections and notes of the reference. With a list of an earlier revision only what is not documented any more is printed.
The page of keywords is made from the table and not counted.
"""

import re
import sys
from pathlib import Path

from spacar.deck.keyword_table import KEYWORDS

from .citations import DOCS, HOUSE, REFERENCE, numbered

WORD = re.compile(r"`([A-Za-z]\w*)[^`]*`")
GENERATED = "keywords.md"


def documented() -> set[str]:
    pages = [HOUSE / "README.md", HOUSE / "CONTRIBUTING.md", *(p for p in DOCS.rglob("*.md") if p.name != GENERATED)]
    text = "\n".join(p.read_text(encoding="utf-8") for p in pages)
    shown = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    names = {f"keyword {name}" for name, _ in KEYWORDS if re.search(rf"\b{name}\b", text)}
    names |= {f"mode {n}" for n in re.findall(r"\bspacar (\d+) ", text)}
    names |= {f"command {n}" for n in re.findall(r"\bspacar ([a-z]{2,})\b", text)}
    names |= {f"option {n}" for n in re.findall(r"(?<![\w-])--[a-z][a-z-]+", text)}
    names |= {f"code {n}" for n in re.findall(r"\[([a-z]+\.[a-z-]+)\]", text)}
    names |= {f"name {n}" for n in WORD.findall(shown) if not re.search(rf"\b{n}\.(?:py|c|md|h)\b", text)}
    return names | {f"{p.stem} {n}" for p in REFERENCE.glob("*.md") for n in numbered(p)}


if __name__ == "__main__":
    now = documented()
    before = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines() if len(sys.argv) > 1 else None
    print("\n".join(sorted(now if before is None else set(before) - now)))
