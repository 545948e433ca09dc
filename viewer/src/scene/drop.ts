/** Files dropped anywhere on the page, or picked from a menu. */

/** `over` is told while a file hangs above the page. */
export function acceptDrops(take: (file: File) => void, over: (hanging: boolean) => void): void {
  let depth = 0;
  const hasFile = (event: DragEvent) => Array.from(event.dataTransfer?.types ?? []).includes("Files");
  window.addEventListener("dragenter", (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    if (++depth === 1) over(true);
  });
  window.addEventListener("dragover", (event) => {
    if (hasFile(event)) event.preventDefault();
  });
  window.addEventListener("dragleave", (event) => {
    if (hasFile(event) && --depth <= 0) {
      depth = 0;
      over(false);
    }
  });
  window.addEventListener("drop", (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    depth = 0;
    over(false);
    const file = event.dataTransfer?.files[0];
    if (file) take(file);
  });
}

/** Opens the browser's own choice of files. */
export function pickFile(take: (file: File) => void): void {
  const input = document.createElement("input");
  input.type = "file";
  input.accept = ".glb,.vrm,.gltf";
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    if (file) take(file);
  });
  input.click();
}
