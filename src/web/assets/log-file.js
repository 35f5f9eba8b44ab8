// The columns of a log, as the server understands them: of a text its beginning is sent, of any other format the whole file.
import { send } from './api.js';

/** Bytes of a text that are looked at: some thousand rows of any robot. */
const HEAD = 1 << 20;
/** First bytes of the formats that are read as a whole. */
const WHOLE = ['\x89MCAP0', 'SQLite format 3', 'PAR1', 'MATLAB 5.0', 'PK\x03\x04', '(\xb5/\xfd'];

/** Resolves with {file, rows, whole, columns: [{name, at, unit, values, points, numeric, shown, largest}]}; rejects with what is wrong. */
export async function readHead(file) {
  const bytes = await firstBytes(file);
  const begin = String.fromCharCode(...bytes.slice(0, 64));
  const form = new FormData();
  form.append('log', WHOLE.some((magic) => begin.startsWith(magic)) ? file : new Blob([bytes]), file.name);
  const head = await (await send('/logs/columns', { method: 'POST', body: form })).json();
  const number = (v) => v ?? NaN;
  return { file: file.name, rows: head.rows, whole: head.whole && bytes.length < HEAD, columns: head.columns.map((c, at) => ({ ...c, at, values: c.first.map(number), points: c.points.map(number), shown: c.first.slice(0, 3).map((v) => (v === null ? '–' : String(v))) })) };
}

async function firstBytes(file) {
  const start = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (start[0] !== 0x1f || start[1] !== 0x8b) return new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  const reader = file.stream().pipeThrough(new DecompressionStream('gzip')).getReader();
  const parts = [];
  try {
    for (let size = 0; size < HEAD;) {
      const { value, done } = await reader.read();
      if (done) break;
      parts.push(value);
      size += value.length;
    }
  } catch {
    // What is wrong with the compression the server says.
    return new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  }
  reader.cancel().catch(() => {});
  const whole = new Uint8Array(parts.reduce((n, p) => n + p.length, 0));
  parts.reduce((at, p) => (whole.set(p, at), at + p.length), 0);
  return whole.slice(0, HEAD);
}
