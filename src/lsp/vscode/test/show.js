// Prints the colours of a file: `node test/show.js FILE [LANGUAGE]`.
"use strict";

const { colours } = require("./colours");
const { language, read } = require("./support");

const [file, other] = process.argv.slice(2);
colours(read(file), other ?? language(file)).then((pieces) => {
  for (const { line, text, scopes } of pieces) {
    console.log(`${String(line + 1).padStart(5)}  ${text.padEnd(30)} ${scopes.slice(1).join(" ")}`);
  }
});
