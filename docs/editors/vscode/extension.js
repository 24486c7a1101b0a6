// Starts `pdlang lsp` for the laws of a window.
const { window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function start() {
  const command = workspace.getConfiguration("pdlang").get("path");
  const server = { command, args: ["lsp"] };
  client = new LanguageClient("pdlang", server, { documentSelector: [{ language: "pdlang" }] });
  return client.start().catch((error) =>
    window.showErrorMessage(
      `\`${command} lsp\` did not start (${error.message ?? error}): say in the setting \`pdlang.path\` where the program is`,
    ),
  );
}

// A client that did not start cannot be stopped.
function stop() {
  return client.stop().catch(() => {});
}

function activate(context) {
  const moved = workspace.onDidChangeConfiguration(async (change) => {
    if (change.affectsConfiguration("pdlang.path")) {
      await stop();
      await start();
    }
  });
  context.subscriptions.push(moved);
  return start();
}

module.exports = { activate, deactivate: stop };
