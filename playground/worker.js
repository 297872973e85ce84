"use strict";
// Python in a thread of its own: calls of exover.playground, one after the other.

importScripts("pyodide/pyodide.js");

async function begun() {
  const pyodide = await loadPyodide({ indexURL: new URL("pyodide/", location.href).href });
  const archive = await (await fetch("exover.zip")).arrayBuffer();
  pyodide.unpackArchive(archive, "zip", { extractDir: "/exover" });
  pyodide.runPython("import sys; sys.path.insert(0, '/exover')");
  const module = pyodide.pyimport("exover.playground");
  module.look("spec s; module m { request a(); }"); // imports what is needed to answer
  postMessage({ ready: true });
  return module;
}

const ready = begun();

onmessage = async ({ data: { id, call, args } }) => {
  try {
    const module = await ready;
    postMessage({ id, result: JSON.parse(module[call](...args)) });
  } catch (error) {
    postMessage({ id, error: String(error.message ?? error) });
  }
};
