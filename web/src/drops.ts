// Files that are dropped on the page. Wherever they fall, the browser does not open them in its place.

/** Calls `take` with a file, and where it fell. While one is over the page, `over` is marked. */
export function takeDropped(over: HTMLElement, take: (file: File, at: Node) => void): void {
  const hasFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  for (const kind of ["dragenter", "dragover"] as const) {
    window.addEventListener(kind, (event) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      over.classList.add("over");
    });
  }
  window.addEventListener("dragleave", (event) => event.relatedTarget === null && over.classList.remove("over"));
  window.addEventListener("drop", (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    over.classList.remove("over");
    const [file] = event.dataTransfer?.files ?? [];
    if (file && event.target instanceof Node) take(file, event.target);
  });
}
