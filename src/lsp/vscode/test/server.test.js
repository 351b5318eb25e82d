// The language server, spoken to with the library of the editor's client.
"use strict";

const assert = require("node:assert");
const path = require("node:path");
const { test } = require("node:test");
const { read, root, rpc, withServer } = require("./support");

const deck = path.join(root, "corpus/kc-experiment/model.adm");

/** Returns the place of the first occurrence of a text, `offset` characters into it. */
function place(text, part, offset = 0) {
  const at = text.indexOf(part);
  assert.ok(at >= 0, part);
  const before = text.slice(0, at + offset).split("\n");
  return { line: before.length - 1, character: before.at(-1).length };
}

test("a deck is opened, complained about, explained and completed", { timeout: 60_000 }, async () => {
  const code = await withServer(async (client) => {
    assert.ok(client.capabilities.renameProvider && client.capabilities.documentFormattingProvider);
    const text = read(deck);
    const uri = await client.open(deck, text);
    const fine = await client.complaints(uri, () => true);
    assert.deepStrictEqual(fine.filter((complaint) => complaint.severity === rpc.DiagnosticSeverity.Error), []);

    const hover = await client.ask(rpc.HoverRequest, uri, place(text, "BUSHING/", 2));
    assert.match(hover.contents.value, /BUSHING[\s\S]*stiffness/i);

    const broken = text.replace(/^(BUSHING\/\d+)/m, "$1, STIFNESS = 5");
    assert.notStrictEqual(broken, text);
    await client.change(uri, 2, broken);
    const [complaint] = await client.complaints(uri, (all) => all.length > 0);
    assert.strictEqual(complaint.source, "admire");
    assert.match(complaint.message, /STIFNESS/);
    assert.deepStrictEqual(complaint.range.start, place(broken, "STIFNESS"));

    const typed = text.replace(/^END\b/m, "JOINT/77, SPHE\nEND");
    await client.change(uri, 3, typed);
    const offered = await client.ask(rpc.CompletionRequest, uri, place(typed, "77, SPHE", 8));
    const labels = (offered.items ?? offered).map((item) => item.label);
    assert.ok(labels.includes("SPHERICAL"), labels.join(" "));
  });
  assert.strictEqual(code, 0);
});

test("a command file is checked against its deck", { timeout: 60_000 }, async () => {
  await withServer(async (client) => {
    const commands = path.join(path.dirname(deck), "unsaved.acf");
    const uri = await client.open(commands, "FILE/MODEL=model\nSFORCE/99, FUNCTION = 5\nSIMULATE/STATICS\n");
    const [complaint] = await client.complaints(uri, (all) => all.length > 0);
    assert.match(complaint.message, /SFORCE\/99/);
    assert.strictEqual(complaint.range.start.line, 1);
  });
});
