"use strict";
// Python in a thread of its own: calls of exover.playground, one after the other.

importScripts("pyodide/pyodide.js");

async function begun() {
  const pyodide = await loadPyodide({ indexURL: new URL("pyodide/", location.href).href });
  const found = await fetch("exover.zip");
  if (!found.ok) throw new Error(`exover.zip: ${found.status} ${found.statusText}`);
  pyodide.unpackArchive(await found.arrayBuffer(), "zip", { extractDir: "/exover" });
  pyodide.runPython("import sys; sys.path.insert(0, '/exover')");
  const module = pyodide.pyimport("exover.playground");
  module.look("spec s; module m { request a(); }"); // imports what is needed to answer
  postMessage({ ready: true });
  return module;
}

/** Return what an error says, of a traceback the last line. */
const said = (error) => String(error.message ?? error).trim().split("\n").at(-1);

const ready = begun();
ready.catch((error) => postMessage({ failed: said(error) }));

onmessage = async ({ data: { id, call, args } }) => {
  try {
    const module = await ready;
    postMessage({ id, result: JSON.parse(module[call](...args)) });
  } catch (error) {
    postMessage({ id, error: said(error) });
  }
};
