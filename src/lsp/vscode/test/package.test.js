// The files that are packed are all that the extension needs: they are started outside of this folder, in a stand-in for the editor.
"use strict";

const assert = require("node:assert");
const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const Module = require("node:module");
const os = require("node:os");
const path = require("node:path");
const { test } = require("node:test");

const folder = path.resolve(__dirname, "..");

test("version and licence are those of the project", () => {
  const cargo = fs.readFileSync(path.join(folder, "../../../Cargo.toml"), "utf8");
  const { version, license } = require("../package.json");
  assert.ok(cargo.includes(`\nversion = "${version}"\n`) && cargo.includes(`\nlicense = "${license}"\n`));
});

test("the packed files hold what package.json names, and start", () => {
  const vsce = path.join(folder, "node_modules/@vscode/vsce/vsce");
  const listed = execFileSync(process.execPath, [vsce, "ls"], { cwd: folder, encoding: "utf8" }).trim().split(/\r?\n/);
  const copy = fs.mkdtempSync(path.join(os.tmpdir(), "admire-"));
  for (const file of listed) {
    fs.cpSync(path.join(folder, file), path.join(copy, file));
  }
  const { contributes, icon, main } = require("../package.json");
  const named = [...contributes.grammars, ...contributes.snippets].map((entry) => entry.path);
  const configurations = contributes.languages.flatMap((language) => language.configuration ?? []);
  for (const file of [icon, main, "README.md", "LICENSE.txt", ...named, ...configurations]) {
    assert.ok(fs.existsSync(path.join(copy, file)), file);
  }

  // Whatever is asked of the editor exists and is a class that can be called and extended.
  const editor = new Proxy(class {}, { get: (own, key) => own[key] ?? editor, apply: () => editor });
  const load = Module._load;
  Module._load = (request, ...others) => (request === "vscode" ? editor : load(request, ...others));
  try {
    const extension = require(path.join(copy, main));
    assert.strictEqual(typeof extension.activate, "function");
  } finally {
    Module._load = load;
    fs.rmSync(copy, { recursive: true });
  }
});
