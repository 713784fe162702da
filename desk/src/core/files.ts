// Dropped, picked and saved files. Nothing leaves the page.

import { strToU8, zipSync } from "fflate";

/** A file from the user: its path within the dropped folder, and its bytes. */
export interface Given {
  path: string;
  bytes: Uint8Array;
}

/** The name of a file without its folders. */
export const plainName = (path: string) => path.split("/").at(-1) ?? path;

/** Files in the module's format: paths and lengths, and the bytes one after the other. */
export function packed(files: readonly Given[]): [names: string, bytes: Uint8Array] {
  const bytes = new Uint8Array(files.reduce((sum, file) => sum + file.bytes.length, 0));
  let at = 0;
  for (const file of files) {
    bytes.set(file.bytes, at);
    at += file.bytes.length;
  }
  return [JSON.stringify(files.map((file) => [file.path, file.bytes.length])), bytes];
}

/** The text of bytes, if they are UTF-8. */
export function text(bytes: Uint8Array): string | undefined {
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return undefined;
  }
}

async function read(path: string, file: File): Promise<Given> {
  return { path, bytes: new Uint8Array(await file.arrayBuffer()) };
}

async function walk(entry: FileSystemEntry, found: Given[]): Promise<void> {
  if (entry.isFile) {
    const file = await new Promise<File>((done, failed) => (entry as FileSystemFileEntry).file(done, failed));
    found.push(await read(entry.fullPath.replace(/^\//, ""), file));
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
    if (some.length === 0) return;
    for (const child of some) await walk(child, found);
  }
}

/** Reports the files dropped on an element, including those in dropped folders. */
export function onDrop(element: HTMLElement, take: (files: Given[]) => void, failed: (error: unknown) => void): void {
  const over = (event: DragEvent) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    element.classList.add("over");
  };
  element.addEventListener("dragenter", over);
  element.addEventListener("dragover", over);
  element.addEventListener("dragleave", () => element.classList.remove("over"));
  element.addEventListener("drop", (event) => {
    element.classList.remove("over");
    if (!event.dataTransfer?.files.length) return;
    event.preventDefault();
    event.stopPropagation();
    // Both lists are valid only during the event: entries and files are read before the first await.
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
    const plain = [...event.dataTransfer.files];
    const walked = async () => {
      const found: Given[] = [];
      if (entries.some((entry) => entry !== null)) {
        for (const entry of entries) if (entry) await walk(entry, found);
      } else {
        for (const file of plain) found.push(await read(file.name, file));
      }
      take(found);
    };
    walked().catch(failed);
  });
}

/** A button that opens files, or a folder. */
export function picker(
  label: string,
  options: { accept?: string; folder?: boolean; several?: boolean },
  take: (files: Given[]) => void,
  failed: (error: unknown) => void,
): HTMLElement {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = options.several ?? false;
  if (options.accept) input.accept = options.accept;
  if (options.folder) input.webkitdirectory = true;
  const root = document.createElement("label");
  root.className = "picker";
  root.append(label, input);
  input.addEventListener("change", () => {
    const files = [...(input.files ?? [])];
    // Allows the same file to be picked again after a change.
    input.value = "";
    Promise.all(files.map((file) => read(file.webkitRelativePath || file.name, file))).then(take, failed);
  });
  return root;
}

/** Time between two downloads, ms: browsers drop those that follow one another too closely. */
const BETWEEN_DOWNLOADS_MS = 300;
let nextDownload = 0;

/** Downloads a file, after all previous ones. */
export function save(name: string, content: string | Uint8Array<ArrayBuffer>, type = "text/plain;charset=utf-8"): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  const now = performance.now();
  const at = Math.max(now, nextDownload);
  nextDownload = at + BETWEEN_DOWNLOADS_MS;
  setTimeout(() => link.click(), at - now);
  setTimeout(() => URL.revokeObjectURL(url), at - now + 120_000);
}

/** The earliest date that an archive can contain; a fixed one makes archives of equal files equal. */
const DATE = new Date(1980, 0, 1);

export function archive(files: Record<string, string>): Uint8Array<ArrayBuffer> {
  return zipSync(Object.fromEntries(Object.entries(files).map(([path, text]) => [path, strToU8(text)])), { mtime: DATE });
}

/** Name of a machine's file outside its folder. */
export function plain(file: string): string {
  return file.replaceAll("../", "").replaceAll("/", "-");
}
