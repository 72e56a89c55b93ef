// The page of `spacar edit`: the editor, its checks while typing, the file, runs. With data-kind "watch" the text is
// that of the file, whatever writes it.
"use strict";
(async function () {
  const $ = (id) => document.getElementById(id), watch = document.body.dataset.kind === "watch";
  const told = (text, kind = "") => { $("told").textContent = text; $("told").className = kind; };
  const table = await (await fetch("keywords.json")).json();
  const language = inputLanguage(table, CM);
  let file = await call("open"), savedText = file.text, edits = 0, saving = 0, picking = false, asking = false;

  const view = new CM.EditorView({
    parent: $("editor"),
    state: CM.EditorState.create({ doc: file.text, extensions: [
      CM.lineNumbers(), CM.foldGutter(), CM.lintGutter(), CM.history(), CM.drawSelection(), CM.bracketMatching(),
      CM.highlightActiveLine(), CM.highlightActiveLineGutter(), CM.search({ top: true }), ...language.extensions,
      CM.keymap.of([{ key: "Mod-s", run: () => { save(); return true; } }, ...CM.completionKeymap, ...CM.lintKeymap,
        ...CM.foldKeymap, ...CM.searchKeymap, ...CM.historyKeymap, ...CM.defaultKeymap, CM.indentWithTab]),
      CM.EditorView.cspNonce.of(document.querySelector("meta[name=csp-nonce]").content),
      CM.EditorView.contentAttributes.of({ "aria-label": "input file", spellcheck: "false" }),
      CM.EditorState.allowMultipleSelections.of(false),
      CM.EditorView.updateListener.of((update) => {
        if (update.docChanged) { edits++; shownSaved(); later(); }
        if ((update.selectionSet || update.docChanged) && !picking) follow();
      }),
    ] }),
  });
  const text = () => view.state.doc.toString();
  const dirty = () => text() !== savedText || !file.digest;
  function shownSaved() {
    $("saved").textContent = watch ? "" : !file.digest ? "new file" : dirty() ? "not saved" : "saved";
  }

  // Change the text where it differs, so that the cursor and undo stay.
  function change(wanted) {
    const now = text();
    if (wanted === now) return;
    let from = 0, end = 0;
    const most = Math.min(now.length, wanted.length);
    while (from < most && now[from] === wanted[from]) from++;
    while (end < most - from && now[now.length - 1 - end] === wanted[wanted.length - 1 - end]) end++;
    view.dispatch({ changes: { from, to: now.length - end, insert: wanted.slice(from, wanted.length - end) } });
  }
  function insert(line) { // before the END of the first block
    const { doc } = view.state;
    for (let n = 1; n <= doc.lines; n++)
      if (/^\s*END\b/i.test(doc.line(n).text)) {
        view.dispatch({ changes: { from: doc.line(n).from, insert: `${line}\n` } });
        return;
      }
  }
  function goTo(from, focus = true) {
    view.dispatch({ selection: { anchor: from }, effects: CM.EditorView.scrollIntoView(from, { y: "center" }) });
    if (focus) view.focus();
  }
  function picked(what) {
    const found = language.definition(view.state.doc, what);
    if (!found) return;
    picking = true;
    goTo(found.from);
    picking = false;
  }
  function follow() {
    const what = language.subject(language.statementAt(view.state.doc, view.state.selection.main.head));
    if (what) results.select(what);
  }
  const results = makeResults({ text, change, insert, picked });

  // Checks while typing: messages first, then the picture, then the freedoms; what is outdated is not shown
  let timer = 0, working = false, freeing = false, waiting = null, seen = -1;
  function later(wait = 200) {
    clearTimeout(timer);
    timer = setTimeout(look, wait);
  }
  async function look() {
    if (working) return;
    working = true;
    const at = edits, now = text();
    try {
      const found = await task("check", { text: now });
      if (at === edits) {
        messages(found);
        if (!found.drawable) results.stale();
        else if (!results.resultOf || results.resultOf !== now) {
          results.resultOf = null;
          const model = await task("picture", { text: now });
          if (at === edits) results.start(model);
        }
        if (found.drawable) free(now, at);
      }
    } catch (error) {
      told(error.message, "error");
    } finally {
      working = false;
      if (at !== edits) later(0);
      else seen = edits;
    }
  }
  async function free(now, at) { // one question at a time; of those that wait the last one
    waiting = { now, at };
    if (freeing) return;
    freeing = true;
    while (waiting) {
      const asked = waiting;
      waiting = null;
      try {
        const found = await task("freedom", { text: asked.now });
        if (asked.at === edits) results.freedom(found);
      } catch (error) {
        $("freedom").textContent = error.message;
      }
    }
    freeing = false;
  }
  function messages(found) {
    const { doc } = view.state, range = (line) => {
      const at = doc.line(Math.min(Math.max(line || 1, 1), doc.lines)), lead = /^\s*/.exec(at.text)[0].length;
      return { from: at.from + Math.min(lead, at.length), to: at.to };
    };
    const said = (m) => `${m.keyword ? `${m.keyword}: ` : ""}${m.text}`;
    view.dispatch(CM.setDiagnostics(view.state, found.messages.filter((m) => m.here && m.severity !== "information")
      .map((m) => ({ ...range(m.line), severity: m.severity, message: said(m) }))));
    const order = ["error", "warning", "information"];
    const rows = [...found.messages].sort((a, b) => order.indexOf(a.severity) - order.indexOf(b.severity)).slice(0, 60);
    if (!rows.length) rows.push({ severity: "fine", text: "no errors, no warnings" });
    $("messages").replaceChildren(...rows.map((m) => {
      const row = results.make("li", `${m.line ? `${m.line}: ` : ""}${said(m)}`);
      row.className = m.severity;
      if (m.here && m.line) row.addEventListener("click", () => goTo(range(m.line).from));
      return row;
    }));
    const code = found.messages.some((m) => m.code === "user-function.listed");
    document.body.dataset.errors = String(found.messages.filter((m) => m.severity === "error").length);
    if (!found.drawable) return; // the buttons stay
    $("modes").replaceChildren(...found.modes.map((mode) => {
      const button = results.make("button", `Mode ${mode.number}`, () => run(mode));
      button.title = `${mode.title}: saves the file and runs it${code ? "; executes its user functions" : ""}`;
      button.dataset.mode = mode.number;
      return button;
    }), code ? " runs execute user functions" : "");
  }

  // The file
  function ask(words, first, doFirst, second, doSecond) {
    asking = true;
    const done = (does) => () => { $("warning").hidden = true; asking = false; does(); };
    $("warning").firstElementChild.textContent = words;
    $("first").textContent = first; $("second").textContent = second;
    $("first").onclick = done(doFirst); $("second").onclick = done(doSecond);
    $("warning").hidden = false;
  }
  async function reload() {
    file = await call("open");
    savedText = file.text;
    change(file.text);
    shownSaved();
  }
  function changedElsewhere(digest) {
    ask("The file was changed by another program.", "Read it, drop mine", reload, "Keep mine",
      () => { file.digest = digest; savedText = null; shownSaved(); });
  }
  async function save() {
    if (watch) return false;
    const now = text();
    saving++;
    try {
      file.digest = await call("save", { text: now, digest: file.digest, newline: file.newline, marked: file.marked });
      savedText = now;
      shownSaved();
      return true;
    } catch (error) {
      if (error.code === "edit.changed") changedElsewhere((await call("state")).digest);
      else told(error.message, "error");
      return false;
    } finally {
      saving--;
    }
  }
  $("save").addEventListener("click", save);

  // Runs
  let current = null, duration = null, lastResult = 0;
  async function run(mode) {
    if (current !== null || (dirty() && !(await save()))) return;
    try {
      await call("run", { mode: mode.number });
      current = mode;
      ({ duration } = mode);
      $("abort").hidden = $("progress").hidden = false;
      $("progress").removeAttribute("value");
      told(`mode ${mode.number}, ${mode.title} ...`);
      document.body.dataset.run = "running";
    } catch (error) { told(error.message, "error"); }
  }
  async function ended(state) {
    const mode = current, ran = text();
    current = null;
    $("abort").hidden = $("progress").hidden = true;
    const steps = state.steps ? `, ${state.steps} step${state.steps === 1 ? "" : "s"}` : "";
    if (state.status === 0) told(`mode ${mode.number} done${steps} in ${state.seconds.toFixed(1)} s`, "fine");
    else if (state.code === "interrupted") told(`aborted${steps}; results so far are kept`, "warning");
    else told(`mode ${mode.number} failed: ${state.error || state.told.trim() || "no reason was told"}`, "error");
    try {
      if (ran === savedText) results.resultOf = ran;
      await results.finished(state.status === 0);
    } catch (error) {
      results.resultOf = null;
      if (state.status === 0) $("note").textContent = error.message;
    }
    if (state.status !== 0 && state.code !== "interrupted") results.tab("log");
    document.body.dataset.run = `ended ${state.status}`;
  }
  $("abort").addEventListener("click", () => call("abort").catch((error) => told(error.message, "error")));
  $("end").addEventListener("click", async () => {
    if (!watch && dirty() && file.digest && !confirm("The text is not saved. End nevertheless?")) return;
    await call("end");
    savedText = text();
    document.body.textContent = "spacar has ended; this page can be closed.";
  });
  window.addEventListener("beforeunload", (e) => { if (!watch && text() !== savedText) e.preventDefault(); });

  // What changes by itself: the file, the run
  async function poll() {
    let wait = 700;
    try {
      const before = file.digest, state = await call("state", { progress: current !== null });
      // an answer from before or during a save of our own says nothing about other programs
      const foreign = state.digest && state.digest !== file.digest && before === file.digest && !saving;
      if (foreign && !asking) {
        if (watch) await reload();
        else changedElsewhere(state.digest);
      }
      if (watch && state.result !== lastResult) {
        lastResult = state.result;
        await results.finished(true).then(() => { results.resultOf = text(); }, () => {});
      }
      if (current !== null) {
        wait = 300;
        const { progress } = state;
        if (!state.running) await ended(state);
        else if (progress && progress.t !== null && duration) {
          $("progress").value = progress.t / duration;
          told(`mode ${current.number}: t = ${progress.t.toPrecision(4)} of ${duration} s`);
        } else if (progress && progress.steps) told(`mode ${current.number}: ${progress.steps} steps`);
      }
    } catch (error) {
      const gone = error instanceof TypeError; // of fetch
      told(gone ? "spacar has ended: save the text elsewhere, or start it again" : error.message, "error");
      wait = 3000;
    }
    setTimeout(poll, wait);
  }
  shownSaved();
  later(0);
  poll();
  const busy = () => working || freeing || seen !== edits;
  window.spacarPage = { view, text, change, goTo, results, busy }; // for scripts that test the page
  document.body.dataset.state = "ready";
})();
