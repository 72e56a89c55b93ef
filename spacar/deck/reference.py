"""The reference page of the input language, made from the keyword table.

`python -m spacar.deck.reference` prints the page that is kept as docs/keywords.md.
"""

from spacar.deck.findings import alternatives
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS
from spacar.deck.table_types import BlockKind, Keyword, Parameter, Variant

_HEADINGS = {
    BlockKind.KINEMATICS: "Kinematics block (first block, every mode)",
    BlockKind.DYNAMICS: "Dynamics block (second block, every mode but 0)",
    BlockKind.TRAJECTORY: "Third block, modes 2 and 3: trajectories, nominal inputs and reference outputs",
    BlockKind.LINEARIZATION: "Third block, modes 4 and 9: inputs and outputs of the linearization",
    BlockKind.SIMULATION: "Third block, controlled simulation: inputs and outputs",
}


def _listed(variant: Variant) -> tuple[Parameter, ...]:
    """The parameters of a variant, a repeated last one shown once."""
    shown = list(variant.parameters)
    while len(shown) > 2 and shown[-1] == shown[-2]:
        shown.pop()
    return tuple(shown)


def rules(keyword: Keyword) -> list[str]:
    """Sentences about a keyword beyond its positions: notes, classes, how often it may be given."""
    found = list(keyword.notes)
    if keyword.classes:
        found.append(f"Only for a {' or '.join(keyword.classes)} coordinate or deformation.")
    if keyword.unique == 0:
        found.append("At most once in a file.")
    elif keyword.unique is not None:
        found.append(
            "At most once for the same node or element" + (", coordinate or mode." if keyword.unique != 1 else ".")
        )
    return found


def markdown() -> str:
    lines = [
        "# Keywords of the input file",
        "",
        "This page is made from the keyword table by `python -m spacar.deck.reference`; do not edit it. The same",
        "table is printed by `spacar keywords` and `spacar keywords NAME`.",
        "",
        _RULES,
        "",
        "## Element types",
        "",
        "| keyword | element | nodes | deformation modes | code |",
        "|---|---|---|---|---|",
    ]
    for t in ELEMENT_TYPES.values():
        modes = ", ".join(f"{i} {name} [{unit}]" for i, (name, unit) in enumerate(t.modes, 1))
        lines.append(f"| {t.keyword} | {t.title} | {', '.join(t.node_names)} | {modes} | {t.code} |")
    for block, heading in _HEADINGS.items():
        lines += ["", f"## {heading}"]
        for keyword in KEYWORDS.values():
            lines += _section(keyword) if keyword.block is block else []
    return "\n".join(lines) + "\n"


_RULES = """\
A statement is a keyword followed by its arguments, separated by blanks, tabs or line ends; the next keyword ends
it. Everything after `%`, `#` or `;` on a line is a comment. Case does not matter. Reals may have an exponent with
`e` or `d`; an integral real such as `3.` is accepted as an integer. Trailing arguments with a default may be left
out. A block ends with `END HALT` when another one follows and with `END END` at the end of the input; a section
`VISUALIZATION` for drawing may follow. Angles are in radians; the units shown are SI, any consistent set will do."""


def _section(keyword: Keyword) -> list[str]:
    lines = ["", f"### {keyword.name}", "", f"{keyword.help[0].upper()}{keyword.help[1:]}."]
    if keyword.aliases:
        lines[-1] += f" Older name: {', '.join(keyword.aliases)}."
    for variant in keyword.variants:
        plural = "" if variant.counts == (1,) else "s"
        heading = f"{' '.join(variant.scope) or 'all models'} ({alternatives(variant.counts)} argument{plural})"
        lines += ["", f"*{heading}*", "", "| position | meaning | unit | default |", "|---|---|---|---|"]
        for i, p in enumerate(_listed(variant), 1):
            last = i == len(_listed(variant)) and len(_listed(variant)) < len(variant.parameters)
            default = "" if p.default is None else f"{p.default:g}"
            lines.append(f"| {i}{' ...' if last else ''} | {p.meaning} | {p.unit} | {default} |")
    more = rules(keyword)
    if more:
        lines += ["", *(f"* {rule}" for rule in more)]
    return lines


if __name__ == "__main__":
    print(markdown(), end="")
