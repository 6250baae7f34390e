// NPY files of data sets, read by the tests' own code: float64, float32 and complex64, C order.
import { readFileSync } from 'node:fs';

export function readNpy(path) {
  const bytes = readFileSync(path);
  const length = bytes.readUInt16LE(8);
  const header = bytes.subarray(10, 10 + length).toString('latin1');
  const kind = /'descr': '([^']+)'/.exec(header)[1];
  const shape = /'shape': \(([^)]*)\)/.exec(header)[1].split(',').filter((t) => t.trim() !== '')
      .map(Number);
  const read = { '<f8': [8, 'readDoubleLE'], '<f4': [4, 'readFloatLE'], '<c8': [4, 'readFloatLE'] };
  if (!(kind in read) || header.includes("'fortran_order': True")) throw new Error(header);
  const [size, method] = read[kind];
  const values = [];
  for (let at = 10 + length; at < bytes.length; at += size) values.push(bytes[method](at));
  return { shape, values };
}

// Levels in dB re 1 µPa of a series, [beams][samples]; -Infinity without energy.
export function levelsOf(path) {
  const { shape: [beams, samples], values } = readNpy(path);
  const level = (k) => 20 * Math.log10(Math.hypot(values[2 * k], values[2 * k + 1])) + 120;
  return Array.from({ length: beams }, (_, beam) => Array.from(
      { length: samples }, (_, sample) => level(beam * samples + sample)));
}
