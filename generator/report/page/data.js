// The page's own data: the report, and pictures that are decoded when they are asked for.

const report = JSON.parse(byId('report').textContent);
for (const member of ['classes', 'splits', 'counts', 'sequences', 'pings']) {
  report[member] = report[member] || [];
}

function chunkBytes(number) {
  const text = atob(byId(`chunk-${number}`).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  return bytes;
}

const MOST_DECODED = 64;
const decoded = new Map();  // in the order of last use

function remember(key, make) {
  const known = decoded.get(key);
  const value = known || make();
  decoded.delete(key);
  decoded.set(key, value);
  if (decoded.size > MOST_DECODED) decoded.delete(decoded.keys().next().value);
  return value;
}

async function decodePicture(number) {
  const blob = new Blob([chunkBytes(number)], { type: 'image/webp' });
  const bitmap = await createImageBitmap(
      blob, { premultiplyAlpha: 'none', colorSpaceConversion: 'none' });
  const canvas = document.createElement('canvas');
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

// The nearest pixel of a picture of another size.
function resized(values, width, height, toWidth, toHeight) {
  if (width === toWidth && height === toHeight) return values;
  const out = new values.constructor(toWidth * toHeight);
  for (let row = 0; row < toHeight; ++row) {
    const from = Math.min(height - 1, Math.floor(((row + 0.5) * height) / toHeight)) * width;
    for (let column = 0; column < toWidth; ++column) {
      const source = Math.min(width - 1, Math.floor(((column + 0.5) * width) / toWidth));
      out[row * toWidth + column] = values[from + source];
    }
  }
  return out;
}

// Codes of a grey picture on the grid [samples, beams]. Lossy pictures blur the code of nothing.
function greyCodes(number, sequence, lossy) {
  if (number === null || number === undefined) return null;
  return remember(`grey ${number}`, async () => {
    const picture = await decodePicture(number);
    const codes = new Uint8Array(picture.width * picture.height);
    for (let k = 0; k < codes.length; ++k) {
      const code = picture.data[4 * k + 1];
      codes[k] = lossy && code <= 2 ? 0 : code;
    }
    return resized(codes, picture.width, picture.height, sequence.beams, sequence.samples);
  });
}

// {ids, classes} of a picture of labels on the grid [samples, beams].
function labelIds(number, sequence) {
  if (number === null || number === undefined) return null;
  return remember(`labels ${number}`, async () => {
    const picture = await decodePicture(number);
    const ids = new Uint16Array(picture.width * picture.height);
    const classes = new Uint8Array(ids.length);
    for (let k = 0; k < ids.length; ++k) {
      ids[k] = picture.data[4 * k] | (picture.data[4 * k + 1] << 8);
      classes[k] = picture.data[4 * k + 2];
    }
    const size = [picture.width, picture.height, sequence.beams, sequence.samples];
    return { ids: resized(ids, ...size), classes: resized(classes, ...size) };
  });
}

// Levels in dB of the one beam that a ping has exactly; NaN where there is no energy.
function exactLevels(number) {
  if (number === null || number === undefined) return null;
  const bytes = chunkBytes(number);
  const view = new DataView(bytes.buffer);
  const levels = new Float32Array(bytes.length / 2);
  for (let k = 0; k < levels.length; ++k) {
    const hundredths = view.getInt16(2 * k, true);
    levels[k] = hundredths === -32768 ? NaN : hundredths / 100;
  }
  return levels;
}

// All that the viewer shows of a ping.
async function loadPing(index) {
  const record = report.pings[index];
  const sequence = report.sequences[record.sequence];
  const pictures = record.pictures || {};
  const [level, clean, elevation, labels, shadow, multipath] = await Promise.all([
    greyCodes(pictures.level, sequence, true),
    greyCodes(pictures.clean, sequence, true),
    greyCodes(pictures.elevation, sequence, false),
    labelIds(pictures.labels, sequence),
    labelIds(pictures.shadow, sequence),
    labelIds(pictures.multipath, sequence),
  ]);
  const exact = record.beam
      ? { beam: record.beam.beam, level: exactLevels(record.beam.level_db),
          clean: exactLevels(record.beam.clean_db) }
      : null;
  return {
    index, record, sequence, geometry: geometryOf(sequence),
    codes: { level, clean, elevation },
    instance: labels && labels.ids, semantic: labels && labels.classes,
    shadow: shadow && shadow.ids, multipath: multipath && multipath.ids, exact,
  };
}

// How the codes of a quantity are to be read.
function codingOf(quantity) {
  if (quantity !== 'elevation') return { min: report.scale.min_db, max: report.scale.max_db };
  const { min_rad: low, max_rad: high } = report.elevation || { min_rad: -1, max_rad: 1 };
  return { min: degrees(low), max: degrees(high), empty: 'none' };
}

function instanceOf(sequence, id) {
  if (!sequence.byId) {
    sequence.byId = new Map((sequence.instances || []).map((instance) => [instance.id, instance]));
  }
  return sequence.byId.get(id) || null;
}

function instanceName(sequence, id) {
  const instance = instanceOf(sequence, id);
  return instance ? instance.name : `instance ${id}`;
}

function className(id) {
  return report.classes[id - 1] || `class ${id}`;
}
