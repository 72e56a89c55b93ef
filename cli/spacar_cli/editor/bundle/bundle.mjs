// Makes ../page/codemirror.js, ../page/codemirror.LICENSE and the checksum: npm ci && npm run bundle
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const page = new URL("../page/", import.meta.url);
const made = await build({
  entryPoints: ["entry.mjs"], bundle: true, minify: true, format: "iife", globalName: "CM", target: "es2020",
  charset: "ascii", legalComments: "none", metafile: true, write: false,
});
const lock = JSON.parse(readFileSync("package-lock.json", "utf8")).packages;
const packageOf = (file) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(file)?.[1];
const used = [...new Set(Object.keys(made.metafile.inputs).map(packageOf))].filter(Boolean).sort();
const names = used.map((name) => `${name} ${lock[`node_modules/${name}`].version}`);
const head = "CodeMirror 6 (MIT, see codemirror.LICENSE), made by editor/bundle/bundle.mjs of";
const text = `/* ${head} ${names.join(", ")} */\n` + made.outputFiles[0].text;
const licences = used.map((name) => {
  const folder = `node_modules/${name}`, file = readdirSync(folder).find((f) => /^licen[cs]e/i.test(f));
  return `${name} ${lock[folder].version}\n\n${readFileSync(`${folder}/${file}`, "utf8").trim()}\n`;
});
writeFileSync(new URL("codemirror.js", page), text);
writeFileSync(new URL("codemirror.LICENSE", page), licences.join(`\n${"-".repeat(80)}\n\n`));
const digest = createHash("sha256").update(text).digest("hex");
writeFileSync(new URL("codemirror.sha256", page), `${digest}  codemirror.js\n`);
