// The grammars, on real files. Which statements a file has is known from the parser of `admire`, which the grammars know nothing of.
"use strict";

const assert = require("node:assert");
const path = require("node:path");
const { test } = require("node:test");
const { colours } = require("./colours");
const { files, language, read, root, rpc, withServer } = require("./support");

const is = (piece, scope) => piece.scopes.some((own) => own.startsWith(scope));

/** Returns the statements that the colours show, as `line:column KEYWORD/ID`. */
function statements(pieces) {
  const found = [];
  for (const piece of pieces) {
    if (is(piece, "keyword.control")) {
      const kind = piece.scopes.find((scope) => scope.startsWith("meta.statement."));
      found.push(`${piece.line}:${piece.column} ${kind?.split(".")[2].toUpperCase() ?? "END"}`);
    } else if (is(piece, "entity.name.type.id")) {
      found[found.length - 1] += `/${Number(piece.text)}`;
    }
  }
  return found;
}

test("the statements of every deck and command file are coloured where the parser reads them", { timeout: 300_000 }, async () => {
  const all = [...files("corpus", ".adm", ".acf"), ...files("../shared/real-decks", ".adm", ".acf")];
  assert.ok(all.length > 100);
  let count = 0;
  await withServer(async (client) => {
    for (const file of all) {
      const text = read(file);
      const uri = await client.open(file, text);
      const symbols = await client.ask(rpc.DocumentSymbolRequest, uri);
      const read_ = symbols.map(({ name, selectionRange: { start } }) => `${start.line}:${start.character} ${name.split(" ")[0]}`);
      const seen = statements(await colours(text, language(file)));
      assert.deepStrictEqual(seen, read_, path.relative(root, file));
      count += seen.length;
    }
  });
  console.log(`${all.length} files, ${count} statements`);
});

test("every word of a deck has a colour, except mistakes", { timeout: 300_000 }, async () => {
  const plain = async (file) => {
    const pieces = await colours(read(file), language(file));
    const without = pieces.filter(({ scopes, text }) => /\w/.test(text) && /^(source|meta)\./.test(scopes.at(-1)));
    return without.map((piece) => `${path.basename(file)}: ${piece.text.trim()}`);
  };
  const all = [...files("corpus", ".adm", ".acf"), ...files("../shared/real-decks", ".adm", ".acf")];
  const found = await Promise.all(all.map(plain));
  assert.deepStrictEqual(found.flat(), [
    "ambiguous-keyword.adm: F/1, I = 20, J = 10",
    "bad-number.adm: 50O0",
    "unknown-argument.adm: STIFFNESS",
    "unknown-statement.adm: BUSHIGN/1, I = 20, J = 10",
    "wrong-type.adm: CURVED",
  ]);
});

/** Returns the innermost scope of each piece of a text, as `text=scope` with the scope's ending left out. */
async function scopes(text, language) {
  const pieces = await colours(text, language);
  return pieces.map((piece) => `${piece.text.trim()}=${piece.scopes.at(-1).replace(/\.(adams|teimorbit)$/, "")}`);
}

/** Asserts that a text has pieces with these scopes, in this order. Other pieces may lie between them. */
async function has(text, language, wanted) {
  const found = await scopes(text, language);
  let at = 0;
  for (const piece of wanted) {
    at = found.indexOf(piece, at) + 1;
    assert.ok(at > 0, `${piece} is not among ${found.join("  ")}`);
  }
}

test("arguments, flags, words, functions, comments and what follows END", async () => {
  const deck = `BUSHING/1, a title
! adams_view_name='arm' ! admire: ignore
SFO/7, TRANSLATIONAL ! admire: ignore[tab]
, I = 21, J = 0011, FUNCTION = 2*STEP(TIME, 0, 90D, 1.5E+02, -.5)
! between
,\t- AX(21, 11)\\
, ACTIONONLY
UNITS/FORCE = NEW, MASS = kilogram; STRING/3, STRING = K = 5 of "a!b"
K = 7
REQUEST/1, COMMENT = F1 of the arm ! not this
END
PART/9, GROUND`;
  await has(deck, "adams-adm", [
    "BUSHING/1, a title=markup.heading.title",
    "arm=string.quoted.single",
    "SFO=keyword.control",
    "7=entity.name.type.id",
    "TRANSLATIONAL=storage.modifier",
    "admire: ignore=keyword.other.directive",
    "I=variable.parameter",
    "21=constant.numeric",
    "FUNCTION=variable.parameter",
    "*=keyword.operator",
    "STEP=support.function",
    "TIME=variable.language",
    "90=constant.numeric",
    "D=keyword.other.unit",
    "1.5E+02=constant.numeric",
    ".5=constant.numeric",
    "! between=comment.line.exclamation",
    ",=punctuation.separator.continuation",
    "AX=support.function",
    "\\=punctuation.terminator.function",
    "ACTIONONLY=storage.modifier",
    "UNITS=keyword.control",
    "NEW=constant.language",
    "kilogram=constant.language",
    "STRING=keyword.control",
    "3=entity.name.type.id",
    "STRING=variable.parameter",
    "K = 7=source",
    "COMMENT=variable.parameter",
    "F1 of the arm=string.unquoted",
    "! not this=comment.line.exclamation",
    "END=keyword.control",
    "PART/9, GROUND=comment.block",
  ]);
});

test("lines that an ampersand or a comma continues belong to their statement", async () => {
  const commands = `folder/model.adm
run 1
SIMULATE/DYNAMICS, & ! so long

! between
END = 1, &
STEPS = 10
MOTION/1, FUNCTION = STEP(TIME,
 0, 0, 1, 5),
JOINT/2
STOP`;
  await has(commands, "adams-acf", [
    "folder/model.adm=string.unquoted.file",
    "run 1=string.unquoted.file",
    "DYNAMICS=storage.modifier",
    "&=punctuation.separator.continuation",
    "! so long=comment.line.exclamation",
    "! between=comment.line.exclamation",
    "END=variable.parameter",
    "&=punctuation.separator.continuation",
    "STEPS=variable.parameter",
    "10=constant.numeric",
    "MOTION=keyword.control",
    "5=constant.numeric",
    "JOINT=keyword.control",
    "STOP=keyword.control",
  ]);
  await has("SIMULATE/STATICS\nSTOP", "adams-acf", ["SIMULATE=keyword.control", "STOP=keyword.control"]);
});

test("files of Adams/Car: blocks, parts, headings, keys, texts, numbers", async () => {
  const all = [...files("corpus", ".sub", ".bus", ".spr"), ...files("../shared/real-car-files", ".sub", ".asy", ".spr", ".tir")];
  assert.ok(all.length >= 3);
  for (const file of all) {
    const text = read(file);
    const blocks = (await colours(text, "teimorbit")).filter((piece) => is(piece, "keyword.control.block"));
    const wanted = text.split(/\r?\n/).flatMap((line) => line.match(/^\s*\[(.*?)\]/)?.[1] ?? []);
    assert.deepStrictEqual(blocks.map((piece) => piece.text), wanted, file);
  }
  await has(read(files("corpus", ".sub")[0]), "teimorbit", [
    "MDI_HEADER=keyword.control.block",
    "FILE_TYPE=variable.parameter",
    "==keyword.operator",
    "'sub'=string.quoted.single",
    "7.0=constant.numeric",
    "hardpoint_name=support.type.column",
    "'global_reference            '=string.quoted.single",
    "-500.0=constant.numeric",
  ]);
});
