// A plain file server on the loopback address, as anybody may have one: `node serve.mjs FOLDER [PORT]`.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml", ".nc": "text/plain" };

/** Serves a folder on a port, or on any that is free. */
export async function serve(folder, port = 0) {
  const server = createServer(async (request, answer) => {
    const path = normalize(new URL(request.url, "http://here").pathname);
    try {
      const content = await readFile(join(folder, path === "/" ? "index.html" : path));
      answer.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/html" }).end(content);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [folder = ".", port = "8000"] = process.argv.slice(2);
  const { address } = await serve(folder, Number(port));
  console.log(`${address} until Ctrl-C`);
}
