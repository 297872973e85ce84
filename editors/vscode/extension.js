"use strict";
// Starts `exover lsp` and hands it every spec and properties file that is open.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const LANGUAGES = ["exo", "exo-properties"];
let client;

function start() {
  const settings = vscode.workspace.getConfiguration("exover");
  const [command, ...args] = settings.get("command");
  client = new LanguageClient(
    "exover",
    "exover",
    { command, args },
    {
      documentSelector: LANGUAGES.map((language) => ({ scheme: "file", language })),
      initializationOptions: { checkSeconds: settings.get("checkSeconds") },
    },
  );
  return client.start().catch((reason) => {
    const advice = "Is it installed? python -m pip install 'exover[lsp]'";
    vscode.window.showErrorMessage(`${command} cannot be started: ${reason.message}. ${advice}`);
  });
}

async function stop() {
  const running = client;
  client = undefined;
  if (running !== undefined && running.isRunning()) {
    await running.stop();
  }
}

async function restart() {
  await stop();
  await start();
}

async function activate(context) {
  context.subscriptions.push(
    vscode.commands.registerCommand("exover.restart", restart),
    vscode.workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("exover") && restart()),
  );
  await start();
}

module.exports = { activate, deactivate: stop };
