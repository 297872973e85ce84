// Runs editors/vscode/extension.js with stand-ins for the editor and for the client library; prints what it asks of them.
"use strict";
const Module = require("node:module");
const said = [];
const settings = { command: ["here/exover", "lsp"], checkSeconds: 3 };
const listeners = {};
const vscode = {
  workspace: {
    getConfiguration: () => ({ get: (name) => settings[name] }),
    onDidChangeConfiguration: (listener) => (listeners.changed = listener),
  },
  commands: { registerCommand: (name, action) => (listeners[name] = action) },
  window: { showErrorMessage: (text) => said.push(["error", text]) },
};
class LanguageClient {
  constructor(id, name, server, client) {
    said.push(["new", id, server, client]);
  }
  async start() {
    said.push(["start"]);
    if (settings.command[0] === "nothing") throw new Error("ENOENT");
  }
  isRunning() {
    return true;
  }
  async stop() {
    said.push(["stop"]);
  }
}
const load = Module._load;
Module._load = (name, ...rest) => ({ vscode, "vscode-languageclient/node": { LanguageClient } })[name] ?? load(name, ...rest);
const extension = require(process.argv[2]);
(async () => {
  const subscriptions = [];
  await extension.activate({ subscriptions });
  await listeners["exover.restart"]();
  listeners.changed({ affectsConfiguration: (name) => name === "other" });
  settings.command = ["nothing"];
  await listeners.changed({ affectsConfiguration: (name) => name === "exover" });
  await extension.deactivate();
  console.log(JSON.stringify({ said, subscriptions: subscriptions.length }));
})();
