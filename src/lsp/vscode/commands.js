// What the commands of the extension run; without the editor, so that Node can test it.
"use strict";

const fs = require("node:fs");
const path = require("node:path");

/** Returns the arguments of `admire` that solve a deck or execute a command file. The working directory is the folder of the file. */
function solve(file) {
  return ["solve", path.basename(file)];
}

/** Returns the arguments of `admire` that write the 3-D view of a deck to `page`, moving through the results file `run` if there is one. */
function view(deck, run, page) {
  return ["view", deck, ...(run ? [run] : []), "--out", page];
}

/** Returns the names of the results files in the folder of a deck, the newest first. */
function results(deck) {
  const folder = path.dirname(deck);
  const time = (name) => fs.statSync(path.join(folder, name)).mtimeMs;
  const names = fs.readdirSync(folder).filter((name) => /\.res$/i.test(name));
  return names.sort((a, b) => time(b) - time(a));
}

module.exports = { solve, view, results };
