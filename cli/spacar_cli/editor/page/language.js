// The input language in the editor, from keywords.json (the keyword table): colours, completion, help, blocks, places.
"use strict";
function inputLanguage(table, CM) {
  const known = (word) => table.keywords[table.aliases[word] || word];
  const bare = (line) => line.replace(/[%#;].*/, "");

  // Statements of lines: {keyword, row, words, line, from, to}; words {text, from, to} behind the keyword. A statement
  // ends where the next keyword begins; nothing behind a line VISUALIZATION is one.
  function* statements(doc, first = 1, last = doc.lines) {
    let now = null;
    for (let n = first; n <= last; n++) {
      const line = doc.line(n), text = bare(line.text);
      for (const found of text.matchAll(/\S+/g)) {
        const word = found[0].toUpperCase(), from = line.from + found.index, to = from + word.length;
        const row = /^[A-Z]/.test(word) ? known(word) : undefined;
        if (word === "VISUALIZATION" && text.trim().toUpperCase() === word) { if (now) yield now; return; }
        if (row || table.ends.includes(word)) {
          if (now) yield now;
          now = row ? { keyword: table.aliases[word] || word, row, words: [], line: n, from, to } : null;
        } else if (now) {
          now.words.push({ text: found[0], from, to });
          now.to = to;
        }
      }
    }
    if (now) yield now;
  }
  // The statement at a position: that of its line, or the one that goes on there from the lines above.
  function statementAt(doc, at) {
    const here = doc.lineAt(at).number;
    let first = here;
    while (first > 1 && here - first < 20) {
      const word = bare(doc.line(first).text).trim().split(/\s+/)[0].toUpperCase();
      if (word && (known(word) || table.ends.includes(word))) break;
      first--;
    }
    let found = null;
    for (const s of statements(doc, first, here)) if (s.from <= at) found = s;
    return found;
  }
  // What a statement is about: {element: n} or {node: n}; null for neither.
  function subject(s) {
    if (!s || !s.row.subject) return null;
    const [kind, place] = s.row.subject, number = s.words[place] && parseInt(s.words[place].text, 10);
    return number > 0 ? { [kind]: number } : null;
  }
  // The statement that defines an element, or gives the place of a node; else the first element that uses the node.
  function definition(doc, { element, node }) {
    let user = null;
    for (const s of statements(doc)) {
      const number = s.words[0] && parseInt(s.words[0].text, 10);
      if (element && s.row.nodes && number === element) return s;
      if (node && s.keyword === "X" && number === node) return s;
      if (node && s.row.nodes && !user && s.words.slice(1, 1 + s.row.nodes).some((w) => +w.text === node)) user = s;
    }
    return user;
  }

  const mode = CM.StreamLanguage.define({
    name: "spacar",
    startState: () => ({ settings: false, first: false }),
    token(stream, state) {
      if (stream.sol()) state.first = true;
      if (stream.eatSpace()) return null;
      if (/[%#;]/.test(stream.peek())) { stream.skipToEnd(); return "comment"; }
      stream.match(/^[^\s%#;]+/);
      const word = stream.current().toUpperCase(), first = state.first;
      state.first = false;
      if (table.ends.includes(word)) {
        if (word === "VISUALIZATION" && first) state.settings = true;
        return "keyword";
      }
      if (state.settings && first) return table.settings[word] ? "propertyName" : null;
      if (state.settings) return /^[-+.\d]/.test(word) ? "number" : null;
      const row = known(word);
      if (row) return row.nodes ? "typeName" : "propertyName";
      return /^[+-]?(\d+\.?\d*|\.\d+)([ED][+-]?\d+)?$/.test(word) ? "number" : "string";
    },
    languageData: { commentTokens: { line: "%" } },
  });
  const { tags } = CM;
  const colours = CM.syntaxHighlighting(CM.HighlightStyle.define([
    { tag: tags.comment, color: "#6f7a83", fontStyle: "italic" },
    { tag: tags.keyword, color: "#a3337a", fontWeight: "bold" },
    { tag: tags.typeName, color: "#1f5fa3", fontWeight: "bold" },
    { tag: tags.propertyName, color: "#1f6f5c", fontWeight: "bold" },
    { tag: tags.number, color: "#33414d" },
    { tag: tags.string, color: "#8a4b14" },
  ]));

  // Which block (1, 2, 3) a position is in: END ends the first and the second.
  function blockAt(doc, at) {
    let ends = 0;
    for (let n = 1; n < doc.lineAt(at).number; n++)
      for (const word of bare(doc.line(n).text).trim().toUpperCase().split(/\s+/)) {
        if (word === "END") ends++;
        if (word === "VISUALIZATION") return 0;
      }
    return Math.min(ends + 1, 3);
  }
  function completion(context) {
    const { doc } = context.state, line = doc.lineAt(context.pos), before = line.text.slice(0, context.pos - line.from);
    if (before !== bare(before)) return null; // in a comment
    const word = /[^\s]*$/.exec(before)[0], from = context.pos - word.length;
    if (before.trim() === word && (word || context.explicit)) {
      const block = blockAt(doc, context.pos);
      const option = (type) => ([label, row]) => ({ label, type, detail: row.help, info: row.text });
      const names = Object.entries(table.keywords).filter(([, row]) => row.blocks.includes(block));
      const options = block ? names.map(option("keyword")) : Object.entries(table.settings).map(option("property"));
      return { from, options: [...options, ...table.ends.map((label) => ({ label, type: "namespace" }))],
        validFor: /^\w*$/ };
    }
    const s = statementAt(doc, Math.max(context.pos - 1, 0)); // the one before the cursor
    if (!s || (!context.explicit && !/\d$/.test(word))) return null;
    const place = s.words.filter((w) => w.to < context.pos).length;
    const of = new Set(s.row.forms.map(({ parameters: p }) => (p[Math.min(place, p.length - 1)] || [])[1]));
    const numbers = new Map(), ofNodes = [...of].some((name) => name && name.includes("node"));
    for (const other of statements(doc)) {
      if (!other.row.nodes || other.from === s.from) continue;
      const [number, ...rest] = other.words.map((w) => parseInt(w.text, 10)), nodes = rest.slice(0, other.row.nodes);
      if (of.has("element") && number > 0) numbers.set(number, `${other.keyword} ${nodes.join(" ")}`);
      if (ofNodes) for (const n of nodes) if (n > 0 && !numbers.has(n)) numbers.set(n, `${other.keyword} ${number}`);
    }
    if (!numbers.size) return null;
    const options = [...numbers].sort(([a], [b]) => a - b).slice(0, 500)
      .map(([n, detail], i) => ({ label: String(n), detail, type: "constant", boost: -i / 10 }));
    return { from, options, validFor: /^\d*$/ };
  }

  // Help of the keyword under the pointer; of a number, what its position means.
  function help(doc, at) {
    const line = doc.lineAt(at);
    if (bare(line.text).length <= at - line.from) return null;
    const s = statementAt(doc, at);
    const column = at - line.from;
    const word = [...line.text.matchAll(/\S+/g)].find((w) => w.index <= column && column <= w.index + w[0].length);
    if (!word) return null;
    const from = line.from + word.index, to = from + word[0].length, name = word[0].toUpperCase();
    const row = known(name) || table.settings[name];
    if (row) return { from, to, text: row.text };
    const place = s ? s.words.findIndex((w) => w.from === from) : -1;
    if (place < 0) return null;
    const meanings = s.row.forms.filter((f) => f.parameters[place])
      .map((f) => `${f.scope ? `${f.scope}: ` : ""}${f.parameters[place][0]}`);
    const text = [`${s.keyword}, argument ${place + 1}`, ...new Set(meanings)].join("\n");
    return meanings.length ? { from, to, text } : null;
  }
  const hover = CM.hoverTooltip((view, at) => {
    const found = help(view.state.doc, at);
    return found && { pos: found.from, end: found.to, above: false, create: () => {
      const dom = document.createElement("pre");
      dom.textContent = found.text;
      return { dom };
    } };
  });
  // A block folds from its first line of statements to the line before its END.
  const folding = CM.foldService.of((state, from) => {
    const { doc } = state, first = doc.lineAt(from).number;
    const isEnd = (n) => /^\s*(END|HALT|VISUALIZATION)\b/i.test(doc.line(n).text);
    const begins = !isEnd(first) && doc.line(first).text.trim() && (first === 1 || isEnd(first - 1));
    if (!begins) return null;
    let last = first;
    while (last < doc.lines && !isEnd(last + 1)) last++;
    return last > first ? { from: doc.line(first).to, to: doc.line(last).to } : null;
  });
  // Enter ends a line whatever is proposed; Tab takes the first proposal, or the one that the arrows chose
  const take = (view) => {
    if (CM.completionStatus(view.state) !== "active") return false;
    if (CM.selectedCompletionIndex(view.state) < 0) CM.moveCompletionSelection(true)(view);
    return CM.acceptCompletion(view);
  };
  const extensions = [mode, colours, hover, folding, CM.keymap.of([{ key: "Tab", run: take }]),
    CM.autocompletion({ override: [completion], icons: false, selectOnOpen: false, interactionDelay: 0 })];
  return { extensions, statements, statementAt, subject, definition, help };
}
