// What the commands run, run with the program.
"use strict";

const assert = require("node:assert");
const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { after, before, test } = require("node:test");
const commands = require("../commands");
const { admire, root } = require("./support");

let folder;
before(() => {
  folder = fs.mkdtempSync(path.join(os.tmpdir(), "admire-"));
  for (const file of ["model.adm", "states.acf"]) {
    fs.copyFileSync(path.join(root, "corpus/double-wishbone", file), path.join(folder, file));
  }
});
after(() => fs.rmSync(folder, { recursive: true }));

const run = (args) => execFileSync(admire, args, { cwd: folder, encoding: "utf8" });

test("a deck and a command file are solved, and the results move the 3-D view", () => {
  const deck = path.join(folder, "model.adm");
  assert.deepStrictEqual(commands.results(deck), []);
  assert.match(run(commands.solve(deck)), /wheel|upright|knuckle|rack/);
  run(commands.solve(path.join(folder, "states.acf")));
  assert.deepStrictEqual(commands.results(deck), ["states.res"]);

  const page = path.join(folder, "view.html");
  run(commands.view(deck, undefined, page));
  const still = fs.readFileSync(page, "utf8");
  run(commands.view(deck, path.join(folder, "states.res"), page));
  const moving = fs.readFileSync(page, "utf8");
  assert.match(still, /class="lead">\d+ parts, \d+ joints and forces; /);
  assert.match(moving, /class="lead">.*, \d+ steps; /);
});
