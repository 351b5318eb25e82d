// What the tests share: the program, the decks, and a client of the language server.
"use strict";

const { execFileSync, spawn } = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");
const { pathToFileURL } = require("node:url");
const rpc = require("vscode-languageserver-protocol/node");

const root = path.resolve(__dirname, "../../../..");
const admire = process.env.ADMIRE || path.join(root, "target/debug/admire");

/** Returns all files below a folder of the project whose name ends in one of the extensions; none if the folder is absent. */
function files(folder, ...extensions) {
  const full = path.join(root, folder);
  if (!fs.existsSync(full)) {
    if (process.env.CI) {
      throw new Error(`${full} is missing, and CI skips nothing`);
    }
    process.stderr.write(`skipped: ${full} is missing\n`);
    return [];
  }
  const all = fs.readdirSync(full, { recursive: true }).sort().map((name) => path.join(full, name));
  return all.filter((file) => extensions.includes(path.extname(file).toLowerCase()));
}

/** Returns the text of a file: UTF-8, or Latin-1 where it is not. */
function read(file) {
  const bytes = fs.readFileSync(file);
  const text = bytes.toString("utf8");
  return text.includes("\uFFFD") ? bytes.toString("latin1") : text;
}

/** Returns the id of the language that the extension gives to a file. */
function language(file) {
  return path.extname(file).toLowerCase() === ".acf" ? "adams-acf" : "adams-adm";
}

/** Starts the language server as the extension does, and hands its client to a test. */
async function withServer(test) {
  const server = spawn(admire, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
  const connection = rpc.createProtocolConnection(
    new rpc.StreamMessageReader(server.stdout),
    new rpc.StreamMessageWriter(server.stdin),
  );
  const published = new Map();
  let notify = () => {};
  connection.onNotification(rpc.PublishDiagnosticsNotification.type, ({ uri, diagnostics }) => {
    published.set(uri, diagnostics);
    notify();
  });
  connection.listen();
  const { capabilities } = await connection.sendRequest(rpc.InitializeRequest.type, {
    processId: process.pid,
    rootUri: null,
    workspaceFolders: null,
    capabilities: {
      textDocument: {
        hover: { contentFormat: ["markdown"] },
        completion: { completionItem: { snippetSupport: true } },
        documentSymbol: { hierarchicalDocumentSymbolSupport: true },
      },
    },
  });
  await connection.sendNotification(rpc.InitializedNotification.type, {});
  const client = {
    capabilities,
    /** Opens a text as a file and returns its address. */
    async open(file, text = read(file)) {
      const uri = pathToFileURL(file).href;
      const textDocument = { uri, languageId: language(file), version: 1, text };
      await connection.sendNotification(rpc.DidOpenTextDocumentNotification.type, { textDocument });
      return uri;
    },
    change: (uri, version, text) =>
      connection.sendNotification(rpc.DidChangeTextDocumentNotification.type, {
        textDocument: { uri, version },
        contentChanges: [{ text }],
      }),
    /** Waits for complaints about a file that satisfy a condition. */
    async complaints(uri, wanted) {
      while (!published.has(uri) || !wanted(published.get(uri))) {
        await new Promise((resolve) => (notify = resolve));
      }
      return published.get(uri);
    },
    ask: (request, uri, position) => connection.sendRequest(request.type, { textDocument: { uri }, position }),
  };
  const ended = new Promise((resolve) => server.on("exit", resolve));
  try {
    await test(client);
    await connection.sendRequest(rpc.ShutdownRequest.type);
    await connection.sendNotification(rpc.ExitNotification.type);
    return await ended;
  } finally {
    connection.dispose();
    server.kill();
  }
}

/** Returns what `admire check` says about files, as its JSON. */
function check(...files) {
  try {
    return execFileSync(admire, ["check", "--format", "json", ...files], { encoding: "utf8" });
  } catch (error) {
    return error.stdout;
  }
}

module.exports = { admire, check, files, language, read, root, rpc, withServer };
