// The extension: a client for `admire lsp`, and the commands that solve a model and show it.
"use strict";

const { execFile } = require("node:child_process");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { promisify } = require("node:util");
const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");
const commands = require("./commands");

let client;
let restarted = Promise.resolve();
let watched;

function activate(context) {
  const command = (name, action) => context.subscriptions.push(vscode.commands.registerCommand(name, action));
  command("admire.solve", (uri) => withFile(uri, solve));
  command("admire.view", (uri) => withFile(uri, show));
  command("admire.restart", restart);
  watched = vscode.workspace.createFileSystemWatcher("**/{admire.toml,*.[aA][dD][mM],*.[aA][cC][fF]}");
  context.subscriptions.push(
    watched,
    vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("admire.path") && restart()),
    vscode.workspace.onDidGrantWorkspaceTrust(restart),
  );
  restart();
}

function deactivate() {
  restarted = restarted.then(stop);
  return restarted;
}

/** Returns the program of the settings. */
function program() {
  return vscode.workspace.getConfiguration("admire").get("path") || "admire";
}

/** Starts the language server anew, after whatever start or stop is under way. */
function restart() {
  restarted = restarted.then(stop).then(start);
  return restarted;
}

async function start() {
  try {
    await promisify(execFile)(program(), ["--version"]);
  } catch (error) {
    failed(error);
    return;
  }
  const languages = ["adams-adm", "adams-acf"];
  client = new LanguageClient(
    "admire",
    { command: program(), args: ["lsp"], transport: TransportKind.stdio },
    {
      documentSelector: languages.flatMap((language) => ["file", "untitled"].map((scheme) => ({ scheme, language }))),
      synchronize: { fileEvents: watched },
    },
  );
  try {
    await client.start();
  } catch {
    // The client has said why.
  }
}

async function stop() {
  try {
    await client?.dispose();
  } catch {
    // A server that did not start cannot be stopped.
  }
  client = undefined;
}

/** Says why the program does not run, and offers its setting. */
async function failed(error) {
  const why =
    error.code === "ENOENT"
      ? `The program \`${program()}\` is not found. Install admire, or set its path.`
      : `The program \`${program()}\` does not run: ${error.message}`;
  if (await vscode.window.showErrorMessage(why, "Set the path")) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "admire.path");
  }
}

/** Runs an action on a file: the given one, or the one in the active editor. The file is saved first, because programs read the disk. */
async function withFile(uri, action) {
  const file = uri ?? vscode.window.activeTextEditor?.document.uri;
  const open = vscode.workspace.textDocuments.find((document) => document.uri.toString() === file?.toString());
  if (file?.scheme !== "file" || (open?.isDirty && !(await open.save()))) {
    return vscode.window.showErrorMessage("Open a deck or command file, and save it.");
  }
  return action(file.fsPath);
}

/** Solves a deck or executes a command file, in a terminal. */
async function solve(file) {
  const options = { cwd: path.dirname(file) };
  const run = new vscode.ProcessExecution(program(), commands.solve(file), options);
  const name = `solve ${path.basename(file)}`;
  const task = new vscode.Task({ type: "admire" }, vscode.TaskScope.Workspace, name, "admire", run, []);
  task.presentationOptions = { clear: true, focus: false, panel: vscode.TaskPanelKind.Dedicated };
  await vscode.tasks.executeTask(task);
}

/** Shows a deck in three dimensions beside the editor, at the design position or moving through results. */
async function show(deck) {
  const design = "design position";
  const runs = commands.results(deck);
  const picked = runs.length ? await vscode.window.showQuickPick([design, ...runs], { title: "Position of the parts" }) : design;
  if (!picked) {
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "admire-"));
  const page = path.join(folder, "view.html");
  const run = picked === design ? undefined : path.join(path.dirname(deck), picked);
  execFile(program(), commands.view(deck, run, page), { cwd: path.dirname(deck) }, (error, _, complaints) => {
    if (fs.existsSync(page)) {
      const title = path.basename(deck);
      const options = { enableScripts: true, retainContextWhenHidden: true };
      const panel = vscode.window.createWebviewPanel("admire.view", title, vscode.ViewColumn.Beside, options);
      panel.webview.html = fs.readFileSync(page, "utf8");
    } else if (error?.code === "ENOENT") {
      failed(error);
    } else {
      vscode.window.showErrorMessage(complaints.trim() || error.message);
    }
    fs.rmSync(folder, { recursive: true });
  });
}

module.exports = { activate, deactivate };
