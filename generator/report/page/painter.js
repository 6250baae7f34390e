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
