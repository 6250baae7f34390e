// Elements, numbers as text, and the one hub that tells parts of the page of changes.

const SVG_NAME = 'http://www.w3.org/2000/svg';

function byId(id) {
  return document.getElementById(id);
}

// What is given as text is text: names of a data set never become markup.
function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'text') node.textContent = value;
    else if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? '' : value);
  }
  for (const child of children) {
    if (child !== null && child !== undefined) node.append(child);
  }
  return node;
}

function el(tag, attributes, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function svg(tag, attributes, ...children) {
  return fill(document.createElementNS(SVG_NAME, tag), attributes, children);
}

function replace(node, ...children) {
  node.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
}

const listeners = new Map();

function on(event, listener) {
  if (!listeners.has(event)) listeners.set(event, []);
  listeners.get(event).push(listener);
}

function emit(event) {
  for (const listener of listeners.get(event) || []) listener();
}

// A function that runs once before the next picture of the screen, however often it is asked for.
function oncePerFrame(work) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      work();
    });
  };
}

const MINUS = '\u2212';

function fixed(value, digits) {
  if (!Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(digits);
  return (value < 0 && Number(text) !== 0 ? MINUS : '') + text;
}

// Up to four significant digits, for numbers of unknown size.
function brief(value) {
  if (typeof value !== 'number') return String(value);
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e7) return whole(value);
  if (size >= 1e7 || size < 1e-3) return value.toExponential(3).replace('-', MINUS);
  return String(Number(value.toPrecision(4))).replace('-', MINUS);
}

function whole(value) {
  return value.toLocaleString('en-US').replace('-', MINUS);
}

function plural(number, one, many) {
  return `${whole(number)} ${number === 1 ? one : many || one + 's'}`;
}

function bytesText(bytes) {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let power = 0;
  while (bytes >= 1000 && power < units.length - 1) {
    bytes /= 1000;
    power += 1;
  }
  return `${power === 0 ? bytes : bytes.toPrecision(3)} ${units[power]}`;
}

function degrees(radians) {
  return (radians * 180) / Math.PI;
}

function clamp(value, low, high) {
  return Math.min(high, Math.max(low, value));
}

// Steps of 1, 2 or 5 times a power of ten, about `wanted` of them in the span.
function niceStep(span, wanted) {
  const raw = span / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return (lead > 5 ? 10 : lead > 2 ? 5 : lead > 1 ? 2 : 1) * power;
}

function ticks(low, high, wanted) {
  if (!(high > low)) return [low];
  const step = niceStep(high - low, wanted);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; ++k) {
    list.push(Number((k * step).toPrecision(12)));
  }
  return list;
}

function tickText(value) {
  return String(Number(value.toPrecision(6))).replace('-', MINUS);
}

// System, light or dark. Canvases take their colours from the style, so `changed` draws them anew.
function createTheme(changed) {
  const select = byId('theme');
  select.addEventListener('change', () => {
    if (select.value === 'auto') delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = select.value;
    changed();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', changed);
}
