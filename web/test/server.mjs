// A plain file server on the loopback address, as anybody may have one.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml", ".nc": "text/plain" };

/** Serves a folder; `asked` gets every path that was asked for. */
export async function serve(folder, asked) {
  const server = createServer(async (request, answer) => {
    const path = normalize(new URL(request.url, "http://here").pathname);
    asked.push(path);
    try {
      const content = await readFile(join(folder, path === "/" ? "index.html" : path));
      answer.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/html" }).end(content);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}
