// Every snippet, with its default values, is accepted by `admire check`.
"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { test } = require("node:test");
const { check, root } = require("./support");

const FRAME = `Adams View model name: snippet
UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND
PART/1, GROUND
MARKER/10, PART = 1
MARKER/11, PART = 1, QP = 100, 0, 0
MARKER/12, PART = 1, FLOATING
PART/2, MASS = 2, CM = 20, IP = 1.0E+04, 1.0E+04, 1.0E+04
MARKER/20, PART = 2
MARKER/21, PART = 2, QP = 100, 0, 0
`;

/** Returns the text that a snippet leaves behind where nothing is typed over it. */
function text({ body }) {
  const line = body.join("\n").replace(/\$\{\d+\|([^,|]*)[^|]*\|\}/g, "$1");
  return line.replace(/\$\{\d+:([^}]*)\}/g, "$1").replace(/\$0/g, "").replace(/\\\\/g, "\\") + "\n";
}

/** Returns the names and texts of the snippets of a file. */
function snippets(file) {
  return Object.entries(require(`../snippets/${file}.json`)).map(([name, snippet]) => [name, text(snippet)]);
}

/** Writes files into a new folder, checks one of them and returns its errors and warnings. */
function complaints(wanted, written) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "admire-"));
  for (const [name, content] of Object.entries(written)) {
    fs.writeFileSync(path.join(folder, name), content);
  }
  const all = JSON.parse(check(path.join(folder, wanted)));
  fs.rmSync(folder, { recursive: true });
  return all.filter((complaint) => complaint.severity !== "note");
}

for (const [name, snippet] of snippets("deck")) {
  test(`deck: ${name}`, () => {
    const whole = /^END$/m.test(snippet);
    const joint = "JOINT/1, REVOLUTE, I = 21, J = 11\n";
    const frame = snippet.includes("UNITS/") ? FRAME.replace(/^UNITS.*\n/m, "") : FRAME;
    const deck = whole ? snippet : `${frame}${snippet.includes("MOTION/") ? joint : ""}${snippet}END\n`;
    assert.deepStrictEqual(complaints("model.adm", { "model.adm": deck }), []);
  });
}
for (const [name, snippet] of snippets("commands")) {
  test(`commands: ${name}`, () => {
    const deck = `${FRAME}SFORCE/1, TRANSLATIONAL, I = 21, J = 11, FUNCTION = 0\nEND\n`;
    assert.deepStrictEqual(complaints("run.acf", { "model.adm": deck, "run.acf": snippet }), []);
  });
}
for (const [name, snippet] of snippets("study")) {
  test(`study: ${name}`, () => {
    const corpus = name.includes("K&C") ? "kc-curves" : "kc-experiment";
    const folder = path.join(root, "corpus", corpus);
    const others = fs.readdirSync(folder).filter((file) => /\.(adm|csv)$/.test(file));
    const written = Object.fromEntries(others.map((file) => [file, fs.readFileSync(path.join(folder, file))]));
    assert.deepStrictEqual(complaints(".", { ...written, "study.toml": snippet }), []);
  });
}
