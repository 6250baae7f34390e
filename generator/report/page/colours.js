// Colours of levels and of names. A colour is an unsigned 32-bit number as canvases of little-endian
// machines keep it: alpha, blue, green, red from the high byte down.

const MAP_NAMES = ['inferno', 'viridis', 'cividis', 'grey'];

function pack(red, green, blue) {
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

// 256 colours, on lines between the stops that the program's figures have too.
function readMap(name) {
  const stops = report.colour_maps[name];
  return Uint32Array.from({ length: 256 }, (_, k) => {
    const place = (k / 255) * (stops.length - 1), below = Math.min(Math.floor(place), stops.length - 2);
    const channel = (shift) => {
      const [from, to] = [stops[below], stops[below + 1]].map((stop) => (stop >> shift) & 255);
      return Math.round(from + (place - below) * (to - from));
    };
    return pack(channel(16), channel(8), channel(0));
  });
}

const readMaps = new Map();

function mapTable(name) {
  if (!readMaps.has(name)) readMaps.set(name, readMap(name));
  return readMaps.get(name);
}

// What is behind a code of a grey picture: 1..255 between two limits, 0 nothing.
function decode(code, coding) {
  return code === 0 ? NaN : coding.min + ((code - 1) / 254) * (coding.max - coding.min);
}

// The colour of each of the 256 codes, for display limits in the quantity's unit.
function colourOfCodes(mapName, coding, limits) {
  const map = mapTable(mapName);
  const colours = new Uint32Array(256);
  colours[0] = coding.empty === 'none' ? 0 : map[0];
  for (let code = 1; code < 256; ++code) {
    const share = (decode(code, coding) - limits.low) / (limits.high - limits.low);
    colours[code] = map[clamp(Math.round(share * 255), 0, 255)];
  }
  return colours;
}

// Told apart on dark and on light, and by most who see colours differently; after these, hues that
// go round by the golden angle.
const FIRST_COLOURS = ['4cc9f0', 'ffb703', 'ef476f', '7bd389', 'b892ff', 'ff8552', '2ec4b6',
                       'f78fb3', 'c5d86d', '8d99ae'];

function nameColour(id) {
  if (id <= 0) return [128, 128, 128];
  const first = FIRST_COLOURS[id - 1];
  if (first) {
    const digits = parseInt(first, 16);
    return [digits >> 16, (digits >> 8) & 255, digits & 255];
  }
  const hue = (id * 137.508) % 360;
  const light = 0.58 + 0.1 * ((id >> 3) % 3 - 1);
  return [0, 8, 4].map((n) => {
    const k = (n + hue / 30) % 12;
    const spread = 0.68 * Math.min(light, 1 - light);
    return Math.round(255 * (light - spread * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  });
}

// Classes have the same colours in another order, so that class 1 is not taken for instance 1.
function classColour(id) {
  return id <= FIRST_COLOURS.length ? nameColour(((id + 4) % FIRST_COLOURS.length) + 1)
                                    : nameColour(id + 100);
}

function cssColour([red, green, blue], alpha = 1) {
  return `rgb(${red} ${green} ${blue} / ${alpha})`;
}

// share of `over` on top of `under`, both packed.
function mix(under, over, share) {
  const keep = 1 - share;
  const red = (under & 255) * keep + (over & 255) * share;
  const green = ((under >> 8) & 255) * keep + ((over >> 8) & 255) * share;
  const blue = ((under >> 16) & 255) * keep + ((over >> 16) & 255) * share;
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

// Colours of all cells of a ping, and of the pixels of a canvas from them.

const HATCH = 5;           // cells between two lines of a hatched shadow
const WIDE = 0.2;          // share of the picture
const DIMMED = pack(18, 22, 28);

// The colours of the polar picture: what is shown, then overlays, then what a highlight leaves dim.
// view: {quantity, map, limits, coding, overlays, opacity, highlight}
function colourise(frame, view) {
  const { beams, samples } = frame.geometry;
  const colours = new Uint32Array(beams * samples);
  const codes = frame.codes[view.quantity];
  if (codes) {
    const table = colourOfCodes(view.map, view.coding, view.limits);
    for (let k = 0; k < colours.length; ++k) colours[k] = table[codes[k]];
  }
  if (view.overlays.shadow && frame.shadow) hatch(colours, frame.shadow, beams, view.opacity);
  if (view.overlays.multipath && frame.multipath) {
    cover(colours, frame.multipath, beams, view.opacity, nameColour);
  }
  if (view.overlays.semantic && frame.semantic) {
    cover(colours, frame.semantic, beams, view.opacity, classColour);
  }
  if (view.overlays.instance && frame.instance) {
    cover(colours, frame.instance, beams, view.opacity, nameColour);
  }
  if (view.highlight) dimAllBut(colours, frame, view.highlight);
  return colours;
}

function packedColours(colourOfId) {
  const known = new Map();
  return (id) => {
    if (!known.has(id)) known.set(id, pack(...colourOfId(id)));
    return known.get(id);
  };
}

// Is a neighbour of another name?
function onEdge(ids, k, beams) {
  const id = ids[k];
  const column = k % beams;
  return (column > 0 && ids[k - 1] !== id) || (column < beams - 1 && ids[k + 1] !== id) ||
      (k >= beams && ids[k - beams] !== id) ||
      (k + beams < ids.length && ids[k + beams] !== id);
}

// Names that have so much of the picture that their coat would hide it, as a seabed's does.
function wideNames(ids) {
  const counts = new Uint32Array(65536);
  for (let k = 0; k < ids.length; ++k) counts[ids[k]] += 1;
  return counts.map((count) => (count > WIDE * ids.length ? 1 : 0));
}

// Labels: a thin coat, and an edge that shows whole.
function cover(colours, ids, beams, opacity, colourOfId) {
  const colourOf = packedColours(colourOfId);
  const wide = wideNames(ids);
  for (let k = 0; k < ids.length; ++k) {
    if (ids[k] === 0) continue;
    const coat = (wide[ids[k]] ? 0.35 : 0.75) * opacity;
    const share = onEdge(ids, k, beams) ? Math.min(1, 1.6 * opacity) : coat;
    colours[k] = mix(colours[k], colourOf(ids[k]), share);
  }
}

// Shadows: lines in the colour of what casts them.
function hatch(colours, ids, beams, opacity) {
  const colourOf = packedColours(nameColour);
  for (let k = 0; k < ids.length; ++k) {
    if (ids[k] === 0) continue;
    const row = Math.floor(k / beams);
    const line = (row + (k % beams)) % HATCH < 2 || onEdge(ids, k, beams);
    colours[k] = mix(colours[k], colourOf(ids[k]), (line ? 1 : 0.2) * opacity);
  }
}

function dimAllBut(colours, frame, { kind, id }) {
  const names = kind === 'class' ? frame.semantic : frame.instance;
  const colour = pack(...(kind === 'class' ? classColour(id) : nameColour(id)));
  for (let k = 0; k < colours.length; ++k) {
    const chosen = names && names[k] === id;
    if (!chosen) colours[k] = mix(colours[k], DIMMED, 0.7);
    else if (onEdge(names, k, frame.geometry.beams)) colours[k] = mix(colours[k], colour, 0.85);
  }
}

// The pixels of a canvas. Where a pixel stands for several samples the brightest of them is shown,
// lest small targets fall between the lines.
function paint(canvas, kind, frame, colours, codes) {
  const lookup = lookupFor(kind, frame.geometry, canvas.width, canvas.height);
  // Written from memory alone, so it is best kept there.
  const context = canvas.getContext('2d', { willReadFrequently: true });
  const image = context.createImageData(canvas.width, canvas.height);
  const pixels = new Uint32Array(image.data.buffer);
  const { cells } = lookup;
  const several = codes ? Math.ceil(lookup.samplesPerPixel - 0.25) : 1;
  if (several <= 1) {
    for (let k = 0; k < cells.length; ++k) {
      if (cells[k] >= 0) pixels[k] = colours[cells[k]];
    }
  } else {
    const { beams } = frame.geometry;
    for (let k = 0; k < cells.length; ++k) {
      if (cells[k] >= 0) pixels[k] = colours[brightest(codes, cells[k], beams, several)];
    }
  }
  context.putImageData(image, 0, 0);
}

function brightest(codes, cell, beams, several) {
  let best = cell;
  for (let n = -(several >> 1); n < several - (several >> 1); ++n) {
    const other = cell + n * beams;
    if (other >= 0 && other < codes.length && codes[other] > codes[best]) best = other;
  }
  return best;
}
