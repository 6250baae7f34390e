// Colours of levels and of names. A colour is an unsigned 32-bit number as canvases of little-endian
// machines keep it: alpha, blue, green, red from the high byte down.

const MAP_NAMES = ['inferno', 'viridis', 'cividis', 'grey'];

function pack(red, green, blue) {
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

function readMap(name) {
  const table = new Uint32Array(256);
  for (let k = 0; k < 256; ++k) {
    const digits = name === 'grey' ? null : parseInt(MAP_TABLES[name].substr(6 * k, 6), 16);
    table[k] = digits === null ? pack(k, k, k)
                               : pack(digits >> 16, (digits >> 8) & 255, digits & 255);
  }
  return table;
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
