// Command lines.

/** A word of a command line, in quotes if a shell would split it. */
export function word(text: string): string {
  return /^[\w./:=,+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}
