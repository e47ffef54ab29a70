// Starts `pirate lsp`, and lets it answer the editor. All that is offered comes from the server.
"use strict";

const path = require("node:path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

/** Return the command line of the server, and the folder that it starts in. */
function server() {
  const settings = vscode.workspace.getConfiguration("pirate_sm");
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  const named = settings.get("path");
  const command = named.includes("/") && folder ? path.resolve(folder, named) : named;
  const args = settings.get("outside") ? ["lsp", "--outside"] : ["lsp"];
  return { command, args, options: { cwd: folder } };
}

async function start() {
  const line = server();
  client = new LanguageClient("pirate_sm", "pirate_sm", line, {
    documentSelector: [{ scheme: "file", language: "yaml" }],
    synchronize: { configurationSection: "pirate_sm" },
  });
  try {
    await client.start();
  } catch (error) {
    const help = "Install it with pip install 'pirate-sm[lsp]', or set pirate_sm.path.";
    vscode.window.showErrorMessage(`${line.command} lsp cannot be started: ${error.message}. ${help}`);
  }
}

async function stop() {
  const ending = client;
  client = undefined;
  if (ending?.isRunning()) {
    await ending.stop();
  }
}

async function restart() {
  await stop();
  await start();
}

async function activate(context) {
  const changed = vscode.workspace.onDidChangeConfiguration((event) => {
    if (["path", "outside"].some((name) => event.affectsConfiguration(`pirate_sm.${name}`))) {
      return restart();
    }
  });
  context.subscriptions.push(changed, vscode.commands.registerCommand("pirate_sm.restart", restart));
  await start();
}

module.exports = { activate, deactivate: stop };
