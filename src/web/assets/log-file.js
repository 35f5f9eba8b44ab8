// The beginning of a log, read in the browser: what kind of file it is, its columns, and some rows to look at.

/** Bytes that are looked at: some thousand rows of any robot. */
const HEAD = 1 << 20;
/** Points of a small picture. */
const POINTS = 160;

/** First bytes by which formats are known, what they are called, and what to do. */
const KINDS = [
  ['\x89MCAP0', 'an MCAP recording'], ['#ROSBAG', 'a ROS 1 bag'], ['SQLite format 3', 'an SQLite database (perhaps a ROS 2 bag)'], ['PAR1', 'a Parquet file'], ['\x89HDF', 'an HDF5 or MATLAB 7.3 file'], ['MATLAB 5.0', 'a MATLAB file'],
  ['\x93NUMPY', 'a NumPy array'], ['PK\x03\x04', 'a ZIP archive, or a spreadsheet (.xlsx, .ods, .npz)'], ['\xd0\xcf\x11\xe0', 'an old Excel file'], ['BZh', 'a bzip2 file'], ['\xfd7zXZ', 'an xz file'], ['(\xb5/\xfd', 'a Zstandard file'], ['%PDF', 'a PDF'], ['\x89PNG', 'a picture'],
  ['{', 'a JSON document'], ['<', 'an XML document'],
];

/** What is wrong with a file as a log, in words; `hint` says what to do. */
class NoLog extends Error {
  constructor(detail, hint) {
    super(detail);
    this.problem = { detail, hint };
  }
}

/** Resolves with {columns: [{name, values, points, numeric}], rows}; rejects with the words for a file that is no table. */
export async function readHead(file) {
  const bytes = await firstBytes(file);
  if (!bytes.length) throw new NoLog(`${file.name} is empty.`, 'Was the recording stopped before it was written?');
  const begin = String.fromCharCode(...bytes.slice(0, 64));
  const kind = KINDS.find(([magic]) => begin.startsWith(magic));
  if (kind) throw new NoLog(`${file.name} is ${kind[1]}, not a table of text.`, 'Export it as CSV: one row per sample, with a header that names the columns.');
  if (bytes.slice(0, 4096).includes(0)) throw new NoLog(`${file.name} is a binary file.`, 'Export it as CSV: one row per sample, with a header that names the columns.');
  return parse(file.name, new TextDecoder('utf-8').decode(bytes).replace(/^\ufeff/, ''), bytes.length >= HEAD);
}

async function firstBytes(file) {
  const start = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (start[0] !== 0x1f || start[1] !== 0x8b) return new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  const reader = file.stream().pipeThrough(new DecompressionStream('gzip')).getReader();
  const parts = [];
  for (let size = 0; size < HEAD;) {
    const { value, done } = await reader.read();
    if (done) break;
    parts.push(value);
    size += value.length;
  }
  reader.cancel().catch(() => {});
  const whole = new Uint8Array(parts.reduce((n, p) => n + p.length, 0));
  parts.reduce((at, p) => (whole.set(p, at), at + p.length), 0);
  return whole.slice(0, HEAD);
}

const cells = (line, separator) => (separator === ' ' ? line.trim().split(/\s+/) : line.split(separator)).map((c) => c.trim().replace(/^"(.*)"$/, '$1'));

function parse(name, text, cut) {
  const lines = text.split(/\r\n|\n|\r/);
  // The last line may be cut off in the middle.
  if (cut) lines.pop();
  const filled = lines.filter((l) => l.trim());
  const first = filled.findIndex((l) => !l.startsWith('#'));
  const commented = first > 0 && numbersIn(filled[first]) ? filled[first - 1].replace(/^#+\s*/, '') : null;
  const header = commented ?? filled[first] ?? '';
  const separator = [',', ';', '\t', ' '].find((s) => cells(header, s).length > 1) ?? ',';
  const names = cells(header, separator);
  if (!commented && names.every((n) => n !== '' && Number.isFinite(Number(n)))) throw new NoLog(`${name} has no header: its first row is numbers.`, 'Put a first row with the names of the columns, such as time, q1, …, tau1, ….');
  if (names.length < 3) throw new NoLog(`${name} has ${names.length} column${names.length > 1 ? 's' : ''}.`, 'A log has at least a position and a torque for every joint, separated by commas, semicolons, tabs or spaces.');
  const rows = filled.slice(commented ? first : first + 1).map((l) => cells(separator === ';' ? l.replaceAll(',', '.') : l, separator));
  const step = Math.max(1, Math.floor(rows.length / POINTS));
  return { file: name, rows: rows.length, whole: !cut, columns: names.map((column, at) => {
    const values = rows.map((r) => Number(r[at] === '' || r[at] === undefined ? NaN : r[at]));
    const numeric = values.filter(Number.isFinite).length > values.length / 2;
    return { name: column, at, values, numeric, shown: rows.slice(0, 3).map((r) => r[at] ?? ''), points: values.filter((_, i) => i % step === 0) };
  }) };
}

const numbersIn = (line) => [',', ';', '\t', ' '].some((s) => { const parts = cells(line, s); return parts.length > 2 && parts.every((p) => Number.isFinite(Number(p))); });
