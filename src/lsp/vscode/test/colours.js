// Colours a text with the grammars of the extension, by the library that the editor has.
"use strict";

const fs = require("node:fs");
const path = require("node:path");
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const folder = path.resolve(__dirname, "..");
const { grammars } = require("../package.json").contributes;

const wasm = fs.readFileSync(path.join(path.dirname(require.resolve("vscode-oniguruma/package.json")), "release/onig.wasm"));
const registry = new textmate.Registry({
  onigLib: oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length)).then(() => ({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  })),
  loadGrammar: async (scope) => {
    const found = grammars.find((grammar) => grammar.scopeName === scope);
    const file = path.join(folder, found.path);
    return textmate.parseRawGrammar(fs.readFileSync(file, "utf8"), file);
  },
});

/** Returns the pieces of a text in order: line and column, the text, and its scopes with the innermost last. Blanks are left out. */
async function colours(text, language) {
  const { scopeName } = grammars.find((grammar) => grammar.language === language);
  const grammar = await registry.loadGrammar(scopeName);
  let state = textmate.INITIAL;
  return text.split(/\r\n|\n|\r/).flatMap((content, line) => {
    const { tokens, ruleStack } = grammar.tokenizeLine(content, state);
    state = ruleStack;
    const pieces = tokens.map(({ startIndex, endIndex, scopes }) => ({
      line,
      column: startIndex,
      text: content.slice(startIndex, endIndex),
      scopes,
    }));
    return pieces.filter((piece) => piece.text.trim());
  });
}

module.exports = { colours };
