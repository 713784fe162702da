// The state of the page as one text, for a link or a file.

import { message } from "./desk";
import type { Files } from "./machine";

/** Content of a link or a file. */
export interface SavedPage {
  version: 1;
  view: string;
  machine: { name: string; files: Files };
  /** State of each view. */
  views: Record<string, unknown>;
}

/** Largest unpacked size of a link. A text of a few kB can unpack to as many MB. */
const LARGEST = 16 << 20;

/** The output of a stream; stops reading, with an error, beyond `most` bytes. */
async function through(bytes: Uint8Array<ArrayBuffer>, stream: ReadableWritablePair<Uint8Array<ArrayBuffer>, BufferSource>, most: number): Promise<Uint8Array<ArrayBuffer>> {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let length = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    length += part.value.length;
    if (length > most) {
      await reader.cancel();
      throw new Error(`found more than ${most >> 20} MB in it, needed at most that`);
    }
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

/** The page's address with the whole state behind the #. */
export async function link(kept: SavedPage): Promise<string> {
  const whole = new TextEncoder().encode(JSON.stringify(kept));
  if (whole.length > LARGEST) throw new Error(`found ${Math.ceil(whole.length / (1 << 20))} MB, needed at most ${LARGEST >> 20} in a link: Save puts them into a file`);
  const bytes = await through(whole, new CompressionStream("deflate-raw"), 2 * LARGEST);
  let binary = "";
  for (let at = 0; at < bytes.length; at += 8192) binary += String.fromCharCode(...bytes.subarray(at, at + 8192));
  const text = btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  return `${location.href.split("#")[0]}#open=${text}`;
}

/** Bytes from base64. A loop: `Uint8Array.from` with a function takes half a second for the page's module. */
export function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** The state in a link's fragment; undefined without one. */
export async function fromLink(fragment: string): Promise<SavedPage | undefined> {
  const text = /^#open=([\w-]+)$/.exec(fragment)?.[1];
  if (!text) return undefined;
  try {
    const bytes = fromBase64(text.replaceAll("-", "+").replaceAll("_", "/"));
    return parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"), LARGEST)));
  } catch (error) {
    throw new Error(`the link is damaged or cut off (${message(error)}); needed: a link that this page made`);
  }
}

/** A kept state from its JSON. */
export function parse(text: string): SavedPage {
  const value = JSON.parse(text) as Partial<SavedPage>;
  if (value.version !== 1) throw new Error(`found version ${String(value.version)}, needed a file of version 1`);
  const { view, machine, views } = value;
  const files = machine?.files;
  const texts = typeof files === "object" && files !== null && Object.values(files).every((text) => typeof text === "string");
  if (typeof view !== "string" || !texts || typeof views !== "object" || views === null || Array.isArray(views))
    throw new Error("found a file without view, machine and views, needed one that this page saved");
  for (const [id, state] of Object.entries(views))
    if (typeof state !== "object" || state === null || Array.isArray(state))
      throw new Error(`views.${id}: found ${state === null ? "null" : `a ${Array.isArray(state) ? "list" : typeof state}`}, needed what this page saved of a view`);
  return { version: 1, view, machine: { name: String(machine?.name ?? "machine"), files: files as Files }, views };
}
