"""Raw statements to typed statements: the variant that applies, the number of arguments, their types, references.

Every node, element, coordinate and mode number that the table declares as such is looked up here. Plain lines about
which nothing needs a message are read by `plain_forms`; every other statement is read here word by word.
"""

from __future__ import annotations

from spacar.deck.findings import Findings, alternatives, ordinal
from spacar.deck.length_unit import length_power
from spacar.deck.lexer import LARGEST_NUMBER, LARGEST_REAL, SMALLEST_REAL, Word, integer_of, is_in_range, number_of
from spacar.deck.outline import Outline
from spacar.deck.raw_statements import NUMBERED_PARTS, Raw
from spacar.deck.statement import Statement, Value
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import Keyword, Parameter, Variant

_NAMES = ("name of a section", "name of a material", "shape", "unit")
_UNUSED_NODES_ALLOWED = ("X", "FIX")
_TOLERANCES = ("ERROR", "ITERSTEP")
_COEFFICIENTS = ("ESTIFF", "EDAMP", "EM", "ESIG", "DELESIG")  # generators write as many as the largest type has


def read_statement(raw: Raw, keyword: Keyword, outline: Outline, findings: Findings) -> Statement | None:
    """Type and check the words of one statement; None when an error makes it useless."""
    subject = keyword.subject
    space, role, kind = outline.space, "", ""
    if raw.keyword in ELEMENT_TYPES:
        space, subject = "", None
    if subject is not None and subject < len(raw.words):
        number = integer_of(raw.words[subject].text)
        if number is not None and keyword.of_element:
            kind = outline.types[number].keyword if number in outline.types else ""
        elif number is not None:
            role = outline.roles.get(number, "")
    variants = [v for v in keyword.variants if v.fits(space, role, kind)]
    if not variants:
        _refuse(raw, keyword, space, role, kind, findings)
        return None
    if role and subject is not None and (wanted := variants[0].parameters[subject].of).endswith(" node"):
        role = wanted.removesuffix(" node")  # sentences about the other arguments tell of the node that is wanted
    variant, words = _choose(raw, variants, space, findings)
    values = _values(raw, words, variant, kind, role, findings)
    if values is not None and outline.metre != 1.0:
        values = _in_metres(raw, values, variant, role, outline)
    if values is None or not _count(raw, words, variants, variant, kind, role, findings):
        return None
    places = tuple([(w.line, w.column) for w in words])
    statement = Statement(raw.keyword, values, raw.block, raw.line, places)
    return statement if _references(statement, variant, outline, findings) else None


def _subject(raw: Raw) -> str:
    return f"{raw.keyword} {raw.words[0].text}" if raw.words else raw.keyword


def _refuse(raw: Raw, keyword: Keyword, space: str, role: str, kind: str, findings: Findings) -> None:
    """No variant of the keyword is for this kind of model, node or element."""
    if kind and any(v.types for v in keyword.variants):
        allowed = ", ".join(dict.fromkeys(t for v in keyword.variants for t in v.types))
        number = raw.words[keyword.subject or 0].text
        text = f"element {number} is a {kind} ({ELEMENT_TYPES[kind].title}); {raw.keyword} is for {allowed}"
    elif role and any(v.role for v in keyword.variants):
        text = f"{raw.keyword} does not apply to the {_owner('', role, space)} {raw.words[0].text}"
    else:
        text = f"{raw.keyword} does not apply to a {space} model"
    findings.add("error", raw.line, _subject(raw), text, "not-applicable")


def _choose(raw: Raw, variants: list[Variant], space: str, findings: Findings) -> tuple[Variant, list[Word]]:
    """The variant that takes this number of words; a surplus zero third component of a planar model and surplus
    zero coefficients of an element are dropped."""
    count = len(raw.words)
    for variant in variants:
        if count in variant.counts:
            return variant, raw.words
    first = max(variants, key=lambda v: v.counts[-1])
    if space == "planar" and first.components and count == first.counts[-1] + 1:
        surplus = raw.words[-1]
        if number_of(surplus.text) == 0.0:
            text = f"third component '{surplus.text}' of a planar model is ignored"
            findings.add("warning", surplus.line, _subject(raw), text, "third-component")
            return first, raw.words[:-1]
    most = first.counts[-1]
    if raw.keyword in _COEFFICIENTS and count > most and all(number_of(w.text) == 0.0 for w in raw.words[most:]):
        text = f"{count - most} surplus zero{'s' * (count - most > 1)} behind the {most} arguments ignored"
        findings.add("information", raw.words[most].line, _subject(raw), text, "surplus-zeros")
        return first, raw.words[:most]
    return first, raw.words


def _values(
    raw: Raw, words: list[Word], variant: Variant, kind: str, role: str, findings: Findings
) -> tuple[Value, ...] | None:
    """Typed values; every word that does not fit its position is reported."""
    values: list[Value] = []
    good = True
    for i, word in enumerate(words[: len(variant.parameters)]):
        parameter = variant.parameters[i]
        value: Value | None
        if parameter.kind == "real":
            value = number_of(word.text)
            problem = "is not a number"
            if value is not None and abs(value) == float("inf"):
                value, problem = None, "is too large for a number"
            elif value is not None and _squared(parameter, raw) and not is_in_range(value, word.text):
                size = "large" if abs(value) > 1.0 else "small"
                limits = f"zero, or a size between {SMALLEST_REAL:g} and {LARGEST_REAL:g}"
                value, problem = None, f"is too {size} ({limits})"
        elif parameter.kind == "integer":
            value = integer_of(word.text)
            problem = "is not a number" if number_of(word.text) is None else "is not an integer"
        else:
            value = word.text if word.text.isidentifier() else None
            problem = "is not a name" if parameter.meaning.startswith(_NAMES) else "is not a name of a function"
        if value is None:
            good = False
            what = _expected(parameter, kind, role, raw)
            text = f"{ordinal(i)} argument '{word.text}' {problem}; expected {what}"
            findings.add("error", word.line, _subject(raw), text, "value")
        else:
            values.append(value)
    return tuple(values) if good else None


def _in_metres(raw: Raw, values: tuple[Value, ...], variant: Variant, role: str, outline: Outline) -> tuple[Value, ...]:
    """The values of a file with another unit of length, in SI."""
    of = [p.of for p in variant.parameters]
    kinds = [outline.types[int(v)] for v, o in zip(values, of, strict=False) if o == "element" and v in outline.types]
    out = list(values)
    for place, value in enumerate(values):
        if isinstance(value, float):
            parameter = variant.parameters[place]
            out[place] = value * outline.metre ** length_power(raw.keyword, place, parameter, values, kinds, role)
    return tuple(out)


def _squared(parameter: Parameter, raw: Raw) -> bool:
    """Whether a value belongs to the geometry or the motion, so that its square must be in range as well. Forces,
    masses, stiffnesses and tolerances may have any size."""
    return raw.keyword not in _TOLERANCES and (raw.block == 1 or not ("N" in parameter.unit or "kg" in parameter.unit))


def _owner(kind: str, role: str, space: str = "") -> str:
    """Whose value it is: "planar beam", "orientation node"."""
    if kind:
        return ELEMENT_TYPES[kind].title
    return f"{space} {role} node".strip() if role else ""


def _expected(parameter: Parameter, kind: str, role: str, raw: Raw) -> str:
    """Meaning of a position with the kind of element or node it is for."""
    owner = _owner(kind, role)
    if raw.keyword in ELEMENT_TYPES:
        owner = ELEMENT_TYPES[raw.keyword].title
    if not owner or parameter.of:
        return parameter.text
    return f"{parameter.text} of {_an(owner)}"


def _an(noun: str) -> str:
    return f"an {noun}" if noun[0] in "aeio" else f"a {noun}"


def _count(
    raw: Raw, words: list[Word], variants: list[Variant], variant: Variant, kind: str, role: str, findings: Findings
) -> bool:
    """Whether the number of arguments is allowed; otherwise say which one is missing or surplus."""
    counts = {n for v in variants for n in v.counts}
    given = len(words)
    if given in counts:
        return True
    owner = ELEMENT_TYPES[kind].title if kind else _owner("", role)
    whom = f" for {_an(owner)}" if owner and raw.keyword not in ELEMENT_TYPES else ""
    takes = f"{raw.keyword} takes {alternatives(counts)} argument{'s' if counts != {1} else ''}{whom}"
    extra = _surplus_node(raw, words, counts)
    if extra is not None:
        element, names = _an(ELEMENT_TYPES[raw.keyword].title), ELEMENT_TYPES[raw.keyword].node_names
        text = f"surplus node '{extra.text}': {element} joins {', '.join(names[:-1])} and {names[-1]} only; {takes}"
        findings.add("error", extra.line, _subject(raw), text, "surplus-argument")
        return False
    if given > max(counts):
        rest = words[max(counts) :]
        surplus = next((w for w in rest if raw.keyword in _COEFFICIENTS and number_of(w.text) != 0.0), rest[0])
        text = f"surplus argument '{surplus.text}'; {takes}"
        findings.add("error", surplus.line, _subject(raw), text, "surplus-argument")
        return False
    fuller = min((v for v in variants if v.counts[-1] > given), key=lambda v: min(n for n in v.counts if n > given))
    missing = fuller.parameters[given] if given < len(fuller.parameters) else variant.parameters[-1]
    needed = min(n for n in counts if n > given)
    line = words[-1].line if words else raw.line
    text = f"too few arguments: {given} given, {needed} needed; the {ordinal(given)} one is missing:"
    text += f" {_expected(missing, kind, role, raw)}; {takes}"
    findings.add("error", line, _subject(raw), text, "missing-argument")
    return False


def _surplus_node(raw: Raw, words: list[Word], counts: set[int]) -> Word | None:
    """The word behind the nodes of an element that looks like one node more; without it the number would be right."""
    kind = ELEMENT_TYPES.get(raw.keyword)
    if kind is None:
        return None
    place = 1 + len(kind.nodes)
    if max(counts) == place or len(words) - 1 not in counts or not words[place].text.isdecimal():
        return None
    return words[place] if int(words[place].text) > 0 else None


def _references(statement: Statement, variant: Variant, outline: Outline, findings: Findings) -> bool:
    """Whether all node, element, coordinate and mode numbers exist."""
    if statement.keyword in ELEMENT_TYPES:
        return _numbers_positive(statement, variant, findings)
    good = True
    owner: tuple[str, int] | None = None
    for i in range(len(statement.values)):
        of = variant.parameters[i].of
        if not of:
            continue
        number = statement.integer(i)
        if of == "element":
            owner = ("element", number)
            if number not in outline.types:
                owner = None
                good = False
                if number not in outline.elements:
                    findings.error(statement, i, outline.missing_element(number), "unknown-element", bare=i == 0)
        elif of.endswith("node"):
            owner = ("node", number)
            if number not in outline.roles:
                owner = None
                good = _unknown_node(statement, i, number, outline, findings) and good
            elif of != "node" and f"{outline.roles[number]} node" != of:
                user = outline.user(number)
                found = outline.roles[number]
                where = f"of {user.subject}, line {user.line}"
                text = f"node {number} is {_an(found)} node ({where}); expected {_an(of)}"
                findings.error(statement, i, text, "node-role")
                good = False
        elif of in NUMBERED_PARTS and owner is not None:
            good = _in_range(statement, i, owner, number, outline, findings) and good
    return good


def _unknown_node(statement: Statement, i: int, number: int, outline: Outline, findings: Findings) -> bool:
    if not outline.complete:
        return False
    if statement.keyword in _UNUSED_NODES_ALLOWED and statement.block == 1:
        findings.warning(statement, i, f"{outline.missing_node(number)}; the statement has no effect", "unknown-node")
        return False
    findings.error(statement, i, outline.missing_node(number), "unknown-node", bare=i == 0)
    return False


def _in_range(
    statement: Statement, i: int, owner: tuple[str, int], number: int, outline: Outline, findings: Findings
) -> bool:
    what, which = owner
    if what == "element":
        most, noun = outline.modes(which), "mode"
        whose = f"element {which} ({outline.types[which].keyword})"
    else:
        most, noun = outline.coordinates(which), "coordinate"
        whose = f"{outline.roles[which]} node {which}"
    if 1 <= number <= most:
        return True
    allowed = "only 1" if most == 1 else f"1 to {most}"
    findings.error(statement, i, f"{noun} {number} does not exist; {whose} has {noun} {allowed}", f"{noun}-range")
    return False


def _numbers_positive(statement: Statement, variant: Variant, findings: Findings) -> bool:
    """Element and node numbers of an element statement must be 1 ... LARGEST_NUMBER."""
    good = True
    for i in range(1 + len(ELEMENT_TYPES[statement.keyword].nodes)):
        number = statement.integer(i)
        if 1 <= number <= LARGEST_NUMBER:
            continue
        what = "element number" if i == 0 else variant.parameters[i].meaning
        limit = "must be positive" if number < 1 else f"is larger than {LARGEST_NUMBER}"
        findings.error(statement, i, f"{what} {number} {limit}", "number-range")
        good = False
    return good
