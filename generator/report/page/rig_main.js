// The instruments of a rig: a table of mounts and clocks, and a row of images for each time.

const FAN = { width: 320, height: 210 };
const MAP = 'inferno';

function canvasOf(title, width, height, draw) {
  const canvas = el('canvas', { width, height, role: 'img', title, 'aria-label': title });
  const watcher = new IntersectionObserver(async ([entry]) => {
    if (!entry.isIntersecting) return;
    watcher.disconnect();
    await draw(canvas);
    canvas.dataset.drawn = 'yes';
  }, { rootMargin: '300px' });
  watcher.observe(canvas);
  return canvas;
}

function fanOf(title, picture, scale) {
  return canvasOf(title, FAN.width, FAN.height, async (canvas) => {
    const level = await greyCodes(picture.level, picture, true);
    const frame = { geometry: geometryOf(picture), codes: { level } };
    const view = { quantity: 'level', map: MAP, overlays: {}, highlight: null,
                   limits: { low: scale.show_min_db, high: scale.show_max_db },
                   coding: { min: scale.min_db, max: scale.max_db } };
    paint(canvas, 'cartesian', frame, colourise(frame, view), level);
  });
}

function colorOf(title, cell) {
  return canvasOf(title, cell.columns, cell.rows, async (canvas) => {
    canvas.getContext('2d', { willReadFrequently: true }).putImageData(await decodePicture(cell.color), 0, 0);
  });
}

// Near is bright.
function depthOf(title, cell) {
  return canvasOf(title, cell.columns, cell.rows, async (canvas) => {
    const codes = await greyCodes(cell.depth.chunk, { beams: cell.columns, samples: cell.rows }, false);
    const colours = colourOfCodes(MAP, { min: 0, max: 1, empty: 'none' }, { low: 1, high: 0 });
    const image = new ImageData(cell.columns, cell.rows);
    new Uint32Array(image.data.buffer).set(Uint32Array.from(codes, (code) => colours[code]));
    canvas.getContext('2d', { willReadFrequently: true }).putImageData(image, 0, 0);
  });
}

function cellOf(instrument, cell) {
  if (!cell) return el('td', { class: 'muted', text: 'no ping' });
  const name = `${instrument.name}, ping ${cell.ping}`;
  const { depth } = cell;
  return el('td', {}, el('div', { class: 'muted', text: `ping ${cell.ping}, ${fixed(cell.time_s, 3)} s` }),
            cell.level && fanOf(name, cell.level, instrument.scale),
            cell.color !== null ? colorOf(`${name}, color`, cell) : null,
            depth && depthOf(`${name}, depth ${brief(depth.min_m)} to ${brief(depth.max_m)} m, logarithmic`, cell));
}

function mountOf({ position_m: position, quaternion_wxyz: q }) {
  if (!position) return 'sampled';
  const ahead = turned(q, [1, 0, 0]);
  const yaw = degrees(Math.atan2(ahead[1], ahead[0]));
  const pitch = degrees(Math.asin(clamp(-ahead[2], -1, 1)));
  const up = turned(q, [0, 0, 1]), port = turned(q, [0, 1, 0]);
  const roll = degrees(Math.atan2(port[2], up[2]));
  return `(${position.map((x) => fixed(x, 2)).join(', ')}) m; roll ${fixed(roll, 1)}°, ` +
      `pitch ${fixed(pitch, 1)}°, yaw ${fixed(yaw, 1)}°`;
}

function showInstruments() {
  const orSampled = (value) => (value === null ? 'sampled' : brief(value));
  const head = ['instrument', 'mount', 'pings per second', 'first ping, s', 'levels, dB re 1 µPa'];
  replace(byId('instruments-table'), el('thead', {}, el('tr', {}, ...head.map((text) => el('th', { text })))),
          el('tbody', {}, ...report.instruments.map((instrument) => el(
              'tr', {}, el('td', {}, instrument.report ? el('a', { href: encodeURIComponent(instrument.report), text: instrument.name })
                                                        : el('span', { text: instrument.name })),
              el('td', { text: mountOf(instrument) }), el('td', { text: orSampled(instrument.ping_rate_hz) }),
              el('td', { text: orSampled(instrument.time_offset_s) }),
              el('td', { text: instrument.scale ? `${fixed(instrument.scale.show_min_db, 0)} to ${fixed(instrument.scale.show_max_db, 0)}`
                                                : '–' })))));
}

function showPings() {
  const { rows } = report;
  const instruments = report.instruments.filter(({ cells }) => cells.some(
      (cell) => cell && (cell.level || cell.color !== null || cell.depth)));
  byId('pings-note').textContent = instruments.length > 1
      ? `of ${report.instruments[report.first].name}, and the pings of the others that are nearest in time` : '';
  const sequences = new Set(rows.map(({ sequence }) => sequence)).size > 1;
  replace(byId('pings-table'),
          el('thead', {}, el('tr', {}, el('th', { text: 'time' }), ...instruments.map(({ name }) => el('th', { text: name })))),
          el('tbody', {}, ...rows.map((row, k) => el(
              'tr', {}, el('th', { text: `${sequences ? `sequence ${row.sequence}, ` : ''}${fixed(row.time_s, 3)} s` }),
              ...instruments.map((instrument) => cellOf(instrument, instrument.cells[k]))))));
}

document.title = `${report.name} – ensonify report`;
byId('title').textContent = report.name;
replace(byId('facts'), el('span', { text: plural(report.instruments.length, 'instrument') }),
        el('span', { text: plural(report.rows.length, 'shown time') }));
byId('foot').textContent = `Rig made by ${report.program}. This page holds all that it shows and asks nothing of any network.`;
createTheme(() => {});
showInstruments();
showPings();
