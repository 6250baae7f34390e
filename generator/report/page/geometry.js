// The fan: beams and samples to metres and back, and which pixel of the polar picture a pixel of the
// screen shows. x is ahead, y to port; azimuth is positive to port, and beam 0 is to starboard.

const geometries = new Map();

function geometryOf(sequence) {
  if (!geometries.has(sequence)) geometries.set(sequence, makeGeometry(sequence));
  return geometries.get(sequence);
}

function makeGeometry(sequence) {
  const { beams, samples, azimuth_rad: azimuth } = sequence;
  const spacing = beams > 1 ? (azimuth[beams - 1] - azimuth[0]) / (beams - 1)
                            : (sequence.sonar && sequence.sonar.beam_width_rad) || 0.02;
  const geometry = {
    beams, samples, azimuth, borders: bordersOf(azimuth, spacing),
    firstRange: sequence.first_range_m || 0, step: sequence.range_step_m,
  };
  geometry.low = geometry.borders[0];
  geometry.high = geometry.borders[beams];
  geometry.reach = geometry.firstRange + (samples - 0.5) * geometry.step;
  geometry.bounds = boundsOf(geometry);
  geometry.lookups = new Map();
  return geometry;
}

// Of the beams' sectors: halfway between two beams, and as far beyond the outer ones.
function bordersOf(azimuth, spacing) {
  const last = azimuth.length - 1;
  const low = last > 0 ? (azimuth[1] - azimuth[0]) / 2 : spacing / 2;
  const high = last > 0 ? (azimuth[last] - azimuth[last - 1]) / 2 : spacing / 2;
  const inner = azimuth.slice(1).map((value, i) => (azimuth[i] + value) / 2);
  return [azimuth[0] - low, ...inner, azimuth[last] + high];
}

// The rectangle that holds the fan, in metres.
function boundsOf({ low, high, reach }) {
  const angles = [low, high];
  for (const angle of [-Math.PI / 2, 0, Math.PI / 2]) {
    if (angle > low && angle < high) angles.push(angle);
  }
  const ahead = angles.map((angle) => reach * Math.cos(angle)).concat(0);
  const port = angles.map((angle) => reach * Math.sin(angle)).concat(0);
  return { top: Math.max(...ahead), bottom: Math.min(...ahead),
           left: Math.max(...port), right: Math.min(...port) };
}

function azimuthOf(geometry, beam) {
  return geometry.azimuth[beam];
}

function rangeOf(geometry, sample) {
  return geometry.firstRange + sample * geometry.step;
}

// The sector that holds the azimuth; -1 or the number of beams outside.
function beamAt({ borders }, azimuth) {
  if (!(azimuth >= borders[0])) return -1;
  let low = 0;
  let high = borders.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (borders[middle] <= azimuth) low = middle;
    else high = middle;
  }
  return low;
}

// Columns from the left border of the fan; beams have the same width in a polar plot.
function placeOf(geometry, azimuth) {
  const { borders, beams } = geometry;
  const beam = Math.min(Math.max(beamAt(geometry, azimuth), 0), beams - 1);
  return beam + (azimuth - borders[beam]) / (borders[beam + 1] - borders[beam]);
}

// The pixel whose sector holds the azimuth and whose sample is nearest in range; null outside.
function cellAt(geometry, range, azimuth) {
  const beam = beamAt(geometry, azimuth);
  const sample = Math.round((range - geometry.firstRange) / geometry.step);
  if (beam < 0 || beam >= geometry.beams || sample < 0 || sample >= geometry.samples) return null;
  return { beam, sample };
}

// Where the plot of a kind lies in metres or cells, in device pixels of its canvas.
function frameFor(kind, geometry, width, height) {
  if (kind === 'polar') {
    return { kind, width, height, across: width / geometry.beams, down: height / geometry.samples };
  }
  const { top, bottom, left, right } = geometry.bounds;
  const scale = Math.min(width / (left - right), height / (top - bottom));
  return { kind, width, height, scale,
           x0: (width - (left - right) * scale) / 2 + left * scale,
           y0: (height - (top - bottom) * scale) / 2 + top * scale };
}

function cellOfPixel(geometry, frame, x, y) {
  if (frame.kind === 'polar') {
    const beam = Math.floor(x / frame.across);
    const sample = Math.floor(y / frame.down);
    const inside = beam >= 0 && beam < geometry.beams && sample >= 0 && sample < geometry.samples;
    return inside ? { beam, sample } : null;
  }
  const ahead = (frame.y0 - y) / frame.scale;
  const port = (frame.x0 - x) / frame.scale;
  return cellAt(geometry, Math.hypot(ahead, port), Math.atan2(port, ahead));
}

function pixelOfCell(geometry, frame, beam, sample) {
  if (frame.kind === 'polar') {
    return { x: (beam + 0.5) * frame.across, y: (sample + 0.5) * frame.down };
  }
  return pixelOfPolar(frame, rangeOf(geometry, sample), azimuthOf(geometry, beam));
}

function pixelOfPolar(frame, range, azimuth) {
  return { x: frame.x0 - frame.scale * range * Math.sin(azimuth),
           y: frame.y0 - frame.scale * range * Math.cos(azimuth) };
}

const MOST_LOOKUPS = 6;

// For each pixel of a canvas the index of the cell that it shows, -1 outside: made once a size.
function lookupFor(kind, geometry, width, height) {
  const key = `${kind} ${width} ${height}`;
  if (!geometry.lookups.has(key)) {
    if (geometry.lookups.size >= MOST_LOOKUPS) {
      geometry.lookups.delete(geometry.lookups.keys().next().value);
    }
    geometry.lookups.set(key, makeLookup(frameFor(kind, geometry, width, height), geometry));
  }
  return geometry.lookups.get(key);
}

function makeLookup(frame, geometry) {
  const cells = new Int32Array(frame.width * frame.height);
  for (let y = 0, k = 0; y < frame.height; ++y) {
    for (let x = 0; x < frame.width; ++x, ++k) {
      const cell = cellOfPixel(geometry, frame, x + 0.5, y + 0.5);
      cells[k] = cell ? cell.sample * geometry.beams + cell.beam : -1;
    }
  }
  const rows = frame.kind === 'polar' ? frame.height : geometry.reach * frame.scale;
  return { frame, cells, samplesPerPixel: geometry.samples / rows };
}

// A vector turned by the quaternion w, x, y, z.
function turned([w, x, y, z], [a, b, c]) {
  const tx = 2 * (y * c - z * b);
  const ty = 2 * (z * a - x * c);
  const tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}
