// What a plugin in AssemblyScript needs of the component model, and no more: records of the interface as bytes at their
// places. A plugin lives for one evaluation, so nothing is ever freed. `grimace plugin build` gives `describe` and `evaluate`
// the names that the interface asks for.

// @ts-ignore: a decorator of AssemblyScript
@external("grimace:node/host@0.1.0", "progress")
declare function hostProgress(fraction: f64, numbers: usize, count: u32): i32;

/** Memory of `size` bytes, filled with zeros, at a multiple of 8. */
export function take(size: usize): usize {
  const start = (heap.alloc(size + 8) + 7) & ~7;
  memory.fill(start, 0, size);
  return start;
}

export function cabi_realloc(old: usize, oldSize: usize, align: usize, size: usize): usize {
  const start = take(size);
  memory.copy(start, old, oldSize < size ? oldSize : size);
  return start;
}

/** A text or a list at `at`: where it lies, and how long it is. */
export function pair(at: usize, where: usize, length: u32): void {
  store<u32>(at, where as u32);
  store<u32>(at, length, 4);
}

export function text(at: usize, words: string): void {
  const bytes = String.UTF8.encode(words);
  const where = take(bytes.byteLength);
  memory.copy(where, changetype<usize>(bytes), bytes.byteLength);
  pair(at, where, bytes.byteLength);
}

/** A port of 28 bytes at `at`. */
export function port(at: usize, name: string, type: string, doc: string): void {
  text(at, name);
  text(at + 8, type);
  text(at + 16, doc);
}

/** A parameter of 72 bytes at `at` that is a number. */
export function number(at: usize, name: string, doc: string, value: f64, least: f64, most: f64): void {
  text(at, name);
  text(at + 8, doc);
  store<u8>(at, 2, 16);
  store<f64>(at, value, 24);
  store<u8>(at, 1, 32);
  store<f64>(at, least, 40);
  store<u8>(at, 1, 48);
  store<f64>(at, most, 56);
}

/** Whether the user no longer wants the result. */
export function stopped(fraction: f64): bool {
  return hostProgress(fraction, 0, 0) != 0;
}
