"""LaTeX: the Z list and the equations I ṡ = f of a program."""

from spacar.symbolic.ordered import OrderedProgram
from spacar.symbolic.printing import latex, symbol_latex


def source(program: OrderedProgram, jacobian: bool, head: list[str]) -> str:
    """Definitions and entries, one aligned equation each, for \\input into a document with amsmath."""
    lines = [f"% {line}".rstrip() for line in head]
    rows = [(symbol_latex(s.name), latex(e)) for s, e in [*program.once, *program.step]]
    upper = iter(program.mass)
    for i in range(1, program.n + 1):
        rows += [(f"I_{{{i},{j}}}", latex(next(upper))) for j in range(i, program.n + 1)]
    rows += [(f"f_{{{i}}}", latex(e)) for i, e in enumerate(program.rhs, 1)]
    rows += [
        (rf"\dot{{{symbol_latex(q.name)}}}", latex(e)) for q, e in zip(program.coordinates, program.rates, strict=True)
    ]
    body = " \\\\\n".join(f"{left} &= {right}" for left, right in rows)
    return "\n".join([*lines, r"\begin{align*}", body, r"\end{align*}", ""])
