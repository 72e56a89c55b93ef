"""Raw statements to typed statements: the variant that applies, the number of arguments, their types, references.

Every node, element, coordinate and mode number that the table declares as such is looked up here. Plain lines about
which nothing needs a message are read by `raw_statements.take_plain`; every other statement is read here word by word.
"""

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
    return _Reader(raw, keyword, outline, findings).statement()


class _Reader:
    """One statement that is read: of what its number names the role of a node or the keyword of an element, "" for what
    is not known; `element`: the type that it defines, None when it is about something."""

    def __init__(self, raw: Raw, keyword: Keyword, outline: Outline, findings: Findings) -> None:
        self.raw, self.keyword, self.outline, self.findings = raw, keyword, outline, findings
        self.element = ELEMENT_TYPES.get(raw.keyword)
        self.space = "" if self.element else outline.space
        self.role = self.kind = ""

    def add(self, severity: str, line: int, text: str, code: str) -> None:
        raw = self.raw
        subject = f"{raw.keyword} {raw.words[0].text}" if raw.words else raw.keyword
        self.findings.add(severity, line, subject, text, code)

    def statement(self) -> Statement | None:
        raw, outline = self.raw, self.outline
        subject = None if self.element else self.keyword.subject
        if subject is not None and subject < len(raw.words):
            number = integer_of(raw.words[subject].text)
            if number is not None and self.keyword.of_element:
                self.kind = outline.types[number].keyword if number in outline.types else ""
            elif number is not None:
                self.role = outline.roles.get(number, "")
        variants = [v for v in self.keyword.variants if v.fits(self.space, self.role, self.kind)]
        if not variants:
            self.refuse()
            return None
        if self.role and subject is not None and (wanted := variants[0].parameters[subject].of).endswith(" node"):
            self.role = wanted.removesuffix(" node")  # sentences about the other arguments tell of the node wanted
        variant, words = self.choose(variants)
        values = self.values(words, variant)
        if values is not None and outline.metre != 1.0:
            values = self.in_metres(values, variant)
        if values is None or not self.right_count(words, variants, variant):
            return None
        places = tuple([(w.line, w.column) for w in words])
        statement = Statement(raw.keyword, values, raw.block, raw.line, places)
        return statement if self.references(statement, variant) else None

    def refuse(self) -> None:
        """No variant of the keyword is for this kind of model, node or element."""
        raw, kind, variants = self.raw, self.kind, self.keyword.variants
        if kind and any(v.types for v in variants):
            allowed = ", ".join(dict.fromkeys(t for v in variants for t in v.types))
            number = raw.words[self.keyword.subject or 0].text
            text = f"element {number} is a {kind} ({ELEMENT_TYPES[kind].title}); {raw.keyword} is for {allowed}"
        elif self.role and any(v.role for v in variants):
            text = f"{raw.keyword} does not apply to the {self.space} {self.role} node {raw.words[0].text}"
        else:
            text = f"{raw.keyword} does not apply to a {self.space} model"
        self.add("error", raw.line, text, "not-applicable")

    def choose(self, variants: list[Variant]) -> tuple[Variant, list[Word]]:
        """The variant that takes this number of words; a surplus zero third component of a planar model and surplus
        zero coefficients of an element are dropped."""
        words = self.raw.words
        count = len(words)
        for variant in variants:
            if count in variant.counts:
                return variant, words
        first = max(variants, key=lambda v: v.counts[-1])
        most = first.counts[-1]
        if self.space == "planar" and first.components and count == most + 1:
            surplus = words[-1]
            if number_of(surplus.text) == 0.0:
                text = f"third component '{surplus.text}' of a planar model is ignored"
                self.add("warning", surplus.line, text, "third-component")
                return first, words[:-1]
        if self.raw.keyword in _COEFFICIENTS and count > most and all(number_of(w.text) == 0.0 for w in words[most:]):
            text = f"{count - most} surplus zero{'s' * (count - most > 1)} behind the {most} arguments ignored"
            self.add("information", words[most].line, text, "surplus-zeros")
            return first, words[:most]
        return first, words

    def values(self, words: list[Word], variant: Variant) -> tuple[Value, ...] | None:
        """Typed values; every word that does not fit its position is reported."""
        values: list[Value] = []
        good = True
        for i, (word, parameter) in enumerate(zip(words, variant.parameters, strict=False)):
            value: Value | None
            if parameter.kind == "real":
                value = number_of(word.text)
                problem = "is not a number"
                if value is not None and abs(value) == float("inf"):
                    value, problem = None, "is too large for a number"
                elif value is not None and self.squared(parameter) and not is_in_range(value, word.text):
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
                text = f"{ordinal(i)} argument '{word.text}' {problem}; expected {self.expected(parameter)}"
                self.add("error", word.line, text, "value")
            else:
                values.append(value)
        return tuple(values) if good else None

    def in_metres(self, values: tuple[Value, ...], variant: Variant) -> tuple[Value, ...]:
        """The values of a file with another unit of length, in SI."""
        types, metre = self.outline.types, self.outline.metre
        named = list(zip(values, variant.parameters, strict=False))
        kinds = [types[int(v)] for v, p in named if p.of == "element" and v in types]
        return tuple([
            v * metre ** length_power(self.raw.keyword, place, p, values, kinds, self.role)
            if isinstance(v, float) else v for place, (v, p) in enumerate(named)
        ])  # fmt: skip

    def squared(self, parameter: Parameter) -> bool:
        """Whether a value belongs to the geometry or the motion, so that its square must be in range as well. Forces,
        masses, stiffnesses and tolerances may have any size."""
        raw = self.raw
        if raw.keyword in _TOLERANCES:
            return False
        return raw.block == 1 or not ("N" in parameter.unit or "kg" in parameter.unit)

    @property
    def owner(self) -> str:
        """Whose value it is: "planar beam", "orientation node"."""
        kind = self.element or ELEMENT_TYPES.get(self.kind)
        return kind.title if kind else f"{self.role} node" if self.role else ""

    def expected(self, parameter: Parameter) -> str:
        """Meaning of a position with the kind of element or node it is for."""
        if not self.owner or parameter.of:
            return parameter.text
        return f"{parameter.text} of {_an(self.owner)}"

    def right_count(self, words: list[Word], variants: list[Variant], variant: Variant) -> bool:
        """Whether the number of arguments is allowed; otherwise say which one is missing or surplus."""
        counts = {n for v in variants for n in v.counts}
        given = len(words)
        if given in counts:
            return True
        whom = f" for {_an(self.owner)}" if self.owner and not self.element else ""
        takes = f"{self.raw.keyword} takes {alternatives(counts)} argument{'s' if counts != {1} else ''}{whom}"
        extra = self.surplus_node(words, counts)
        if self.element and extra is not None:
            element, names = _an(self.element.title), self.element.node_names
            text = f"surplus node '{extra.text}': {element} joins {', '.join(names[:-1])} and {names[-1]} only; {takes}"
            self.add("error", extra.line, text, "surplus-argument")
            return False
        if given > max(counts):
            rest = words[max(counts) :]
            coefficients = self.raw.keyword in _COEFFICIENTS
            surplus = next((w for w in rest if coefficients and number_of(w.text) != 0.0), rest[0])
            self.add("error", surplus.line, f"surplus argument '{surplus.text}'; {takes}", "surplus-argument")
            return False
        fuller = min((v for v in variants if v.counts[-1] > given), key=lambda v: min(n for n in v.counts if n > given))
        missing = fuller.parameters[given] if given < len(fuller.parameters) else variant.parameters[-1]
        needed = min(n for n in counts if n > given)
        line = words[-1].line if words else self.raw.line
        text = f"too few arguments: {given} given, {needed} needed; the {ordinal(given)} one is missing:"
        self.add("error", line, f"{text} {self.expected(missing)}; {takes}", "missing-argument")
        return False

    def surplus_node(self, words: list[Word], counts: set[int]) -> Word | None:
        """The word behind the nodes of an element that looks like one node more; without it the number would be
        right."""
        if self.element is None:
            return None
        place = 1 + len(self.element.nodes)
        if max(counts) == place or len(words) - 1 not in counts or not words[place].text.isdecimal():
            return None
        return words[place] if int(words[place].text) > 0 else None

    def references(self, statement: Statement, variant: Variant) -> bool:
        """Whether all node, element, coordinate and mode numbers exist."""
        if self.element:
            return self.numbers_positive(statement, variant)
        outline, findings = self.outline, self.findings
        good = True
        owner: tuple[str, int] | None = None
        for i, (number, parameter) in enumerate(zip(statement.values, variant.parameters, strict=False)):
            of = parameter.of
            if not of:
                continue
            assert isinstance(number, int)
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
                    good = False
                    if outline.complete:
                        self.unknown_node(statement, i, outline.missing_node(number))
                elif of != "node" and f"{outline.roles[number]} node" != of:
                    user = outline.user(number)
                    where = f"of {user.subject}, line {user.line}"
                    text = f"node {number} is {_an(outline.roles[number])} node ({where}); expected {_an(of)}"
                    findings.error(statement, i, text, "node-role")
                    good = False
            elif of in NUMBERED_PARTS and owner is not None:
                good = self.in_range(statement, i, *owner) and good
        return good

    def unknown_node(self, statement: Statement, i: int, text: str) -> None:
        if statement.keyword in _UNUSED_NODES_ALLOWED and statement.block == 1:
            self.findings.warning(statement, i, f"{text}; the statement has no effect", "unknown-node")
        else:
            self.findings.error(statement, i, text, "unknown-node", bare=i == 0)

    def in_range(self, statement: Statement, i: int, what: str, which: int) -> bool:
        number, outline = statement.integer(i), self.outline
        if what == "element":
            kind = outline.types[which]
            most, noun, whose = len(kind.modes), "mode", f"element {which} ({kind.keyword})"
        else:
            most, noun = outline.coordinates(which), "coordinate"
            whose = f"{outline.roles[which]} node {which}"
        if 1 <= number <= most:
            return True
        allowed = "only 1" if most == 1 else f"1 to {most}"
        text = f"{noun} {number} does not exist; {whose} has {noun} {allowed}"
        self.findings.error(statement, i, text, f"{noun}-range")
        return False

    def numbers_positive(self, statement: Statement, variant: Variant) -> bool:
        """Element and node numbers of an element statement must be 1 ... LARGEST_NUMBER."""
        assert self.element is not None
        good = True
        for i in range(1 + len(self.element.nodes)):
            number = statement.integer(i)
            if 1 <= number <= LARGEST_NUMBER:
                continue
            what = "element number" if i == 0 else variant.parameters[i].meaning
            limit = "must be positive" if number < 1 else f"is larger than {LARGEST_NUMBER}"
            self.findings.error(statement, i, f"{what} {number} {limit}", "number-range")
            good = False
        return good


def _an(noun: str) -> str:
    return f"an {noun}" if noun[0] in "aeio" else f"a {noun}"
